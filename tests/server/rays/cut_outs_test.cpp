// Surfaces with holes: rays and shadow rays pass where alpha is 0.
#include <gtest/gtest.h>

#include "server/estimate/queries/irradiance.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// Alpha 1 for u < 1/2, else 0.
std::int32_t left_half(SceneDescription& d) {
  return d.textures.add(
      CheckerboardTexture{.mapping = {.scale = {2, 1}},
                          .parts = {ColourValue{Rgb<double>(1)}, ColourValue{Rgb<double>(0)}}});
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
      const Ray ray{Vec3<float>(Vec3<double>{x, y, 0} - scene.origin()), {0, 0, 2}, 0, 1, 0};
      EXPECT_EQ(scene.occluded(ray), x < 0.5) << what << " at " << x << ", " << y;
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
  const auto ray = [&](const Vec3<double>& from, const Vec3<double>& way) {
    return Ray{Vec3<float>(from - scene->origin()), Vec3<float>(way), 0, 10, 0};
  };
  const auto through = scene->closest_hit(ray({0, -3, 0}, {0, 1, 0}));
  ASSERT_TRUE(through.has_value());
  EXPECT_NEAR(through->t, 4, 1e-5);
  const auto near = scene->closest_hit(ray({0, 3, 0}, {0, -1, 0}));
  ASSERT_TRUE(near.has_value());
  EXPECT_NEAR(near->t, 2, 1e-5);
  EXPECT_FALSE(scene->occluded(ray({-3, -0.5, 0}, {1, 0, 0})));
}

/// A texture that follows the world, in a scene whose coordinates begin elsewhere.
TEST(CutOuts, TexturesOfTheWorldStayInPlaceFarFromZero) {
  SceneDescription d = description();
  const Vec3<double> far{1e4, -3e4, 2e4};
  TextureMapping planar;
  planar.kind = TextureMapping::Kind::kPlanar;
  planar.axis_s = {2, 0, 0}, planar.axis_t = {0, 0, 0};
  planar.shift = {-2 * far.x, 0.5};
  const std::int32_t stripes = d.textures.add(CheckerboardTexture{
      .mapping = planar, .parts = {ColourValue{Rgb<double>(1)}, ColourValue{Rgb<double>(0)}}});
  d.shapes = {patch(far + Vec3<double>{0, 0, 1}, far + Vec3<double>{1, 0, 1},
                    far + Vec3<double>{0, 1, 1}, far + Vec3<double>{1, 1, 1})};
  d.shapes[0].alpha = {0, stripes};
  const auto scene = build(std::move(d));
  ASSERT_FALSE(scene->origin() == Vec3<double>{});
  for (const double x : {0.1, 0.4, 0.6, 0.9}) {
    const Ray ray{Vec3<float>(far + Vec3<double>{x, 0.5, 0} - scene->origin()), {0, 0, 2}, 0, 1, 0};
    EXPECT_EQ(scene->occluded(ray), x < 0.5) << x;
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
    const Vec3<double> from{(i % 64 + 0.5) / 64, (i / 64 + 0.5) / 64, 0};
    const Ray ray{Vec3<float>(from - scene->origin()), {0, 0, 2}, 0, 1, 0};
    blocked += scene->occluded(ray);
    EXPECT_EQ(scene->occluded(ray), scene->closest_hit(ray).has_value());
  }
  EXPECT_NEAR(blocked / double(kRays), 0.3, 0.04);
}

TEST(CutOuts, SurfacesInARowLetRaysPassEachOnItsOwn) {
  SceneDescription d = description();
  d.shapes = {patch({0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}),
              patch({0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {1, 1, 2}), shape(SphereParams{})};
  d.shapes[2].geometry = SphereParams{
      .radius_m = 1, .world_from_object = Transform::translate({0.5, 0.5, 5})};
  for (ShapeDescription& s : d.shapes) s.alpha = {0.5};
  const auto scene = build(std::move(d));
  int passed = 0, near = 0;
  constexpr int kRays = 8000;
  for (int i = 0; i < kRays; ++i) {
    const Vec3<double> from{(i % 80 + 0.5) / 80, (i / 80 + 0.5) / 100, 0};
    Ray ray{Vec3<float>(from - scene->origin()), {0, 0, 9}, 0, 1, 0};
    passed += !scene->occluded(ray);  // two sheets, and both sides of the ball
    ray.t_max = 0.4F;
    near += !scene->occluded(ray);  // two sheets
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
  EXPECT_EQ(scene->textures().size(), 2U);
  const IrradiancePoint point{Vec3<double>{0.3, 0.5, 3} - scene->origin(), {}, {0, 0, -1}};
  const auto lux = estimate_irradiance(
      *scene, std::span(&point, 1), {.samples_per_block = 64, .block_count = 16, .bounces = {}},
      {});
  EXPECT_GT(lux.points[0].irradiance_lx.g, 101);  // more than the direct light from 1 m
}

TEST(CutOuts, LightFallsThroughHoles) {
  SceneDescription d = description();
  ShapeDescription screen = patch({0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1});
  screen.alpha = {0, left_half(d)};
  screen.has_uv = true;
  d.shapes = {screen,
              emissive(patch({0.2, 0.4, 3}, {0.2, 0.6, 3}, {0.4, 0.4, 3}, {0.4, 0.6, 3}), 1, true)};
  const auto scene = build(std::move(d));
  const auto lx = [&](double x) {
    const IrradiancePoint point{Vec3<double>{x, 0.5, 0} - scene->origin(), {}, {0, 0, 1}};
    return estimate_irradiance(*scene, std::span(&point, 1), {.bounces = 0}, {})
        .points[0]
        .irradiance_lx.g;
  };
  EXPECT_EQ(lx(0.3), 0);
  EXPECT_GT(lx(0.95), 0);
}

}  // namespace
}  // namespace lucerna::testing
