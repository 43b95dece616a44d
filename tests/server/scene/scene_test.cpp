#include "server/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

SurfaceHit hit_below(const Scene& scene, float x, float y, float z) {
  const auto hit = scene.closest_hit({{x, y, z}, {0, 0, -1}});
  if (!hit) throw std::runtime_error("nothing hit");
  return *hit;
}

TEST(Scene, KeepsTheCoordinatesOfSceneNearTheirOwnZero) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(5, 0.125)};
  const auto scene = build(std::move(d));
  EXPECT_EQ(scene->origin(), (Vec3{}));
  const Vec3 p = hit_below(*scene, 1.5f, 2, 3).position;
  EXPECT_NEAR(p.x, 1.5, 1e-6);
  EXPECT_NEAR(p.y, 2, 1e-6);
  EXPECT_EQ(p.z, 0.125f);
}

TEST(Scene, MovesItsOriginToGeometryFarAway) {
  SceneDescription d = testing::description();
  // Extent 2: the origin is rounded to multiples of 2.
  d.shapes = {testing::patch({1000000, 3, 0}, {1000002, 3, 0}, {1000000, 5, 0}, {1000002, 5, 0})};
  d.lights = {testing::point_light({1000001, 4, 1e-3}, 1)};
  const auto scene = build(std::move(d));
  EXPECT_EQ(scene->origin().x, 1000000);
  EXPECT_EQ(scene->origin().y, 4);
  EXPECT_EQ(scene->origin().z, 0);
  const auto s = scene->lights()[0].light->sample_li({1, 0, 0}, {});
  EXPECT_FLOAT_EQ(s.distance, 1e-3f);
}

TEST(Scene, NumbersLightsFromOneAreaLightsLast) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(1), testing::emissive(testing::floor(1, 1), 3),
              testing::emissive({SphereParams{}}, 4)};
  d.lights = {testing::point_light({0, 0, 2}, 1), {UniformInfiniteLightParams{Rgb(1)}, {}}};
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->lights().size(), 4u);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(scene->lights()[i].id, i + 1);
    EXPECT_EQ(scene->lights().find(i + 1), i);
  }
  EXPECT_FALSE(scene->lights().find(0));
  EXPECT_FALSE(scene->lights().find(5));
  const auto shape_of = [&](std::size_t i) {
    return &dynamic_cast<const AreaLight&>(*scene->lights()[i].light).shape();
  };
  EXPECT_NE(dynamic_cast<const PatchMesh*>(shape_of(2)), nullptr);
  EXPECT_NE(dynamic_cast<const Sphere*>(shape_of(3)), nullptr);
  EXPECT_THAT(std::vector(scene->lights().infinite().begin(), scene->lights().infinite().end()),
              ElementsAre(1u));
  EXPECT_EQ(hit_below(*scene, 0.9f, 0.9f, 0.5f).light, -1);
  EXPECT_EQ(hit_below(*scene, 0.9f, 0.9f, 3).light, 2);
  EXPECT_EQ(hit_below(*scene, 0, 0, 0.99f).light, -1);
}

TEST(Scene, ReportsThePrimitiveOfALightAlsoForFlatPatchesOfTwoTriangles) {
  SceneDescription d = testing::description();
  PatchMeshData mesh;  // flat, twisted, flat
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 2; ++y)
      mesh.positions.push_back({double(x), double(y), x == 2 && y == 1 ? 0.25 : 0.0});
  mesh.positions.push_back({4, 0, 0});
  mesh.positions.push_back({4, 1, 0});
  mesh.positions[4].z = mesh.positions[5].z = mesh.positions[6].z = mesh.positions[7].z = 0;
  mesh.positions[3].z = 0;
  // Patch 1, from x = 1 to 2, is bent by its own copy of a corner.
  mesh.positions.push_back({2, 1, 0.25});
  mesh.indices = {0, 2, 1, 3, 2, 4, 3, 10, 4, 6, 5, 7, 6, 8, 7, 9};
  d.shapes = {testing::floor(9, -1), {mesh}};
  d.shapes[1] = testing::emissive(d.shapes[1], 1);
  const auto scene = build(std::move(d));
  EXPECT_EQ(scene->geometry().primitive_count(), 2 + 3 * 2 + 1u);
  for (const float y : {0.1f, 0.9f})
    for (int x = 0; x < 4; ++x) {
      const SurfaceHit hit = hit_below(*scene, static_cast<float>(x) + 0.5f, y, 3);
      EXPECT_EQ(hit.light_primitive, static_cast<std::uint32_t>(x)) << y;
      EXPECT_EQ(hit.light, 0);
      EXPECT_GT(hit.ng.z, 0.9);
    }
}

TEST(Scene, InterpolatesShadingNormalsAndTurnsThemToTheGeometricSide) {
  SceneDescription d = testing::description();
  TriangleMeshData mesh{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {0.6f, 0, 0.8f}, {0, 0, 1}}, {0, 1, 2}};
  TriangleMeshData flipped = mesh;
  for (auto& p : flipped.positions) p.x += 2;
  for (auto& n : flipped.normals) n = -n;
  TriangleMeshData flat{{{4, 0, 0}, {5, 0, 0}, {4, 1, 0}}, {}, {0, 1, 2}};
  d.shapes = {{flat}, {mesh}, {flipped}, {testing::floor(0.5, -5).geometry}};
  const auto scene = build(std::move(d));
  for (const float x : {0.5f, 2.5f}) {
    const SurfaceHit hit = hit_below(*scene, x, 0.25f, 1);
    // Halfway to vertex 1: (0.3, 0, 0.9), normalised.
    EXPECT_NEAR(hit.ns.x, 0.3 / std::hypot(0.3, 0.9), 1e-6);
    EXPECT_NEAR(hit.ns.z, 0.9 / std::hypot(0.3, 0.9), 1e-6);
    EXPECT_EQ(hit.ng, (Vec3{0, 0, 1}));
  }
  EXPECT_EQ(hit_below(*scene, 4.5f, 0.25f, 1).ns, (Vec3{0, 0, 1}));
}

TEST(Scene, MapsInstancedNormalsByTheInverseTransposeMirrorsIncluded) {
  SceneDescription d = testing::description();
  // The plane z = x through an object, outside up; stretched twofold along x and mirrored in y.
  d.objects = {{"ramp", {testing::patch({-1, -1, -1}, {1, -1, 1}, {-1, 1, -1}, {1, 1, 1})}}};
  d.instances = {{0, Transform::translate({10, 0, 0}) * *Transform::scale({2, -1, 1})}};
  const auto scene = build(std::move(d));
  const Vec3 o = scene->origin();
  const SurfaceHit hit = hit_below(*scene, static_cast<float>(11 - o.x), 0.3f, 5);
  EXPECT_NEAR(hit.position.z, 0.5, 1e-6);
  const Vec3 expected = normalized(Vec3{-1, 0, 2});
  EXPECT_NEAR(hit.ng.x, expected.x, 1e-6);
  EXPECT_NEAR(hit.ng.y, 0, 1e-6);
  EXPECT_NEAR(hit.ng.z, expected.z, 1e-6);
  EXPECT_EQ(scene->geometry().shape_count(), 1u);
}

TEST(Scene, BoundsTheErrorOfPositions) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  SceneDescription d = testing::description();
  const Vec3 a{-3 + u(random), -3 + u(random), u(random)}, b{3, -3, u(random)},
      c{u(random), 4, u(random)};
  d.shapes = {{TriangleMeshData{{a, b, c}, {}, {0, 1, 2}}},
              {SphereParams{.world_from_object = Transform::translate({0, 0, -3})}}};
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->origin(), (Vec3{}));
  const Vec3 fa{Vec3f(a)}, fb{Vec3f(b)}, fc{Vec3f(c)};
  const Vec3 n = normalized(cross(fb - fa, fc - fa));
  for (int i = 0; i < 2000; ++i) {
    const auto x = static_cast<float>(u(random) / 2), y = static_cast<float>(u(random) / 2);
    SurfaceHit hit = hit_below(*scene, x, y, 9);
    const auto reach = [&](const Vec3& m) {
      return std::fabs(m.x) * hit.position_error.x + std::fabs(m.y) * hit.position_error.y +
             std::fabs(m.z) * hit.position_error.z;
    };
    EXPECT_LE(std::fabs(dot(Vec3(hit.position) - fa, n)), reach(n));
    EXPECT_LT(max_abs(hit.position_error), 1e-5f);
    hit = hit_below(*scene, x, y, -1.5f);
    const Vec3 radius = Vec3(hit.position) - Vec3{0, 0, -3};
    EXPECT_LE(std::fabs(length(radius) - 1), reach(normalized(radius)));
  }
}

TEST(Scene, StoresEachSpectrumOnceAndReportsItsBytes) {
  const auto samples = std::make_shared<const Spectrum>(
      *Spectrum::create(SampledSpectrum{{400, 500, 700}, {1, 2, 3}}));
  const auto body = std::make_shared<const Spectrum>(*Spectrum::create(BlackBody{3000}));
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(2, -1), testing::emissive(testing::floor(1), 1)};
  d.shapes[1].emission->spectrum = samples;
  d.lights = {testing::point_light({0, 0, 1}, 1), testing::point_light({0, 0, 2}, 1),
              testing::point_light({0, 0, 3}, 1)};
  d.lights[1].spectrum = body;
  d.lights[2].spectrum = samples;
  const auto scene = build(d);
  ASSERT_EQ(scene->lights().spectra().size(), 2u);
  EXPECT_EQ(scene->lights().spectrum(0), nullptr);
  EXPECT_EQ(scene->lights().spectrum_number(0), std::nullopt);
  EXPECT_EQ(scene->lights().spectrum(1), body.get());
  EXPECT_EQ(scene->lights().spectrum(2), samples.get());
  EXPECT_EQ(scene->lights().spectrum(3), samples.get());  // the area light comes last
  EXPECT_EQ(scene->lights().spectrum_number(2), scene->lights().spectrum_number(3));
  const std::vector<ScenePart> parts = scene->parts();
  const auto part = std::ranges::find(parts, "spectra", &ScenePart::name);
  ASSERT_NE(part, parts.end());
  EXPECT_EQ(part->why, "2 spectra of 3 lights");
  // Each spectrum once, their places, and the index of each of the four lights.
  EXPECT_EQ(part->bytes, samples->bytes() + body->bytes() + 2 * sizeof samples + 4 * 4);
}

TEST(Scene, OfASinglePointChoosesInfiniteLights) {
  SceneDescription d = testing::description();
  d.lights = {testing::point_light({0, 0, 1}, 3), testing::point_light({0, 0, 1}, 3)};
  d.lights[1].params = DistantLightParams{{0, 0, 1}, Rgb(5)};
  const auto scene = build(d);
  EXPECT_EQ(scene->sphere().radius_m, 0);
  EXPECT_EQ(scene->lights().choose(LightSelection::kAutomatic, {}, 0.01)->light, 1u);
  EXPECT_EQ(scene->lights().choose(LightSelection::kAutomatic, {}, 0.01)->probability, 0.5);
  EXPECT_EQ(scene->lights().choose_emitter(0.99).light, 1u);
}

TEST(Scene, ErrorsOfLightsNameTheirPlaceInTheFile) {
  SceneDescription d = testing::description();
  d.shapes = {testing::emissive(testing::floor(1), -3)};
  auto error = Scene::build(d).status();
  EXPECT_EQ(error.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(error.message()), StartsWith("test.pbrt:7:3: "));
  EXPECT_THAT(std::string(error.message()), HasSubstr("radiance"));
  d.shapes = {
      testing::emissive({SphereParams{.world_from_object = *Transform::scale({1, 2, 1})}}, 1)};
  error = Scene::build(d).status();
  EXPECT_THAT(std::string(error.message()), StartsWith("test.pbrt:7:3: "));
}

TEST(Scene, RefusesValuesThatAreNotFiniteOrOutOfRange) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(1)};
  d.shapes[0].where = {"a.pbrt", 3, 9};
  std::get<PatchMeshData>(d.shapes[0].geometry).positions[2].y = NAN;
  auto error = Scene::build(d).status();
  EXPECT_EQ(error.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(error.message()), StartsWith("a.pbrt:3:9: vertex 2 at (-1, nan, 0)"));
  d.shapes = {testing::floor(1)};
  d.shapes[0].where = {"a.pbrt", 3, 9};
  std::get<PatchMeshData>(d.shapes[0].geometry).indices[3] = 4;
  error = Scene::build(d).status();
  EXPECT_THAT(std::string(error.message()),
              StartsWith("a.pbrt:3:9: vertex number 4, allowed: less than 4"));
  d.shapes = {testing::floor(1)};
  d.shapes[0].material = 1;
  EXPECT_EQ(Scene::build(d).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Scene, StopsBuildingOnRequest) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(1)};
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(Scene::build(d, "", stop.get_token()).status().code(), absl::StatusCode::kCancelled);
}

TEST(Scene, IdIsTheDigestOfItsFiles) {
  SceneDescription d = testing::description();
  d.assets = {{"a", std::string(32, 'x'), 5}};
  const std::string id = build(d)->id();
  EXPECT_EQ(build(d)->id(), id);
  d.assets[0].sha256[31] = 'y';
  EXPECT_NE(build(d)->id(), id);
}

TEST(FlatPatch, IsConvexAndPlanarToWithinRounding) {
  const auto flat = [](double x, double z) {
    return is_flat_and_convex({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {x, 1, z}}});
  };
  EXPECT_TRUE(flat(1, 0));
  EXPECT_TRUE(flat(0.5, 0));  // a trapezium
  EXPECT_TRUE(flat(1, 1e-8));
  EXPECT_FALSE(flat(1, 1e-6));
  EXPECT_FALSE(flat(-0.5, 0));  // folded
  EXPECT_FALSE(is_flat_and_convex({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0}}}));
  EXPECT_FALSE(is_flat_and_convex({{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {1, 1, 0}}}));
}

}  // namespace
}  // namespace lucerna
