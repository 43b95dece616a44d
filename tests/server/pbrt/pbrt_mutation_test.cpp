// Loading any broken file ends with a scene or with a printable error.
#include <gtest/gtest.h>

#include <random>

#include "pbrt_fixture.h"
#include "server/formats/ply.h"
#include "server/pbrt/syntax/place.h"
#include "tests/mutated.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

using testing::message;
using testing::mutated;
using testing::SceneFiles;

std::string contents(const std::string& name) {
  std::ifstream file(test_data(name), std::ios::binary);
  EXPECT_TRUE(file.good()) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

constexpr const char* kWords[] = {
    "\"", "[",           "]",          "-",   "1e308", "AttributeEnd", "ObjectBegin \"x\"",
    "\\", "\"float x\"", "4294967295", "nan", "#",     "\xff",         "Include \"scene.pbrt\""};

void load_and_check(const SceneFiles& files) {
  const auto scene = files.load("scene.pbrt");
  if (scene.ok()) {
    for (const ShapeDescription& shape : scene->shapes)
      ASSERT_LT(shape.material, scene->materials.size());
    for (const InstanceDescription& instance : scene->instances)
      ASSERT_LT(instance.object, scene->objects.size());
    for (const Remark& remark : scene->remarks) {
      ASSERT_TRUE(pbrt::is_printable(remark.what)) << remark.what;
      ASSERT_TRUE(pbrt::is_printable(remark.instead)) << remark.instead;
    }
  } else {
    ASSERT_NE(message(scene.status()), "");
    ASSERT_TRUE(pbrt::is_printable(message(scene.status()))) << scene.status();
  }
}

TEST(PbrtMutations, BrokenScenesEndWithASceneOrAnError) {
  std::mt19937 random(20240229);
  const SceneFiles files;
  files.write("parts.pbrt", contents("pbrt/parts.pbrt"));
  files.write("square.ply", contents("pbrt/square.ply"));
  const std::string whole = contents("pbrt/everything.pbrt");
  int errors = 0;
  for (int i = 0; i < 400; ++i) {
    files.write("scene.pbrt", mutated(whole, random, kWords, 4));
    load_and_check(files);
    errors += !files.load("scene.pbrt").ok();
  }
  EXPECT_GT(errors, 50);
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    files.write("scene.pbrt", whole.substr(0, size));
    load_and_check(files);
  }
}

TEST(PbrtMutations, BrokenMeshesEndWithAMeshOrAnError) {
  std::mt19937 random(20240301);
  for (const char* name : {"pbrt/square.ply", "reference/ball.ply"}) {
    // The header and the first vertices of the ball; truncation must be detected too.
    const std::string whole = contents(name).substr(0, 2000);
    for (int i = 0; i < 400; ++i) {
      const auto mesh = parse_ply(mutated(whole, random, kWords, 4));
      if (!mesh.ok()) {
        ASSERT_TRUE(pbrt::is_printable(pbrt::printable(message(mesh.status()))));
        continue;
      }
      for (const std::uint32_t index : mesh->indices) ASSERT_LT(index, mesh->positions.size());
    }
  }
}

TEST(PbrtMutations, TheUnbrokenSceneLoads) {
  auto assets = AssetReader::open(test_data("pbrt"));
  const auto scene = load_pbrt(*assets, "everything.pbrt");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(testing::remarks_of(*scene), "");
  EXPECT_EQ(scene->shapes.size(), 7U);
  EXPECT_EQ(scene->lights.size(), 6U);
  EXPECT_EQ(scene->instances.size(), 2U);
}

}  // namespace
}  // namespace lucerna
