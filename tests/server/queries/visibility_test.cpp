#include "server/queries/visibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using ::lucerna::testing::build;
using ::lucerna::testing::description;

struct Seen {
  std::vector<std::uint8_t> bits;
  std::vector<int> status;
  bool operator[](std::size_t i) const { return (bits[i / 8] >> (i % 8) & 1) != 0; }
};

Seen answer_to(const Scene& scene, const VisibilityQuery& query) {
  const std::size_t n = query.from.size();
  Seen seen{std::vector<std::uint8_t>((n + 7) / 8), std::vector<int>(n)};
  test_visibility(scene, query, {seen.bits.data(), nullptr, seen.status.data()}, {});
  return seen;
}

/// Walls of 2 m at z = 0 and z = 4.
std::shared_ptr<const Scene> two_walls() {
  SceneDescription d = description();
  d.shapes.push_back(testing::floor(1, 0));
  d.shapes.push_back(testing::floor(1, 4));
  return build(d);
}

TEST(TestVisibility, RaysEndAtTheirLength) {
  const std::vector<float> from{0, 0, 1, 0, 0, 1, 0, 0, 1};
  const std::vector<float> up{0, 0, 2, 0, 0, 0.5F, 0, 0, 7};
  const std::vector<float> lengths{2.99F, 3.01F, 3.01F};
  const Seen seen =
      answer_to(*two_walls(), {.from = {{}, from}, .directions = up, .lengths_m = lengths});
  EXPECT_TRUE(seen[0]);
  EXPECT_FALSE(seen[1]);
  EXPECT_FALSE(seen[2]);
  const Seen endless = answer_to(*two_walls(), {.from = {{}, from}, .directions = up});
  EXPECT_FALSE(endless[0]);
}

TEST(TestVisibility, SegmentsOfNoLengthAreVisible) {
  const std::vector<float> p{0, 0, 0};
  EXPECT_TRUE(answer_to(*two_walls(), {.from = {{}, p}, .to = PointArray{{}, p}})[0]);
}

TEST(TestVisibility, BadItemsAreMarkedAndDoNotFailOthers) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> from{0, 0, 1, inf, 0, 1, 0, 0, 1, 0, 0, 1};
  const std::vector<float> to{0, 0, 2, 0, 0, 2, 0, std::nanf(""), 2, 0, 0, 2};
  const Seen seen = answer_to(*two_walls(), {.from = {{}, from}, .to = PointArray{{}, to}});
  EXPECT_EQ(seen.status, (std::vector<int>{1, 7, 7, 1}));
  EXPECT_EQ(seen.bits[0], 0b1001);
  const std::vector<float> directions{0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  const std::vector<float> lengths{1, 1, 1, -1};
  const Seen rays =
      answer_to(*two_walls(), {.from = {{}, from}, .directions = directions, .lengths_m = lengths});
  EXPECT_EQ(rays.status, (std::vector<int>{1, 7, 7, 7}));
}

/// A tilted plane through `center` with half edge `scale`, and points on it as floats.
struct Tilted {
  std::shared_ptr<const Scene> scene;
  std::vector<float> points, normals, up, down;
};

Tilted tilted(double scale, const Vec3& center) {
  const Vec3 n = normalized(Vec3{0.3, -0.5, 0.8});
  const Frame frame = Frame::around(n);
  const auto at = [&](double s, double t) { return center + frame.s * s + frame.t * t; };
  SceneDescription d = description();
  d.shapes.push_back(
      testing::patch(at(-scale, -scale), at(scale, -scale), at(-scale, scale), at(scale, scale)));
  Tilted out{build(d), {}, {}, {}, {}};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.9 * scale, 0.9 * scale);
  for (int i = 0; i < 2000; ++i) {
    // Rounded like typed numbers.
    const Vec3f p(at(uniform(random), uniform(random)));
    // 30 degrees off the plane.
    const Vec3f w(normalized(n * 0.5 + frame.s * 0.866));
    out.points.insert(out.points.end(), {p.x, p.y, p.z});
    out.normals.insert(out.normals.end(), {float(n.x), float(n.y), float(n.z)});
    out.up.insert(out.up.end(), {w.x, w.y, w.z});
  }
  return out;
}

TEST(TestVisibility, PointsTypedOnASurfaceDoNotShadowThemselves) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    for (const Vec3& center : {Vec3{}, Vec3{3, 5, -7} * scale}) {
      const Tilted t = tilted(scale, center);
      VisibilityQuery query{.from = {{}, t.points}, .directions = t.up};
      const Seen free = answer_to(*t.scene, query);
      query.normals = t.normals;
      const Seen with_normal = answer_to(*t.scene, query);
      int hidden = 0, hidden_with_normal = 0;
      for (std::size_t i = 0; i < 2000; ++i) {
        hidden += free[i] ? 0 : 1;
        hidden_with_normal += with_normal[i] ? 0 : 1;
      }
      EXPECT_EQ(hidden, 0) << scale << " " << center.x;
      EXPECT_EQ(hidden_with_normal, 0) << scale << " " << center.x;
    }
  }
}

TEST(TestVisibility, PointsNearZeroOfALargeSurfaceDoNotShadowThemselves) {
  // Nearly 0 ulps of their own, on a plane that is rounded with vertices 1000 m away.  No height
  // of a corner is a float, so rounding moves the plane by more than the ulps of the points.
  SceneDescription d = description();
  const auto at = [](double x, double y) { return Vec3{x, y, x / 3 - y / 7}; };
  d.shapes.push_back(
      testing::patch(at(-900, -800), at(1100, -800), at(-900, 1200), at(1100, 1200)));
  const auto scene = build(d);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.01, 0.01);
  std::vector<float> points{0, 0, 0}, above{0, 0, 1}, below{0, 0, -1};
  std::vector<float> just_above{0, 0, 1e-3F}, just_below{0, 0, -1e-3F};
  for (int i = 1; i < 2000; ++i) {
    const Vec3f p(at(uniform(random), uniform(random)));
    points.insert(points.end(), {p.x, p.y, p.z});
    above.insert(above.end(), {p.x, p.y, p.z + 1});
    below.insert(below.end(), {p.x, p.y, p.z - 1});
    just_above.insert(just_above.end(), {p.x, p.y, p.z + 1e-3F});
    just_below.insert(just_below.end(), {p.x, p.y, p.z - 1e-3F});
  }
  const Seen to = answer_to(*scene, {.from = {{}, points}, .to = PointArray{{}, above}});
  const Seen from = answer_to(*scene, {.from = {{}, below}, .to = PointArray{{}, points}});
  const Seen through =
      answer_to(*scene, {.from = {{}, just_below}, .to = PointArray{{}, just_above}});
  int hidden = 0, through_count = 0;
  for (std::size_t i = 0; i < 2000; ++i) {
    hidden += (to[i] ? 0 : 1) + (from[i] ? 0 : 1);
    through_count += through[i] ? 1 : 0;
  }
  EXPECT_EQ(hidden, 0);
  EXPECT_EQ(through_count, 0);
}

TEST(TestVisibility, APointAtZeroDoesNotShadowItselfAtAnyScale) {
  const std::vector<float> from{0, 0, 0};
  for (const int exponent : {-66, -40, -20, -10, 0, 20, 40}) {
    const double scale = std::ldexp(1.0, exponent);
    SceneDescription d = description();
    d.shapes.push_back(testing::floor(scale, 0));
    const auto scene = build(d);
    const std::vector<float> to{0.3F * float(scale), 0.2F * float(scale), 0.5F * float(scale)};
    EXPECT_TRUE(answer_to(*scene, {.from = {{}, from}, .to = PointArray{{}, to}})[0]) << exponent;
    EXPECT_TRUE(answer_to(*scene, {.from = {{}, from}, .directions = to})[0]) << exponent;
  }
}

TEST(TestVisibility, AWallCloseToAPointAtZeroHides) {
  // The point lies on the floor at zero, but not on the surface a tenth of a millimetre above.
  SceneDescription d = description();
  d.shapes.push_back(testing::floor(1, 0));
  d.shapes.push_back(testing::floor(1, 1e-4));
  const std::vector<float> from{0, 0, 0}, up{0, 0, 1}, down{0, 0, -1};
  const auto scene = build(d);
  EXPECT_FALSE(answer_to(*scene, {.from = {{}, from}, .directions = up})[0]);
  EXPECT_TRUE(answer_to(*scene, {.from = {{}, from}, .directions = down})[0]);
}

TEST(TestVisibility, WithoutAnyErrorSomePointsWouldShadowThemselves) {
  const Tilted t = tilted(1, {3, 5, -7});
  const Seen seen =
      answer_to(*t.scene, {.from = {{}, t.points}, .directions = t.up, .position_error_m = 0.0F});
  int hidden = 0;
  for (std::size_t i = 0; i < 2000; ++i) hidden += seen[i] ? 0 : 1;
  EXPECT_GT(hidden, 100);  // about half lie below the plane
}

TEST(TestVisibility, TheOffsetDoesNotLeakThroughThinWalls) {
  // A second plane behind the first, at a hundred default errors.
  SceneDescription d = description();
  const double gap = 100 * 4 * 1.1920929e-7;
  d.shapes.push_back(testing::floor(1, 0));
  d.shapes.push_back(testing::floor(1, gap));
  const auto scene = build(d);
  const std::vector<float> from{0.5F, 0.5F, 0}, up{0, 0, 1}, normal{0, 0, 1};
  EXPECT_FALSE(answer_to(*scene, {.from = {{}, from}, .directions = up})[0]);
  EXPECT_FALSE(answer_to(*scene, {.from = {{}, from}, .directions = up, .normals = normal})[0]);
}

}  // namespace
}  // namespace lucerna
