#include "server/monitor/request_id.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace lucerna::monitor {
namespace {

TEST(RequestId, IsAShortTextThatCannotBreakALine) {
  EXPECT_TRUE(is_request_id("a"));
  EXPECT_TRUE(is_request_id("3f1c-8A_b.9:+/=@"));
  EXPECT_TRUE(is_request_id(std::string(128, 'x')));
  for (const std::string& bad :
       {std::string(), std::string(129, 'x'), std::string("a b"), std::string("a\nb"),
        std::string("a\"b"), std::string("a\\b"), std::string("a\0b", 3), std::string("\xc3\xa4")})
    EXPECT_FALSE(is_request_id(bad)) << bad;
}

TEST(RequestId, OfTheServerIsNewAndWellFormed) {
  std::set<std::string> ids;
  for (int i = 0; i < 1000; ++i) ids.insert(make_request_id());
  // Two of 1000 numbers of 64 bits are equal with a chance of 3e-14.
  EXPECT_EQ(ids.size(), 1000U);
  for (const std::string& id : ids) {
    EXPECT_EQ(id.size(), 16U);
    EXPECT_TRUE(is_request_id(id)) << id;
  }
}

// The example of the W3C page, and one wrong letter at a time.
TEST(Traceparent, FollowsTheStandard) {
  const std::string good = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  EXPECT_TRUE(is_traceparent(good));
  EXPECT_FALSE(is_traceparent(""));
  EXPECT_FALSE(is_traceparent(good + "-00"));
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = 'G';
    EXPECT_FALSE(is_traceparent(bad)) << bad;
  }
  EXPECT_FALSE(is_traceparent("00-" + std::string(32, '0') + "-b7ad6b7169203331-01"));
  EXPECT_FALSE(
      is_traceparent("00-0af7651916cd43dd8448eb211c80319c-" + std::string(16, '0') + "-01"));
}

TEST(PrintableName, ReplacesWhatCouldBreakALineOfTheLog) {
  EXPECT_EQ(printable_name("*.lamps.example"), "*.lamps.example");
  EXPECT_EQ(printable_name("a b\n\"c\"=\x80"), "a?b??c?=?");
  EXPECT_EQ(printable_name(std::string(1000, 'a')).size(), 128U);
}

TEST(SceneId, IsADigest) {
  EXPECT_TRUE(is_scene_id(std::string(64, 'a')));
  EXPECT_FALSE(is_scene_id(std::string(63, 'a')));
  EXPECT_FALSE(is_scene_id(std::string(64, 'A')));
  EXPECT_FALSE(is_scene_id(""));
}

}  // namespace
}  // namespace lucerna::monitor
