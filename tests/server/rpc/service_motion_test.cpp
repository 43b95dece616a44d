// Motion in calls: the requested moment, and the motion that ListLights reports.
#include <cmath>

#include "every_query.h"

namespace lucerna::testing {
namespace {

class MotionServiceTest : public ::testing::Test {
 protected:
  /// The mean radiance of a picture of one finished tile.
  double mean_of_image(const v1::RenderImageRequest& q) {
    const auto sent = service_.answer(q);
    EXPECT_EQ(sent.size(), 1U);
    return mean_of(sent.at(0).tile());
  }
  /// Illuminance below the start of the light, while 18 cd are at (2 t, 0, 3): I h / d^3.
  static double illuminance(double t) { return 18 * 3 / std::pow(4 * t * t + 9, 1.5); }

  Service service_{scenes_in(test_data("pbrt"))};
  std::string point_ = service_.load("moving_point.pbrt");
  std::string sun_ = service_.load("moving_sun.pbrt");
};

TEST_F(MotionServiceTest, ListLightsReportsTheKeyFrames) {
  auto q = about<v1::ListLightsRequest>(point_);
  auto r = service_.answer(q);
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
  r = service_.answer(q);
  const v1::KeyFrame& turned = r.lights(0).motion().key_frames(1);
  EXPECT_NEAR(turned.angle_rad(), kPi / 2, 1e-12);
  EXPECT_NEAR(turned.axis().y(), 1, 1e-12);
  EXPECT_NEAR(turned.axis().x(), 0, 1e-12);

  Service still;  // a scene without motion
  q.set_scene_id(still.load("point.pbrt"));
  r = still.answer(q);
  EXPECT_FALSE(r.lights(0).has_motion());
}

TEST_F(MotionServiceTest, GetSceneReportsTheShutter) {
  auto q = about<v1::GetSceneRequest>(point_);
  auto r = service_.answer(q);
  EXPECT_EQ(r.summary().shutter_open_s(), 0);
  EXPECT_EQ(r.summary().shutter_close_s(), 2);
  q.set_scene_id(sun_);  // no camera: pbrt's default
  r = service_.answer(q);
  EXPECT_EQ(r.summary().shutter_open_s(), 0);
  EXPECT_EQ(r.summary().shutter_close_s(), 1);
}

TEST_F(MotionServiceTest, SamplesAndIrradianceAreThoseOfTheTime) {
  auto li = about<v1::SampleLiRequest>(point_);
  li.set_light_id(1);
  li.mutable_seed();
  set(li.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.5);
  auto e = about<v1::EstimateIrradianceRequest>(point_);
  e.set_bounces(0);
  set(e.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
  set(e.mutable_normals(), 0, 0, 1);
  const auto check = [&](double t) {
    const auto s = service_.answer(li);
    EXPECT_NEAR(s.value(0), 18 / (4 * t * t + 6.25), 1e-5) << t;
    EXPECT_NEAR(s.light_offsets_m(0), 2 * t, 1e-6);
    const auto lux = service_.answer(e);
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
  auto pdf = about<v1::PdfLiRequest>(sun_);
  pdf.set_light_id(1);
  auto le = about<v1::LeRequest>(sun_);
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
    const auto p = service_.answer(pdf);
    const auto l = service_.answer(le);
    for (int i = 0; i < 2; ++i) {
      const bool there = t == i;  // halfway neither light is there
      EXPECT_NEAR(p.pdf_per_sr(i), there ? density : 0, 1e-5 * density) << t;
      EXPECT_NEAR(l.radiance_cd_m2(3 * i), there ? radiance : 0, 1e-5 * radiance) << t;
      EXPECT_EQ(l.light_ids(i), there ? 1U : 0U);
    }
  }
}

TEST_F(MotionServiceTest, RaysStartAtThePlaceOfTheLightAtTheTime) {
  auto q = about<v1::SampleLeRequest>(point_);
  q.set_light_id(1);
  q.set_count(3);
  q.mutable_seed();
  for (const double t : {0.0, 0.3, 2.0}) {
    q.set_time_s(t);
    const auto s = service_.answer(q);
    ASSERT_EQ(s.points().offsets_m_size(), 9);
    auto back = about<v1::PdfLeRequest>(point_);
    back.set_light_id(1);
    *back.mutable_points() = s.points();
    *back.mutable_directions() = s.directions();
    back.set_time_s(t);
    auto p = service_.answer(back);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(s.points().origin_m().x() + s.points().offsets_m(3 * i), 2 * t, 1e-6);
      EXPECT_NEAR(p.pdf_direction_per_sr(i), 1 / (4 * kPi), 1e-7) << t;
      EXPECT_EQ(p.pdf_position_per_m2(i), 0);
    }
    back.set_time_s(t + 0.1);
    p = service_.answer(back);
    // From 2 s on it is at rest.
    EXPECT_NEAR(p.pdf_direction_per_sr(0), t < 2 ? 0 : 1 / (4 * kPi), 1e-7);
  }
}

TEST_F(MotionServiceTest, SurfacesHideAndEmitAtTheirPlaceAtTheTime) {
  const std::string scene = service_.load("moving_surfaces.pbrt");
  const auto lights = service_.answer(about<v1::ListLightsRequest>(scene));
  ASSERT_EQ(lights.lights_size(), 1);
  // At the first key frame.
  EXPECT_NEAR(lights.lights(0).bounds().lower_m().x(), 9.5, 1e-5);
  EXPECT_NEAR(lights.lights(0).bounds().upper_m().x(), 10.5, 1e-5);
  EXPECT_NEAR(lights.lights(0).bounds().lower_m().z(), 1, 1e-5);
  EXPECT_NEAR(lights.lights(0).area_m2(), kPi / 4, 1e-6);
  EXPECT_EQ(lights.lights(0).motion().key_frames(0).position_m().z(), 1);
  EXPECT_EQ(lights.lights(0).motion().key_frames(1).position_m().z(), 3);

  auto visible = about<v1::TestVisibilityRequest>(scene);
  set(visible.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 0);
  set(visible.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 3);
  auto le = about<v1::LeRequest>(scene);
  set(le.mutable_points()->mutable_offsets_m(), 10, 0, 0, 10, 0, 2.5);
  set(le.mutable_directions(), 0, 0, 1, 0, 0, 1);
  auto meter = about<v1::EstimateIrradianceRequest>(scene);
  meter.set_bounces(0);
  meter.mutable_accuracy()->set_samples(4096);
  set(meter.mutable_receivers()->mutable_offsets_m(), 10, 0, 0);
  set(meter.mutable_normals(), 0, 0, 1);
  for (const double t : {0.0, 1.0, 2.0}) {
    visible.set_time_s(t);
    le.set_time_s(t);
    meter.set_time_s(t);
    const auto v = service_.answer(visible);
    const auto l = service_.answer(le);
    const auto e = service_.answer(meter);
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
  auto q = about<v1::RenderTileRequest>(point_);
  set_rect(&q, 4, 2);
  q.mutable_accuracy()->set_samples(1024);
  auto image = about<v1::RenderImageRequest>(point_);
  image.set_final_only(true);
  image.mutable_accuracy()->set_samples(1024);
  // Radiance at reflectance 0.5 is 0.5 / pi of the illuminance.  All visible points lie within 2
  // mm.
  v1::RenderTileResponse r;
  for (const double t : {0.0, 0.75, 2.0}) {
    q.set_time_s(t);
    image.set_time_s(t);
    r = service_.answer(q);
    const double expected = 0.5 / kPi * illuminance(t);
    EXPECT_NEAR(mean_of(r.tile()), expected, 2e-3 * expected) << t;
    EXPECT_NEAR(mean_of_image(image), expected, 2e-3 * expected) << t;
  }
  q.clear_time_s();
  image.clear_time_s();
  // The mean of I h / (x^2 + h^2)^(3/2) over x from 0 to X: I / (h sqrt(X^2 + h^2)) = 18 / 15.
  // Over the shutter's interval, illuminance varies between 0.43 and 2.  Its standard deviation is
  // below 0.79, for 8192 samples below 0.0088.  Seven of that are exceeded by chance less than once
  // in 1e11.
  r = service_.answer(q);
  EXPECT_NEAR(mean_of(r.tile()), 0.5 / kPi * 1.2, 0.5 / kPi * 0.062);
  EXPECT_NEAR(mean_of_image(image), 0.5 / kPi * 1.2, 0.5 / kPi * 0.062);
}

TEST_F(MotionServiceTest, TimesThatAreNotFiniteAreNamed) {
  int queries = 0;
  for_each_query(point_, 1, [&](auto q) {
    if constexpr (requires { q.set_time_s(NAN); }) {
      ++queries;
      for (const double bad : {double{NAN}, double{INFINITY}, -double{INFINITY}}) {
        q.set_time_s(bad);
        expect_bad_field(service_.status(q), "time_s");
      }
    }
  });
  EXPECT_EQ(queries, 10);  // all but EstimatePower
}

}  // namespace
}  // namespace lucerna::testing
