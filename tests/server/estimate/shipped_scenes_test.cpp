// The scenes under scenes/ load with the expected contents, and are small.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <type_traits>

#include "server/scene/scene.h"
#include "tests/paths.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScenes[] = {"cornell", "meadow", "room", "stage", "street"};

SceneDescription shipped(const std::string& name) {
  auto assets = AssetReader::open(source_path("scenes"));
  EXPECT_TRUE(assets.ok()) << assets.status();
  auto scene = load_pbrt(*assets, name + "/scene.pbrt");
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *std::move(scene) : SceneDescription();
}

/// The number of lights of each kind.
std::map<std::string, int> census(const SceneDescription& scene) {
  std::map<std::string, int> count;
  for (const LightDescription& light : scene.lights) {
    ++count[std::visit(
        []<typename Params>(const Params&) {
          if constexpr (std::is_same_v<Params, PointLightParams>) return "point";
          if constexpr (std::is_same_v<Params, SpotLightParams>) return "spot";
          if constexpr (std::is_same_v<Params, GoniometricLightParams>) return "goniometric";
          if constexpr (std::is_same_v<Params, ProjectionLightParams>) return "projection";
          if constexpr (std::is_same_v<Params, SunLightParams>) return "sun";
          if constexpr (std::is_same_v<Params, UniformInfiniteLightParams>) return "uniform sky";
          if constexpr (std::is_same_v<Params, ImageInfiniteLightParams>) return "image sky";
          if constexpr (std::is_same_v<Params, PortalLightParams>) return "portal";
          return "other";
        },
        light.params)];
  }
  for (const ShapeDescription& shape : scene.shapes) {
    if (!shape.emission) continue;
    ++count[std::visit(
        []<typename Shape>(const Shape&) {
          if constexpr (std::is_same_v<Shape, TriangleMeshData>) return "triangles";
          if constexpr (std::is_same_v<Shape, PatchMeshData>) return "patches";
          if constexpr (std::is_same_v<Shape, SphereParams>) return "sphere";
          if constexpr (std::is_same_v<Shape, CylinderParams>) return "cylinder";
          return "disk";
        },
        shape.geometry)];
  }
  return count;
}

// The counts of the street by hand.  Spheres: 15 strings of 43 bulbs, 164 about the marquee, 27
// doors and 3 trees of 105.  Points: 5 trees of 105, and 70 under the marquee.  Spots: 27 shops of
// 5, and two headlamps.  Cylinders: 15 + 14 + 18 + 15 strokes of four words.  The lit windows
// (patches) are random.
TEST(ShippedScenes, LoadWithoutRemarksAndHaveTheExpectedLights) {
  using Census = std::map<std::string, int>;
  const std::map<std::string, Census> expected{
      {"cornell", {{"patches", 1}}},
      {"meadow", {{"image sky", 1}, {"sun", 1}}},
      {"room", {{"goniometric", 8}, {"patches", 3}, {"portal", 1}}},
      {"stage", {{"projection", 3}, {"spot", 14}}},
      {"street",
       {{"cylinder", 62},
        {"goniometric", 12},
        {"patches", 785},
        {"point", 595},
        {"sphere", 1151},
        {"spot", 137},
        {"triangles", 12},
        {"uniform sky", 1}}},
  };
  for (const char* name : kScenes) {
    SCOPED_TRACE(name);
    SceneDescription scene = shipped(name);
    EXPECT_EQ(testing::remarks_of(scene), "");
    const Census lights = census(scene);
    EXPECT_EQ(lights, expected.at(name));
    EXPECT_EQ(scene.film.height, name == std::string("cornell") ? 512 : 400);
    int sum = 0;
    for (const auto& [kind, count] : lights) sum += count;
    const auto built = Scene::build(std::move(scene));
    ASSERT_TRUE(built.ok()) << built.status();
    // The reveal of the room's window reaches outdoors, where its portal lights nothing.
    const auto& remarks = (*built)->report().remarks;
    ASSERT_EQ(remarks.size(), name == std::string("room") ? 1U : 0U);
    for (const Remark& r : remarks) EXPECT_NE(r.what.find("portal"), std::string::npos) << r.what;
    EXPECT_EQ((*built)->lights().size(), static_cast<std::size_t>(sum));
  }
}

TEST(ShippedScenes, AreTogetherUnder10Megabytes) {
  std::uintmax_t bytes = 0;
  for (const char* name : kScenes)
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(source_path("scenes")) / name))
      if (entry.is_regular_file()) bytes += entry.file_size();
  EXPECT_LT(bytes, 10'000'000U);
  EXPECT_GT(bytes, 1'000'000U);
}

}  // namespace
}  // namespace lucerna
