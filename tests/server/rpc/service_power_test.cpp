// EstimatePower of each kind of light, exact and approximate.
#include <algorithm>

#include "every_light.h"

namespace lucerna::testing {
namespace {

double luminance_of(const v1::Rgb& c) { return testing::luminance_of(c.r(), c.g(), c.b()); }

TEST_F(PowerTest, ExactPowersAreThoseOfListLights) {
  const auto exact = answer(request(v1::EstimatePowerRequest::METHOD_EXACT));
  ASSERT_EQ(exact.lights_size(), lights_.lights_size());
  for (int i = 0; i < exact.lights_size(); ++i) {
    const v1::Light& light = lights_.lights(i);
    const v1::LightPower& p = exact.lights(i);
    EXPECT_EQ(p.light_id(), light.id());
    EXPECT_NEAR(luminance_of(p.rgb_lm()), p.power_lm(), 1e-6 * p.power_lm());
    EXPECT_EQ(p.power_lm(), light.power_lm());
    EXPECT_EQ(p.error_lm(), light.power_error_lm());
  }
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
    expect_bad_field(service_.status(changed), "page_token");
  };
  refused([](auto& q) { q.set_method(v1::EstimatePowerRequest::METHOD_EXACT); });
  refused([](auto& q) { q.add_wavelengths_nm(550); });
  refused([](auto& q) {
    for (const std::uint64_t id : {1, 2, 3}) q.add_light_ids(id);
  });
  refused([](auto& q) { q.set_page_token(q.page_token() + "AAAA"); });
}

TEST_F(PowerTest, InvalidRequestsAreRefused) {
  v1::EstimatePowerRequest q = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  q.add_light_ids(1);
  q.add_light_ids(9999);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(service_.status(q)).reason(), "NO_SUCH_LIGHT");
  q = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  q.set_page_token("nonsense");
  expect_bad_field(service_.status(q), "page_token");
  q = request(static_cast<v1::EstimatePowerRequest::Method>(9));
  expect_bad_field(service_.status(q), "method");
  q = request(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  q.mutable_light_ids()->Resize(65537, 1);
  EXPECT_EQ(service_.status(q).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
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
