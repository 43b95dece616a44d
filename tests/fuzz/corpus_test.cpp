// Every input of the corpora runs through its fuzz target, without libFuzzer.  A target ends the
// program if it finds something wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "tests/fuzz/allocations.h"
#include "tests/paths.h"

// All targets.  A folder of the corpora that is not in this list fails a test.
#define LUCERNA_FUZZ_TARGETS(f)                                                         \
  f(config_fuzz) f(eulumdat_fuzz) f(gltf_fuzz) f(ies_fuzz) f(pbrt_fuzz) f(picture_fuzz) \
      f(ply_fuzz) f(request_fuzz) f(texture_fuzz) f(token_file_fuzz)

#define LUCERNA_DECLARE(target) extern "C" int target(const std::uint8_t* data, std::size_t size);
LUCERNA_FUZZ_TARGETS(LUCERNA_DECLARE)
#undef LUCERNA_DECLARE

namespace lucerna::fuzz {
namespace {

using Target = int (*)(const std::uint8_t*, std::size_t);

const std::map<std::string, Target>& targets() {
  static const std::map<std::string, Target> all{
#define LUCERNA_ENTRY(target) {#target, &target},
      LUCERNA_FUZZ_TARGETS(LUCERNA_ENTRY)
#undef LUCERNA_ENTRY
  };
  return all;
}

class Corpus : public ::testing::TestWithParam<std::string> {};

TEST_P(Corpus, RunsThroughItsTarget) {
  const std::filesystem::path folder =
      std::filesystem::path(source_path("tests/fuzz/corpus")) / GetParam();
  std::vector<std::filesystem::path> inputs;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    inputs.push_back(entry.path());
  std::sort(inputs.begin(), inputs.end());
  ASSERT_FALSE(inputs.empty());
  for (const auto& path : inputs) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    SCOPED_TRACE(path.string());
    // A target that ends the program does not name the input.
    std::fprintf(stderr, "%s\n", path.c_str());
    EXPECT_EQ(
        targets().at(GetParam())(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()),
        0);
  }
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const auto& [name, target] : targets()) names.push_back(name);
  return names;
}

TEST(Corpora, HaveOneFolderForEachTarget) {
  std::vector<std::string> folders;
  for (const auto& entry : std::filesystem::directory_iterator(source_path("tests/fuzz/corpus")))
    folders.push_back(entry.path().filename());
  EXPECT_THAT(folders, ::testing::UnorderedElementsAreArray(names()));
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, ::testing::ValuesIn(names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace lucerna::fuzz
