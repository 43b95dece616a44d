// EstimatePower of each kind of light, exact and approximate.
#include <algorithm>

#include "every_light.h"

namespace lucerna::testing {
namespace {

double luminance_of(const v1::Rgb& c) { return testing::luminance_of(c.r(), c.g(), c.b()); }

/// Luminous flux by hand, from the answer of ListLights and the radius of the scene's sphere; 0
/// where a picture or a file determines it.
double by_hand(const v1::Light& light, double radius) {
  const double disk = kPi * radius * radius;
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return 4 * kPi * luminance_of(light.point().intensity_cd());
    case v1::Light::kSpot: {
      // Full light over the inner cap.  In the edge, zones of equal height have equal areas.  So
      // the edge adds the mean of the profile: 1/2 for smoothstep, 1/5 for x^4.
      const v1::SpotLight& spot = light.spot();
      const double inner = 1 - std::cos(spot.falloff_start_rad());
      const double outer = 1 - std::cos(spot.cone_half_angle_rad());
      const double mean = spot.profile() == v1::SPOT_PROFILE_QUARTIC ? 0.2 : 0.5;
      return luminance_of(spot.intensity_cd()) * 2 * kPi * (inner + (outer - inner) * mean);
    }
    case v1::Light::kProjection: {
      if (light.projection().has_image()) return 0;
      // A pyramid of equal half apex angles a covers 4 asin(sin^2 a).
      const double sine = std::sin(light.projection().fov_rad() / 2);
      return luminance_of(light.projection().intensity_cd()) * 4 * std::asin(sine * sine);
    }
    case v1::Light::kBeam:
      if (light.beam().has_image()) return 0;
      return luminance_of(light.beam().illuminance_lx()) * light.beam().width_m() *
             light.beam().height_m();
    case v1::Light::kDistant:
      return luminance_of(light.distant().illuminance_lx()) * disk;
    case v1::Light::kSun: {
      // E = pi L sin^2 a on a surface that faces the centre.  All directions together give L times
      // their solid angle 2 pi (1 - cos a), through disks that face them.
      const double cosine = std::cos(light.sun().angular_diameter_rad() / 2);
      return luminance_of(light.sun().illuminance_lx()) * disk * 2 / (1 + cosine);
    }
    case v1::Light::kUniformInfinite:
      return luminance_of(light.uniform_infinite().radiance_cd_m2()) * 4 * kPi * disk;
    case v1::Light::kDiffuseArea:
      if (light.diffuse_area().has_image() || light.diffuse_area().has_profile()) return 0;
      return luminance_of(light.diffuse_area().radiance_cd_m2()) * kPi * light.area_m2() *
             (light.diffuse_area().two_sided() ? 2 : 1);
    case v1::Light::kGoniometric:
      if (light.goniometric().distribution_case() != v1::GoniometricLight::DISTRIBUTION_NOT_SET) {
        return 0;
      }
      return 4 * kPi * luminance_of(light.goniometric().intensity());
    case v1::Light::kImageInfinite: {
      // A uniform sky gives pi L for each square metre of its portal.
      const v1::ImageInfiniteLight& sky = light.image_infinite();
      if (sky.has_map() || !has_portal(light)) return 0;
      const auto side = [&](int to) {
        const v1::Vector3 &a = sky.portal_m(0), &b = sky.portal_m(to);
        return std::hypot(b.x() - a.x(), b.y() - a.y(), b.z() - a.z());
      };
      return kPi * luminance_of(sky.radiance_cd_m2()) * side(1) * side(3);
    }
    default:
      return 0;
  }
}

TEST_F(PowerTest, ExactPowersAreThoseDerivedByHand) {
  const auto exact = answer(request(v1::EstimatePowerRequest::METHOD_EXACT));
  ASSERT_EQ(exact.lights_size(), lights_.lights_size());
  int derived = 0;
  for (int i = 0; i < exact.lights_size(); ++i) {
    const v1::Light& light = lights_.lights(i);
    const v1::LightPower& p = exact.lights(i);
    EXPECT_EQ(p.light_id(), light.id());
    EXPECT_NEAR(luminance_of(p.rgb_lm()), p.power_lm(), 1e-6 * p.power_lm());
    EXPECT_EQ(p.power_lm(), light.power_lm());
    EXPECT_EQ(p.error_lm(), light.power_error_lm());
    const double lumens = by_hand(light, summary_.radius_m());
    if (lumens == 0) continue;
    ++derived;
    EXPECT_NEAR(p.power_lm(), lumens, p.error_lm() + 1e-6 * lumens) << light.ShortDebugString();
  }
  EXPECT_GE(derived, 17);
  // 200 cd straight down, linear in the angle to 0 at 90 degrees.  The flux is 2 pi 200 times the
  // integral of (1 - 2 t / pi) sin t, which is 1 - 2 / pi.
  EXPECT_NEAR(first(v1::Light::kGoniometric).power_lm(), 400 * kPi * (1 - 2 / kPi), 1e-9);
  // 200 cd straight down, linear in the angle to the values of the planes C0, C90, C180, C270 at 90
  // degrees, and linear between planes.  Their mean is 100, so the flux is 2 pi (200 - 100 2 / pi).
  // Half of it counts here and all of it on a panel.
  const auto is_sconce = [](const v1::PhotometricFile& file) {
    return file.name() == "lights/sconce.ldt";
  };
  EXPECT_NEAR(first([&](const v1::Light& l) {
                return is_sconce(l.goniometric().photometric_file());
              }).power_lm(),
              200 * (kPi - 1), 1e-9);
  EXPECT_NEAR(
      first([&](const v1::Light& l) { return is_sconce(l.diffuse_area().profile()); }).power_lm(),
      400 * (kPi - 1), 1e-9);
  // The default is exact.
  EXPECT_EQ(answer(request(v1::EstimatePowerRequest::METHOD_UNSPECIFIED)).total().power_lm(),
            exact.total().power_lm());
}

TEST_F(PowerTest, AreasAndDiametersAreThoseOfTheFile) {
  // The shapes of every_light.pbrt, independent of the server's areas.
  EXPECT_NEAR(first(v1::AREA_SHAPE_TRIANGLE_MESH).area_m2(), 0.5, 1e-6);
  EXPECT_NEAR(first(v1::AREA_SHAPE_BILINEAR_MESH).area_m2(), 1.5, 1e-6);
  EXPECT_NEAR(first(v1::AREA_SHAPE_SPHERE).area_m2(), 4 * kPi * 0.35 * 0.35, 1e-6);
  EXPECT_NEAR(first(v1::AREA_SHAPE_DISK).area_m2(), kPi * 0.4 * 0.4, 1e-6);
  EXPECT_NEAR(first(v1::AREA_SHAPE_CYLINDER).area_m2(), 2 * kPi * 0.06 * 2, 1e-6);
}

TEST_F(PowerTest, ApproximatePowerIsWithinItsError) {
  const auto exact = answer(request(v1::EstimatePowerRequest::METHOD_EXACT));
  const auto books = answer(request(v1::EstimatePowerRequest::METHOD_APPROXIMATE));
  ASSERT_EQ(books.lights_size(), exact.lights_size());
  for (int i = 0; i < exact.lights_size(); ++i) {
    const v1::LightPower &e = exact.lights(i), &b = books.lights(i);
    EXPECT_EQ(b.light_id(), e.light_id());
    const double off = std::fabs(b.power_lm() - e.power_lm());
    EXPECT_NEAR(b.error_lm(), off + e.error_lm(), 1e-9 * e.power_lm())
        << lights_.lights(i).ShortDebugString();
  }
}

TEST_F(PowerTest, ApproximatePowerIsTheTextbookFormula) {
  const auto books = answer(request(v1::EstimatePowerRequest::METHOD_APPROXIMATE));
  const double radius = summary_.radius_m();
  for (int i = 0; i < books.lights_size(); ++i) {
    const v1::Light& light = lights_.lights(i);
    double lumens = by_hand(light, radius);
    if (light.has_spot()) {
      // Half of the edge, whatever its profile.
      const double inner = std::cos(light.spot().falloff_start_rad());
      const double outer = std::cos(light.spot().cone_half_angle_rad());
      lumens =
          luminance_of(light.spot().intensity_cd()) * 2 * kPi * ((1 - inner) + (inner - outer) / 2);
    } else if (light.has_projection() && !light.projection().has_image()) {
      // The cone about the corners of a square.
      const double corner = std::atan(std::sqrt(2.0) * std::tan(light.projection().fov_rad() / 2));
      lumens = luminance_of(light.projection().intensity_cd()) * 2 * kPi * (1 - std::cos(corner));
    } else if (light.has_sun()) {
      // As if all light came from the centre.
      lumens = luminance_of(light.sun().illuminance_lx()) * kPi * radius * radius;
    } else if (has_portal(light) && !light.image_infinite().has_map()) {
      // Without the cosine: 2 pi instead of pi.
      lumens *= 2;
    }
    if (lumens == 0) continue;
    EXPECT_NEAR(books.lights(i).power_lm(), lumens, 1e-6 * lumens) << light.ShortDebugString();
  }
  // Known errors: 0.2 of the edge is not half, and the sun is 30 degrees wide.
  const auto error_of = [&](const v1::Light& light) {
    for (const v1::LightPower& p : books.lights()) {
      if (p.light_id() == light.id()) return p.error_lm() / p.power_lm();
    }
    return 0.0;
  };
  EXPECT_GT(error_of(first(
                [](const v1::Light& l) { return l.spot().profile() == v1::SPOT_PROFILE_QUARTIC; })),
            0.1);
  EXPECT_NEAR(error_of(first(v1::Light::kSun)), 2 / (1 + std::cos(kPi / 12)) - 1, 1e-9);
  EXPECT_EQ(error_of(first(v1::Light::kPoint)), 0);
}

TEST_F(PowerTest, TotalsAreSumsOfTheRequestedLights) {
  for (const auto method :
       {v1::EstimatePowerRequest::METHOD_EXACT, v1::EstimatePowerRequest::METHOD_APPROXIMATE}) {
    v1::EstimatePowerRequest q = request(method);
    const auto check = [](const v1::EstimatePowerResponse& of, const v1::LightPower& total) {
      double lumens = 0, error = 0, red = 0;
      for (const v1::LightPower& p : of.lights()) {
        lumens += p.power_lm();
        error += p.error_lm();
        red += p.rgb_lm().r();
      }
      EXPECT_EQ(total.light_id(), 0U);
      EXPECT_NEAR(total.power_lm(), lumens, 1e-12 * lumens);
      EXPECT_NEAR(total.rgb_lm().r(), red, 1e-12 * red);
      EXPECT_NEAR(total.error_lm(), error, 1e-12 * error);
    };
    const auto all = answer(q);
    check(all, all.total());
    // In the requested order.  A light that is listed twice counts twice.
    for (const std::uint64_t id : {3, 1, 3}) q.add_light_ids(id);
    const auto some = answer(q);
    ASSERT_EQ(some.lights_size(), 3);
    EXPECT_EQ(some.lights(0).light_id(), 3U);
    EXPECT_EQ(some.lights(1).light_id(), 1U);
    EXPECT_EQ(some.lights(2).power_lm(), some.lights(0).power_lm());
    check(some, some.total());
    // For any page.
    q.set_page_size(2);
    const auto page = answer(q);
    ASSERT_EQ(page.lights_size(), 2);
    EXPECT_EQ(page.total().power_lm(), some.total().power_lm());
    q.set_page_token(page.next_page_token());
    const auto last = answer(q);
    ASSERT_EQ(last.lights_size(), 1);
    EXPECT_EQ(last.lights(0).light_id(), 3U);
    EXPECT_EQ(last.total().power_lm(), some.total().power_lm());
    EXPECT_TRUE(last.next_page_token().empty());
  }
}

TEST_F(PowerTest, PagesBelongToOneRequest) {
  v1::EstimatePowerRequest first = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  first.set_page_size(2);
  first.set_page_token(answer(first).next_page_token());
  EXPECT_EQ(answer(first).lights_size(), 2);
  const auto refused = [&](const std::function<void(v1::EstimatePowerRequest&)>& change) {
    v1::EstimatePowerRequest changed = first;
    change(changed);
    v1::EstimatePowerResponse r;
    expect_bad_field(power(changed, &r), "page_token");
  };
  refused([](auto& q) { q.set_method(v1::EstimatePowerRequest::METHOD_EXACT); });
  refused([](auto& q) { q.add_wavelengths_nm(550); });
  refused([](auto& q) {
    for (const std::uint64_t id : {1, 2, 3}) q.add_light_ids(id);
  });
  refused([](auto& q) { q.set_page_token(q.page_token() + "AAAA"); });
}

TEST_F(PowerTest, InvalidRequestsAreRefused) {
  v1::EstimatePowerResponse r;
  v1::EstimatePowerRequest q = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  q.add_light_ids(1);
  q.add_light_ids(9999);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(power(q, &r)).reason(), "NO_SUCH_LIGHT");
  q = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  q.set_page_token("nonsense");
  expect_bad_field(power(q, &r), "page_token");
  q = request(static_cast<v1::EstimatePowerRequest::Method>(9));
  expect_bad_field(power(q, &r), "method");
  q = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  q.mutable_light_ids()->Resize(65537, 1);
  EXPECT_EQ(power(q, &r).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(EveryLightTest, OnlyThoseAtInfinityHaveNoBounds) {
  for (const v1::Light& light : lights_.lights()) {
    const bool at_infinity = light.has_distant() || light.has_sun() ||
                             light.has_uniform_infinite() || light.has_image_infinite();
    EXPECT_EQ(light.has_bounds(), !at_infinity) << light.ShortDebugString();
    EXPECT_EQ(light.has_area_m2(), light.has_diffuse_area()) << light.ShortDebugString();
    if (light.has_diffuse_area())
      EXPECT_NE(light.diffuse_area().shape(), v1::AREA_SHAPE_UNSPECIFIED);
    EXPECT_FALSE(at_infinity && light.has_directions()) << light.ShortDebugString();
  }
}

TEST_F(EveryLightTest, ConfinedLightsReportTheirDirections) {
  constexpr double kDegree = kPi / 180;
  EXPECT_FALSE(first(v1::Light::kPoint).has_directions());
  EXPECT_FALSE(first(v1::AREA_SHAPE_SPHERE).has_directions());
  EXPECT_FALSE(
      first([](const v1::Light& l) { return l.diffuse_area().two_sided(); }).has_directions());
  const v1::Light& spot = first(v1::Light::kSpot);
  EXPECT_NEAR(spot.directions().half_angle_rad(), 30 * kDegree, 1e-5);
  EXPECT_NEAR(spot.directions().axis().z(), -3.5 / std::sqrt(4 + 6.25 + 12.25), 1e-6);
  // Downwards: the file's, the disk's, the triangle's, the rectangle's.
  for (const v1::Light* light :
       {&first(v1::Light::kGoniometric), &first(v1::AREA_SHAPE_DISK),
        &first(v1::AREA_SHAPE_TRIANGLE_MESH), &first(v1::AREA_SHAPE_BILINEAR_MESH)}) {
    EXPECT_NEAR(light->directions().axis().z(), -1, 1e-6) << light->ShortDebugString();
    EXPECT_NEAR(light->directions().half_angle_rad(), 90 * kDegree, 1e-4);
  }
}

}  // namespace
}  // namespace lucerna::testing
