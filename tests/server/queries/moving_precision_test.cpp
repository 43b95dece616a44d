// Moving surfaces where rounding is noticeable.  Some are far from their own zero but near the
// scene's.  Some are small in a large scene.  In others the t of rays has another unit in the
// object.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "tests/server/estimate/moving_shapes.h"
#include "tests/server/queries/li_samples.h"

namespace lucerna::testing {
namespace {

const Transform kTilt = *Transform::rotate(0.7, {1, 2, 0.5});
const Transform kStart = *Transform::rotate(1.1, {-1, 0.3, 2});

std::array<Vec3, 4> corners() {
  return {kStart.point({-64, -64, 0}), kStart.point({64, -64, 0}), kStart.point({-64, 64, 0}),
          kStart.point({64, 64, 0})};
}

/// A square of 128 m about its own zero.  A second later its corner is at the scene's zero, with
/// its sides along kTilt's x and y.  Coordinates near that corner are exact in the scene.  The
/// square's own coordinates there are rounded by 4e-6 m.
ShapeDescription moved_there(ShapeDescription s) {
  s.motion = moving({{0, kStart}, {1, kTilt * Transform::translate({64, 64, 0})}});
  return s;
}

ShapeDescription plate() {
  const auto c = corners();
  return moved_there(patch(c[0], c[1], c[2], c[3]));
}

/// The same as triangles, which Embree intersects itself.
ShapeDescription plate_of_triangles() {
  const auto c = corners();
  return moved_there(shape(TriangleMeshData{{c[0], c[1], c[2], c[3]}, {}, {0, 1, 3, 0, 3, 2}}));
}

Vec3 normal_then() { return kTilt.vector({0, 0, 1}); }

/// Points of the plate near its corner, a second later, x y z interleaved.
std::vector<float> points_of_corner(int count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(0.01, 0.5);
  std::vector<float> points;
  for (int i = 0; i < count; ++i) {
    const Vec3f p(kTilt.point({u(random), u(random), 0}));
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

std::vector<float> repeated(const Vec3& v, int count) {
  std::vector<float> all;
  for (int i = 0; i < count; ++i)
    for (const double c : {v.x, v.y, v.z}) all.push_back(static_cast<float>(c));
  return all;
}

int bits_of(const std::vector<std::uint8_t>& bytes) {
  int sum = 0;
  for (std::uint8_t b : bytes)
    for (; b != 0; b &= static_cast<std::uint8_t>(b - 1)) ++sum;
  return sum;
}

TEST(MovingPrecision, PositionsAreWithinTheirReportedErrors) {
  for (const ShapeDescription& s : {plate(), plate_of_triangles()}) {
    const auto scene = scene_of(s);
    ASSERT_EQ(scene->origin(), Vec3{});
    const Vec3 n = normal_then();
    std::mt19937 random(5);
    std::uniform_real_distribution<double> u(0.01, 0.5);
    int hits = 0;
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 to = kTilt.point({u(random), u(random), 0});
      const Vec3 from = to + n * (1 + u(random)) + Vec3{u(random), u(random), u(random)};
      Ray ray{Vec3f(from), Vec3f(to - from)};
      ray.time_s = 1;
      const auto hit = scene->closest_hit(ray);
      if (!hit) continue;
      ++hits;
      const double off = std::fabs(dot(Vec3(hit->position), n));
      const Vec3f& e = hit->position_error;
      EXPECT_LE(off, std::fabs(n.x) * e.x + std::fabs(n.y) * e.y + std::fabs(n.z) * e.z);
      worst = std::fmax(worst, off);
    }
    EXPECT_EQ(hits, 2000);
    // The rounding must be noticeable, so that the bound is tested.  Positions themselves are
    // rounded by at most 6e-8 m.
    EXPECT_GT(worst, 2e-7);
  }
}

TEST(MovingPrecision, RaysFromPointsOnThemDoNotMeetThem) {
  constexpr int kPoints = 200;
  const std::vector<float> points = points_of_corner(kPoints);
  const std::vector<float> normals = repeated(normal_then(), kPoints);
  for (const ShapeDescription& s : {plate(), plate_of_triangles()}) {
    const auto scene = scene_of(s);
    const Vec3 along = kTilt.vector({3, 2, 1});
    for (const Vec3& towards : {normal_then() * 2.0, along}) {
      const std::vector<float> directions = repeated(towards, kPoints);
      std::vector<std::uint8_t> visible((kPoints + 7) / 8);
      std::vector<int> status(kPoints);
      test_visibility(
          *scene, {.from = {{}, points}, .directions = directions, .normals = normals, .time_s = 1},
          {visible.data(), nullptr, status.data()}, {});
      EXPECT_EQ(bits_of(visible), kPoints);
    }
  }
}

TEST(MovingPrecision, PointsOnThemSeeLightsInFrontOfThem) {
  constexpr int kPoints = 200;
  const std::vector<float> points = points_of_corner(kPoints);
  const std::vector<float> normals = repeated(normal_then(), kPoints);
  SceneDescription d = description();
  d.shapes = {plate()};
  d.lights = {point_light(kTilt.point({4, 3, 1}), 5)};
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->origin(), Vec3{});
  SampleLiQuery q;
  q.receivers = {{}, points};
  q.light = 0;
  q.seed = SeedRange{};
  q.test_visibility = true;
  q.normals = normals;
  q.time_s = 1;
  EXPECT_EQ(bits_of(LiSamples(*scene, q).visible), kPoints);
}

// A light far from its own zero must not shadow itself.  The receivers are a few centimetres in
// front of its corner, and samples lie there too.
TEST(MovingPrecision, LightsDoNotHideTheirOwnPoints) {
  constexpr int kReceivers = 100;
  constexpr std::uint32_t kSamples = 16;
  std::vector<float> receivers = points_of_corner(kReceivers);
  const Vec3f up(normal_then() * 0.02);
  for (std::size_t i = 0; i < receivers.size(); i += 3)
    receivers[i] += up.x, receivers[i + 1] += up.y, receivers[i + 2] += up.z;
  for (const ShapeDescription& shape : {plate(), plate_of_triangles()}) {
    const auto scene = scene_of(emissive(shape, 1, true));
    ASSERT_EQ(scene->origin(), Vec3{});
    SampleLiQuery q;
    q.receivers = {{}, receivers};
    q.samples = kSamples;
    q.light = 0;
    q.seed = SeedRange{};
    q.test_visibility = true;
    q.time_s = 1;
    q.methods.area_sampling = AreaSampling::kSolidAngle;
    const LiSamples s(*scene, q);
    int near = 0, hidden = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      ASSERT_TRUE(s.is_ok(i));
      near += s.distance_m[i] < 0.1F ? 1 : 0;
      hidden += s.is_visible(i) ? 0 : 1;
    }
    EXPECT_GT(near, 500);
    EXPECT_EQ(hidden, 0);
  }
}

// Inside the object t has another unit.
TEST(MovingPrecision, RaysKeepTheirEnds) {
  for (const Kind& kind : {kinds()[0], kinds()[3]}) {
    SCOPED_TRACE(kind.name);
    ShapeDescription s = kind.make({});
    if (auto* sphere = std::get_if<SphereParams>(&s.geometry)) *sphere = SphereParams{};
    s.motion = sliding({8, 0, 0}, 2);
    const auto scene = scene_of(s);
    // From 5 m above the centre of a ball of radius 1.  The ray enters it at 4 m and leaves at 6.
    const Vec3 from = Vec3{4.05, 0.1, 5} - scene->origin();
    const double sag = kind.name == std::string("mesh") ? 0.1 : 0.02;
    for (const float length : {1e-3F, 0.3F, 1.F, 7.F, 1e3F}) {
      const auto hit_m = [&](float begin_m, float end_m) {
        Ray ray{Vec3f(from), {0, 0, -length}, begin_m / length, end_m / length};
        ray.time_s = 1;
        const auto hit = scene->closest_hit(ray);
        EXPECT_EQ(scene->geometry().occluded(ray), hit.has_value())
            << begin_m << " " << end_m << " " << length;
        return hit ? hit->t * length : -1;
      };
      EXPECT_NEAR(hit_m(0, 9), 4, sag) << length;
      EXPECT_NEAR(hit_m(3.5F, 4.5F), 4, sag) << length;
      EXPECT_EQ(hit_m(0, 3.5F), -1) << length;
      EXPECT_NEAR(hit_m(4.5F, 9), 6, sag) << length;
      EXPECT_EQ(hit_m(4.5F, 5.5F), -1) << length;
      EXPECT_EQ(hit_m(6.5F, 9), -1) << length;
    }
  }
}

// A nanometre in a scene of ten kilometres.
TEST(MovingPrecision, SpecksInALargeSceneAreFound) {
  constexpr double kRadius = 1e-9;
  SceneDescription d = description();
  d.shapes.push_back(floor(5000, -1));
  d.shapes.push_back(shape(ball(2, [](const Vec3& p) { return p * kRadius; })));
  d.shapes.back().motion = sliding({8e-8, 0, 0}, 1);
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->origin(), Vec3{});
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-0.6 * kRadius, 0.6 * kRadius);
  for (int i = 0; i < 200; ++i) {
    const double x = u(random), y = u(random);
    Ray ray{Vec3f(Vec3{4e-8 + x, y, 1e-8}), {0, 0, -1}};
    ray.time_s = 0.5;
    const auto hit = scene->closest_hit(ray);
    ASSERT_TRUE(hit);
    // Faces are up to a tenth of the radius inside of the ball.
    const double top = std::sqrt(kRadius * kRadius - x * x - y * y);
    EXPECT_LE(1e-8 - hit->t, top + 1e-3 * kRadius);
    EXPECT_GE(1e-8 - hit->t, top - 0.2 * kRadius);
    // The ball is convex, so no ray that leaves it meets it again, at any angle.
    const Frame frame = Frame::around(hit->ng);
    for (int k = 0; k < 64; ++k) {
      const double phi = 0.1 * k, up = std::exp2(-k / 4.0);
      Ray away =
          spawn_ray(*hit, Vec3f(frame.s * std::cos(phi) + frame.t * std::sin(phi) + frame.n * up));
      away.t_max = 1e-6F;  // not the floor
      EXPECT_FALSE(scene->geometry().occluded(away)) << up;
    }
  }
}

TEST(MovingPrecision, RaysSeeTheirOwnTime) {
  SceneDescription d = description();
  d.shapes.push_back(floor(0.5, 1.5));
  d.shapes.back().motion = sliding({8, 0, 0}, 2);
  const auto scene = build(std::move(d));
  const std::vector<float> from{0, 0, 0, 4, 0, 0}, up{0, 0, 1, 0, 0, 1};
  for (const double t : {0.0, 1.0, 2.0}) {
    std::uint8_t visible = 0;
    int status[2];
    test_visibility(*scene, {.from = {{}, from}, .directions = up, .time_s = t},
                    {&visible, nullptr, status}, {});
    EXPECT_EQ(visible, t == 0 ? 2 : t == 1 ? 1 : 3) << t;
  }
}

// Reflected light comes from the place of the surface at that time.
TEST(MovingPrecision, BouncesStartAtTheSurfaceOfThatTime) {
  const auto scene_at = [](double t, bool moves) {
    SceneDescription d = description(0.9);
    // First the surface is above the meter and the lamp between them; later it is 40 m aside.
    d.shapes.push_back(floor(1, 1));
    if (moves)
      d.shapes.back().motion = sliding({40, 0, 0}, 1);
    else
      for (auto& p : std::get<PatchMeshData>(d.shapes.back().geometry).positions) p.x += 40 * t;
    d.shapes.push_back(floor(0.1, -3));
    d.lights.push_back(point_light({0.2, 0, 0.5}, 10));
    return build(std::move(d));
  };
  const auto scene = scene_at(0, true);
  for (const double t : {0.0, 0.02, 1.0}) {
    const auto of = [&](const Scene& s, double time_s) {
      const std::vector<IrradiancePoint> meter{{-s.origin(), {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}}};
      return estimate_irradiance(
                 s, meter,
                 {.samples_per_block = 64, .block_count = 64, .bounces = 1, .time_s = time_s}, {})
          .points[0];
    };
    const auto moved = of(*scene, t), still = of(*scene_at(t, false), 0);
    const double error = std::hypot(moved.illuminance_error_lx, still.illuminance_error_lx);
    // Seven standard errors, which come from 64 blocks; exceeded by chance less than once in 1e8.
    EXPECT_NEAR(moved.irradiance_lx.g, still.irradiance_lx.g, 7 * error + 1e-4) << t;
    const double direct = 10 * 0.5 / std::pow(0.04 + 0.25, 1.5);
    if (t == 1)
      EXPECT_NEAR(moved.irradiance_lx.g, direct, 1e-3 * direct);
    else
      EXPECT_GT(moved.irradiance_lx.g, 1.05 * direct);
  }
}

}  // namespace
}  // namespace lucerna::testing
