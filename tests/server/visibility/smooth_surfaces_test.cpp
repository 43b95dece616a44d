#include "server/visibility/smooth_surfaces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/visibility/smooth_remarks.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

Material mirror(double roughness = 0) {
  return {.params = MetalParams{.reflectance = ColourValue{Rgb(0.9)},
                                .roughness = {{roughness}, {roughness}}}};
}
Material glass() { return {.params = DielectricParams{}}; }
Material pane() { return {.params = ThinDielectricParams{}}; }

ShapeDescription with(std::uint32_t material, ShapeDescription shape) {
  shape.material = material;
  return shape;
}

SceneDescription scene_with(const Material& material, ShapeList shapes) {
  SceneDescription d = description();
  d.materials.push_back(material);
  for (ShapeDescription& s : shapes) d.shapes.push_back(with(1, std::move(s)));
  d.lights = {point_light({0, 0, 5}, 1)};
  return d;
}

/// A scene that lives as long as its surfaces are used.
struct Collected {
  explicit Collected(SceneDescription d) : scene(build(std::move(d))) {}
  Collected(const Material& material, ShapeList shapes)
      : Collected(scene_with(material, std::move(shapes))) {}
  const SmoothSurfaces* operator->() const { return &smooth_surfaces(*scene); }

  std::shared_ptr<const Scene> scene;
};

TEST(SmoothSurfaces, ADiffuseSceneHasNone) {
  SceneDescription d = description();
  d.shapes = {floor(1)};
  EXPECT_TRUE(Collected(std::move(d))->empty());
}

TEST(SmoothSurfaces, FacesInOnePlaneAreOnePart) {
  const auto scene = build(scene_with(
      mirror(), {floor(1), patch({2, -1, 0}, {4, -1, 0}, {2, 1, 0}, {4, 1, 0}), floor(1, 1)}));
  const SmoothSurfaces& s = smooth_surfaces(*scene);
  ASSERT_EQ(s.parts().size(), 2U);
  EXPECT_TRUE(s.unsolved().empty());
  EXPECT_TRUE(s.parts()[0].reflects);
  EXPECT_FALSE(s.parts()[0].refracts);
  // Every face of the first plane has this part.
  for (const double x : {0.0, 3.0}) {
    const auto hit = scene->closest_hit({{static_cast<float>(x), 0.3F, 0.5F}, {0, 0, -1}});
    ASSERT_TRUE(hit);
    EXPECT_EQ(s.part_of(*hit), 0);
    EXPECT_TRUE(s.parts()[0].may_contain(hit->position));
  }
  EXPECT_FALSE(s.parts()[0].may_contain({0, 9, 0}));
}

TEST(SmoothSurfaces, PanesReflectAndGlassRefracts) {
  const Collected panes(pane(), {floor(1)});
  ASSERT_EQ(panes->parts().size(), 1U);
  EXPECT_TRUE(panes->parts()[0].reflects);
  EXPECT_FALSE(panes->parts()[0].refracts);
  EXPECT_NEAR(panes->parts()[0].reflected, 0.0769, 1e-4);  // 2 r / (1 + r), r = 0.04
  const Collected slab(glass(), {floor(1), floor(1, 1)});
  ASSERT_EQ(slab->parts().size(), 2U);
  EXPECT_TRUE(slab->parts()[0].refracts);
  EXPECT_EQ(slab->parts()[0].eta, 1.5);
}

TEST(SmoothSurfaces, AWholeMirrorBallIsAPart) {
  const auto ball = [](double z_max) {
    return shape(SphereParams{
        .radius_m = 0.5, .z_max_m = z_max, .world_from_object = Transform::translate({1, 2, 3})});
  };
  const Collected whole(mirror(), {ball(1)});
  ASSERT_EQ(whole->parts().size(), 1U);
  EXPECT_TRUE(whole->parts()[0].is_sphere);
  EXPECT_EQ(whole->parts()[0].radius_m, 0.5);
  // A part of a ball reflects on its inside too, and a ball of glass focuses light.
  EXPECT_EQ(Collected(mirror(), {ball(0.2)})->unsolved().size(), 1U);
  EXPECT_EQ(Collected(glass(), {ball(1)})->unsolved().size(), 1U);
}

// Floats 1 km from the origin move corners by 0.03 mm.  The facets are turned by 1.5 degrees.
TEST(SmoothSurfaces, SmallFacetsFarFromTheOriginStayApart) {
  const auto facet = [](double turn_rad, double y) {
    const Vec3 c{1000, y, 0}, u{0, 0, 0.05},
        v{0.05 * std::sin(turn_rad), 0.05 * std::cos(turn_rad), 0};
    return patch(c - u - v, c + u - v, c - u + v, c + u + v);
  };
  const auto parts = [&](double turn_rad) {
    return Collected(mirror(), {facet(0, 0), facet(turn_rad, 0.11), facet(0, -2000)})
        ->parts()
        .size();
  };
  EXPECT_EQ(parts(0), 1U);
  EXPECT_EQ(parts(0.026), 2U);
}

TEST(SmoothSurfaces, AMirrorBallWithALightInItIsNoPart) {
  SceneDescription d = scene_with(mirror(), {shape(SphereParams{.radius_m = 2})});
  d.lights = {point_light({0, 0, 1}, 1)};
  const auto inside = build(d);
  EXPECT_TRUE(smooth_surfaces(*inside).parts().empty());
  EXPECT_EQ(smooth_surfaces(*inside).unsolved().size(), 1U);
  d.lights = {point_light({0, 0, 5}, 1)};
  const auto outside = build(d);
  EXPECT_EQ(smooth_surfaces(*outside).parts().size(), 1U);
  EXPECT_TRUE(smooth_surfaces(*outside).unsolved().empty());
}

TEST(SmoothSurfaces, NearMirrorsBesideVeryManyLightsAreUnsolved) {
  SceneDescription d = scene_with(mirror(1e-5), {floor(1)});
  d.lights.resize(SmoothSurfaces::kMostGuidedPairs, d.lights[0]);
  const Collected guided(d);
  ASSERT_EQ(guided->parts().size(), 1U);
  EXPECT_GT(guided->parts()[0].glossy_alpha, 0);
  EXPECT_TRUE(guided->unsolved().empty());
  d.lights.push_back(d.lights[0]);
  const Collected many(d);
  ASSERT_EQ(many->unsolved().size(), 1U);
  EXPECT_EQ(many->unsolved()[0].kind, UnsolvedSurface::Kind::kNearlySmooth);
}

TEST(SmoothSurfaces, RoughMetalIsNotSmooth) {
  EXPECT_TRUE(Collected(mirror(0.05), {floor(1)})->empty());
}

TEST(SmoothSurfaces, ShadingNormalsAndMapsBendLight) {
  TriangleMeshData bent = room();
  bent.normals.assign(bent.positions.size(), Vec3f{0, 0, 1});
  const Collected s(mirror(), {shape(std::move(bent))});
  EXPECT_TRUE(s->parts().empty());
  ASSERT_EQ(s->unsolved().size(), 1U);
  EXPECT_NEAR(s->unsolved()[0].bounds_m.upper.x, 1, 1e-6);
}

TEST(SmoothSurfaces, PatchesThatRoundingBendsAreFlat) {
  const auto bent = [](double by) {
    return patch({-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, by});
  };
  const auto scene = build(scene_with(mirror(), {bent(2e-6)}));
  const SmoothSurfaces& s = smooth_surfaces(*scene);
  ASSERT_EQ(s.parts().size(), 1U);
  EXPECT_TRUE(s.unsolved().empty());
  EXPECT_NEAR(s.parts()[0].n.z, 1, 1e-9);
  const auto hit = scene->closest_hit({{0.4F, 0.3F, 0.5F}, {0, 0, -1}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->kind, HitKind::kPatch);
  EXPECT_EQ(s.part_of(*hit), 0);
  EXPECT_EQ(Collected(mirror(), {bent(1e-3)})->unsolved().size(), 1U);
}

TEST(SmoothSurfaces, TooManyRefractingFacesAreUnsolved) {
  ShapeList boxes;
  for (int i = 0; i < 3; ++i) boxes.push_back(shape(room({3.0 * i, 4.0 * i, 5.0 * i})));
  EXPECT_EQ(Collected(glass(), {boxes[0], boxes[1]})->parts().size(), 12U);
  const Collected s(glass(), std::move(boxes));
  EXPECT_TRUE(s->parts().empty());
  EXPECT_EQ(s->unsolved().size(), 3U);
}

TEST(SmoothSurfaces, InstancesHaveTheirOwnParts) {
  SceneDescription d = scene_with(mirror(), {});
  ObjectDefinition object{.name = "mirror", .shapes = {}};
  object.shapes.push_back(with(1, floor(1)));
  d.objects.push_back(std::move(object));
  for (const double z : {0.0, 2.0})
    d.instances.push_back({.object = 0, .world_from_object = Transform::translate({0, 0, z})});
  const auto scene = build(std::move(d));
  const SmoothSurfaces& s = smooth_surfaces(*scene);
  ASSERT_EQ(s.parts().size(), 2U);
  const auto hit = scene->closest_hit({{0.1F, 0.3F, 1}, {0, 0, 1}});
  ASSERT_TRUE(hit);
  const std::int32_t part = s.part_of(*hit);
  ASSERT_GE(part, 0);
  EXPECT_NEAR(s.parts()[static_cast<std::size_t>(part)].height(hit->position), 0, 1e-6);
}

TEST(SmoothRemarks, NameWhatLightMayBeMissed) {
  const auto remark_of = [](SceneDescription d) {
    return remark_on_smooth_surfaces(*build(std::move(d)));
  };
  ShapeDescription lens = shape(SphereParams{.radius_m = 0.5});
  lens.where = {"room.pbrt", 7, 3};
  SceneDescription d = scene_with(glass(), {lens});
  const auto remark = remark_of(d);
  ASSERT_TRUE(remark);
  EXPECT_EQ(text_of(remark->where), "room.pbrt:7:3");
  EXPECT_EQ(remark->count, 1U);
  EXPECT_THAT(remark->instead,
              ::testing::HasSubstr("pictures leave out light of lights without a size (light 1)"));
  for (int i = 0; i < 6; ++i) {
    d.lights.push_back(point_light({0, 0, 5}, 1));
    d.shapes.push_back(d.shapes.back());
  }
  const auto many = remark_of(d);
  ASSERT_TRUE(many);
  EXPECT_EQ(many->count, 7U);
  EXPECT_EQ(many->more.size(), 4U);
  EXPECT_THAT(many->instead, ::testing::HasSubstr("(light 1, 2, 3, 4 and 3 more)"));
  d.lights = {{UniformInfiniteLightParams{Rgb(1)}, {"test.pbrt", 6, 1}}};
  const auto found = remark_of(d);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->instead, ::testing::Not(::testing::HasSubstr("pictures")));
  d.lights.clear();
  EXPECT_FALSE(remark_of(d)) << "without lights nothing is missed";
  EXPECT_FALSE(remark_of(scene_with(mirror(), {floor(1)}))) << "a flat mirror is solved";
  EXPECT_FALSE(remark_of(scene_with(mirror(0.5), {lens}))) << "rough metal is not smooth";
}

}  // namespace
}  // namespace lucerna::testing
