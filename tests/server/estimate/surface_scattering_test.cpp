// The shading normals of surfaces with bumps, and single directions of mixes.
#include "server/estimate/surface_scattering.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// A height that grows by `rise.x` over u and by `rise.y` over v.
std::int32_t ramp(SceneDescription& d, Vec2 rise) {
  BilerpTexture t;
  // At (u, v) = (0, 0), (0, 1), (1, 0), (1, 1).
  t.corners = {Rgb(0), Rgb(rise.y), Rgb(rise.x), Rgb(rise.x + rise.y)};
  return d.textures.add(t);
}

/// The shading normal where a ray meets the first shape, whose material has these bumps.
Vec3 normal_at(SceneDescription d, std::int32_t bumps, const Vec3& from, const Vec3& way) {
  d.materials[0].bumps = bumps;
  for (ShapeDescription& s : d.shapes) s.has_uv = true;
  const auto scene = build(std::move(d));
  Ray ray{Vec3f(from - scene->origin()), Vec3f(way)};
  auto hit = scene->closest_hit(ray);
  EXPECT_TRUE(hit.has_value());
  const SurfaceScattering scattering(*scene, *hit);
  return Vec3(hit->ns);
}

void expect_near(const Vec3& a, const Vec3& b, double error) {
  EXPECT_NEAR(a.x, b.x, error);
  EXPECT_NEAR(a.y, b.y, error);
  EXPECT_NEAR(a.z, b.z, error);
}

TEST(Bumps, TiltThePlaneByTheSlopeOfTheirHeight) {
  // u along x over 4 m, v along y over 2 m.
  SceneDescription d = description();
  d.shapes = {patch({-2, -1, 0}, {2, -1, 0}, {-2, 1, 0}, {2, 1, 0})};
  const std::int32_t bumps = ramp(d, {0.8, 0.5});
  const Vec3 expected = normalized(Vec3{-0.2, -0.25, 1});
  expect_near(normal_at(d, bumps, {0.3, 0.2, 1}, {0, 0, -1}), expected, 1e-6);
  // From below, the normal stays on the side of the geometric normal.
  expect_near(normal_at(d, bumps, {0.3, 0.2, -1}, {0, 0, 1}), expected, 1e-6);

  TriangleMeshData mesh{
      .positions = {{-2, -1, 0}, {2, -1, 0}, {2, 1, 0}}, .normals = {}, .indices = {0, 1, 2}};
  mesh.corner_uv = {{0, 0}, {1, 0}, {1, 1}};
  d.shapes = {shape(std::move(mesh))};
  expect_near(normal_at(d, bumps, {0.3, -0.2, 1}, {0, 0, -1}), expected, 1e-6);
}

TEST(Bumps, KeepTheirSlopeInInstancesAndOnTurnedPatches) {
  SceneDescription d = description();
  // u runs against x here, so (u, v) have the other handedness.
  d.objects = {{"plane", {patch({1, -1, 0}, {-1, -1, 0}, {1, 1, 0}, {-1, 1, 0})}}};
  d.objects[0].shapes[0].has_uv = true;
  d.instances.push_back({0, *Transform::scale({3, 1, 1})});
  const Vec3 n = normal_at(d, ramp(d, {0.6, 0}), {0.3, 0.2, 1}, {0, 0, -1});
  // The height is that of the world: 0.6 over 6 m, downwards from z = 0.
  expect_near(n, normalized(Vec3{0.1, 0, -1}), 1e-6);
}

TEST(Bumps, FollowTheCoordinatesOfQuadrics) {
  SceneDescription d = description();
  d.shapes = {shape(SphereParams{.radius_m = 2})};
  // u is the angle about z over a turn: a metre of u is 1 / (4 pi) on the equator.
  const std::int32_t along_u = ramp(d, {1, 0}), along_v = ramp(d, {0, 1});
  const double u_slope = 1 / (4 * std::numbers::pi), v_slope = 1 / (2 * std::numbers::pi);
  expect_near(normal_at(d, along_u, {0, -5, 0}, {0, 1, 0}), normalized(Vec3{-u_slope, -1, 0}),
              1e-5);
  // v grows from -z to +z over half a turn.
  expect_near(normal_at(d, along_v, {5, 0.001, 0}, {-1, 0, 0}),
              normalized(Vec3{1, 0.0005, -v_slope}), 1e-4);
}

TEST(Bumps, AreNothingOnAnEvenHeight) {
  SceneDescription d = description();
  d.shapes = {floor(1)};
  expect_near(normal_at(d, ramp(d, {0, 0}), {0.3, 0.2, 1}, {0, 0, -1}), {0, 0, 1}, 1e-9);
}

TEST(Footprints, FollowTheDistanceOfTheCameraRay) {
  // Black and white texels of 1/64 m on a ground.
  SceneDescription d = description();
  std::vector<Rgbf> texels;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) texels.emplace_back((x + y) % 2 == 0 ? 0.0F : 1.0F);
  const auto image = d.textures.picture("checks", **Image::create(64, 64, texels));
  ImageTexture t{.image = image, .filter = TextureFilter::kEwa};
  t.mapping.scale = {1000, 1000};
  d.materials[0].params = DiffuseParams{{{}, d.textures.add(t)}};
  d.shapes = {patch({-500, -500, 0}, {500, -500, 0}, {-500, 500, 0}, {500, 500, 0})};
  d.shapes[0].has_uv = true;
  const auto scene = build(std::move(d));
  EXPECT_TRUE(scene->geometry().textures().uses_footprints());
  const auto contrast = [&](double distance, double angle) {
    double most = 0;
    for (int i = 0; i < 32; ++i) {
      const Vec3 target{0.3 + i / 300.0, 0.2, 0};
      const Vec3 w{0, std::sin(angle), -std::cos(angle)};
      const auto ray = [&](const Vec3& beside) {
        return Ray{Vec3f(target - w * distance - scene->origin()), Vec3f(normalized(w + beside))};
      };
      // Pixels of a milliradian.
      const NeighbourRays rays{ray({1e-3, 0, 0}),
                               ray({0, 1e-3 * std::cos(angle), 1e-3 * std::sin(angle)})};
      auto hit = scene->closest_hit(ray({}));
      EXPECT_TRUE(hit.has_value());
      const Vec3 up{0, 0, 1};
      const SurfaceScattering s(*scene, *hit, RayFilter::kSurfaces, &rays);
      most = std::max(most, std::fabs(s.value(up, up).r * std::numbers::pi - 0.5));
    }
    return most;
  };
  EXPECT_GT(contrast(1, 0), 0.2);     // 1 mm
  EXPECT_LT(contrast(100, 0), 0.03);  // 0.1 m, six texels
  EXPECT_GT(contrast(3, 0), 0.2);
  EXPECT_LT(contrast(3, 1.5), 0.1);  // 14 times as long on the ground
}

// At a point, chance takes one material.  A lamp's one mirror image would be whole or missing.
TEST(MeanSingle, WeighsTheMaterialsOfMixes) {
  const auto of = [](std::uint32_t material) {
    SceneDescription d = description();
    d.materials.push_back({.params = MetalParams{.reflectance = ColourValue{Rgb(0.8)}}});
    d.materials.push_back({.params = MixParams{{0, 1}, {0.25}}});
    d.materials.push_back({.params = MixParams{{2, 1}, {0.5}}});
    d.shapes = {floor(1)};
    d.shapes[0].material = material;
    const auto scene = build(std::move(d));
    const auto hit = scene->closest_hit({Vec3f(Vec3{0, 0, 1} - scene->origin()), {0, 0, -1}});
    return mean_single(*scene, *hit, {0, 0, 1}, Side::kReflected).g;
  };
  EXPECT_GT(of(1), 0.5);
  EXPECT_EQ(of(0), 0);
  EXPECT_NEAR(of(2), 0.25 * of(1), 1e-12);
  EXPECT_NEAR(of(3), 0.625 * of(1), 1e-12);
}

}  // namespace
}  // namespace lucerna::testing
