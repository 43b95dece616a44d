// Motion in calls: the requested moment, and the motion that ListLights reports.
#include <cmath>
#include <cstring>
#include <limits>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

class MotionServiceTest : public ::testing::Test {
 protected:
  /// The mean radiance of the first finished picture in the stream.
  double mean_of_image(const v1::RenderImageRequest& q) {
    grpc::ClientContext context;
    const auto reader = service_.render.RenderImage(&context, q);
    v1::RenderImageResponse r;
    EXPECT_TRUE(reader->Read(&r));
    const v1::Tile tile = r.tile();
    EXPECT_FALSE(reader->Read(&r));
    EXPECT_TRUE(reader->Finish().ok());
    return mean(tile);
  }
  static double mean(const v1::Tile& tile) {
    double sum = 0;
    const std::size_t n = tile.sum().size() / sizeof(double);
    for (std::size_t i = 0; i < n; ++i) {
      double v = 0;
      std::memcpy(&v, tile.sum().data() + i * sizeof v, sizeof v);
      sum += v / static_cast<double>(tile.block_count());
    }
    return sum / static_cast<double>(n);
  }
  /// Illuminance below the start of the light, while 18 cd are at (2 t, 0, 3): I h / d^3.
  static double illuminance(double t) { return 18 * 3 / std::pow(4 * t * t + 9, 1.5); }

  Service service_{pbrt_options()};
  std::string point_ = service_.load("moving_point.pbrt");
  std::string sun_ = service_.load("moving_sun.pbrt");
};

TEST_F(MotionServiceTest, ListLightsReportsTheKeyFrames) {
  v1::ListLightsRequest q;
  v1::ListLightsResponse r;
  q.set_scene_id(point_);
  ASSERT_TRUE(status_of([&](auto* c) { return service_.scenes.ListLights(c, q, &r); }).ok());
  ASSERT_EQ(r.lights(0).motion().key_frames_size(), 2);
  const v1::KeyFrame &first = r.lights(0).motion().key_frames(0),
                     &last = r.lights(0).motion().key_frames(1);
  EXPECT_EQ(first.time_s(), 0);
  EXPECT_EQ(last.time_s(), 2);
  EXPECT_EQ(first.position_m().z(), 3);
  EXPECT_NEAR(last.position_m().x(), 4, 1e-12);
  EXPECT_EQ(last.position_m().z(), 3);
  EXPECT_EQ(first.angle_rad(), 0);
  EXPECT_EQ(last.angle_rad(), 0);
  // Parameters and bounds are those of the first key frame.
  EXPECT_EQ(r.lights(0).point().position_m().x(), 0);
  EXPECT_EQ(r.lights(0).bounds().lower_m().z(), 3);
  EXPECT_NEAR(r.lights(0).power_lm(), 4 * kPi * 18, 1e-9);

  q.set_scene_id(sun_);
  ASSERT_TRUE(status_of([&](auto* c) { return service_.scenes.ListLights(c, q, &r); }).ok());
  const v1::KeyFrame& turned = r.lights(0).motion().key_frames(1);
  EXPECT_NEAR(turned.angle_rad(), kPi / 2, 1e-12);
  EXPECT_NEAR(turned.axis().y(), 1, 1e-12);
  EXPECT_NEAR(turned.axis().x(), 0, 1e-12);

  Service still;  // a scene without motion
  q.set_scene_id(still.load("point.pbrt"));
  ASSERT_TRUE(status_of([&](auto* c) { return still.scenes.ListLights(c, q, &r); }).ok());
  EXPECT_FALSE(r.lights(0).has_motion());
}

TEST_F(MotionServiceTest, GetSceneReportsTheShutter) {
  v1::GetSceneRequest q;
  v1::GetSceneResponse r;
  q.set_scene_id(point_);
  ASSERT_TRUE(status_of([&](auto* c) { return service_.scenes.GetScene(c, q, &r); }).ok());
  EXPECT_EQ(r.summary().shutter_open_s(), 0);
  EXPECT_EQ(r.summary().shutter_close_s(), 2);
  q.set_scene_id(sun_);  // no camera: pbrt's default
  ASSERT_TRUE(status_of([&](auto* c) { return service_.scenes.GetScene(c, q, &r); }).ok());
  EXPECT_EQ(r.summary().shutter_open_s(), 0);
  EXPECT_EQ(r.summary().shutter_close_s(), 1);
}

TEST_F(MotionServiceTest, SamplesAndIrradianceAreThoseOfTheTime) {
  v1::SampleLiRequest li;
  li.set_scene_id(point_);
  li.set_light_id(1);
  li.mutable_seed();
  set(li.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.5);
  v1::EstimateIrradianceRequest e;
  e.set_scene_id(point_);
  e.set_bounces(0);
  set(e.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
  set(e.mutable_normals(), 0, 0, 1);
  const auto check = [&](double t) {
    v1::SampleLiResponse s;
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.SampleLi(c, li, &s); }).ok());
    EXPECT_NEAR(s.value(0), 18 / (4 * t * t + 6.25), 1e-5) << t;
    EXPECT_NEAR(s.light_offsets_m(0), 2 * t, 1e-6);
    v1::EstimateIrradianceResponse lux;
    ASSERT_TRUE(
        status_of([&](auto* c) { return service_.lighting.EstimateIrradiance(c, e, &lux); }).ok());
    EXPECT_NEAR(lux.illuminance_lx(0), illuminance(t), 1e-5) << t;
  };
  check(0);  // unset
  for (const double t : {0.0, 0.5, 1.25, 2.0}) {
    li.set_time_s(t);
    e.set_time_s(t);
    check(t);
  }
}

TEST_F(MotionServiceTest, DensitiesAndRadianceAreThoseOfTheTime) {
  // The sun's centre is at 45 t degrees from the zenith.
  v1::PdfLiRequest pdf;
  pdf.set_scene_id(sun_);
  pdf.set_light_id(1);
  v1::LeRequest le;
  le.set_scene_id(sun_);
  set(pdf.mutable_receivers()->mutable_offsets_m(), 0, 0, 0, 0, 0, 0);
  set(pdf.mutable_wi(), 0, 0, 1, 1, 0, 1);
  *le.mutable_points() = pdf.receivers();
  *le.mutable_directions() = pdf.wi();
  const double half = 10 * kPi / 180;
  const double density = 1 / (2 * kPi * (1 - std::cos(half)));
  const double radiance = 100 / (kPi * std::pow(std::sin(half), 2));
  for (const double t : {0.0, 1.0, 0.5}) {
    pdf.set_time_s(t);
    le.set_time_s(t);
    v1::PdfLiResponse p;
    v1::LeResponse l;
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.PdfLi(c, pdf, &p); }).ok());
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.Le(c, le, &l); }).ok());
    for (int i = 0; i < 2; ++i) {
      const bool there = t == i;  // halfway neither light is there
      EXPECT_NEAR(p.pdf_per_sr(i), there ? density : 0, 1e-5 * density) << t;
      EXPECT_NEAR(l.radiance_cd_m2(3 * i), there ? radiance : 0, 1e-5 * radiance) << t;
      EXPECT_EQ(l.light_ids(i), there ? 1U : 0U);
    }
  }
}

TEST_F(MotionServiceTest, RaysStartAtThePlaceOfTheLightAtTheTime) {
  v1::SampleLeRequest q;
  q.set_scene_id(point_);
  q.set_light_id(1);
  q.set_count(3);
  q.mutable_seed();
  for (const double t : {0.0, 0.3, 2.0}) {
    q.set_time_s(t);
    v1::SampleLeResponse s;
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.SampleLe(c, q, &s); }).ok());
    ASSERT_EQ(s.points().offsets_m_size(), 9);
    v1::PdfLeRequest back;
    back.set_scene_id(point_);
    back.set_light_id(1);
    *back.mutable_points() = s.points();
    *back.mutable_directions() = s.directions();
    back.set_time_s(t);
    v1::PdfLeResponse p;
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.PdfLe(c, back, &p); }).ok());
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(s.points().origin_m().x() + s.points().offsets_m(3 * i), 2 * t, 1e-6);
      EXPECT_NEAR(p.pdf_direction_per_sr(i), 1 / (4 * kPi), 1e-7) << t;
      EXPECT_EQ(p.pdf_position_per_m2(i), 0);
    }
    back.set_time_s(t + 0.1);
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.PdfLe(c, back, &p); }).ok());
    // From 2 s on it is at rest.
    EXPECT_NEAR(p.pdf_direction_per_sr(0), t < 2 ? 0 : 1 / (4 * kPi), 1e-7);
  }
}

TEST_F(MotionServiceTest, SurfacesHideAndEmitAtTheirPlaceAtTheTime) {
  const std::string scene = service_.load("moving_surfaces.pbrt");
  v1::ListLightsRequest list;
  v1::ListLightsResponse lights;
  list.set_scene_id(scene);
  ASSERT_TRUE(
      status_of([&](auto* c) { return service_.scenes.ListLights(c, list, &lights); }).ok());
  ASSERT_EQ(lights.lights_size(), 1);
  // At the first key frame.
  EXPECT_NEAR(lights.lights(0).bounds().lower_m().x(), 9.5, 1e-5);
  EXPECT_NEAR(lights.lights(0).bounds().upper_m().x(), 10.5, 1e-5);
  EXPECT_NEAR(lights.lights(0).bounds().lower_m().z(), 1, 1e-5);
  EXPECT_NEAR(lights.lights(0).area_m2(), kPi / 4, 1e-6);
  EXPECT_EQ(lights.lights(0).motion().key_frames(0).position_m().z(), 1);
  EXPECT_EQ(lights.lights(0).motion().key_frames(1).position_m().z(), 3);

  v1::TestVisibilityRequest visible;
  visible.set_scene_id(scene);
  set(visible.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 0);
  set(visible.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 3);
  v1::LeRequest le;
  le.set_scene_id(scene);
  set(le.mutable_points()->mutable_offsets_m(), 10, 0, 0, 10, 0, 2.5);
  set(le.mutable_directions(), 0, 0, 1, 0, 0, 1);
  v1::EstimateIrradianceRequest meter;
  meter.set_scene_id(scene);
  meter.set_bounces(0);
  meter.mutable_accuracy()->set_samples(4096);
  set(meter.mutable_receivers()->mutable_offsets_m(), 10, 0, 0);
  set(meter.mutable_normals(), 0, 0, 1);
  for (const double t : {0.0, 1.0, 2.0}) {
    visible.set_time_s(t);
    le.set_time_s(t);
    meter.set_time_s(t);
    v1::TestVisibilityResponse v;
    v1::LeResponse l;
    v1::EstimateIrradianceResponse e;
    ASSERT_TRUE(
        status_of([&](auto* c) { return service_.lighting.TestVisibility(c, visible, &v); }).ok());
    ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.Le(c, le, &l); }).ok());
    ASSERT_TRUE(status_of([&](auto* c) {
                  return service_.lighting.EstimateIrradiance(c, meter, &e);
                }).ok());
    EXPECT_EQ(v.visible(), std::string(1, t == 1 ? '\0' : '\1')) << t;
    EXPECT_EQ(l.radiance_cd_m2(0), 10);
    EXPECT_EQ(l.radiance_cd_m2(3), t == 2 ? 10 : 0) << t;  // from 2.5 m up
    // On the axis of the disk: pi L r^2 / (r^2 + h^2); seven standard errors.
    const double h = 1 + t;
    EXPECT_NEAR(e.illuminance_lx(0), kPi * 10 * 0.25 / (0.25 + h * h),
                7 * double{e.standard_error_lx(0)})
        << t;
    EXPECT_LT(e.standard_error_lx(0), 0.05);
  }
}

TEST_F(MotionServiceTest, PicturesAreOfTheMomentOrOfTheWholeShutter) {
  v1::RenderTileRequest q;
  q.set_scene_id(point_);
  q.mutable_rect()->set_x1(4);
  q.mutable_rect()->set_y1(2);
  q.mutable_accuracy()->set_samples(1024);
  v1::RenderImageRequest image;
  image.set_scene_id(point_);
  image.set_final_only(true);
  image.mutable_accuracy()->set_samples(1024);
  // Radiance at reflectance 0.5 is 0.5 / pi of the illuminance.  All visible points lie within 2
  // mm.
  v1::RenderTileResponse r;
  for (const double t : {0.0, 0.75, 2.0}) {
    q.set_time_s(t);
    image.set_time_s(t);
    ASSERT_TRUE(status_of([&](auto* c) { return service_.render.RenderTile(c, q, &r); }).ok());
    const double expected = 0.5 / kPi * illuminance(t);
    EXPECT_NEAR(mean(r.tile()), expected, 2e-3 * expected) << t;
    EXPECT_NEAR(mean_of_image(image), expected, 2e-3 * expected) << t;
  }
  q.clear_time_s();
  image.clear_time_s();
  // The mean of I h / (x^2 + h^2)^(3/2) over x from 0 to X: I / (h sqrt(X^2 + h^2)) = 18 / 15.
  // Over the shutter's interval, illuminance varies between 0.43 and 2.  Its standard deviation is
  // below 0.79, for 8192 samples below 0.0088.  Seven of that are exceeded by chance less than once
  // in 1e11.
  ASSERT_TRUE(status_of([&](auto* c) { return service_.render.RenderTile(c, q, &r); }).ok());
  EXPECT_NEAR(mean(r.tile()), 0.5 / kPi * 1.2, 0.5 / kPi * 0.062);
  EXPECT_NEAR(mean_of_image(image), 0.5 / kPi * 1.2, 0.5 / kPi * 0.062);
}

TEST_F(MotionServiceTest, TimesThatAreNotFiniteAreNamed) {
  for (const double bad : {double{NAN}, double{INFINITY}, -double{INFINITY}}) {
    const auto refused = [&](auto request, auto&& call) {
      request.set_scene_id(point_);
      request.set_time_s(bad);
      expect_bad_field(call(request), "time_s");
    };
    const auto unary = [&](auto request, auto response, auto stub, auto& service) {
      refused(std::move(request), [&](const auto& q) {
        return status_of([&](auto* c) { return (service.*stub)(c, q, &response); });
      });
    };
    using Light = v1::LightingService::Stub;
    v1::SampleLiRequest li;
    li.mutable_seed();
    unary(li, v1::SampleLiResponse(), &Light::SampleLi, service_.lighting);
    v1::PdfLiRequest pdf;
    pdf.set_light_id(1);
    unary(pdf, v1::PdfLiResponse(), &Light::PdfLi, service_.lighting);
    unary(v1::LeRequest(), v1::LeResponse(), &Light::Le, service_.lighting);
    v1::SampleLeRequest emit;
    emit.set_count(1);
    emit.mutable_seed();
    unary(emit, v1::SampleLeResponse(), &Light::SampleLe, service_.lighting);
    v1::PdfLeRequest emit_pdf;
    emit_pdf.set_light_id(1);
    unary(emit_pdf, v1::PdfLeResponse(), &Light::PdfLe, service_.lighting);
    v1::TestVisibilityRequest visible;
    visible.mutable_segments();
    unary(visible, v1::TestVisibilityResponse(), &Light::TestVisibility, service_.lighting);
    unary(v1::EstimateIrradianceRequest(), v1::EstimateIrradianceResponse(),
          &Light::EstimateIrradiance, service_.lighting);
    v1::RenderTileRequest tile;
    tile.mutable_rect()->set_x1(1);
    tile.mutable_rect()->set_y1(1);
    unary(tile, v1::RenderTileResponse(), &v1::RenderService::Stub::RenderTile, service_.render);
    refused(v1::RenderImageRequest(), [&](const v1::RenderImageRequest& q) {
      return status_of([&](auto* c) {
        const auto reader = service_.render.RenderImage(c, q);
        v1::RenderImageResponse r;
        while (reader->Read(&r)) continue;
        return reader->Finish();
      });
    });
  }
}

}  // namespace
}  // namespace lucerna::testing
