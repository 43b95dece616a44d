#include "server/description/scene_contents.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// "kind count primitives".
std::vector<std::string> texts(const std::vector<KindCount>& kinds) {
  std::vector<std::string> result;
  for (const KindCount& k : kinds)
    result.push_back(k.kind + " " + std::to_string(k.count) + " " + std::to_string(k.primitives));
  return result;
}

TEST(SceneContents, CountsWhatAFileHoldsByKind) {
  const std::string triangles =
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 1 "
      "3 "
      "2] ";
  const testing::SceneFiles files;
  std::string picture = "PF\n4 2\n-1.0\n" + std::string(std::size_t{4} * 2 * 3 * 4, '\0');
  files.write("wood.pfm", picture);
  files.write("scene.pbrt",
              "Camera \"orthographic\" \"float lensradius\" 0.1\nWorldBegin "
              "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.pfm\" "
              "Texture \"u\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.pfm\" \"bool "
              "invert\" true "
              "MakeNamedMaterial \"a\" \"string type\" \"conductor\" "
              "MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"texture reflectance\" \"t\" "
              "MakeNamedMaterial \"unused\" \"string type\" \"dielectric\" "
              "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"a\" \"b\"] "
              "NamedMaterial \"m\" Shape \"sphere\" Shape \"sphere\" " +
                  triangles + "ObjectBegin \"o\" " + triangles +
                  "ObjectEnd ObjectInstance \"o\" ObjectInstance \"o\" ObjectInstance \"o\"");
  const auto scene = files.load("scene.pbrt");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const SceneContents contents = contents_of(*scene);
  EXPECT_THAT(texts(contents.shapes), ElementsAre("triangle mesh 2 4", "sphere 2 2"));
  EXPECT_EQ(contents.objects, 1U);
  EXPECT_EQ(contents.instances, 3U);
  EXPECT_THAT(texts(contents.materials), ElementsAre("diffuse 1 0", "conductor 1 0", "mix 1 0"));
  EXPECT_THAT(texts(contents.textures), ElementsAre("imagemap 2 0"));
  ASSERT_EQ(contents.pictures.size(), 1U);
  EXPECT_EQ(contents.pictures[0].name, "wood.pfm");
  EXPECT_EQ(contents.pictures[0].width, 4);
  EXPECT_EQ(contents.pictures[0].height, 2);
  EXPECT_GE(contents.pictures[0].bytes, 4U * 2);
  EXPECT_EQ(contents.camera, "orthographic with a lens");
}

TEST(SceneContents, CountPrimitivesWithoutAreaAndDoNotReportThem) {
  const auto scene = testing::load_world(
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0  0 1 0] \"integer indices\" [0 1 2 0 "
      "1 3 1 1 3] Shape \"bilinearmesh\" \"point3 P\" [0 0 1 1 0 1 2 0 1 3 0 1]");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const SceneContents contents = contents_of(*scene);
  EXPECT_EQ(contents.shapes.at(0).without_area, 2U);
  EXPECT_EQ(contents.shapes.at(1).without_area, 1U);
  EXPECT_THAT(scene->remarks, IsEmpty());
}

TEST(SceneContents, OfAnEmptySceneHaveNoKinds) {
  const SceneContents contents = contents_of(SceneDescription());
  EXPECT_THAT(contents.shapes, IsEmpty());
  EXPECT_THAT(contents.materials, IsEmpty());
  EXPECT_THAT(contents.textures, IsEmpty());
  EXPECT_THAT(contents.pictures, IsEmpty());
  EXPECT_EQ(contents.camera, "perspective");
}

}  // namespace
}  // namespace lucerna
