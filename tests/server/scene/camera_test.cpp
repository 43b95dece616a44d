#include "server/scene/camera.h"

#include <gtest/gtest.h>

namespace lucerna {
namespace {

// From (1, 2, 3) along +y, +z up; 90 degrees wide, half as high.  Camera space is left-handed.  So
// its +x, right in the picture, is cross(up, forward) = -x of the world.
Camera camera(const Vec3<double>& origin = {}) {
  PerspectiveCamera c;
  c.world_from_camera = *Transform::look_at({1, 2, 3}, {1, 7, 3}, {0, 0, 1});
  c.screen_min = {-1, -0.5};
  c.screen_max = {1, 0.5};
  return {c, {.width = 200, .height = 100, .scale = 2}, origin};
}

void expect_direction(const Ray& ray, Vec3<double> expected) {
  expected = normalized(expected);
  EXPECT_NEAR(ray.direction.x, expected.x, 1e-7);
  EXPECT_NEAR(ray.direction.y, expected.y, 1e-7);
  EXPECT_NEAR(ray.direction.z, expected.z, 1e-7);
  EXPECT_NEAR(length(ray.direction), 1, 1e-7);
}

TEST(Camera, TheAxisPassesTheCentreOfThePicture) {
  expect_direction(camera().ray(100, 50), {0, 1, 0});
}

TEST(Camera, HasTheUpperLeftCornerAtZeroZero) {
  expect_direction(camera().ray(0, 0), {1, 1, 0.5});
  expect_direction(camera().ray(200, 0), {-1, 1, 0.5});
  expect_direction(camera().ray(0, 100), {1, 1, -0.5});
}

TEST(Camera, PositionIsRelativeToTheScenesOrigin) {
  const Ray ray = camera({1e6, 0, 0}).ray(3, 4);
  EXPECT_EQ(ray.origin, (Vec3<float>{-999999, 2, 3}));
  EXPECT_EQ(ray.direction, camera().ray(3, 4).direction);
}

TEST(Camera, HasFilmSizeAndScale) {
  EXPECT_EQ(camera().width(), 200);
  EXPECT_EQ(camera().height(), 100);
  EXPECT_EQ(camera().film_scale(), 2);
}

}  // namespace
}  // namespace lucerna
