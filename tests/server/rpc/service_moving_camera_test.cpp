// The moving camera and the requested shutter, in calls.
#include <cmath>
#include <limits>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

class MovingCameraServiceTest : public ::testing::Test {
 protected:
  MovingCameraServiceTest() {
    tile_.set_scene_id(scene_);
    set_rect(&tile_, 4, 2);
    tile_.mutable_accuracy()->set_samples(1024);
    image_.set_scene_id(scene_);
    image_.set_final_only(true);
    image_.mutable_accuracy()->set_samples(1024);
  }
  /// Radiance at reflectance 0.5 below the camera, while it is over x = 2 t: 0.5 / pi I h / d^3.
  static double radiance(double t) { return 0.5 / kPi * 18 * 3 / std::pow(4 * t * t + 9, 1.5); }
  /// The mean of that from `a` to `b` s.  I h / d^3 is the slope of I x / (h d).
  static double radiance(double a, double b) {
    const auto f = [](double x) { return 18 * x / (3 * std::sqrt(x * x + 9)); };
    return 0.5 / kPi * (f(2 * b) - f(2 * a)) / (2 * b - 2 * a);
  }
  /// Checks both kinds of picture.  All visible points lie within 2 mm.
  void expect_mean(double expected, double tolerance) {
    EXPECT_NEAR(mean_of(service_.answer(tile_).tile()), expected, tolerance);
    const auto sent = service_.answer(image_);
    ASSERT_FALSE(sent.empty());
    EXPECT_NEAR(mean_of(sent[0].tile()), expected, tolerance);
  }

  Service service_{scenes_in(test_data("pbrt"))};
  std::string scene_ = service_.load("moving_camera.pbrt");
  v1::RenderTileRequest tile_;
  v1::RenderImageRequest image_;
};

TEST_F(MovingCameraServiceTest, GetSceneReportsItsMotion) {
  auto q = about<v1::GetSceneRequest>(scene_);
  auto r = service_.answer(q);
  EXPECT_EQ(r.remarks_size(), 0);
  const v1::Motion& motion = r.summary().camera_motion();
  ASSERT_EQ(motion.key_frames_size(), 2);
  EXPECT_EQ(motion.key_frames(0).time_s(), 0);
  EXPECT_EQ(motion.key_frames(1).time_s(), 2);
  EXPECT_NEAR(motion.key_frames(0).position_m().x(), 0, 1e-12);
  EXPECT_NEAR(motion.key_frames(1).position_m().x(), 4, 1e-12);
  EXPECT_NEAR(motion.key_frames(1).position_m().z(), 2, 1e-12);
  EXPECT_NEAR(motion.key_frames(1).angle_rad(), 0, 1e-12);
  q.set_scene_id(service_.load("moving_point.pbrt"));  // the camera is at rest there
  r = service_.answer(q);
  EXPECT_FALSE(r.summary().has_camera_motion());
}

TEST_F(MovingCameraServiceTest, PicturesShowTheViewAtTheMoment) {
  for (const double t : {-1.0, 0.0, 0.75, 2.0, 5.0}) {
    tile_.set_time_s(t);
    image_.set_time_s(t);
    const double expected = radiance(std::min(std::max(t, 0.0), 2.0));
    expect_mean(expected, 2e-3 * expected);
  }
}

TEST_F(MovingCameraServiceTest, PicturesAreOfTheRequestedShutter) {
  // Between the shutter's ends, illuminance varies by less than 1.6.  Its standard deviation is
  // below 0.8, for 8192 samples below 0.0089.  Seven of that are exceeded by chance less than once
  // in 1e11.
  const double tolerance = 0.5 / kPi * 0.062;
  expect_mean(radiance(0, 2), tolerance);
  const auto shut = [&](double offset_s, std::optional<double> length_s) {
    for (v1::Shutter* s : {tile_.mutable_shutter(), image_.mutable_shutter()}) {
      s->set_offset_s(offset_s);
      if (length_s) s->set_length_s(*length_s);
      if (!length_s) s->clear_length_s();
    }
  };
  shut(0, {});
  expect_mean(radiance(0, 2), tolerance);
  shut(1, 0.5);
  expect_mean(radiance(1, 1.5), tolerance);
  shut(0.25, 0.25);
  expect_mean(radiance(0.25, 0.5), tolerance);
  shut(0.75, 0);  // an instant
  expect_mean(radiance(0.75), 2e-3 * radiance(0.75));
  // Two seconds longer: half of the time at its end.
  shut(1, {});
  expect_mean(0.5 * radiance(1, 2) + 0.5 * radiance(2), tolerance);
  shut(-2, {});
  expect_mean(radiance(0), 2e-3 * radiance(0));
  // As wide as the scene's own shutter: the same bits.
  const auto bits = [&] { return service_.answer(tile_).tile().sum(); };
  tile_.clear_shutter();
  const std::string plain = bits();
  shut(0, 2);
  EXPECT_EQ(bits(), plain);
  shut(0.5, 1);
  const std::string shifted = bits();
  EXPECT_EQ(bits(), shifted);
  EXPECT_NE(plain, shifted);
}

TEST_F(MovingCameraServiceTest, InvalidShuttersAreNamed) {
  const auto refused = [&](const v1::Shutter& shutter, const std::string& field) {
    *tile_.mutable_shutter() = shutter;
    *image_.mutable_shutter() = shutter;
    expect_bad_field(service_.status(tile_), field);
    expect_bad_field(service_.status(image_), field);
  };
  v1::Shutter shutter;
  for (const double bad : {double{NAN}, double{INFINITY}, -double{INFINITY}}) {
    shutter.set_offset_s(bad);
    refused(shutter, "shutter.offset_s");
  }
  shutter.set_offset_s(std::numeric_limits<double>::max());
  for (const double bad : {double{NAN}, double{INFINITY}, -1e-9, 1e308}) {
    shutter.set_length_s(bad);
    refused(shutter, "shutter.length_s");
  }
  shutter.set_offset_s(0);
  shutter.set_length_s(1);
  tile_.set_time_s(0);
  image_.set_time_s(0);
  refused(shutter, "shutter");
}

}  // namespace
}  // namespace lucerna::testing
