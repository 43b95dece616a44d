// Surfaces with holes: rays and shadow rays pass where alpha is 0.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// Alpha 1 for u < 1/2, else 0.
std::int32_t left_half(SceneDescription& d) {
  return d.textures.add(CheckerboardTexture{.mapping = {.scale = {2, 1}},
                                            .parts = {ColourValue{Rgb(1)}, ColourValue{Rgb(0)}}});
}

/// A surface over (0, 0) to (1, 1) at z = 1 with holes where x > 1/2.
std::shared_ptr<const Scene> with_holes(ShapeDescription surface) {
  SceneDescription d = description();
  surface.alpha = {0, left_half(d)};
  surface.has_uv = true;
  d.shapes = {std::move(surface)};
  return build(std::move(d));
}

void expect_left_half(const Scene& scene, const char* what) {
  for (const double x : {0.05, 0.3, 0.45, 0.55, 0.7, 0.95})
    for (const double y : {0.1, 0.6}) {
      const Ray ray{Vec3f(Vec3{x, y, 0} - scene.origin()), {0, 0, 2}, 0, 1, 0};
      EXPECT_EQ(scene.geometry().occluded(ray), x < 0.5) << what << " at " << x << ", " << y;
      EXPECT_EQ(scene.closest_hit(ray).has_value(), x < 0.5) << what << " at " << x << ", " << y;
    }
}

TEST(CutOuts, RaysPassThroughHolesOfEachKindOfMesh) {
  expect_left_half(*with_holes(patch({0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1})), "flat patch");
  expect_left_half(*with_holes(patch({0, 0, 1}, {1, 0, 1.1}, {0, 1, 1.1}, {1, 1, 1})),
                   "bent patch");
  TriangleMeshData mesh{.positions = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}},
                        .normals = {},
                        .indices = {0, 1, 2, 1, 3, 2}};
  for (const std::uint32_t i : mesh.indices)
    mesh.corner_uv.push_back(
        {static_cast<float>(mesh.positions[i].x), static_cast<float>(mesh.positions[i].y)});
  expect_left_half(*with_holes(shape(std::move(mesh))), "triangles");
}

TEST(CutOuts, RaysMeetTheFarSideOfASphereThroughAHole) {
  // u turns about z from +x, so the half y < 0 is cut away.
  const auto scene = with_holes(shape(SphereParams{.radius_m = 1}));
  const auto ray = [&](const Vec3& from, const Vec3& way) {
    return Ray{Vec3f(from - scene->origin()), Vec3f(way), 0, 10, 0};
  };
  const auto through = scene->closest_hit(ray({0, -3, 0}, {0, 1, 0}));
  ASSERT_TRUE(through.has_value());
  EXPECT_NEAR(through->t, 4, 1e-5);
  const auto near = scene->closest_hit(ray({0, 3, 0}, {0, -1, 0}));
  ASSERT_TRUE(near.has_value());
  EXPECT_NEAR(near->t, 2, 1e-5);
  EXPECT_FALSE(scene->geometry().occluded(ray({-3, -0.5, 0}, {1, 0, 0})));
}

/// A texture that follows the world, in a scene whose coordinates begin elsewhere.
TEST(CutOuts, TexturesOfTheWorldStayInPlaceFarFromZero) {
  SceneDescription d = description();
  const Vec3 far{1e4, -3e4, 2e4};
  TextureMapping planar;
  planar.kind = TextureMapping::Kind::kPlanar;
  planar.axis_s = {2, 0, 0}, planar.axis_t = {0, 0, 0};
  planar.shift = {-2 * far.x, 0.5};
  const std::int32_t stripes = d.textures.add(
      CheckerboardTexture{.mapping = planar, .parts = {ColourValue{Rgb(1)}, ColourValue{Rgb(0)}}});
  d.shapes = {
      patch(far + Vec3{0, 0, 1}, far + Vec3{1, 0, 1}, far + Vec3{0, 1, 1}, far + Vec3{1, 1, 1})};
  d.shapes[0].alpha = {0, stripes};
  const auto scene = build(std::move(d));
  ASSERT_FALSE(scene->origin() == Vec3{});
  for (const double x : {0.1, 0.4, 0.6, 0.9}) {
    const Ray ray{Vec3f(far + Vec3{x, 0.5, 0} - scene->origin()), {0, 0, 2}, 0, 1, 0};
    EXPECT_EQ(scene->geometry().occluded(ray), x < 0.5) << x;
  }
}

TEST(CutOuts, PartOfTheRaysPassAThinnedSurface) {
  SceneDescription d = description();
  d.shapes = {patch({0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1})};
  d.shapes[0].alpha = {0.3};
  const auto scene = build(std::move(d));
  int blocked = 0;
  constexpr int kRays = 4000;
  for (int i = 0; i < kRays; ++i) {
    const Vec3 from{(i % 64 + 0.5) / 64, (i / 64 + 0.5) / 64, 0};
    const Ray ray{Vec3f(from - scene->origin()), {0, 0, 2}, 0, 1, 0};
    blocked += scene->geometry().occluded(ray);
    EXPECT_EQ(scene->geometry().occluded(ray), scene->closest_hit(ray).has_value());
  }
  EXPECT_NEAR(blocked / double(kRays), 0.3, 0.04);
}

TEST(CutOuts, SurfacesInARowLetRaysPassEachOnItsOwn) {
  SceneDescription d = description();
  d.shapes = {patch({0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}),
              patch({0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {1, 1, 2}), shape(SphereParams{})};
  d.shapes[2].geometry =
      SphereParams{.radius_m = 1, .world_from_object = Transform::translate({0.5, 0.5, 5})};
  for (ShapeDescription& s : d.shapes) s.alpha = {0.5};
  const auto scene = build(std::move(d));
  int passed = 0, near = 0;
  constexpr int kRays = 8000;
  for (int i = 0; i < kRays; ++i) {
    const Vec3 from{(i % 80 + 0.5) / 80, (i / 80 + 0.5) / 100, 0};
    Ray ray{Vec3f(from - scene->origin()), {0, 0, 9}, 0, 1, 0};
    passed += !scene->geometry().occluded(ray);  // two sheets, and both sides of the ball
    ray.t_max = 0.4F;
    near += !scene->geometry().occluded(ray);  // two sheets
  }
  EXPECT_NEAR(near / double(kRays), 1.0 / 4, 0.02);
  EXPECT_NEAR(passed / double(kRays), 1.0 / 16, 0.02);
}

TEST(CutOuts, MayHaveMaterialsWithTextures) {
  SceneDescription d = description();
  d.shapes = {patch({0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1})};
  d.shapes[0].alpha = {0, left_half(d)};
  d.shapes[0].has_uv = true;
  d.materials = {{.params = DiffuseParams{{{}, left_half(d)}}}};
  d.lights = {point_light({0.3, 0.5, 2}, 100)};
  const auto scene = build(std::move(d));
  EXPECT_EQ(scene->geometry().textures().size(), 2U);
  const IrradiancePoint point{Vec3{0.3, 0.5, 3} - scene->origin(), {}, {0, 0, -1}};
  const auto lux =
      estimate_irradiance(*scene, std::span(&point, 1),
                          {.samples_per_block = 64, .block_count = 16, .bounces = {}}, {});
  EXPECT_GT(lux.points[0].irradiance_lx.g, 101);  // more than the direct light from 1 m
}

/// The light of a lamp over (0, 0) to (1, 1) at z = 1 at a point of the ground, and its power.
struct LampLight {
  double by_lights, by_surfaces, error, power;
};
LampLight light_of(ShapeDescription lamp, SceneDescription d) {
  d.shapes = {emissive(std::move(lamp), 10)};
  const auto scene = build(std::move(d));
  EXPECT_THAT(scene->report().remarks, ::testing::IsEmpty());
  const IrradiancePoint point{Vec3{0.2, 0.3, 0} - scene->origin(), {}, {0, 0, 1}};
  LampLight light{};
  for (const Combination by : {Combination::kLights, Combination::kSurfaces}) {
    IrradianceSettings settings{.samples_per_block = 512, .block_count = 16, .bounces = 0};
    settings.methods.combination = by;
    settings.methods.closed_forms = ClosedForms::kOff;
    const auto e = estimate_irradiance(*scene, std::span(&point, 1), settings, {}).points[0];
    (by == Combination::kLights ? light.by_lights : light.by_surfaces) = e.irradiance_lx.g;
    light.error = std::max(light.error, e.illuminance_error_lx);
  }
  light.power = light_power(*scene, 0).lumens.g;
  return light;
}

void expect_light(const LampLight& a, const LampLight& b, double share) {
  EXPECT_NEAR(a.by_lights, b.by_lights * share, 4 * (a.error + b.error));
  EXPECT_NEAR(a.by_surfaces, b.by_surfaces * share, 4 * (a.error + b.error));
  EXPECT_LT(a.error, 0.05 * a.by_lights);
  EXPECT_NEAR(a.power, b.power * share, 1e-9 * b.power);
}

TEST(CutOuts, ThinnedLampsEmitTheShareOfTheirAlpha) {
  // Normals down.
  const ShapeDescription flat = patch({0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 1});
  const ShapeDescription ball = shape(
      SphereParams{.radius_m = 0.5, .world_from_object = Transform::translate({0.5, 0.5, 1})});
  for (ShapeDescription lamp : {flat, ball}) {
    const LampLight whole = light_of(lamp, description());
    lamp.alpha = {0.3};
    expect_light(light_of(lamp, description()), whole, 0.3);
  }
}

TEST(CutOuts, LampsWithHolesEmitAsTheRestOfThemWould) {
  // Alpha is 1 where v < 1/2, which is x < 1/2 here.
  const auto holes = [](SceneDescription& d) {
    return NumberValue{
        0, d.textures.add(CheckerboardTexture{
               .mapping = {.scale = {1, 2}}, .parts = {ColourValue{Rgb(1)}, ColourValue{Rgb(0)}}})};
  };
  const LampLight half =
      light_of(patch({0, 0, 1}, {0, 1, 1}, {0.5, 0, 1}, {0.5, 1, 1}), description());
  SceneDescription d = description();
  ShapeDescription lamp = patch({0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 1});
  lamp.alpha = holes(d);
  const LampLight flat = light_of(lamp, d);
  EXPECT_NEAR(flat.by_surfaces, half.by_surfaces, 4 * (flat.error + half.error));
  EXPECT_NEAR(flat.by_lights, half.by_lights, 4 * (flat.error + half.error));
  EXPECT_NEAR(flat.power, half.power, 1e-6 * half.power);

  TriangleMeshData mesh{.positions = {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 1}},
                        .normals = {},
                        .indices = {0, 1, 2, 1, 3, 2}};
  const Vec2f uv[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  for (const std::uint32_t i : mesh.indices) mesh.corner_uv.push_back(uv[i]);
  ShapeDescription triangles = shape(std::move(mesh));
  triangles.alpha = lamp.alpha;
  triangles.has_uv = true;
  const LampLight two = light_of(triangles, d);
  EXPECT_NEAR(two.by_surfaces, half.by_surfaces, 4 * (two.error + half.error));
  EXPECT_NEAR(two.by_lights, half.by_lights, 4 * (two.error + half.error));
  EXPECT_NEAR(two.power, half.power, 1e-6 * half.power);
}

TEST(CutOuts, LampsWhoseAlphaFollowsThePlaceAreOpaqueAndReported) {
  SceneDescription d = description();
  TextureMapping planar;
  planar.kind = TextureMapping::Kind::kPlanar;
  d.shapes = {emissive(patch({0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 1}), 10)};
  d.shapes[0].alpha = {0, d.textures.add(CheckerboardTexture{.mapping = planar})};
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->report().remarks.size(), 1U);
  EXPECT_EQ(scene->report().remarks[0].what,
            "\"alpha\" of a light that follows the place in space is not modelled");
  EXPECT_EQ(scene->report().remarks[0].instead, "opaque");
  EXPECT_NEAR(light_power(*scene, 0).lumens.g, 10 * std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace lucerna::testing
