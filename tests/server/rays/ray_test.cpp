// No surface shadows itself, and light reaches all receivers, at every scale and place.
#include "server/rays/ray.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lights/sampling/sampling.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;

TEST(OffsetOrigin, LeavesTheErrorBoxOnTheSideOfTheDirection) {
  const Vec3f p{1, -2, 3}, error{1e-6f, 2e-6f, 4e-6f};
  const Vec3 n = normalized(Vec3{1, 2, -2});
  // Every corner of the box lies below the plane through the new origin.
  for (const double side : {1.0, -1.0}) {
    const Vec3 o(offset_origin(p, error, n, n * side));
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner{p.x + (i & 1 ? 1.0 : -1.0) * error.x, p.y + (i & 2 ? 1.0 : -1.0) * error.y,
                        p.z + (i & 4 ? 1.0 : -1.0) * error.z};
      EXPECT_GE(side * dot(o - corner, n), -1e-12);
    }
    // And not far beyond: |n| . error is 4.7e-6, and rounding adds an ulp of each coordinate.
    EXPECT_LT(length(o - Vec3(p)), 5.5e-6);
  }
}

TEST(OffsetOrigin, GoesToTheNextFloatOutwards) {
  constexpr float kLeast = std::numeric_limits<float>::denorm_min();
  constexpr float kMost = std::numeric_limits<float>::max();
  for (const float p : {0.0F, -0.0F, kLeast, -kLeast, 0x1p-126F, -0x1p-126F, 1.0F, -1.0F, 0.7F,
                        kMost, -kMost, INFINITY, -INFINITY}) {
    const Vec3f up = offset_origin({p, p, p}, {kLeast, kLeast, kLeast}, {1, 0, 0}, {1, 0, 0});
    EXPECT_EQ(up.x, std::nextafter(p + kLeast, INFINITY)) << p;
    EXPECT_EQ(up.y, p);
    const Vec3f down = offset_origin({p, p, p}, {kLeast, kLeast, kLeast}, {1, 0, 0}, {-1, 0, 0});
    EXPECT_EQ(down.x, std::nextafter(p - kLeast, -INFINITY)) << p;
  }
}

TEST(OffsetOrigin, MovesAtLeastOneUlpWhereTheOffsetIsLost) {
  const Vec3f p{1e6f, 0, 0};
  EXPECT_GT(offset_origin(p, {1e-5f, 0, 0}, {1, 0, 0}, {1, 0, 0}).x, 1e6f);
  EXPECT_LT(offset_origin(p, {1e-5f, 0, 0}, {1, 0, 0}, {-1, 0, 0}).x, 1e6f);
}

struct Place {
  double scale;
  Vec3 offset;
};

class SelfShadowing : public ::testing::TestWithParam<Place> {
 protected:
  // A tilted map of equal scale, so that nothing is aligned with an axis.
  Transform placed() const {
    const Place& p = GetParam();
    return Transform::translate(p.offset) * *Transform::rotate(0.7, {1, 2, 3}) *
           *Transform::scale({p.scale, p.scale, p.scale});
  }

  /// Shoots rays at the unit ball in object space from outside, and from each hit into the
  /// half space above.  Returns how many of the latter meet the shape again.
  int shadowed(const Scene& scene, float error_factor = 1) const {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> u(0, 1);
    const Transform scene_from_object = Transform::translate(-scene.origin()) * placed();
    int hits = 0, shadowed = 0;
    for (int i = 0; i < 20000; ++i) {
      const auto from = Vec3(sample_uniform_sphere(Vec2f{u(random), u(random)})) * 3.0;
      const auto to = Vec3(sample_uniform_sphere(Vec2f{u(random), u(random)})) * 0.9;
      const Ray ray{Vec3f(scene_from_object.point(from)),
                    Vec3f(scene_from_object.vector(to - from))};
      auto hit = scene.closest_hit(ray);
      if (!hit) continue;
      ++hits;
      hit->position_error = hit->position_error * error_factor;
      const Vec3f ng(hit->ng), n = dot(ng, ray.direction) < 0 ? ng : -ng;
      // Includes grazing directions, as far as floats resolve them from directions that
      // enter.
      const float c = std::max(std::pow(u(random), 4.0f), 1e-6f);
      const float phi = 2 * std::numbers::pi_v<float> * u(random), r = std::sqrt(1 - c * c);
      const Vec3f w{r * std::cos(phi), r * std::sin(phi), c};
      const Ray leaving = spawn_ray(*hit, Framef::around(n).world_from_local(w));
      shadowed += scene.geometry().occluded(leaving) ? 1 : 0;
    }
    EXPECT_GT(hits, 2000);
    return shadowed;
  }

  std::shared_ptr<const Scene> scene_of(ShapeDescription shape) const {
    SceneDescription d = testing::description();
    d.shapes.push_back(std::move(shape));
    return build(std::move(d));
  }
};

TEST_P(SelfShadowing, DoesNotHappenOnMovingSurfaces) {
  // Made elsewhere, and come to rest here before time 0.
  const Transform first = *Transform::rotate(2, {1, -1, 0.5}) *
                          Transform::translate({1e2 * GetParam().scale, 0, 0}) *
                          *Transform::scale({GetParam().scale, GetParam().scale, GetParam().scale});
  const std::vector<KeyTransform> keys{{-2, first}, {-1, placed()}};
  const auto motion = std::make_shared<const Motion>(*Motion::create(keys));
  for (int kind = 0; kind < 3; ++kind) {
    SceneDescription d = testing::description();
    if (kind == 0)
      d.shapes.push_back({testing::ball(3, [&](const Vec3& p) { return first.point(p); })});
    if (kind == 1) d.shapes.push_back({SphereParams{.world_from_object = first}});
    if (kind < 2) d.shapes[0].motion = motion;
    if (kind == 2) {
      d.objects = {{"ball", {{testing::ball(3, [](const Vec3& p) { return p * 5.0; })}}}};
      d.instances = {{0, first * *Transform::scale({0.2, 0.1, 0.2}), motion}};
    }
    EXPECT_EQ(shadowed(*build(std::move(d))), 0) << kind;
  }
}

TEST_P(SelfShadowing, CompanionHappensWithoutTheErrorBound) {
  const Transform t = placed();
  const auto scene = scene_of({testing::ball(0, [&](const Vec3& p) { return t.point(p); })});
  EXPECT_GT(shadowed(*scene, 0), 20);
}

INSTANTIATE_TEST_SUITE_P(Places, SelfShadowing,
                         ::testing::Values(Place{1e-3, {}}, Place{1, {}}, Place{1e4, {}},
                                           Place{1, {1e6, -1e6, 1e6}}, Place{1e-3, {1e6, 0, 7}},
                                           Place{1e4, {0, 1e6, -1e6}}, Place{1, {5, -3, 4}},
                                           Place{0x1p-20, {}}, Place{1e7, {}}));

}  // namespace
}  // namespace lucerna
