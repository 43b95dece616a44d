#include "server/description/remark_groups.h"

#include <gtest/gtest.h>

namespace lucerna {
namespace {

SourceLocation at(int line) { return {"scene.pbrt", line, 1}; }

TEST(RemarkGroups, EqualRemarksAreOneWithACountAndTheFirstPlaces) {
  RemarkGroups groups;
  for (int line = 1; line <= 5000; ++line) {
    groups.add(at(line), "hair", "diffuse");
    if (line == 7) groups.add(at(line), "hair", "left out");
  }
  const std::vector<Remark> remarks = groups.take("scene.pbrt");
  ASSERT_EQ(remarks.size(), 2U);
  EXPECT_EQ(remarks[0].what, "hair");
  EXPECT_EQ(remarks[0].instead, "diffuse");
  EXPECT_EQ(remarks[0].count, 5000U);
  EXPECT_EQ(remarks[0].where.line, 1);
  ASSERT_EQ(remarks[0].more.size(), RemarkGroups::kMostMorePlaces);
  EXPECT_EQ(remarks[0].more.front().line, 2);
  EXPECT_EQ(remarks[0].more.back().line, 5);
  EXPECT_EQ(remarks[1].instead, "left out");
  EXPECT_EQ(remarks[1].count, 1U);
  EXPECT_EQ(remarks[1].where.line, 7);
}

TEST(RemarkGroups, TheSamePlaceCountsOnce) {
  RemarkGroups groups;
  for (const int line : {1, 2, 1, 2, 1}) groups.add(at(line), "hair", "diffuse");
  const std::vector<Remark> remarks = groups.take("scene.pbrt");
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_EQ(remarks[0].count, 2U);
}

TEST(RemarkGroups, TextsDoNotRunTogether) {
  RemarkGroups groups;
  groups.add(at(1), "ab", "c");
  groups.add(at(1), "a", "bc");
  EXPECT_EQ(groups.take("scene.pbrt").size(), 2U);
}

TEST(RemarkGroups, AreBoundedAndTheOthersAreCounted) {
  RemarkGroups groups;
  for (int i = 0; i < 1200; ++i) groups.add(at(i), "thing " + std::to_string(i), "nothing");
  groups.add(at(5000), "thing 3", "nothing");
  const std::vector<Remark> remarks = groups.take("scene.pbrt");
  ASSERT_EQ(remarks.size(), RemarkGroups::kMostGroups + 1);
  EXPECT_EQ(remarks[3].count, 2U);
  EXPECT_EQ(remarks.back().what, "200 more things are not modelled");
  EXPECT_EQ(remarks.back().where.file, "scene.pbrt");
  EXPECT_EQ(remarks.back().where.line, 0);
}

}  // namespace
}  // namespace lucerna
