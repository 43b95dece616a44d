#include "server/scene/light_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(LightNames, FindsTheLightsOfANameAndTheNameOfALight) {
  const LightNames names({{0, "window"}, {2, "desk"}, {3, "window"}, {9, "a"}});
  EXPECT_THAT(names.lights("window"), ElementsAre(0, 3));
  EXPECT_THAT(names.lights("desk"), ElementsAre(2));
  EXPECT_THAT(names.lights("des"), IsEmpty());
  EXPECT_THAT(names.lights(""), IsEmpty());
  EXPECT_THAT(names.lights("zzz"), IsEmpty());
  EXPECT_EQ(names.of(0), "window");
  EXPECT_EQ(names.of(3), "window");
  EXPECT_EQ(names.of(9), "a");
  EXPECT_EQ(names.of(1), "");
  EXPECT_EQ(names.of(10), "");
  EXPECT_EQ(names.size(), 3U);
  EXPECT_EQ(names.light_count(), 4U);
}

TEST(LightNames, OfNothingAreEmpty) {
  const LightNames names;
  EXPECT_TRUE(names.empty());
  EXPECT_EQ(names.of(0), "");
  EXPECT_THAT(names.lights("lamp"), IsEmpty());
  EXPECT_THAT(names.similar("lamp", 3), IsEmpty());
  EXPECT_EQ(names.bytes(), 0U);
}

TEST(LightNames, SimilarNamesDifferByTheFewestBytes) {
  const LightNames names({{0, "desk lamp"}, {1, "desk"}, {2, "ceiling"}, {3, "wall lamp"}});
  // One byte less; four replaced; five deleted after one insertion.
  EXPECT_THAT(names.similar("dsk lamp", 2), ElementsAre("desk lamp", "wall lamp"));
  EXPECT_THAT(names.similar("desc", 1), ElementsAre("desk"));
  EXPECT_EQ(names.similar("x", 10).size(), 4U);
}

TEST(LightNames, SimilarNamesAmongManyAreThoseBesideTheName) {
  std::vector<std::pair<std::uint32_t, std::string>> many;
  for (std::uint32_t i = 0; i < 100'000; ++i) many.emplace_back(i, "lamp " + std::to_string(i));
  const LightNames names(std::move(many));
  EXPECT_THAT(names.similar("lamp 54321x", 1), ElementsAre("lamp 54321"));
  EXPECT_THAT(names.similar("", 1), ElementsAre("lamp 0"));
  EXPECT_EQ(names.similar("zebra", 5).size(), 5U);
}

TEST(LightNames, ASharedNameIsStoredOnce) {
  const std::string name(200, 'n');
  const LightNames one({{0, name}}), two({{0, name}, {1, name}});
  EXPECT_LT(two.bytes(), one.bytes() + 20);
}

}  // namespace
}  // namespace lucerna
