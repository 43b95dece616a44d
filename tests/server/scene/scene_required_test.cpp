// A scene has only the parts that it requires.  Each part exists where something uses it, with its
// bytes, its time and its reason, and nowhere else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/queries/receiver_irradiance.h"
#include "server/visibility/shaft.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::part_names;

std::shared_ptr<const Image> grey(int width, int height) {
  std::vector<Rgbf> texels;
  for (int i = 0; i < width * height; ++i) texels.emplace_back(static_cast<float>(1 + i % 3));
  return *Image::create(width, height, std::move(texels));
}

/// A floor under one point light.  It needs a hierarchy, and none of the parts that the cases below
/// add.
SceneDescription plain() {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(5)};
  d.lights = {testing::point_light({0, 0, 2}, 10)};
  return d;
}

using Change = std::function<void(SceneDescription&)>;
using Query = std::function<void(const Scene&)>;

LightDescription light_with(auto params) { return {std::move(params), {}}; }

void query_irradiance(const Scene& scene, VisibilityMethod visibility) {
  const IrradiancePoint point{{0.5, 0.25, 0}, {1e-6f, 1e-6f, 1e-6f}, {0, 0, 1}};
  IrradianceSettings settings{.block_count = 2, .bounces = 0};
  settings.methods.visibility = visibility;
  estimate_irradiance(scene, std::span(&point, 1), settings, {});
}

/// A box of a medium that absorbs so much.
void add_tank(SceneDescription& d, double absorption_per_m) {
  d.media = {{Rgb(absorption_per_m)}};
  ShapeDescription box = testing::shape(testing::room());
  box.is_interface = true;
  box.media = MediumSides{-1, 0};
  d.shapes.push_back(box);
}

struct Case {
  std::string part;
  Change needs;                                 ///< what makes the scene need it
  Change needs_not = [](SceneDescription&) {};  ///< the nearest change that does not
  Query query = [](const Scene&) {};            ///< the query that needs it
  Query other_query = [](const Scene&) {};
};

std::vector<Case> cases() {
  const auto add_light = [](auto params) -> Change {
    return [params](SceneDescription& d) { d.lights.push_back(light_with(params)); };
  };
  const auto none = [](SceneDescription& d) { d.shapes.clear(); };
  const auto unchanged = [](SceneDescription&) {};
  const std::vector<KeyTransform> keys{{0, Transform()}, {1, Transform::translate({1, 0, 0})}};
  const auto as_spot = [](SceneDescription& d) {  // its map has one face
    d.lights = {light_with(SpotLightParams{.position_m = {0, 0, 2},
                                           .axis = {0, 0, -1},
                                           .intensity_cd = Rgb(1),
                                           .cone_half_angle_rad = 0.5})};
  };
  const auto motion = std::make_shared<const Motion>(*Motion::create(keys));
  const auto sky = [](const std::shared_ptr<const Image>& image) {
    return ImageInfiniteLightParams{
        *SphereMap::create(image, SphereMapping::kLatitudeLongitude, ImageFilter::kNearest)};
  };
  PhotometricWebParams web;
  web.horizontal_deg = {0};
  web.vertical_deg = {0, 90};
  web.intensity_cd = {2, 1};
  GoniometricLightParams even, with_map, with_web;
  even.intensity = with_map.intensity = with_web.intensity = Rgb(1);
  with_web.web = *PhotometricWeb::create(web);
  with_map.map =
      *IntensityMap::create(grey(4, 4), SphereMapping::kEqualArea, ImageFilter::kBilinear);
  return {
      {"bvh", unchanged, none},
      {"triangles", unchanged,
       [](SceneDescription& d) { d.shapes = {testing::shape(SphereParams{})}; }},
      {"spheres", [](SceneDescription& d) { d.shapes = {testing::shape(SphereParams{})}; }},
      {"surfaces", unchanged, none},
      {"materials", unchanged, none},
      {"lights", unchanged, [](SceneDescription& d) { d.lights.clear(); }},
      {"light choice", [](SceneDescription& d) { d.lights.push_back(d.lights[0]); }},
      {"image distributions", add_light(sky(grey(8, 4))),
       add_light(UniformInfiniteLightParams{Rgb(1)})},
      {"images", add_light(sky(grey(8, 4))), add_light(UniformInfiniteLightParams{Rgb(1)})},
      {"photometric webs", add_light(with_web), add_light(even)},
      {"intensity maps", add_light(with_map), add_light(even)},
      {"spectra",
       [](SceneDescription& d) {
         d.lights[0].spectrum =
             std::make_shared<const Spectrum>(*Spectrum::create(BlackBody{3000}));
       }},
      {"light names", [](SceneDescription& d) { d.lights[0].name = "desk"; }},
      {"light names",
       [](SceneDescription& d) {
         d.shapes.push_back(testing::emissive(testing::floor(0.1, 2), 1));
         d.shapes.back().emission->name = "panel";
       },
       [](SceneDescription& d) {
         d.shapes.push_back(testing::emissive(testing::floor(0.1, 2), 1));
       }},
      {"motion", [motion](SceneDescription& d) { d.lights[0].motion = motion; }},
      {"motion", [motion](SceneDescription& d) { d.shapes[0].motion = motion; }},
      {"motion", [motion](SceneDescription& d) { d.camera.motion = motion; }},
      {"media", [](SceneDescription& d) { add_tank(d, 0.5); },
       [](SceneDescription& d) { add_tank(d, 0); }},
      {.part = "shadow maps",
       .needs = as_spot,
       .needs_not = as_spot,
       .query = [](const Scene& s) { query_irradiance(s, VisibilityMethod::kShadowMaps); },
       .other_query = [](const Scene& s) { query_irradiance(s, VisibilityMethod::kRays); }},
      // The query wants maps, but no light of the scene has one.
      {.part = "shadow maps",
       .needs = as_spot,
       .needs_not =
           [](SceneDescription& d) {
             d.lights = {light_with(UniformInfiniteLightParams{Rgb(1)})};
             d.shapes.push_back(testing::emissive(testing::floor(0.1, 2), 1));
           },
       .query = [](const Scene& s) { query_irradiance(s, VisibilityMethod::kShadowMaps); },
       .other_query = [](const Scene& s) { query_irradiance(s, VisibilityMethod::kShadowMaps); }},
      {.part = "shafts", .needs = unchanged, .query = [](const Scene& s) { shafts(s); }},
  };
}

TEST(OnlyWhatASceneRequires, AreTheOnlyOnesBuiltAndListed) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.part);
    SceneDescription d = plain();
    c.needs_not(d);
    const auto without = testing::build(std::move(d));
    c.other_query(*without);
    EXPECT_THAT(part_names(*without), Not(Contains(c.part)));

    d = plain();
    c.needs(d);
    const auto with = testing::build(std::move(d));
    c.query(*with);
    int times = 0;
    for (const ScenePart& part : with->parts()) {
      if (part.name != c.part) continue;
      ++times;
      EXPECT_GT(part.bytes, 0u);
      EXPECT_TRUE(part.build_ms >= 0 && std::isfinite(part.build_ms)) << part.build_ms;
      EXPECT_FALSE(part.why.empty());
    }
    EXPECT_EQ(times, 1);
  }
}

TEST(OnlyWhatASceneRequires, AnEmptySceneHasNoParts) {
  const auto scene = testing::build(testing::description());
  EXPECT_THAT(part_names(*scene), IsEmpty());
  EXPECT_EQ(scene->bytes(), 0u);
  EXPECT_EQ(scene->geometry().accelerator().bytes(), 0u);
  EXPECT_TRUE(scene->geometry().empty());  // an empty hierarchy of Embree takes 0 bytes too
  EXPECT_FALSE(scene->closest_hit({{0, 0, 1}, {0, 0, -1}}));
  EXPECT_FALSE(scene->geometry().occluded({{0, 0, 1}, {0, 0, -1}}));
  EXPECT_FALSE(scene->geometry().isa().empty());
}

TEST(OnlyWhatASceneRequires, ObjectsWithoutInstancesAreLeftOut) {
  SceneDescription d = testing::description();
  d.objects = {{"floor", {testing::floor(1)}}, {"ball", {testing::shape(SphereParams{})}}};
  EXPECT_THAT(part_names(*testing::build(d)), IsEmpty());
  d.instances = {{.object = 1, .world_from_object = Transform::translate({0, 0, 3})}};
  const auto scene = testing::build(d);
  EXPECT_THAT(part_names(*scene), Contains("spheres"));
  EXPECT_THAT(part_names(*scene), Not(Contains("triangles")));
  EXPECT_EQ(scene->geometry().shape_count(), 1u);
  const auto hit = scene->closest_hit({Vec3f(Vec3{0, 0, 9} - scene->origin()), {0, 0, -1}});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t, 5, 1e-5);
}

}  // namespace
}  // namespace lucerna
