// Surfaces of lights that edits move: they share the BVH of all others, and rays have the bits that
// they have in a scene built with the surfaces at their new places.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <tuple>

#include "lights/maths/motion.h"
#include "server/scene/light_at_time.h"
#include "server/scene/moved_geometry.h"
#include "server/scene/scene.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;

template <typename T>
T value(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

absl::StatusOr<std::shared_ptr<const SceneGeometry>> edited(const Scene& loaded,
                                                            const SurfaceEdits& edits) {
  return moved_geometry(loaded.geometry(), loaded.lights(), edits);
}

/// A sheet of triangles that is not flat, with normals, about `centre`.
ShapeDescription wave(const Vec3& centre, double size) {
  TriangleMeshData mesh;
  constexpr int kSide = 5;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      mesh.positions.push_back(
          centre + Vec3{i / 4.0 - 0.5, j / 4.0 - 0.5, 0.1 * std::sin(i + 2 * j)} * size);
      mesh.normals.push_back(Vec3f(normalized(Vec3{0.1 * i, 0.1 * j, 1})));
    }
  for (std::uint32_t i = 0; i + 1 < kSide; ++i)
    for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
      const std::uint32_t a = i * kSide + j, c = a + kSide;
      for (const std::uint32_t k : {a, c, a + 1, a + 1, c, c + 1}) mesh.indices.push_back(k);
    }
  return testing::shape(std::move(mesh));
}

template <typename Params>
ShapeDescription at(const Vec3& centre, double size) {
  Params params;
  params.world_from_object = Transform::translate(centre) * *Transform::scale({size, size, size});
  return testing::shape(params);
}

/// One light of every shape, in a scene with an instance, a shape that moves by itself, and grounds
/// that are horizontal and tilted.  The lights are 1 to 8.
SceneDescription every_shape(double size, double ground) {
  SceneDescription d = testing::description();
  const auto place = [&](double x, double y) { return Vec3{x, y, 2} * size; };
  ShapeDescription tilted = testing::patch(
      Vec3{-ground, -ground, -0.5 * ground} * size, Vec3{ground, -ground, -0.5 * ground} * size,
      Vec3{-ground, ground, 0.3 * ground} * size, Vec3{ground, ground, 0.3 * ground} * size);
  const Vec3 c = place(1, -1);
  ShapeList lamps{
      wave(place(-1, -1), size),
      testing::patch(c, c + Vec3{size, 0, 0}, c + Vec3{0, size, 0}, c + Vec3{size, size, 0}),
      testing::patch(place(-1, 1), place(0, 1), place(-1, 2), place(0, 2) + Vec3{0, 0, size}),
      at<SphereParams>(place(1, 1), 0.25 * size),
      at<DiskParams>(place(0, 0), 0.5 * size),
      at<CylinderParams>(place(2, 2), 0.25 * size),
      wave(place(-2, 0), size),
      wave(place(2, 0), size)};
  lamps[6].alpha = NumberValue{0.5};
  d.shapes = {testing::floor(ground * size), tilted};
  for (ShapeDescription& lamp : lamps) {
    d.shapes.push_back(testing::emissive(lamp, 3, true));
    d.shapes.push_back(wave(place(0.3 * static_cast<double>(d.shapes.size()), -2), 0.5 * size));
  }
  ShapeDescription moving = wave({}, size);
  const std::vector<KeyTransform> keys{{0, Transform::translate(place(0, -2))},
                                       {1, Transform::translate(place(0.5, -2))}};
  moving.motion = std::make_shared<const Motion>(value(Motion::create(keys)));
  d.shapes.push_back(moving);
  d.objects = {{"leaf", {wave({}, size)}}};
  d.instances = {{0, Transform::translate(place(-2, 2)), {}, {}}};
  return d;
}

MovedSurfaces moves_of(double size) {
  MovedSurfaces moves;
  for (std::uint64_t light = 1; light <= 8; ++light) {
    if (light == 8) continue;  // stays where it is
    moves[light] = {.shift_m = Vec3{0.37, -0.21, 0.13} * (size * (light % 2 == 0 ? 1 : -1))};
    // Flat patches of two triangles and disks turn too.
    if (light != 3) moves[light].turn_axis = {0, 0, 1}, moves[light].turn_rad = 0.1 * light;
  }
  return moves;
}

LightEdits edits_of(const MovedSurfaces& moves) {
  LightEdits edits;
  for (const auto& [id, change] : moves) edits.changes[id] = change;
  return edits;
}

auto bits_of(const SurfaceHit& hit) {
  const auto of = [](const auto& v) { return std::tuple(v.x, v.y, v.z); };
  return std::tuple(hit.t, of(hit.position), of(hit.position_error), of(hit.ng), of(hit.ns),
                    hit.light, hit.light_primitive, hit.shape, hit.kind, hit.primitive, hit.uv.x,
                    hit.uv.y);
}

class Moved : public ::testing::TestWithParam<std::pair<double, double>> {};

// Sizes from a millimetre to a kilometre change the unit of rays.  Small lights over a tilted
// ground make its triangles wide.
INSTANTIATE_TEST_SUITE_P(Sizes, Moved,
                         ::testing::Values(std::pair(1.0, 4.0), std::pair(1e-3, 4.0),
                                           std::pair(1e3, 4.0), std::pair(1.0, 1e6)));

TEST_P(Moved, SurfacesHaveTheBitsOfASceneBuiltThere) {
  const auto [size, ground] = GetParam();
  const MovedSurfaces moves = moves_of(size);
  const auto loaded = build(every_shape(size, ground));
  const auto placed = value(edited(*loaded, {moves, {}}));
  ASSERT_NE(placed, nullptr);
  const auto moved = value(Scene::revise(loaded, placed, edits_of(moves)));
  const auto built = value(Scene::build_moved(every_shape(size, ground), moves));
  EXPECT_EQ(built->geometry().surfaces().runs[0].size(),
            moved->geometry().surfaces().runs[0].size());
  if (ground > 1e3) {
    EXPECT_FALSE(moved->geometry().accelerator().scene().large.empty());
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-3, 3);
  std::map<int, int> found;
  for (int i = 0; i < 40'000; ++i) {
    const auto point = [&] {
      return Vec3{uniform(random), uniform(random), 2 + 0.5 * uniform(random)} * size;
    };
    const Vec3 from = point(), to = point();
    Ray ray{Vec3f(from), Vec3f(to - from)};
    ray.time_s = 0.1 * (i % 10);
    for (const RayFilter filter : {RayFilter::kSurfaces, RayFilter::kOpaque}) {
      ASSERT_EQ(moved->geometry().occluded(ray, filter), built->geometry().occluded(ray, filter))
          << i;
      const auto a = moved->closest_hit(ray, filter), b = built->closest_hit(ray, filter);
      ASSERT_EQ(a.has_value(), b.has_value()) << i;
      if (!a) continue;
      ASSERT_EQ(bits_of(*a), bits_of(*b)) << i;
      ++found[a->light];
    }
    const auto all = [&](const Scene& scene) {
      std::multiset<std::tuple<int, std::uint32_t, std::int32_t>> hits;
      for (const RawHit& hit : scene.geometry().accelerator().all_hits(ray, RayFilter::kSurfaces))
        hits.emplace(static_cast<int>(hit.kind), hit.primitive, hit.instance);
      return hits;
    };
    // A triangle may occur twice, which depends on the BVH.
    const auto a = all(*moved), b = all(*built);
    ASSERT_EQ(std::set(a.begin(), a.end()), std::set(b.begin(), b.end())) << i;
  }
  for (int light = 0; light < 8; ++light) EXPECT_GT(found[light], 20) << light;
}

TEST_P(Moved, LightsHaveTheBitsOfASceneBuiltThere) {
  const auto [size, ground] = GetParam();
  const MovedSurfaces moves = moves_of(size);
  const auto loaded = build(every_shape(size, ground));
  const auto moved = value(Scene::revise(loaded, edits_of(moves)));
  const auto built = value(Scene::build_moved(every_shape(size, ground), moves));
  ASSERT_EQ(moved->lights().size(), built->lights().size());
  Receiver receiver;
  receiver.position = Vec3{0.1, 0.2, 0.3} * size;
  for (std::uint32_t i = 0; i < moved->lights().size(); ++i) {
    const LightAtTime a(moved->lights()[i], 0), b(built->lights()[i], 0);
    const auto p = a->sample_li(receiver, {0.3, 0.6}), q = b->sample_li(receiver, {0.3, 0.6});
    EXPECT_EQ(p.wi, q.wi) << i;
    EXPECT_EQ(p.distance, q.distance) << i;
    EXPECT_EQ(a->power(moved->sphere()).lumens, b->power(built->sphere()).lumens) << i;
  }
}

/// A floor under triangles that emit.  Each differs from the others in all that a file can say.
SceneDescription triangles(int count) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(4)};
  for (int i = 0; i < count; ++i) {
    const Vec3 a = Vec3{0.1 * i - 1, 0, 2};
    ShapeDescription lamp =
        testing::emissive(testing::shape(TriangleMeshData{
                              {a, a + Vec3{0.1, 0, 0}, a + Vec3{0, 0.1, 0}}, {}, {0, 2, 1}}),
                          1 + i, i % 2 == 0);
    lamp.has_uv = i % 3 == 0;
    lamp.emission->name = fmt::format("lamp {}", i);
    lamp.emission->samples = static_cast<std::uint32_t>(1 + i);
    lamp.emission->where = {"lamps.pbrt", 10 + i, 3};
    if (i % 2 == 1)
      lamp.emission->spectrum =
          std::make_shared<const Spectrum>(value(Spectrum::create(BlackBody{2000.0 + 100 * i})));
    d.shapes.push_back(std::move(lamp));
  }
  return d;
}

TEST(MovedSurfaces, OfPlainTrianglesKeepAllThatTheirFileSays) {
  constexpr int kCount = 4;
  MovedSurfaces moves;
  for (std::uint64_t light = 1; light <= kCount; ++light)
    moves[light] = {.shift_m = Vec3{0.3, -0.2, 0.1} * static_cast<double>(light)};
  const auto loaded = build(triangles(kCount));
  const auto placed = value(edited(*loaded, {moves, {}}));
  ASSERT_NE(placed, nullptr);
  const auto moved = value(Scene::revise(loaded, placed, edits_of(moves)));
  const auto built = value(Scene::build_moved(triangles(kCount), moves));
  ASSERT_EQ(moved->lights().size(), built->lights().size());
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const SceneLight &a = moved->lights()[i], &b = built->lights()[i];
    EXPECT_EQ(moved->lights().names().of(i), built->lights().names().of(i));
    EXPECT_EQ(moved->lights().source_of(a).line, built->lights().source_of(b).line);
    EXPECT_EQ(moved->lights().source_of(a).file, built->lights().source_of(b).file);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(moved->lights().spectrum(i) == nullptr, built->lights().spectrum(i) == nullptr);
    EXPECT_EQ(LightAtTime(a, 0)->power(moved->sphere()).lumens,
              LightAtTime(b, 0)->power(built->sphere()).lumens);
    Ray ray{{static_cast<float>(0.1 * i - 0.97 + 0.3 * (i + 1)),
             static_cast<float>(0.03 - 0.2 * (i + 1)), 1},
            {0, 0, 10}};
    const auto p = moved->closest_hit(ray), q = built->closest_hit(ray);
    ASSERT_TRUE(p && q) << i;
    EXPECT_EQ(p->light, static_cast<std::int32_t>(i));
    EXPECT_EQ(bits_of(*p), bits_of(*q)) << i;
  }
}

TEST(MovedSurfaces, OfPlainTrianglesTakeLittleMemory) {
  const auto parts = build(triangles(100))->parts();
  const auto kept = std::ranges::find(parts, "movable surfaces", &ScenePart::name);
  ASSERT_NE(kept, parts.end());
  // Three vertices and three indices take 84 bytes.
  EXPECT_LT(kept->bytes, 100 * 2 * 84U);
}

TEST(MovedSurfaces, ShareTheMemoryOfAllOthers) {
  SceneDescription d = every_shape(1, 4);
  TriangleMeshData many = testing::ball(6, [](const Vec3& p) { return p * 0.5; });
  d.shapes.push_back(testing::shape(std::move(many)));
  const auto loaded = build(std::move(d));
  const auto moved = value(Scene::revise(loaded, edits_of(moves_of(1))));
  EXPECT_TRUE(moved->has_own_geometry());
  EXPECT_EQ(moved->loaded(), loaded);
  // Vertices and their numbers are copied, and the BVH is shared.
  const std::vector<ScenePart> parts = loaded->parts();
  const auto bvh = std::ranges::find(parts, "bvh", &ScenePart::name);
  EXPECT_LT(moved->own_bytes(), loaded->own_bytes() - bvh->bytes / 2);
  // A level shares the surfaces too.
  LightEdits edits = moved->edits();
  edits.changes[8].scale = 0.5;
  const auto dimmed = value(Scene::revise(loaded, moved->shared_geometry(), edits));
  EXPECT_EQ(dimmed->shared_geometry(), moved->shared_geometry());
}

TEST(MovedSurfaces, NeedABuildIfTheSceneChangesItsOrigin) {
  const auto loaded = build(every_shape(1, 4));
  MovedSurfaces far;
  far[4] = {.shift_m = {1e6, 0, 0}};
  EXPECT_EQ(value(edited(*loaded, {far, {}})), nullptr);
  EXPECT_EQ(Scene::revise(loaded, edits_of(far)).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(MovedSurfaces, NeedABuildIfTheShapesOfLightsTakeTooMuchMemory) {
  SceneDescription d = every_shape(1, 4);
  MovedSurfaces moves;
  moves[4] = {.shift_m = {0.1, 0, 0}};
  EXPECT_NE(value(edited(*build(d), {moves, {}})), nullptr);
  // 2 MB of vertices in a lamp.
  d.shapes.push_back(testing::emissive(
      testing::shape(testing::ball(6, [](const Vec3& p) { return p * 0.5; })), 1));
  const auto loaded = build(std::move(d));
  const auto names = testing::part_names(*loaded);
  EXPECT_EQ(std::ranges::count(names, "movable surfaces"), 0);
  EXPECT_EQ(value(edited(*loaded, {moves, {}})), nullptr);
}

TEST(MovedSurfaces, NeedABuildIfAFlatPatchIsNotFlatAnyMore) {
  // The rounding of floats hides the twist far from zero, and shows it near zero.
  SceneDescription d = testing::description();
  const Vec3 c{1000, 1000, 1000};
  d.shapes = {
      testing::floor(2000),
      testing::emissive(
          testing::patch(c, c + Vec3{1, 0, 0}, c + Vec3{0, 1, 0}, c + Vec3{1, 1, 1e-5}), 1)};
  const auto loaded = build(std::move(d));
  MovedSurfaces moves;
  moves[1] = {.shift_m = {0, 0, 1}};
  EXPECT_NE(value(edited(*loaded, {moves, {}})), nullptr);
  moves[1] = {.shift_m = c * -1.0};
  EXPECT_EQ(value(edited(*loaded, {moves, {}})), nullptr);
}

TEST(MovedSurfaces, NeedABuildIfOtherTrianglesAreNotWideAnyMore) {
  const Vec3 a{-1e5, -1e5, -1e4}, b{1e5, -1e5, -1e4}, c{-1e5, 1e5, 2e4};
  const double error_m = ray_error_of({a, b, c});
  ASSERT_GT(error_m, 0);
  // The light is the smallest shape.  Turned by 45 degrees, its box is 1.41 times as large.
  const double side = error_m / kLargeShare / 1.2;
  SceneDescription d = testing::description();
  d.shapes = {
      testing::shape(TriangleMeshData{{a, b, c}, {}, {0, 1, 2}}),
      testing::emissive(
          testing::patch({0, 0, 1e4}, {side, 0, 1e4}, {0, side, 1e4}, {side, side, 1e4}), 1)};
  const auto loaded = build(std::move(d));
  ASSERT_EQ(loaded->geometry().accelerator().scene().large.size(), 1U);
  MovedSurfaces moves;
  moves[1] = {.shift_m = {1, 0, 0}};
  EXPECT_NE(value(edited(*loaded, {moves, {}})), nullptr);
  moves[1] = {.turn_axis = {0, 0, 1}, .turn_rad = std::numbers::pi / 4};
  EXPECT_EQ(value(edited(*loaded, {moves, {}})), nullptr);
}

TEST(MovedSurfaces, RefuseALightThatMovesByItself) {
  SceneDescription d = testing::description();
  ShapeDescription lamp = testing::emissive(at<SphereParams>({0, 0, 2}, 1), 1);
  const std::vector<KeyTransform> keys{{0, Transform()}, {1, Transform::translate({1, 0, 0})}};
  lamp.motion = std::make_shared<const Motion>(value(Motion::create(keys)));
  d.shapes = {testing::floor(4), lamp};
  const auto loaded = build(std::move(d));
  MovedSurfaces moves;
  moves[1] = {.shift_m = {1, 0, 0}};
  EXPECT_EQ(edited(*loaded, {moves, {}}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace lucerna
