// Moving shapes and instances: at each moment the scene equals one whose surfaces stand still in
// that place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "tests/server/estimate/moving_shapes.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// Expects rays from all around at time `t` to hit the same in `moves` as in `still`.
void expect_same_hits(const Scene& moves, const Scene& still, double t) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto somewhere = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
  const Vec3 centre = placed_at(t).point({});
  const auto ray_in = [&](const Scene& scene, const Vec3& from, const Vec3& to) {
    Ray ray{Vec3f(from - scene.origin()), Vec3f(to - from)};
    ray.time_s = t;
    return ray;
  };
  int hits = 0, differ = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 from = centre + normalized(somewhere()) * 4.0;
    const Vec3 to = centre + normalized(somewhere()) * 0.7;
    const Ray m = ray_in(moves, from, to), s = ray_in(still, from, to);
    const auto a = moves.closest_hit(m), b = still.closest_hit(s);
    if (a.has_value() != b.has_value() || moves.geometry().occluded(m) != b.has_value()) {
      ++differ;
      continue;
    }
    if (!a) continue;
    ++hits;
    const Vec3 p = Vec3(a->position) + moves.origin();
    const Vec3 q = Vec3(b->position) + still.origin();
    // Only one of the rays passed an edge, and met a surface beyond it.
    if (length(p - q) > 1e-4) {
      ++differ;
      continue;
    }
    EXPECT_LE(length(p - q), 2e-5);
    EXPECT_NEAR(a->t, b->t, 1e-5);
    EXPECT_LE(length(a->ng - b->ng), 1e-4);
    EXPECT_EQ(a->time_s, t);
    // The surface passes within the reported error.
    EXPECT_LE(std::fabs(dot(b->ng, p - q)),
              2 * std::sqrt(3) * (max_abs(a->position_error) + max_abs(b->position_error)));
  }
  EXPECT_GT(hits, 500);
  // Roundings of 1e-6 m at outlines and edges of about 10 m in length, seen on 10 m2.
  EXPECT_LE(differ, 2);
}

TEST(MovingSurfaces, RaysHitThemAtTheirPlaceAtThatTime) {
  for (const Kind& kind : kinds()) {
    const auto moves = scene_of(moved(kind));
    EXPECT_TRUE(moves->moves());
    for (const double t : {0.0, 0.5, 1.3, 2.0}) {
      SCOPED_TRACE(std::string(kind.name) + " at " + std::to_string(t));
      expect_same_hits(*moves, *scene_of(kind.make(placed_at(t))), t);
    }
  }
}

TEST(MovingSurfaces, RestBeforeAndAfterTheirKeyFrames) {
  const auto moves = scene_of(moved(kinds()[0]));
  const Vec3 last = placed_at(2).point({}), first = placed_at(0).point({});
  const auto seen = [&](const Vec3& centre, double t) {
    Ray ray{Vec3f(centre + Vec3{0, 0, 5} - moves->origin()), {0, 0, -1}};
    ray.time_s = t;
    return moves->geometry().occluded(ray);
  };
  for (const double t : {-1e300, -1.0, 0.0}) EXPECT_TRUE(seen(first, t) && !seen(last, t)) << t;
  for (const double t : {2.0, 7.0, 1e300}) EXPECT_TRUE(seen(last, t) && !seen(first, t)) << t;
}

TEST(MovingSurfaces, ScaledInstancesMove) {
  const Transform stretched = *Transform::scale({0.5, 0.25, 1.5});
  const auto place = [&](double t, bool moves) {
    SceneDescription d = description();
    // A scene with its own size and zero around it, and an instance at rest.
    d.objects = {{"ball",
                  {shape(ball(2,
                              [](const Vec3& p) {
                                return p + Vec3{0.3, 0, 0};
                              })),
                   shape(SphereParams{.radius_m = 0.9})}}};
    d.instances = {{0, Transform::translate({9, 9, 9})}, {0, placed_at(t) * stretched}};
    if (moves) d.instances[1].motion = moving();
    return build(std::move(d));
  };
  const auto moves = place(0, true);
  EXPECT_TRUE(moves->moves());
  for (const double t : {0.0, 0.5, 1.3, 2.0}) {
    SCOPED_TRACE(t);
    expect_same_hits(*moves, *place(t, false), t);
  }
}

TEST(MovingSurfaces, KeepMaterialsShadingNormalsAndLightNumbers) {
  SceneDescription d = description();
  d.materials.push_back(diffuse_material(Rgb(0.25)));
  d.shapes.push_back(emissive(floor(1, 0), 1));
  TriangleMeshData mesh{{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}, {}, {0, 1, 2, 1, 3, 2}};
  const Vec3f tilted = normalized(Vec3f{0, 0.6F, 0.8F});
  mesh.normals = {tilted, tilted, tilted, tilted};
  d.shapes.push_back(emissive(shape(mesh), 2));
  d.shapes.push_back(emissive(floor(1, -1), 3));
  d.shapes[1].material = 1;
  // A quarter turn about +z and a metre up.
  d.shapes[1].motion = moving(
      {{0, {}}, {1, Transform::translate({0, 0, 1}) * *Transform::rotate(M_PI / 2, {0, 0, 1})}});
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->lights().size(), 3U);
  // (0.75, 0.75) of the mesh, its second triangle, is now at (-0.75, 0.75).
  Ray ray{Vec3f(Vec3{-0.75, 0.75, 5} - scene->origin()), {0, 0, -1}};
  ray.time_s = 1;
  const auto hit = scene->closest_hit(ray);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t, 3, 1e-6);
  EXPECT_EQ(hit->material, 1U);
  EXPECT_EQ(hit->light, 1);
  EXPECT_EQ(hit->light_primitive, 1U);
  EXPECT_LE(length(hit->ns - Vec3{-0.6, 0, 0.8}), 1e-6);
  EXPECT_EQ(scene->lights()[2].moving, nullptr);
  EXPECT_EQ(scene->geometry().shape_count(), 3U);
}

TEST(MovingSurfaces, BlurFollowsTheTimeAtEachPlace) {
  // A panel of 8 cd/m2, a metre wide, crosses the middle of the picture at 4 m/s: a quarter of a
  // second.
  SceneDescription d = description(0);
  d.film = {.width = 2, .height = 2};
  d.camera.screen_min = {-1e-3, -1e-3};
  d.camera.screen_max = {1e-3, 1e-3};
  d.shapes.push_back(emissive(floor(0.5, 1), 8, true));
  for (auto& p : std::get<PatchMeshData>(d.shapes.back().geometry).positions) p.x -= 2;
  d.shapes.back().motion = sliding({4, 0, 0}, 1);
  d.hints.shutter_close_s = 1;
  const auto scene = build(std::move(d));
  TileSettings s{.rect = {0, 0, 2, 2}, .samples_per_block = 4, .block_count = 1024, .bounces = 0};
  const TileResult blurred = render_tile(*scene, s, {});
  // One sample in four sees it: sqrt(0.25 0.75 / 4096) is 0.0068 of the panel.  Seven of these are
  // exceeded less than once in 1e11.
  for (const BlockStatistics& c : blurred.channels) EXPECT_NEAR(c.sum / 1024, 2, 8 * 0.048);
  s.block_count = 1;
  for (const double t : {0.0, 0.3, 0.5, 0.7}) {
    s.time_s = t;
    const double seen = std::fabs(4 * t - 2) < 0.5 ? 8 : 0;
    for (const BlockStatistics& c : render_tile(*scene, s, {}).channels) EXPECT_EQ(c.sum, seen);
  }
}

TEST(MovingSurfaces, BeyondTheRangeOfRaysAreAnError) {
  SceneDescription d = description();
  d.shapes.push_back(floor(1));
  d.shapes.back().where = {"a.pbrt", 3, 4};
  d.shapes.back().motion = sliding({0, 1e31, 0}, 1);
  const auto scene = Scene::build(d);
  ASSERT_FALSE(scene.ok());
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("a.pbrt:3:4: motion reaching to 1"));
  d.shapes.clear();
  d.lights = {point_light({0, 0, 1}, 1)};
  d.lights.back().where = {"a.pbrt", 5, 6};
  d.lights.back().motion = sliding({0, 1e200, 0}, 1);
  const auto lit = Scene::build(d);
  ASSERT_FALSE(lit.ok());
  EXPECT_THAT(std::string(lit.status().message()), HasSubstr("a.pbrt:5:6: motion reaching to 1"));
}

TEST(MovingSurfaces, TheScenesSphereHoldsTheirWholeMotion) {
  SceneDescription d = description();
  d.shapes.push_back(floor(1));
  d.shapes.back().motion = sliding({100, 0, 0}, 1);
  const auto scene = build(std::move(d));
  const Vec3 centre = scene->origin() + scene->sphere().center_m;
  EXPECT_LE(length(centre - Vec3{50, 0, 0}), 1e-6);
  EXPECT_NEAR(scene->sphere().radius_m, std::hypot(51, 1), 1e-6);
  bool reported = false;
  for (const ScenePart& part : scene->parts())
    reported |= part.name == "motion" && part.bytes > 0 &&
                part.why == "0 lights, 1 shapes and instances move";
  EXPECT_TRUE(reported);
}

TEST(PbrtMotion, OfShapesAreaLightsAndInstancesIsRead) {
  const auto scene = load_text(R"(TransformTimes 1 3
    WorldBegin
    ObjectBegin "ball" Shape "sphere" ObjectEnd
    AttributeBegin
      Translate 1 2 3
      ActiveTransform EndTime Translate 4 0 0 ActiveTransform All
      Shape "disk"
      AreaLightSource "diffuse"
      Shape "sphere" "float radius" 0.5
      ObjectInstance "ball"
    AttributeEnd
    Shape "disk" ObjectInstance "ball")");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(remarks_of(*scene), "");
  ASSERT_EQ(scene->shapes.size(), 3U);
  ASSERT_EQ(scene->instances.size(), 2U);
  for (const auto& motion :
       {scene->shapes[0].motion, scene->shapes[1].motion, scene->instances[0].motion}) {
    ASSERT_NE(motion, nullptr);
    EXPECT_EQ(motion->key_frames()[0].time_s, 1);
    EXPECT_LE(length(motion->at(2).point({1, 2, 3}) - Vec3{3, 2, 3}), 1e-14);
  }
  EXPECT_TRUE(scene->shapes[1].emission.has_value());
  EXPECT_EQ(scene->shapes[2].motion, nullptr);
  EXPECT_EQ(scene->instances[1].motion, nullptr);
  EXPECT_EQ(scene->instances[0].world_from_object.point({}), Vec3(1, 2, 3));
}

TEST(PbrtMotion, ThatIsNotRigidIsAnErrorForSurfaces) {
  const std::string grows =
      "WorldBegin ObjectBegin \"o\" ObjectEnd\n"
      "ActiveTransform EndTime Scale 1 2 1\n  ";
  EXPECT_THAT(error_of(grows + "Shape \"sphere\""),
              HasSubstr("scene.pbrt:3:3: Shape: motion that scales or shears"));
  EXPECT_THAT(error_of(grows + "AreaLightSource \"diffuse\" Shape \"sphere\""),
              HasSubstr("scene.pbrt:3:29: Shape: motion that scales or shears"));
  EXPECT_THAT(error_of(grows + "ObjectInstance \"o\""),
              HasSubstr("scene.pbrt:3:3: ObjectInstance: motion that scales or shears"));
  // A scale that both key frames share is not a motion.
  EXPECT_EQ(error_of("WorldBegin ActiveTransform EndTime Translate 1 0 0 ActiveTransform All "
                     "Scale 2 3 -4 Shape \"sphere\""),
            "");
}

TEST(PbrtMotion, WithinAnObjectIsRemarkedOn) {
  const auto scene = load_text(
      "WorldBegin ObjectBegin \"o\"\nActiveTransform EndTime Translate 1 0 0\nShape \"sphere\"\n"
      "ObjectEnd");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(remarks_of(*scene),
            "3:1 motion of a shape within an object definition is not modelled -> its position at "
            "the start\n");
}

}  // namespace
}  // namespace lucerna::testing
