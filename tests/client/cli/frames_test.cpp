// --frames and its patterns.
#include "client/cli/frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lucerna::cli {
namespace {

using ::testing::HasSubstr;

TEST(FrameRange, ReadsANumberARangeOrARangeWithAStep) {
  const auto expect = [](const char* text, std::uint64_t first, std::uint64_t last,
                         std::uint64_t step, std::uint64_t count) {
    const auto range = FrameRange::parse(text);
    ASSERT_TRUE(range.ok()) << range.status();
    EXPECT_EQ(range->first, first) << text;
    EXPECT_EQ(range->last, last) << text;
    EXPECT_EQ(range->step, step) << text;
    EXPECT_EQ(range->count(), count) << text;
  };
  expect("7", 7, 7, 1, 1);
  expect("0", 0, 0, 1, 1);
  expect("1-240", 1, 240, 1, 240);
  expect("0001-0240:2", 1, 240, 2, 120);
  expect("5-5:9", 5, 5, 9, 1);
  expect("999000000-999999999", 999000000, 999999999, 1, 1000000);
}

TEST(FrameRange, RefusesOtherTexts) {
  const auto error = [](const char* text) {
    return std::string(FrameRange::parse(text).status().message());
  };
  for (const char* bad : {"", "-", "x", "1-", "-3", "1-3:", "1-3:x", "1:2:3", "1-2-3", "1.5", " 1",
                          "1-1000000000", "99999999999999999999"})
    EXPECT_THAT(error(bad), HasSubstr("is not a range of frames, allowed: N, A-B or A-B:STEP"))
        << bad;
  EXPECT_THAT(error("9-1"), HasSubstr("\"9-1\" ends before it begins"));
  EXPECT_THAT(error("1-9:0"), HasSubstr("has a step of 0, allowed: 1 or more"));
  EXPECT_THAT(error("0-1000000"), HasSubstr("names 1000001 frames, allowed: up to 1000000"));
}

TEST(FramePattern, PutsTheNumberInItsPlace) {
  const auto name = [](const char* text, std::uint64_t frame) {
    const auto pattern = FramePattern::create(text);
    EXPECT_TRUE(pattern.ok()) << pattern.status();
    return pattern.ok() ? pattern->name(frame) : "";
  };
  EXPECT_EQ(name("frame.%04d.exr", 7), "frame.0007.exr");
  EXPECT_EQ(name("frame.%04d.exr", 12345), "frame.12345.exr");
  EXPECT_EQ(name("%d", 0), "0");
  EXPECT_EQ(name("%02d/a{}%%.pfm", 3), "03/a{}%.pfm");
  EXPECT_EQ(name("100%%%d", 3), "100%3");
}

TEST(FramePattern, NeedsExactlyOnePlaceForTheNumber) {
  const auto error = [](const char* text) {
    return std::string(FramePattern::create(text).status().message());
  };
  EXPECT_THAT(error("a.exr"), HasSubstr("\"a.exr\" has no place for the frame's number"));
  EXPECT_THAT(error("a%%.exr"), HasSubstr("has no place"));
  EXPECT_THAT(error("%d/%04d.exr"), HasSubstr("has 2 places for the frame's number"));
  for (const char* bad : {"a.%f", "a.%", "a.%4d", "a.%00d", "a.%010d", "a.%s.%d", "a.%-4d", "%ld"})
    EXPECT_THAT(error(bad), HasSubstr("which is not a frame number, allowed: %d, %04d")) << bad;
}

TEST(Frame, MovesTheMomentOrTheShutter) {
  Frame frame;
  frame.later_s = 0.75;
  v1::RenderImageRequest shutter;
  frame.put(shutter);
  EXPECT_EQ(shutter.shutter().offset_s(), 0.75);
  EXPECT_FALSE(shutter.shutter().has_length_s());
  v1::RenderImageRequest moment;
  moment.set_time_s(2);
  frame.put(moment);
  EXPECT_EQ(moment.time_s(), 2.75);
  EXPECT_FALSE(moment.has_shutter());
  frame.shutter_s = 0.25;
  frame.put(shutter);
  EXPECT_EQ(shutter.shutter().length_s(), 0.25);
  frame.own_scene = true;
  v1::RenderImageRequest untouched;
  frame.put(untouched);
  EXPECT_FALSE(untouched.has_shutter() || untouched.has_time_s());
}

}  // namespace
}  // namespace lucerna::cli
