#include "server/rays/accelerator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "lights/shapes/triangle.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

std::unique_ptr<Accelerator> build_accelerator(GeometrySet set,
                                               std::vector<GeometrySet> objects = {},
                                               std::vector<GeometryInstance> instances = {}) {
  auto a = Accelerator::build(std::move(set), std::move(objects), std::move(instances), "", {});
  EXPECT_TRUE(a.ok()) << a.status();
  return *std::move(a);
}

GeometrySet triangle(float z) {
  return {.vertices = {{0, 0, z}, {1, 0, z}, {0, 1, z}}, .triangles = {0, 1, 2}};
}

Sphere sphere(double radius, const Vec3& centre) {
  return *Sphere::create({.radius_m = radius, .world_from_object = Transform::translate(centre)});
}

TEST(Accelerator, AnswersTheNearestOfAllKindsOfGeometry) {
  GeometrySet set = triangle(5);
  // Along +z at (0.25, 0.25): sphere at 1..2, disk at 3, twisted patch at 4 + 1/16, triangle at 5,
  // a tube that lies across at 6.5..7.5.
  set.of<Sphere>() = {sphere(0.5, {0.25, 0.25, 1.5})};
  set.of<Disk>() = {*Disk::create({.height_m = 3, .radius_m = 1})};
  set.patches = {{{0, 0, 4}, {1, 0, 4}, {0, 1, 4}, {1, 1, 5}}};
  set.of<Cylinder>() = {
      *Cylinder::create({.radius_m = 0.5,
                         .world_from_object = Transform::translate({0.25, 0, 7}) *
                                              *Transform::rotate(M_PI / 2, {1, 0, 0})})};
  const auto a = build_accelerator(std::move(set));
  const Ray ray{{0.25f, 0.25f, 0}, {0, 0, 1}};
  struct Expected {
    float from, t;
    HitKind kind;
  };
  for (const Expected& e : {Expected{0, 1, kHitKind<Sphere>},
                            {1.5f, 2, kHitKind<Sphere>},
                            {2.5f, 3, kHitKind<Disk>},
                            {3.5f, 4.0625f, HitKind::kPatch},
                            {4.5f, 5, HitKind::kTriangle},
                            {5.5f, 6.5f, kHitKind<Cylinder>},
                            {7, 7.5f, kHitKind<Cylinder>}}) {
    Ray from = ray;
    from.t_min = e.from;
    const auto hit = a->closest_hit(from);
    ASSERT_TRUE(hit) << e.from;
    EXPECT_EQ(hit->kind, e.kind) << e.from;
    EXPECT_FLOAT_EQ(hit->t, e.t);
    if (e.kind != HitKind::kTriangle) {
      EXPECT_NEAR(hit->position.z, e.t, 1e-14);
    }
    // Open interval: from this hit on there is nothing up to just before the next.
    from.t_max = e.t * (1 - 1e-6f);
    EXPECT_FALSE(a->closest_hit(from)) << e.from;
    EXPECT_FALSE(a->occluded(from)) << e.from;
    from.t_max = e.t * (1 + 1e-6f);
    EXPECT_TRUE(a->occluded(from)) << e.from;
  }
}

TEST(Accelerator, TakesRaysOfAnyLengthInTheirOwnUnits) {
  GeometrySet set;
  set.of<Sphere>() = {sphere(1, {0, 0, 10})};
  const auto a = build_accelerator(std::move(set));
  const auto hit = a->closest_hit({{0, 0, 0}, {0, 0, 4}});
  ASSERT_TRUE(hit);
  EXPECT_FLOAT_EQ(hit->t, 9 / 4.0f);
  EXPECT_NEAR(hit->normal.z, -1, 1e-15);
}

EndTolerances ends_at(const EndTolerance& end) { return {.start = {}, .end = end}; }

TEST(Accelerator, TellsOtherObstaclesFromThoseThatAnEndMayLieOn) {
  const auto a = build_accelerator(triangle(1));
  const auto met = [&](const EndTolerances& ends) {
    return a->obstacle({{0.2F, 0.2F, 0}, {0, 0, 1}}, ends, RayFilter::kSurfaces);
  };
  EXPECT_EQ(met({}), Obstacle::kOther);
  EXPECT_EQ(met(ends_at({{0.2, 0.2, 0}, 1e-6F})), Obstacle::kOther);
  EXPECT_EQ(met(ends_at({{0.2, 0.2, 1}, 0})), Obstacle::kPerhapsOwn);
  EXPECT_EQ(met(ends_at({{0.2, 0.2, 1.5}, 1})), Obstacle::kPerhapsOwn);
  // Elsewhere in the plane too.
  EXPECT_EQ(met(ends_at({{90, 80, 1}, 1e-6F})), Obstacle::kPerhapsOwn);
  EXPECT_EQ(met({.start = {{0.2, 0.2, 1}, 1e-6F}, .end = {}}), Obstacle::kPerhapsOwn);
  EXPECT_EQ(a->obstacle({{2, 2, 0}, {0, 0, 1}}, ends_at({{2, 2, 1}, 1}), RayFilter::kSurfaces),
            Obstacle::kNone);
}

TEST(Accelerator, ASurfaceBehindThatOfTheStartIsAnotherObstacle) {
  GeometrySet set = triangle(1);
  set.of<Sphere>() = {sphere(1, {0.2, 0.2, 5})};
  const auto a = build_accelerator(std::move(set));
  const auto met = [&](const EndTolerances& ends, float t_max) {
    return a->obstacle({{0.2F, 0.2F, 0}, {0, 0, 1}, 0, t_max}, ends, RayFilter::kSurfaces);
  };
  const EndTolerance on_triangle{{0.2, 0.2, 1}, 1e-6F}, on_sphere{{0.2, 0.2, 4}, 1e-6F};
  EXPECT_EQ(met({.start = on_triangle, .end = {}}, 9), Obstacle::kOther);
  EXPECT_EQ(met({.start = on_triangle, .end = on_sphere}, 4.5F), Obstacle::kPerhapsOwn);
  EXPECT_EQ(met({.start = {}, .end = on_sphere}, 4.5F), Obstacle::kOther);
}

TEST(Accelerator, TheSurfaceOfAnInstanceMayAlwaysBeThatOfAnEnd) {
  const auto a = build_accelerator({}, {triangle(0)}, {{0, Transform::translate({0, 0, 1})}});
  const Ray ray{{0.2F, 0.2F, 0}, {0, 0, 1}};
  EXPECT_EQ(a->obstacle(ray, ends_at({{0.2, 0.2, 3}, 0}), RayFilter::kSurfaces),
            Obstacle::kPerhapsOwn);
  EXPECT_EQ(a->obstacle(ray, {}, RayFilter::kSurfaces), Obstacle::kOther);
}

TEST(Accelerator, ReportsTheInstanceThatWasHit) {
  GeometrySet object = triangle(0);
  object.of<Sphere>() = {sphere(1, {0, 0, 8})};
  const Transform twice = *Transform::scale({2, 2, 2});
  const auto a = build_accelerator(
      {}, {std::move(object)},
      {{0, Transform::translate({10, 0, 1})}, {0, Transform::translate({20, 0, 2}) * twice}});
  auto hit = a->closest_hit({{20.5f, 0.5f, 0}, {0, 0, 1}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->instance, 1);
  EXPECT_EQ(hit->kind, HitKind::kTriangle);
  EXPECT_FLOAT_EQ(hit->t, 2);
  hit = a->closest_hit({{20, 0, 3}, {0, 0, 1}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->kind, kHitKind<Sphere>);
  EXPECT_FLOAT_EQ(hit->t, 2 + 14 - 3);    // centre 2 + 16, radius 2
  EXPECT_NEAR(hit->position.z, 7, 1e-6);  // in the object's own space
  EXPECT_FALSE(a->closest_hit({{0.2f, 0.2f, -1}, {0, 0, 1}}));
}

TEST(Accelerator, AgreesWithTryingEveryTriangle) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(-1, 1);
  GeometrySet set;
  std::vector<Triangle> all;
  for (std::uint32_t i = 0; i < 500; ++i) {
    const Vec3f a{u(random), u(random), u(random)};
    const auto near = [&] { return a + Vec3f{u(random), u(random), u(random)} * 0.3f; };
    const Vec3f b = near(), c = near();
    for (const auto& p : {a, b, c}) {
      set.triangles.push_back(static_cast<std::uint32_t>(set.vertices.size()));
      set.vertices.push_back(p);
    }
    all.push_back({Vec3(a), Vec3(b), Vec3(c)});
  }
  const auto accelerator = build_accelerator(std::move(set));
  int hits = 0, mismatches = 0;
  for (int i = 0; i < 5000; ++i) {
    const Ray ray{{u(random) * 2, u(random) * 2, u(random) * 2}, {u(random), u(random), u(random)}};
    double nearest = INFINITY;
    for (const auto& t : all)
      if (const auto h = t.intersect(Vec3(ray.origin), Vec3(ray.direction), 0, nearest))
        nearest = h->t;
    const auto hit = accelerator->closest_hit(ray);
    hits += hit ? 1 : 0;
    if (std::isfinite(nearest) != hit.has_value())
      ++mismatches;  // through an edge
    else if (hit && std::fabs(hit->t - nearest) > 1e-4 * nearest)
      ++mismatches;
    EXPECT_EQ(accelerator->occluded(ray), hit.has_value());
  }
  EXPECT_GT(hits, 500);
  EXPECT_LE(mismatches, 2);
}

TEST(Accelerator, TakesDirectionsOfAnyLengthAndRefusesInvalidRays) {
  const auto a = build_accelerator(triangle(1));
  for (const float length : {1e-30f, 1e-10f, 1e10f, 1e30f}) {
    const auto hit = a->closest_hit({{0.2f, 0.2f, 0}, {0, 0, length}});
    ASSERT_TRUE(hit) << length;
    EXPECT_FLOAT_EQ(hit->t, 1 / length);
  }
  for (const float bad : {0.0f, INFINITY, NAN}) {
    EXPECT_FALSE(a->closest_hit({{0.2f, 0.2f, 0}, {0, 0, bad}}));
    EXPECT_FALSE(a->occluded(Ray{{0.2f, 0.2f, 0}, {0, 0, bad}}));
  }
  EXPECT_FALSE(a->closest_hit({{0.2f, NAN, 0}, {0, 0, 1}}));
}

TEST(Accelerator, TakesRaysFromAnyDistance) {
  const auto a = build_accelerator(triangle(1));
  for (const float z : {-1e3F, -1e10F, -1e20F, -1e30F}) {
    const auto hit = a->closest_hit({{0.25F, 0.5F, z}, {0, 0, 2}});
    ASSERT_TRUE(hit) << z;
    EXPECT_FLOAT_EQ(hit->t, (1 - z) / 2);
    EXPECT_TRUE(a->occluded(Ray{{0.25F, 0.5F, z}, {0, 0, 2}}));
    EXPECT_FALSE(a->occluded(Ray{{0.25F, 0.5F, z}, {0, 0, 2}, 0, -z / 4}));
    EXPECT_FALSE(a->occluded(Ray{{0.25F, 0.5F, z}, {0, 0, 2}, -z}));
    EXPECT_FALSE(a->occluded(Ray{{0.25F, 0.5F, z}, {0, 0, -2}}));
    EXPECT_FALSE(a->occluded(Ray{{0.75F, 0.5F, z}, {0, 0, 2}}));
  }
  // Its path is computed in doubles: floats from there would not resolve the triangle's
  // corners.
  const auto slanting = a->closest_hit({{-0x1p22F, 0.5F, -0x1p24F}, {0x1p22F, 0, 0x1p24F}});
  ASSERT_TRUE(slanting);
  EXPECT_NEAR(slanting->uv.x, 0.25, 1e-6);
}

TEST(Accelerator, TakesGeometryOfAnySize) {
  for (const float s : {1e-30F, 1e-20F, 1e-10F, 1e10F, 1e18F, 1e30F}) {
    const auto a =
        build_accelerator({.vertices = {{0, 0, s}, {s, 0, s}, {0, s, s}}, .triangles = {0, 1, 2}});
    const auto hit = a->closest_hit({{0.25F * s, 0.5F * s, 0}, {0, 0, 1}});
    ASSERT_TRUE(hit) << s;
    EXPECT_FLOAT_EQ(hit->t, s);
    EXPECT_FLOAT_EQ(hit->uv.x, 0.25F);
    EXPECT_FLOAT_EQ(hit->uv.y, 0.5F);
  }
}

TEST(Accelerator, StopsBuildingOnRequest) {
  std::stop_source stop;
  stop.request_stop();
  const auto a = Accelerator::build(triangle(0), {}, {}, "", stop.get_token());
  EXPECT_EQ(a.status().code(), absl::StatusCode::kCancelled);
}

TEST(Accelerator, UsesTheRequestedKernels) {
  const auto a = Accelerator::build(triangle(1), {}, {}, "sse2", {});
  ASSERT_TRUE(a.ok()) << a.status();
  EXPECT_EQ((*a)->isa(), "sse2");
  EXPECT_TRUE((*a)->occluded(Ray{{0.2f, 0.2f, 0}, {0, 0, 1}}));
  const auto unknown = Accelerator::build(triangle(1), {}, {}, "mmx", {});
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(unknown.status().message()), HasSubstr("isa = \"mmx\", allowed"));
  EXPECT_THAT(std::string(unknown.status().message()), HasSubstr("\"sse2\""));
}

TEST(Accelerator, CountsEmbreesMemoryAndItsOwn) {
  GeometrySet many;
  for (int i = 0; i < 10000; ++i) {
    const auto x = static_cast<float>(i);
    for (const auto& p : {Vec3f{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}}) {
      many.triangles.push_back(static_cast<std::uint32_t>(many.vertices.size()));
      many.vertices.push_back(p);
    }
  }
  const std::size_t own = 30000 * (12 + 4);
  EXPECT_GT(build_accelerator(std::move(many))->bytes(),
            own + 10000 * 16);  // at least 16 bytes a triangle
}

}  // namespace
}  // namespace lucerna
