#include "server/scene/camera.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

namespace lucerna {
namespace {

// From (1, 2, 3) along +y, +z up; 90 degrees wide, half as high.  Camera space is left-handed.  So
// its +x, right in the picture, is cross(up, forward) = -x of the world.
Camera camera(const Vec3& origin = {}) {
  CameraDescription c;
  c.world_from_camera = *Transform::look_at({1, 2, 3}, {1, 7, 3}, {0, 0, 1});
  c.screen_min = {-1, -0.5};
  c.screen_max = {1, 0.5};
  return {c, {.width = 200, .height = 100, .scale = 2}, origin};
}

void expect_direction(const Ray& ray, Vec3 expected) {
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
  EXPECT_EQ(ray.origin, (Vec3f{-999999, 2, 3}));
  EXPECT_EQ(ray.direction, camera().ray(3, 4).direction);
}

// At (1, 2, 3), looking along +y; +z is up, and the picture's right is -x.
CameraDescription described(Projection projection, double lens_radius = 0) {
  CameraDescription c;
  c.world_from_camera = *Transform::look_at({1, 2, 3}, {1, 7, 3}, {0, 0, 1});
  c.projection = projection;
  c.screen_min = {-1, -0.5};
  c.screen_max = {1, 0.5};
  c.lens_radius = lens_radius;
  c.focal_distance = 4;
  return c;
}

constexpr int kWidth = 200, kHeight = 100;

Camera of(const CameraDescription& c, const Vec3& origin = {}) {
  return {c, {.width = kWidth, .height = kHeight}, origin};
}

void expect_point(const Vec3f& p, const Vec3& expected, double tolerance = 1e-6) {
  EXPECT_NEAR(p.x, expected.x, tolerance);
  EXPECT_NEAR(p.y, expected.y, tolerance);
  EXPECT_NEAR(p.z, expected.z, tolerance);
}

TEST(OrthographicCamera, HasParallelRaysFromItsPlane) {
  const Camera camera = of(described(Projection::kOrthographic));
  EXPECT_FALSE(camera.has_lens());
  for (const auto& [x, y] : {std::pair{0.0F, 0.0F}, {200.0F, 30.0F}, {100.0F, 50.0F}})
    expect_direction(camera.ray(x, y), {0, 1, 0});
  expect_point(camera.ray(100, 50).origin, {1, 2, 3});
  expect_point(camera.ray(0, 0).origin, {2, 2, 3.5});
  expect_point(camera.ray(200, 100).origin, {0, 2, 2.5});
  // Beside the film, for pixel filters.
  expect_point(camera.ray(-20, 100).origin, {2.2, 2, 2.5});
  const Camera far = of(described(Projection::kOrthographic), {1e6, 0, 0});
  expect_point(far.ray(0, 0).origin, {2 - 1e6, 2, 3.5}, 0.07);
}

// Scale in the camera's transform is that of its plane, as in pbrt-v4.
TEST(OrthographicCamera, ScalesWithItsTransform) {
  CameraDescription c = described(Projection::kOrthographic);
  c.world_from_camera = c.world_from_camera * *Transform::scale({3, 3, 3});
  expect_point(of(c).ray(0, 0).origin, {4, 2, 4.5});
  expect_direction(of(c).ray(0, 0), {0, 1, 0});
}

Vec3 point_at(const Ray& ray, double t) { return Vec3(ray.origin) + Vec3(ray.direction) * t; }

TEST(ThinLens, RaysOfAFilmPositionMeetInThePlaneOfFocus) {
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    const Camera camera = of(described(projection, 0.25));
    ASSERT_TRUE(camera.has_lens());
    for (const auto& [x, y] : {std::pair{0.0F, 0.0F}, {170.0F, 20.0F}, {100.0F, 50.0F}}) {
      const double size = projection == Projection::kPerspective ? 4 : 1;
      const Vec3 focus{1 - (x / 100 - 1) * size, 6, 3 + (0.5 - y / 100) * size};
      for (const float u : {0.0F, 0.3F, 0.99F}) {
        const Ray ray = camera.ray(x, y, 0, {u, 0.7F});
        const Vec3 p = point_at(ray, 4 / ray.direction.y);
        EXPECT_NEAR(p.x, focus.x, 3e-6);
        EXPECT_NEAR(p.y, 6, 3e-6);
        EXPECT_NEAR(p.z, focus.z, 3e-6);
      }
    }
  }
}

// A uniform disk of radius R: the mean square of the distance is R^2 / 2.
TEST(ThinLens, RaysLeaveADiskAroundTheCamera) {
  const Camera camera = of(described(Projection::kPerspective, 0.25));
  double squares = 0, largest = 0;
  constexpr int kEdge = 64;
  for (int i = 0; i < kEdge * kEdge; ++i) {
    const Ray ray = camera.ray(3, 90, 0,
                               {(static_cast<float>(i % kEdge) + 0.5F) / kEdge,
                                (static_cast<float>(i / kEdge) + 0.5F) / kEdge});
    EXPECT_NEAR(ray.origin.y, 2, 1e-6);
    const double r = std::hypot(ray.origin.x - 1, ray.origin.z - 3);
    squares += r * r;
    largest = std::max(largest, r);
  }
  EXPECT_NEAR(squares / (kEdge * kEdge), 0.25 * 0.25 / 2, 1e-4);
  EXPECT_LE(largest, 0.25 + 1e-6);
  EXPECT_GT(largest, 0.24);
}

TEST(ThinLens, CentreIsThePinhole) {
  const Ray lens = of(described(Projection::kPerspective, 0.25)).ray(31, 77);
  const Ray pinhole = of(described(Projection::kPerspective)).ray(31, 77);
  expect_point(lens.origin, Vec3(pinhole.origin));
  expect_direction(lens, Vec3(pinhole.direction));
}

TEST(ThinLens, FocusCanBeVeryFarOrNear) {
  for (const double distance : {1e-6, 1e30}) {
    CameraDescription c = described(Projection::kPerspective, 0.25);
    c.focal_distance = distance;
    for (const float u : {0.0F, 0.5F})
      EXPECT_NEAR(length(of(c).ray(0, 0, 0, {u, 0.5F}).direction), 1, 1e-6) << distance;
  }
}

// [Pharr23, 5.3]: the colatitude from +y grows downwards, the longitude from +x through +z.
TEST(SphericalCamera, EquirectangularHasUpAtTheTop) {
  const Camera camera = of(described(Projection::kEquirectangular));
  expect_direction(camera.ray(0, 0), {0, 0, 1});
  expect_direction(camera.ray(0, 100), {0, 0, -1});
  expect_direction(camera.ray(0, 50), {-1, 0, 0});
  expect_direction(camera.ray(50, 50), {0, 1, 0});
  expect_direction(camera.ray(100, 50), {1, 0, 0});
  expect_direction(camera.ray(50, 25), {0, 1, 1});
  // Beside the film: over the pole, and around.
  expect_direction(camera.ray(50, -25), {0, -1, 1});
  expect_direction(camera.ray(250, 50), {0, 1, 0});
  expect_point(camera.ray(20, 30).origin, {1, 2, 3});
}

// The inverse of the mapping, by its definition: latitude and longitude.
TEST(SphericalCamera, EquirectangularIsInvertible) {
  const Camera camera = of(described(Projection::kEquirectangular));
  for (float y = 0.5F; y < 100; y += 11)
    for (float x = 0.5F; x < 200; x += 13) {
      const Vec3 w(camera.ray(x, y).direction);
      const Vec3 local{-w.x, w.z, w.y};
      const double phi = std::atan2(local.z, local.x), theta = std::acos(local.y);
      EXPECT_NEAR((phi < 0 ? phi + 2 * M_PI : phi) / (2 * M_PI) * 200, x, 1e-3);
      EXPECT_NEAR(theta / M_PI * 100, y, 1e-3);
    }
}

TEST(SphericalCamera, EqualAreaHasUpInTheMiddle) {
  const Camera camera = of(described(Projection::kEqualArea));
  expect_direction(camera.ray(100, 50), {0, 0, 1});
  for (const float x : {0.0F, 200.0F})
    for (const float y : {0.0F, 100.0F}) expect_direction(camera.ray(x, y), {0, 0, -1});
  expect_direction(camera.ray(200, 50), {-1, 0, 0});  // right
  expect_direction(camera.ray(100, 100), {0, 1, 0});  // forward
  expect_direction(camera.ray(100, 0), {0, -1, 0});
}

// A rectangle of the picture has its share of all directions: those above 60 degrees are 0.067 of
// the sphere.  Inverting the mapping is not needed for that.
TEST(SphericalCamera, EqualAreaHasEqualAreas) {
  const Camera camera = of(described(Projection::kEqualArea));
  int above = 0, ahead = 0;
  constexpr int kEdge = 2000;
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      const Ray ray = camera.ray((static_cast<float>(x) + 0.5F) * kWidth / kEdge,
                                 (static_cast<float>(y) + 0.5F) * kHeight / kEdge);
      above += ray.direction.z > std::sqrt(0.75);
      ahead += ray.direction.y > 0.5;
    }
  EXPECT_NEAR(above / double(kEdge * kEdge), (1 - std::sqrt(0.75)) / 2, 2e-4);
  EXPECT_NEAR(ahead / double(kEdge * kEdge), 0.25, 1e-3);
}

// Pixel filters ask for positions beside the film.
TEST(SphericalCamera, EqualAreaGoesOnBesideTheFilm) {
  const Camera camera = of(described(Projection::kEqualArea));
  for (const float d : {0.01F, 30.0F, 250.0F})
    for (const float t : {10.0F, 73.0F}) {
      expect_direction(camera.ray(-d, t), Vec3(camera.ray(d, 100 - t).direction));
      expect_direction(camera.ray(200 + d, t), Vec3(camera.ray(200 - d, 100 - t).direction));
      expect_direction(camera.ray(t, -d), Vec3(camera.ray(200 - t, d).direction));
    }
  // Neighbours across the edge are neighbours on the sphere.
  EXPECT_LT(length(camera.ray(-0.01F, 10).direction - camera.ray(0.01F, 10).direction), 1e-2);
}

TEST(Camera, OfAnyKindRestsAtItsKeyFrames) {
  const Transform moved = Transform::translate({3, -2, 5}) * *Transform::rotate(1.2, {1, 2, 0.5});
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic,
                                      Projection::kEqualArea, Projection::kEquirectangular}) {
    CameraDescription start = described(projection, 0.2), moves = start, end = start;
    end.world_from_camera = moved * start.world_from_camera;
    const std::array<KeyTransform, 2> frames{
        {{0, start.world_from_camera}, {2, end.world_from_camera}}};
    moves.motion = std::make_shared<const Motion>(*Motion::create(frames));
    for (const Vec3& origin : {Vec3{}, Vec3{7, 8, 9}})
      for (const auto& [x, y] : {std::pair{0.0F, 0.0F}, {151.0F, 20.0F}}) {
        const Vec2f u{0.1F, 0.8F};
        const Ray at_start = of(start, origin).ray(x, y, 0, u),
                  at_end = of(end, origin).ray(x, y, 0, u);
        for (const double t : {-1.0, 0.0}) {
          const Ray first = of(moves, origin).ray(x, y, t, u);
          EXPECT_EQ(first.origin, at_start.origin);
          EXPECT_EQ(first.direction, at_start.direction);
        }
        for (const double t : {2.0, 1e9}) {
          const Ray last = of(moves, origin).ray(x, y, t, u);
          expect_point(last.origin, Vec3(at_end.origin), 2e-6);
          expect_direction(last, Vec3(at_end.direction));
          EXPECT_EQ(last.time_s, t);
        }
      }
  }
}

TEST(Camera, ShowsTheCropOfItsFilm) {
  const Film film{.width = 200, .height = 100, .crop = FilmCrop{20, 30, 100, 90}};
  const Camera camera(described(Projection::kPerspective), film, {});
  EXPECT_EQ(camera.width(), 80);
  EXPECT_EQ(camera.height(), 60);
  EXPECT_EQ(camera.film_width(), 200);
  EXPECT_TRUE(camera.is_cropped());
  // Positions are those of the film.
  expect_direction(camera.ray(100, 50), {0, 1, 0});
  EXPECT_FALSE(of(described(Projection::kPerspective)).is_cropped());
}

}  // namespace
}  // namespace lucerna
