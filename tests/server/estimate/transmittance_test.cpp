// Light that arrives in part: through media that absorb, and through smooth thin panes.
#include <gtest/gtest.h>

#include <cmath>

#include "server/estimate/render.h"
#include "server/queries/emission_queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

constexpr double kFog = 0.7;
const Rgb kInk{0.5, 1, 2};

/// The outside of a box, normals outwards.
TriangleMeshData box(const Vec3& centre, const Vec3& half) {
  TriangleMeshData mesh = room();
  for (Vec3& p : mesh.positions) p = centre + Vec3{p.x * half.x, p.y * half.y, p.z * half.z};
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  return mesh;
}

ShapeDescription boundary(TriangleMeshData mesh, std::int32_t inside, std::int32_t outside = -1) {
  ShapeDescription s = shape(std::move(mesh));
  s.media = MediumSides{inside, outside};
  s.is_interface = true;
  return s;
}

/// Media 0, which is grey, and 1, which has a colour.
SceneDescription with_media() {
  SceneDescription d = description();
  d.media = {{Rgb(kFog)}, {kInk}};
  return d;
}

/// A pane of glass over (-1, -1) to (1, 1) at this height.
ShapeDescription pane(SceneDescription& d, double z, double eta = 1.5) {
  ShapeDescription s = floor(1, z);
  s.material = static_cast<std::uint32_t>(d.materials.size());
  d.materials.push_back({.params = ThinDielectricParams{{eta}}});
  return s;
}

/// The share that a pane passes at the angle of this cosine, from Fresnel's equations and the sum
/// over all reflections between its two sides.
double pane_share(double cosine, double eta = 1.5) {
  const double sine = std::sqrt(1 - cosine * cosine) / eta, inner = std::sqrt(1 - sine * sine);
  const double s = (cosine - eta * inner) / (cosine + eta * inner),
               p = (eta * cosine - inner) / (eta * cosine + inner);
  const double r = (s * s + p * p) / 2;
  return (1 - r) / (1 + r);
}

Rgb seen(const Scene& scene, const Vec3& a, const Vec3& b,
         ThinGlass thin_glass = ThinGlass::kPasses) {
  const Vec3f from(a), to(b);
  const std::array f{from.x, from.y, from.z}, t{to.x, to.y, to.z};
  std::uint8_t visible = 0;
  std::array<float, 3> share{};
  int status = 0;
  test_visibility(
      scene, {.from = {{}, f}, .to = PointArray{{}, t}, .thin_glass = thin_glass},
      {&visible, Transmittance(scene, thin_glass).is_partial() ? share.data() : nullptr, &status},
      {});
  EXPECT_EQ(status, static_cast<int>(ItemResult::kOk));
  if (!Transmittance(scene, thin_glass).is_partial()) return Rgb(visible);
  if (visible == 0) {
    EXPECT_EQ(share, (std::array<float, 3>{}));
  }
  return {share[0], share[1], share[2]};
}

void expect_near(const Rgb& a, const Rgb& b, double error, const char* what = "") {
  EXPECT_NEAR(a.r, b.r, error) << what;
  EXPECT_NEAR(a.g, b.g, error) << what;
  EXPECT_NEAR(a.b, b.b, error) << what;
}

Rgb left_of(const Rgb& absorption, double metres) {
  return {std::exp(-absorption.r * metres), std::exp(-absorption.g * metres),
          std::exp(-absorption.b * metres)};
}

IrradianceResult light_at(const Scene& scene, const Vec3& at, const IrradianceSettings& settings) {
  const IrradiancePoint point{at - scene.origin(), {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}};
  return estimate_irradiance(scene, std::span(&point, 1), settings, {});
}

TEST(Media, SegmentsLoseLightOverTheirLengthWithinAMedium) {
  SceneDescription d = with_media();
  d.shapes = {boundary(box({2, 0, 0}, {1, 1, 1}), 1), boundary(box({6, 0, 0}, {1, 1, 1}), 0)};
  const auto scene = build(std::move(d));
  const Rgb fog(kFog), none(0);
  struct Segment {
    double from, to;
    double in_ink, in_fog;  // metres
  };
  for (const Segment& s : {Segment{0, 8, 2, 2}, Segment{0, 0.9, 0, 0}, Segment{0, 2.5, 1.5, 0},
                           Segment{1.5, 2.75, 1.25, 0}, Segment{2.25, 4, 0.75, 0},
                           Segment{3.5, 4.5, 0, 0}, Segment{1.25, 6.5, 1.75, 1.5}}) {
    const Rgb expected = left_of(kInk, s.in_ink) * left_of(fog, s.in_fog);
    expect_near(seen(*scene, {s.from, 0.1, 0.2}, {s.to, 0.1, 0.2}), expected, 1e-6);
    expect_near(seen(*scene, {s.to, 0.1, 0.2}, {s.from, 0.1, 0.2}), expected, 1e-6);
  }
}

TEST(Media, BoxesWithinBoxesEndWhereTheyEnd) {
  SceneDescription d = with_media();
  d.shapes = {boundary(box({0, 0, 0}, {2, 2, 2}), 0), boundary(box({0, 0, 0}, {1, 1, 1}), 1, 0)};
  const auto scene = build(std::move(d));
  const auto expected = [&](double fog, double ink) {
    return left_of(Rgb(kFog), fog) * left_of(kInk, ink);
  };
  expect_near(seen(*scene, {-3, 0.1, 0.2}, {5, 0.1, 0.2}), expected(2, 2), 1e-6);
  expect_near(seen(*scene, {0.5, 0.1, 0.2}, {1.5, 0.1, 0.2}), expected(0.5, 0.5), 1e-6);
  expect_near(seen(*scene, {-0.5, 0.1, 0.2}, {0.5, 0.1, 0.2}), expected(0, 1), 1e-6);
}

TEST(Media, OpaqueSurfacesBlockAndMayBoundMedia) {
  SceneDescription d = with_media();
  // A tank with an opaque wall at x = 3; a stone within it that bounds nothing.
  d.shapes = {boundary(box({2, 0, 0}, {1, 1, 1}), 1), shape(ball(2, [](const auto& p) {
                return p * 0.2 + Vec3{2, 0, 0};
              }))};
  d.shapes[0].is_interface = false;
  const auto scene = build(std::move(d));
  expect_near(seen(*scene, {0, 0, 0}, {2, 0.5, 0}), Rgb(0), 0, "through the wall");
  expect_near(seen(*scene, {1.5, 0, 0}, {2.5, 0, 0}), Rgb(0), 0, "through the stone");
  expect_near(seen(*scene, {1.25, 0, 0}, {1.75, 0, 0}), left_of(kInk, 0.5), 1e-6, "to the stone");
  expect_near(seen(*scene, {1.75, 0.5, 0}, {1.25, 0.5, 0}), left_of(kInk, 0.5), 1e-6);
}

TEST(Media, TheSurroundingMediumIsWhereNoSurfaceBoundsOne) {
  SceneDescription d = with_media();
  d.surrounding_medium = 0;
  d.lights = {point_light({0, 0, 2}, 100), {UniformInfiniteLightParams{Rgb(1)}, {}}};
  d.shapes = {floor(5)};
  const auto scene = build(std::move(d));
  expect_near(seen(*scene, {0, 0, 1}, {0, 3, 1}), left_of(Rgb(kFog), 3), 1e-6);
  // Light from infinitely far does not arrive.
  const auto lux = light_at(*scene, {0, 0, 0}, {.block_count = 2, .bounces = 0});
  expect_near(lux.points[0].irradiance_lx, left_of(Rgb(kFog), 2) * 25.0, 1e-4);
}

TEST(Media, ASurroundingMediumTakesLightInScenesWithoutSurfaces) {
  SceneDescription d = with_media();
  d.surrounding_medium = 0;
  d.lights = {point_light({0, 0, 2}, 100), {UniformInfiniteLightParams{Rgb(1)}, {}}};
  const auto scene = build(std::move(d));
  const auto lux = light_at(*scene, {0, 0, 0}, {.block_count = 2, .bounces = 0, .per_light = true});
  expect_near(lux.per_light[0].irradiance_lx, left_of(Rgb(kFog), 2) * 25.0, 1e-4);
  expect_near(lux.per_light[1].irradiance_lx, Rgb(0), 0);
}

/// A tank that is open at the top: its water has one boundary, which is above.
TEST(Media, ABoundaryBehindARayTellsItsMediumIfNoneIsAhead) {
  SceneDescription d = with_media();
  d.shapes = {floor(5), floor(5, 1)};
  d.shapes[1].is_interface = true;
  d.shapes[1].media = MediumSides{1, -1};
  const auto scene = build(std::move(d));
  expect_near(seen(*scene, {0, 0, 0.75}, {0, 0, 0.25}), left_of(kInk, 0.5), 1e-6);
  expect_near(seen(*scene, {0, 0, 1.5}, {0, 0, 0.5}), left_of(kInk, 0.5), 1e-6);
}

TEST(Media, SurfacesInOnePlaceFollowEachOther) {
  // 1 m of ink, over which is fog without an end.
  for (const bool ink_first : {true, false}) {
    SceneDescription d = with_media();
    const auto level = [](double z, MediumSides sides) {
      TriangleMeshData square;
      square.positions = {{-5, -5, z}, {5, -5, z}, {5, 5, z}, {-5, 5, z}};
      square.indices = {0, 1, 2, 0, 2, 3};
      ShapeDescription s = shape(std::move(square));
      s.is_interface = true;
      s.media = sides;
      return s;
    };
    // The media below and above.
    const ShapeDescription top_of_ink = level(1, {1, -1}), bottom_of_fog = level(1, {-1, 0});
    d.shapes = {level(0, {-1, 1}), ink_first ? top_of_ink : bottom_of_fog,
                ink_first ? bottom_of_fog : top_of_ink};
    const auto scene = build(std::move(d));
    const Rgb expected = left_of(kInk, 1) * left_of(Rgb(kFog), 2);
    // Also along the edge of two triangles.
    expect_near(seen(*scene, {0.1, 0.2, -1}, {0.1, 0.2, 3}), expected, 1e-6);
    expect_near(seen(*scene, {0.1, 0.1, -1}, {0.1, 0.1, 3}), expected, 1e-6);
    expect_near(seen(*scene, {0.1, 0.2, 3}, {0.1, 0.2, -1}), expected, 1e-6);
    const Rgb less = left_of(kInk, 0.5) * left_of(Rgb(kFog), 2);
    expect_near(seen(*scene, {0.1, 0.2, 0.5}, {0.1, 0.2, 3}), less, 1e-6);
    expect_near(seen(*scene, {0.1, 0.2, 3}, {0.1, 0.2, 0.5}), less, 1e-6);
  }
}

TEST(Media, InterfacesWithoutAbsorptionLeaveNothingBehind) {
  SceneDescription d = with_media();
  d.media[1] = {};
  d.shapes = {floor(1), boundary(box({2, 0, 0}, {1, 1, 1}), 1)};
  const auto scene = build(std::move(d));
  EXPECT_FALSE(scene->geometry().has_media());
  EXPECT_EQ(scene->geometry().shape_count(), 1U);
}

TEST(Media, InterfacesOfInstancesAndOfQuadricsCount) {
  SceneDescription d = with_media();
  ShapeDescription ball = shape(SphereParams{.radius_m = 1});
  ball.media = MediumSides{0, -1};
  ball.is_interface = true;
  d.objects = {{"ball", {ball}}};
  d.instances = {{0, Transform::translate({2, 0, 0}) * *Transform::scale({0.5, 2, 1})}};
  d.shapes = {floor(1, -4)};
  const auto scene = build(std::move(d));
  expect_near(seen(*scene, {0, 0, 0}, {4, 0, 0}), left_of(Rgb(kFog), 1), 1e-6);
  expect_near(seen(*scene, {2, -3, 0}, {2, 1, 0}), left_of(Rgb(kFog), 3), 1e-5);
  EXPECT_FALSE(scene->geometry().occluded(Ray{{0, 0, 0}, {4, 0, 0}, 0, 1}));
}

TEST(Media, LightOfEachCallLosesTheSame) {
  SceneDescription d = with_media();
  const Vec3 lamp{0, 0, 3};
  d.shapes = {floor(5), boundary(box({0, 0, 1}, {4, 4, 0.5}), 1),
              emissive(patch({-.1, -.1, 3.5}, {-.1, .1, 3.5}, {.1, -.1, 3.5}, {.1, .1, 3.5}), 50)};
  d.lights = {point_light(lamp, 90)};
  const auto scene = build(d);
  d.shapes.erase(d.shapes.begin() + 1);
  const auto clear = build(std::move(d));
  // Straight down, so that nearly all light passes 1 m of ink.
  const auto of = [&](const Scene& s, std::uint64_t block_samples) {
    return light_at(s, {0, 0, 0},
                    {.samples_per_block = static_cast<std::uint32_t>(block_samples),
                     .block_count = 16,
                     .bounces = 0,
                     .per_light = true});
  };
  const auto with = of(*scene, 64), without = of(*clear, 64);
  expect_near(with.per_light[0].irradiance_lx,
              without.per_light[0].irradiance_lx * left_of(kInk, 1), 1e-6, "point");
  const Rgb expected = without.per_light[1].irradiance_lx * left_of(kInk, 1);
  expect_near(with.per_light[1].irradiance_lx, expected, 2e-3 * expected.r, "area");

  const std::array<float, 3> from{0, 0, 0}, up{0, 0, 1};
  std::array<float, 3> radiance{};
  std::uint64_t light = 0;
  int status = 0;
  le(*scene, {.points = {{}, from}, .directions = up},
     {.radiance_cd_m2 = radiance.data(),
      .light_ids = &light,
      .status = &status,
      .spectral_radiance = nullptr},
     {});
  expect_near({radiance[0], radiance[1], radiance[2]}, left_of(kInk, 1) * 50.0, 1e-4, "Le");
}

TEST(Media, PathsLoseLightOnEachPart) {
  // A white room full of fog: what a diffuse wall sends back is lost on the way.  With the lamp at
  // the centre of a sphere of radius 1, direct light is exp(-fog) of that without fog; each
  // reflection sends light along chords of mean density cos / pi.
  SceneDescription d = description(0.5);
  d.media = {{Rgb(kFog)}};
  ShapeDescription wall = shape(SphereParams{.radius_m = 1, .reverse_orientation = true});
  wall.media = MediumSides{-1, 0};
  d.shapes = {wall};
  d.lights = {point_light({0, 0, 0}, 100)};
  const auto scene = build(std::move(d));
  // A chord at angle t to the normal is 2 cos t long: the mean of exp(-2 k c) over the density
  // 2 c dc is (1 - (1 + 2 k) exp(-2 k)) / (2 k^2).
  const double k = kFog, chord = (1 - (1 + 2 * k) * std::exp(-2 * k)) / (2 * k * k);
  const double direct = 100 * std::exp(-k), expected = direct / (1 - 0.5 * chord);
  const IrradiancePoint point{{0, 0, -1}, {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}};
  const auto lux =
      estimate_irradiance(*scene, std::span(&point, 1),
                          {.samples_per_block = 1024, .block_count = 16, .bounces = {}}, {});
  EXPECT_NEAR(lux.points[0].irradiance_lx.g, expected, 4 * lux.points[0].illuminance_error_lx);
  EXPECT_LT(lux.points[0].illuminance_error_lx, 0.005 * expected);
}

TEST(ThinGlass, PanesInARowMultiplyAlsoInStretchedInstances) {
  SceneDescription d = description();
  d.objects = {{"pane", {pane(d, 0)}}};
  const auto tilted = *Transform::rotate(0.5, {1, 0, 0}) * *Transform::scale({3, 0.5, 2});
  d.instances = {{0, Transform::translate({0, 0, 1}) * tilted},
                 {0, Transform::translate({0, 0, 2}) * tilted}};
  const auto scene = build(std::move(d));
  const double one = pane_share(std::cos(0.5));
  EXPECT_NEAR(seen(*scene, {0, 0, 0}, {0, 0, 3}).g, one * one, 1e-6);
  EXPECT_EQ(seen(*scene, {0, 0, 0}, {0, 0, 3}, ThinGlass::kBlocks).g, 0);
  EXPECT_EQ(seen(*scene, {4, 0, 0}, {4, 0, 3}).g, 1);
  // Rays that look for surfaces pass by chance, each pane on its own.
  int passed = 0;
  constexpr int kRays = 20000;
  for (int i = 0; i < kRays; ++i) {
    const Ray ray{{0.001F * static_cast<float>(i % 100), 0.001F * static_cast<float>(i / 100), 0},
                  {0, 0, 1}};
    passed += !scene->closest_hit(ray, RayFilter::kPanesByChance);
    EXPECT_TRUE(scene->closest_hit(ray, RayFilter::kSurfaces));
    EXPECT_FALSE(scene->closest_hit(ray, RayFilter::kOpaque));
  }
  EXPECT_NEAR(passed / double(kRays), one * one, 0.01);
}

/// Light through a pane as direct light, and the same light found by paths.
TEST(ThinGlass, DirectLightEqualsThatOfPathsThroughThePane) {
  SceneDescription d = description(0);
  d.shapes = {floor(3), pane(d, 1),
              emissive(patch({-1, -1, 2}, {-1, 1, 2}, {1, -1, 2}, {1, 1, 2}), 100)};
  const auto scene = build(std::move(d));
  IrradianceSettings direct{.samples_per_block = 256, .block_count = 16, .bounces = 0};
  IrradianceSettings paths = direct;
  paths.bounces = 1;
  paths.methods.thin_glass = ThinGlass::kBlocks;
  const auto a = light_at(*scene, {0.3, 0.1, 0}, direct).points[0];
  const auto b = light_at(*scene, {0.3, 0.1, 0}, paths).points[0];
  // The pane reflects nothing else, since all else is black.
  EXPECT_NEAR(a.irradiance_lx.g, b.irradiance_lx.g,
              4 * std::hypot(a.illuminance_error_lx, b.illuminance_error_lx));
  EXPECT_LT(a.illuminance_error_lx, 0.01 * a.irradiance_lx.g);
  direct.methods.thin_glass = ThinGlass::kBlocks;
  const auto blocked = light_at(*scene, {0.3, 0.1, 0}, direct).points[0];
  EXPECT_LT(blocked.irradiance_lx.g, 0.5 * a.irradiance_lx.g);
}

/// Energy is neither lost nor gained: a closed white room with a pane across it is as bright as
/// without one, in the mean over all its walls.
TEST(ThinGlass, RoomsWithAPaneKeepTheirLight) {
  SceneDescription d = description(0.8);
  // A lamp with a surface, because paths do not find points in mirrors.
  d.shapes = {
      shape(room()),
      emissive(shape(SphereParams{.radius_m = 0.1,
                                  .world_from_object = Transform::translate({0.2, 0.1, 0.5})}),
               2000),
      pane(d, 0)};
  const auto with = build(d);
  d.shapes.pop_back();
  const auto without = build(std::move(d));
  const auto total = [](const Scene& scene) {
    std::vector<IrradiancePoint> points;
    // All six walls, at the centres of 6 x 6 squares.
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0})
        for (int i = 0; i < 36; ++i) {
          const double a = (i % 6 + 0.5) / 3 - 1, b = (i / 6 + 0.5) / 3 - 1;
          const Vec3 p = axis == 0   ? Vec3{side, a, b}
                         : axis == 1 ? Vec3{a, side, b}
                                     : Vec3{a, b, side};
          const Vec3 n = axis == 0   ? Vec3{-side, 0, 0}
                         : axis == 1 ? Vec3{0, -side, 0}
                                     : Vec3{0, 0, -side};
          points.push_back({p, {1e-6F, 1e-6F, 1e-6F}, n});
        }
    const auto lux = estimate_irradiance(
        scene, points, {.samples_per_block = 64, .block_count = 16, .bounces = {}}, {});
    double sum = 0, variance = 0;
    for (const auto& e : lux.points)
      sum += e.irradiance_lx.g, variance += e.illuminance_error_lx * e.illuminance_error_lx;
    return std::pair{sum / 216, std::sqrt(variance) / 216};
  };
  const auto [a, a_error] = total(*with);
  const auto [b, b_error] = total(*without);
  EXPECT_NEAR(a, b, 4 * std::hypot(a_error, b_error) + 0.005 * b);  // the squares
  EXPECT_LT(a_error, 0.005 * a);
}

TEST(ThinGlass, ShadowMapsAreNotUsedWhereLightArrivesInPart) {
  SceneDescription d = description();
  d.shapes = {floor(3), pane(d, 1)};
  d.lights = {point_light({0, 0, 2}, 100)};
  const auto scene = build(std::move(d));
  IrradianceSettings settings{.block_count = 2, .bounces = 0};
  settings.methods.visibility = VisibilityMethod::kShadowMaps;
  const auto lux = light_at(*scene, {0, 0, 0}, settings);
  EXPECT_NEAR(lux.points[0].irradiance_lx.g, 25 * pane_share(1), 1e-5);
  EXPECT_EQ(lux.work.map_lookups, 0U);
  EXPECT_EQ(lux.work.through_panes, 1U);
}

// A hash of the ray would let all of a point light pass, or none.
TEST(Sheets, WithAConstantAlphaPassTheRest) {
  SceneDescription d = description();
  d.shapes = {floor(1, 1), pane(d, 1.5)};
  d.shapes[0].alpha = {0.25};
  d.shapes[1].alpha = {0.5};
  d.lights = {point_light({0, 0, 2}, 10)};
  const auto scene = build(std::move(d));
  for (const double x : {0.0, 0.1, 0.3}) {
    const Vec3 to = Vec3{-x, 0, 2};
    const double cosine = normalized(to).z;
    const double share = 0.75 * (0.5 + 0.5 * pane_share(cosine));
    EXPECT_NEAR(luminance(light_at(*scene, {x, 0, 0}, {.bounces = 0}).points[0].irradiance_lx),
                10 * share * cosine / dot(to, to), 1e-5);
    expect_near(seen(*scene, {x, 0, 0}, {0, 0, 2}), Rgb(share), 1e-6);
  }
  expect_near(seen(*scene, {0.1, 0, 0}, {0.1, 0, 1.2}), Rgb(0.75), 1e-6);
}

}  // namespace
}  // namespace lucerna::testing
