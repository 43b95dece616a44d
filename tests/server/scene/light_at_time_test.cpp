// LightAtTime compared with the models themselves: one light of each kind, at rest and moving.
#include "server/scene/light_at_time.h"

#include <gtest/gtest.h>

#include <cmath>
#include <concepts>
#include <cstring>
#include <memory>
#include <set>
#include <stdexcept>
#include <typeindex>
#include <typeinfo>
#include <vector>

#include "server/assets/asset_reader.h"
#include "server/pbrt/load.h"
#include "tests/paths.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

SceneDescription every_light() {
  auto assets = AssetReader::open(test_data());
  if (!assets.ok()) throw std::runtime_error(assets.status().ToString());
  AssetReader reader = *std::move(assets);
  return load_pbrt(reader, "lights/every_light.pbrt").value();
}

std::shared_ptr<const Scene> scene_of(bool moving) {
  SceneDescription d = every_light();
  if (moving) {
    const std::vector<KeyTransform> keys{
        {0, Transform::translate({0.1, 0.2, 0})},
        {2, Transform::translate({1, -2, 0.5}) * *Transform::rotate(0.7, {1, 2, 3})}};
    const auto motion = std::make_shared<const Motion>(Motion::create(keys).value());
    for (LightDescription& l : d.lights) l.motion = motion;
    for (ShapeDescription& s : d.shapes) s.motion = motion;
  }
  return testing::build(std::move(d));
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(const Rgb& a, const Rgb& b) { return same(a.r, b.r) && same(a.g, b.g) && same(a.b, b.b); }
bool same(const Vec3& a, const Vec3& b) {
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}
bool same(const LightSample& a, const LightSample& b) {
  return a.reason == b.reason && a.delta == b.delta && same(a.value, b.value) && same(a.wi, b.wi) &&
         same(a.pdf.per_sr, b.pdf.per_sr) && same(a.distance, b.distance) &&
         same(a.point, b.point) && same(a.normal, b.normal);
}
bool same(const EmissionSample& a, const EmissionSample& b) {
  return a.reason == b.reason && same(a.value, b.value) && same(a.origin, b.origin) &&
         same(a.direction, b.direction) && same(a.normal, b.normal) &&
         same(a.pdf_position.per_m2, b.pdf_position.per_m2) &&
         same(a.pdf_direction.per_sr, b.pdf_direction.per_sr) && a.primitive == b.primitive;
}
bool same(const EmissionPdf& a, const EmissionPdf& b) {
  return same(a.position.per_m2, b.position.per_m2) && same(a.direction.per_sr, b.direction.per_sr);
}

/// Compares all members of one light, for a receiver and a pair of random numbers.
template <typename L>
void expect_same(const LightAtTime& at_time, const L& light, const Receiver& receiver, Vec2 u,
                 const SceneSphere& sphere) {
  const LightSample s = light.sample_li(receiver, u);
  EXPECT_TRUE(same(at_time.sample_li(receiver, u), s));
  EXPECT_TRUE(same(at_time.pdf_li(receiver, s.wi).per_sr, light.pdf_li(receiver, s.wi).per_sr));
  const EmissionSample e = light.sample_le(u, {u.y, u.x}, sphere);
  EXPECT_TRUE(same(at_time.sample_le(u, {u.y, u.x}, sphere), e));
  EXPECT_TRUE(same(at_time.pdf_le(e.origin, e.direction, sphere),
                   light.pdf_le(e.origin, e.direction, sphere)));
  EXPECT_EQ(at_time.is_delta(), L::kDelta);
  EXPECT_EQ(at_time.has_surface(), SeenOnSurface<L>);
  EXPECT_EQ(at_time.is_seen_beyond(), SeenBeyond<L>);
  EXPECT_EQ(at_time.leaves_freely(), LeavesFreely<L>);
  EXPECT_EQ(at_time.has_irradiance(), HasIrradiance<L>);
  if constexpr (SeenOnSurface<L>) {
    const SurfacePoint point{e.origin, e.normal, e.primitive};
    EXPECT_TRUE(same(at_time.le(point, e.direction), light.le(point, e.direction)));
    EXPECT_TRUE(same(at_time.pdf_li(receiver, point).per_sr, light.pdf_li(receiver, point).per_sr));
    EXPECT_TRUE(same(at_time.ray_from(point, e.direction), light.ray_from(point, e.direction)));
  }
  if constexpr (SeenBeyond<L>) {
    EXPECT_TRUE(same(at_time.le_escaped(receiver.position, s.wi),
                     light.le_escaped(receiver.position, s.wi)));
  }
  if constexpr (LeavesFreely<L>) {
    EXPECT_TRUE(
        same(at_time.le_leaving(e.origin, e.direction), light.le_leaving(e.origin, e.direction)));
  }
  if constexpr (HasIrradiance<L>) {
    const auto lx = light.irradiance(receiver), at_time_lx = at_time.irradiance(receiver);
    ASSERT_EQ(at_time_lx.has_value(), lx.has_value());
    if (lx) {
      EXPECT_TRUE(same(*at_time_lx, *lx));
    }
    EXPECT_EQ(at_time.hides_itself(), light.hides_itself());
  }
  EXPECT_TRUE(same(at_time.power(sphere).lumens, light.power(sphere).lumens));
  EXPECT_TRUE(
      same(at_time.power_approximate(sphere).lumens, light.power_approximate(sphere).lumens));
  const auto bounds = light.bounds(), at_time_bounds = at_time.bounds();
  ASSERT_EQ(at_time_bounds.has_value(), bounds.has_value());
  if (bounds) {
    EXPECT_TRUE(same(at_time_bounds->lower, bounds->lower));
    EXPECT_TRUE(same(at_time_bounds->upper, bounds->upper));
    EXPECT_TRUE(same(at_time_bounds->axis, bounds->axis));
  }
}

void expect_bits_of_models(const Scene& scene) {
  std::set<std::type_index> models;
  for (const SceneLight& light : scene.lights())
    visit([&](const auto& model) { models.insert(typeid(model)); }, light.light);
  // Each model of the closed set takes part.
  ASSERT_EQ(models.size(), std::variant_size_v<LightModels>);
  for (const SceneLight& light : scene.lights()) {
    SCOPED_TRACE(light.id);
    for (const double time_s : {-1.0, 0.75, 3.0})
      for (const Vec2& u : {Vec2{0.3, 0.6}, {0.9, 0.2}, {0.5, 0.5}}) {
        Receiver receiver(scene.sphere().center_m + Vec3{u.x - 1, 2 * u.y, -3 * u.x});
        receiver.normal = normalized(Vec3{u.x, -u.y, 1});
        const LightAtTime at_time(light, time_s);
        visit_light(light, time_s, [&](const auto& model) {
          expect_same(at_time, model, receiver, u, scene.sphere());
        });
      }
  }
}

TEST(LightAtTime, HasTheBitsOfEachModelAtRest) { expect_bits_of_models(*scene_of(false)); }

TEST(LightAtTime, HasTheBitsOfEachModelInMotion) {
  const auto scene = scene_of(true);
  ASSERT_TRUE(scene->moves());
  expect_bits_of_models(*scene);
}

TEST(LightAtTime, HasNoMemberThatItsModelLacks) {
  SceneDescription d = testing::description();
  d.lights = {testing::point_light({0, 0, 3}, 100)};
  const auto scene = testing::build(std::move(d));
  const LightAtTime point(scene->lights()[0], 0);
  const Vec3 up{0, 0, 1};
  const SurfacePoint nowhere{{}, up, 0};
  EXPECT_TRUE(point.le(nowhere, up).is_black());
  EXPECT_TRUE(point.le_escaped({}, up).is_black());
  EXPECT_TRUE(point.le_leaving({}, up).is_black());
  EXPECT_EQ(point.pdf_li(Receiver(0, 0, 0), nowhere).per_sr, 0);
  EXPECT_FALSE(point.irradiance(Receiver(0, 0, 0)));
  EXPECT_FALSE(point.hides_itself());
}

}  // namespace
}  // namespace lucerna
