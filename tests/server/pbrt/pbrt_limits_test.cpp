// Limits on what .pbrt files may need.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stop_token>
#include <string>

#include "server/pbrt/load_pbrt.h"
#include "tests/server/files/gzip.h"
#include "tests/server/files/limited_pool.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::LimitedPool;
using testing::message;
using testing::SceneFiles;

absl::Status load(const SceneFiles& files, const LoadLimits& limits, std::stop_token stop = {}) {
  auto reader = AssetReader::open(
      files.path().string(),
      {.max_total_bytes = limits.max_scene_bytes, .stop = stop, .budget = limits.budget});
  if (!reader.ok()) return reader.status();
  return load_pbrt(*reader, "scene.pbrt", stop, limits).status();
}

void expect_refused(const absl::Status& status, const std::string& text) {
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(message(status), HasSubstr(text));
}

TEST(PbrtLimits, TokensOfAllFilesTogether) {
  const SceneFiles files;
  files.write("more.pbrt", "Identity Identity Identity");
  files.write("scene.pbrt", "Include \"more.pbrt\" Identity WorldBegin");
  // Two words, a string and its three; then one more.
  EXPECT_TRUE(load(files, {.max_tokens = 8}).ok());
  expect_refused(load(files, {.max_tokens = 5}),
                 "scene.pbrt:1:21: more than 5 words, strings and "
                 "brackets");
}

TEST(PbrtLimits, DepthOfIncludes) {
  const SceneFiles files;
  files.write("scene.pbrt", "Include \"a.pbrt\" WorldBegin");
  files.write("a.pbrt", "Include \"b.pbrt\"");
  files.write("b.pbrt", "");
  EXPECT_TRUE(load(files, {.max_include_depth = 3}).ok());
  expect_refused(load(files, {.max_include_depth = 2}),
                 "a.pbrt:1:9: files include each other more than 2 deep");
}

TEST(PbrtLimits, PrimitivesOfAllShapesTogether) {
  const SceneFiles files;
  files.write("scene.pbrt",
              "WorldBegin Shape \"sphere\"\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 "
              "0 1 0] \"integer indices\" [0 1 2 0 2 3]");
  EXPECT_TRUE(load(files, {.max_primitives = 3}).ok());
  expect_refused(load(files, {.max_primitives = 2}),
                 "scene.pbrt:2:1: the scene has 3 triangles and other primitives up to here, "
                 "allowed: at most 2");
}

TEST(PbrtLimits, BytesOfAllFilesUnpacked) {
  const SceneFiles files;
  const std::string text = "WorldBegin " + std::string(10'000, ' ');
  files.write("scene.pbrt", testing::gzipped(text));
  EXPECT_TRUE(load(files, {.max_scene_bytes = 2 * text.size()}).ok());
  expect_refused(load(files, {.max_scene_bytes = text.size()}), "the limit of 10011 bytes");
}

TEST(PbrtLimits, TexelsOfAPicture) {
  const SceneFiles files;
  files.write("a.pfm", "PF\n2 2\n-1.0\n" + std::string(48, '\0'));
  files.write("scene.pbrt",
              "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.pfm\"");
  EXPECT_TRUE(load(files, {.max_texels = 4}).ok());
  expect_refused(load(files, {.max_texels = 3}), "a.pfm: 2 x 2 texels, allowed: 3 in all");
}

TEST(PbrtLimits, NumbersInTheFileCountWhileTheyAreRead) {
  const SceneFiles files;
  std::string text = "WorldBegin Shape \"trianglemesh\" \"point3 P\" [";
  for (int i = 0; i < 90'000; ++i) text += "1 ";
  files.write("scene.pbrt", text);  // the list has no end
  LimitedPool pool(text.size() + 400'000);
  LoadBudget budget(&pool);
  expect_refused(load(files, {.budget = &budget}), "the pool is empty");
  EXPECT_EQ(budget.used(), 0);
}

TEST(PbrtLimits, AStopEndsTheUnpackingOfAFile) {
  const SceneFiles files;
  files.write("scene.pbrt", testing::gzipped("WorldBegin " + std::string(5'000'000, ' ')));
  // The unpacked bytes are the first large claim.
  LimitedPool pool;
  LoadBudget budget(&pool);
  std::stop_source stop;
  pool.on_take = [&] {
    if (budget.kStepBytes <= pool.taken()) stop.request_stop();
  };
  const absl::Status status = load(files, {.budget = &budget}, stop.get_token());
  EXPECT_TRUE(stop.stop_requested());
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
}

}  // namespace
}  // namespace lucerna
