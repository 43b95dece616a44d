#include "server/scene/light_edit.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace lucerna {
namespace {

constexpr std::uint64_t kFirst = std::uint64_t{1} << 32U;

/// The first id of a content, if nothing is taken.
std::uint64_t first_id(const std::string& content) { return AddedLightIds({}).take(content); }

TEST(AddedLightIds, AreTheFirstFreeOnesAlsoAfterOthersAreFreed) {
  std::map<std::uint64_t, AddedLight> taken;
  std::mt19937 random(1);
  AddedLightIds ids(taken);
  for (int step = 0; step < 4000; ++step) {
    if (step % 997 == 0) ids = AddedLightIds(taken);
    if (random() % 3 == 0 && !taken.empty()) {
      auto gone = taken.begin();
      std::advance(gone, random() % std::min<std::size_t>(taken.size(), 100));
      ids.free(gone->first);
      taken.erase(gone);
      continue;
    }
    const std::string content = random() % 2 == 0 ? "a" : "b";
    std::uint64_t free = first_id(content);
    while (taken.contains(free)) ++free;
    ASSERT_EQ(ids.take(content), free) << step;
    taken[free];
  }
}

TEST(AddedLightIds, ThoseAfterTheLastBeginAgain) {
  const std::string last = "3299074";  // its digest begins with almost only ones
  const std::uint64_t first = first_id(last);
  ASSERT_GT(first, 2 * kFirst - 1000);
  AddedLightIds ids({{kFirst, {}}, {kFirst + 1, {}}});
  for (std::uint64_t id = first; id < 2 * kFirst; ++id) EXPECT_EQ(ids.take(last), id);
  EXPECT_EQ(ids.take(last), kFirst + 2);
  EXPECT_EQ(ids.take(last), kFirst + 3);
}

TEST(AddedLightIds, OfLightsOfTheFileDoNotCount) {
  AddedLightIds ids({{1, {}}, {2, {}}});
  ids.free(1);
  EXPECT_EQ(ids.take("a"), first_id("a"));
}

}  // namespace
}  // namespace lucerna
