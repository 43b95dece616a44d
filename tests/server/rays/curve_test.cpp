// Curves: against cylinders, rectangles and dense samples of their axes; and rays that leave them.
#include "server/rays/curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lights/shapes/cylinder.h"
#include "server/visibility/shaft.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;
CubicCurve straight(const Vec3& from, const Vec3& to, double width) {
  return {{from, from + (to - from) / 3.0, from + (to - from) * (2.0 / 3), to}, width, width, {}};
}

/// A quarter of a turn and more, thick enough to see its bend.
CubicCurve bent(double width) {
  return {{Vec3{-1, 0, 0}, {-1, 0, 1.5}, {1, 0.5, 1.5}, {1, 0.5, 0}}, width, width / 2, {}};
}

class Random {
 public:
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vec3 in_cube(double half) { return {in(-half, half), in(-half, half), in(-half, half)}; }
  Vec3 direction() {
    for (;;)
      if (const Vec3 v = in_cube(1); dot(v, v) < 1 && dot(v, v) > 0.01) return normalized(v);
  }

 private:
  std::mt19937 engine_{1};
};

/// The first hit on any piece.
std::optional<ShapeHit> first_hit(const std::vector<CurvePiece>& pieces, const Vec3& o,
                                  const Vec3& d) {
  std::optional<ShapeHit> best;
  for (const CurvePiece& piece : pieces)
    if (const auto hit = piece.intersect(o, d, 0, best ? best->t : 1e30)) best = hit;
  return best;
}

// The hit is at the axis, so within the radius of the cylinder's own hit across the axis.
TEST(Curve, StraightTubeHidesWhatACylinderHides) {
  const auto tube = pieces_of(straight({0, 0, -40}, {0, 0, 40}, 0.5), CurveKind::kCylinder, {});
  EXPECT_EQ(tube.size(), 4U);
  const auto cylinder = *Cylinder::create({.radius_m = 0.25, .z_min_m = -40, .z_max_m = 40});
  Random random;
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 o = random.direction() * random.in(1.5, 30);
    if (std::hypot(o.x, o.y) < 0.5) continue;
    const Vec3 d = (random.in_cube(0.8) - o) * random.in(0.1, 3);
    const auto expected = cylinder.intersect(o, d, 0, 1e30);
    const auto hit = first_hit(tube, o, d);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << i;
    if (!hit) continue;
    ++hits;
    const Vec3 p = hit->point.position;
    EXPECT_LE(std::hypot(p.x, p.y), 0.25 + 1e-9);
    EXPECT_NEAR(p.x * d.x + p.y * d.y, 0, 1e-7 * dot(d, d));  // nearest to the axis
    EXPECT_LT(dot(hit->point.normal, d), 1e-9 * length(d));
  }
  EXPECT_GT(hits, 5000);
}

TEST(Curve, StraightRibbonIsARectangle) {
  CubicCurve strip = straight({0, -2, 0.5}, {0, 2, 0.5}, 0.6);
  strip.normals = {Vec3{0, 0, 1}, Vec3{0, 0, 1}};
  const auto ribbon = pieces_of(strip, CurveKind::kRibbon, {});
  Random random;
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 o = random.in_cube(3), d = random.direction();
    if (std::fabs(d.z) < 1e-3) continue;
    const double t = (0.5 - o.z) / d.z;
    const Vec3 p = o + d * t;
    const double edge = std::max(std::fabs(p.x) - 0.3, std::fabs(p.y) - 2);
    if (std::fabs(edge) < 1e-6 || std::fabs(t) < 1e-6) continue;
    const auto hit = first_hit(ribbon, o, d);
    ASSERT_EQ(hit.has_value(), t > 0 && edge < 0) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_LT(length(hit->point.position - p), 1e-8);
    EXPECT_LT(length(hit->point.normal - Vec3{0, 0, 1}), 1e-9);
  }
  EXPECT_GT(hits, 300);
}

// A flat curve turns to each ray: a ray hits it if the axis is within half the width, at the axis.
TEST(Curve, FlatCurveFacesEveryRay) {
  const auto flat = pieces_of(straight({0, 0, -1}, {0, 0, 1}, 0.2), CurveKind::kFlat, {});
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const double angle = random.in(0, 6.28), aside = random.in(-0.3, 0.3);
    const Vec3 towards{-std::cos(angle), -std::sin(angle), 0}, across{towards.y, -towards.x, 0};
    const Vec3 o = towards * -5.0 + across * aside + Vec3{0, 0, random.in(-0.99, 0.99)};
    const auto hit = first_hit(flat, o, towards);
    ASSERT_EQ(hit.has_value(), std::fabs(aside) <= 0.1) << aside;
    if (!hit) continue;
    EXPECT_NEAR(hit->t, 5, 1e-12);
    EXPECT_LT(length(hit->point.normal + towards), 1e-9);
  }
}

// Dense samples of the axis, to find distances without the curve's own search.
TEST(Curve, BentCurveIsHitByRaysNearItsAxis) {
  const CubicCurve curve = bent(0.3);
  const auto tube = pieces_of(curve, CurveKind::kCylinder, {});
  std::vector<std::pair<Vec3, double>> axis;
  for (const CurvePiece& piece : tube)
    for (int i = 0; i <= 2000; ++i) axis.push_back({piece.at(i / 2e3), piece.radius_m(i / 2e3)});
  Random random;
  int hits = 0, misses = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 o = random.direction() * 4, d = normalized(random.in_cube(1.2) - o);
    double outside = 1e30;
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < axis.size(); ++k) {
      const double to_ray = length(cross(axis[k].first - o, d)) - axis[k].second;
      if (to_ray < outside) outside = to_ray, nearest = k;
    }
    // Where the ends or the edges decide, the samples do not.
    if (std::fabs(outside) < 1e-3 || nearest < 900 || nearest + 900 > axis.size()) continue;
    const auto hit = first_hit(tube, o, d);
    ASSERT_EQ(hit.has_value(), outside < 0) << i << " " << outside;
    ++(hit ? hits : misses);
  }
  EXPECT_GT(hits, 100);
  EXPECT_GT(misses, 200);
}

TEST(Curve, PiecesJoinWithoutGaps) {
  for (const CurveKind kind : {CurveKind::kFlat, CurveKind::kCylinder, CurveKind::kRibbon}) {
    CubicCurve curve = bent(0.1);
    curve.normals = {Vec3{0, 1, 0}, Vec3{0, 1, 0}};
    const auto pieces = pieces_of(curve, kind, {});
    for (int i = 1; i < 4; ++i) {
      EXPECT_LT(length(pieces[i - 1].at(1) - pieces[i].at(0)), 1e-15);
      EXPECT_EQ(pieces[i - 1].radius_m(1), pieces[i].radius_m(0));
      const Vec3 joint = pieces[i].at(0);
      Random random;
      for (int k = 0; k < 500; ++k) {
        Vec3 d = random.direction();
        if (std::fabs(d.y) < 0.3) continue;  // a ribbon is thin from the side
        EXPECT_TRUE(first_hit(pieces, joint - d * 2.0, d)) << i << " " << k;
      }
    }
  }
}

// As in pbrt-v4, whose tubes look like the inside of half a pipe: light from the left is on the
// right.
TEST(Curve, NormalOfATubeTurnsEvenlyOverItsWidth) {
  const auto tube = pieces_of(straight({0, 0, -1}, {0, 0, 1}, 2), CurveKind::kCylinder, {});
  for (const double aside : {-0.9, -0.5, 0.0, 0.3, 0.8}) {
    Vec2 uv;
    const auto hit = tube[0].intersect({aside, -5, 0}, {0, 1, 0}, 0, 100, &uv);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(uv.x, 0.5, 1e-9);
    EXPECT_NEAR(std::atan2(hit->point.normal.x, -hit->point.normal.y), -kPi / 2 * aside, 1e-9);
    EXPECT_NEAR(hit->point.normal.z, 0, 1e-12);
  }
}

ShapeDescription shape_of(const CubicCurve& c, CurveKind kind) {
  return testing::shape(CurveData{.kind = kind,
                                  .points = {c.points.begin(), c.points.end()},
                                  .start_width_m = c.start_width_m,
                                  .end_width_m = c.end_width_m,
                                  .normals = {c.normals.begin(), c.normals.end()}});
}

/// Rays from hits on a straight curve, on the side of their normals, and their number that hits the
/// curve again; then rays back to each hit from just outside, and those that miss it.
struct Spawned {
  int rays = 0, again = 0, lost = 0;
};

Spawned spawn(const Scene& scene, const Vec3& middle, double size) {
  Random random;
  Spawned count;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 o = middle + random.direction() * (size * random.in(1, 4)) - scene.origin();
    const Vec3 target = middle + random.in_cube(size * 0.5) - scene.origin();
    const auto hit = scene.closest_hit({Vec3f(o), Vec3f(target - o)});
    if (!hit) continue;
    const Vec3 side = dot(hit->ng, o - hit->position) < 0 ? -hit->ng : hit->ng;
    Vec3 d = random.direction();
    if (i % 3 == 0) d = d - side * dot(d, side) * 0.999;  // nearly along the surface
    if (dot(d, side) < 0) d = -d;
    ++count.rays;
    count.again += scene.geometry().occluded(spawn_ray(*hit, Vec3f(d)));
    Ray back = spawn_ray(*hit, Vec3f(side));
    back.direction = Vec3f(-side);
    count.lost += !scene.geometry().occluded(back);
  }
  return count;
}

TEST(Curve, RaysThatLeaveDoNotHitItAgainAndRaysBackAreNotLost) {
  for (const CurveKind kind : {CurveKind::kFlat, CurveKind::kCylinder, CurveKind::kRibbon})
    for (const double width : {1e-3, 1e-2, 0.3})
      for (const Vec3& middle : {Vec3{0, 0, 0}, Vec3{3, -7, 11}, Vec3{4000, 5000, -6000}}) {
        CubicCurve curve =
            straight(middle - Vec3{0.5, 0.3, 0.2}, middle + Vec3{0.5, 0.3, 0.2}, width);
        curve.normals = {normalized(Vec3{-0.3, 0.5, 0}), normalized(Vec3{-0.3, 0.5, 0})};
        SceneDescription d = testing::description();
        // A far triangle keeps the origin of the scene, so that floats round the curve's place.
        d.shapes = {shape_of(curve, kind), testing::floor(0.1, -9000)};
        const auto scene = build(std::move(d));
        const Spawned count = spawn(*scene, middle, std::max(width, 0.02));
        EXPECT_GT(count.rays, 20) << width;
        // The normal of a cylinder leans inwards, so some rays that leave it meet its other side.
        if (kind == CurveKind::kCylinder) {
          EXPECT_LT(count.again, 0.1 * count.rays);
        } else {
          EXPECT_EQ(count.again, 0)
              << "kind " << int(kind) << " width " << width << " of " << count.rays;
        }
        // Floats round the start of a ray, which may move it past an edge.
        const double at_edges = 8 * kFloatRoundoff * (1 + max_abs(middle)) / width;
        EXPECT_LE(count.lost, std::ceil(at_edges * count.rays))
            << "kind " << int(kind) << " width " << width << " of " << count.rays;
      }
}

TEST(Curve, HitsOfObjectsAreInTheirPlace) {
  const Ray down{{0, 0, 5}, {0, 0, -1}};
  SceneDescription d = testing::description();
  d.objects = {{"tube", {shape_of(straight({-1, 0, 0}, {1, 0, 0}, 1), CurveKind::kCylinder)}}};
  d.instances = {{0, Transform::translate({0, 0, 1}) * *Transform::scale({2, 2, 2})}};
  const auto placed = build(d);
  const auto hit = placed->closest_hit(down);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->position.z + placed->origin().z, 1, 1e-6);
  EXPECT_NEAR(hit->ng.z, 1, 1e-6);
  EXPECT_FALSE(placed->geometry().occluded({{0, 1.01F, 5}, {0, 0, -1}}));
  EXPECT_TRUE(placed->geometry().occluded({{0, 0.99F, 5}, {0, 0, -1}}));
  EXPECT_EQ(placed->geometry().primitive_count(), 1U);
}

TEST(Curve, MovesWithItsShape) {
  const std::vector<KeyTransform> keys{{0, Transform()}, {1, Transform::translate({0, 4, 0})}};
  SceneDescription d = testing::description();
  d.shapes = {shape_of(straight({-1, 0, 0}, {1, 0, 0}, 0.5), CurveKind::kCylinder)};
  d.shapes[0].motion = std::make_shared<const Motion>(*Motion::create(keys));
  const auto scene = build(d);
  for (const double time_s : {0.0, 0.5, 1.0})
    for (const double y : {0.0, 2.0, 4.0}) {
      const Vec3 o = Vec3{0, y + 0.2, 5} - scene->origin();
      Ray ray{Vec3f(o), {0, 0, -1}};
      ray.time_s = time_s;
      EXPECT_EQ(scene->geometry().occluded(ray), y == 4 * time_s) << time_s << " " << y;
    }
}

TEST(Curve, BlocksShafts) {
  SceneDescription d = testing::description();
  const Vec3 a{-0.2, -0.2, 2}, b{-0.2, 0.2, 2}, c{0.2, -0.2, 2}, e{0.2, 0.2, 2};
  d.shapes = {testing::floor(1), testing::emissive(testing::patch(a, b, c, e), 10),
              shape_of(straight({-1, 0.3, 1}, {1, 0.3, 1}, 0.02), CurveKind::kFlat)};
  const auto scene = build(std::move(d));
  const Shafts shafts(*scene);
  for (const double y : {-0.5, 0.0, 0.25, 0.35, 0.5, 0.7, 0.9}) {
    const auto receiver = scene->closest_hit({{0, float(y), 0.5F}, {0, 0, -1}});
    ASSERT_TRUE(receiver);
    // At half the height, the shaft reaches from (y - 0.2) / 2 to (y + 0.2) / 2.
    const bool blocked = (y - 0.2) / 2 < 0.31 && (y + 0.2) / 2 > 0.29;
    EXPECT_EQ(shafts.is_empty(*receiver, Vec3f(receiver->ns), 0), !blocked) << y;
  }
}

TEST(Curve, CountsItsBytesAndOnlyItsOwn) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(1)};
  const auto part = [](const Scene& scene) -> std::uint64_t {
    for (const ScenePart& p : scene.parts())
      if (p.name == "pieces of curves") return p.bytes;
    return 0;
  };
  EXPECT_EQ(part(*build(d)), 0U);
  for (const double width : {0.1, 0.2})
    d.shapes.push_back(shape_of(bent(width), CurveKind::kCylinder));
  const std::uint64_t bytes = part(*build(d));
  EXPECT_GE(bytes, 8 * sizeof(CurvePiece));
  EXPECT_LT(bytes, 17 * sizeof(CurvePiece));  // what a vector may keep for growth
}

}  // namespace
}  // namespace lucerna
