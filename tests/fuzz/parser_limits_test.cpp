// Limits that keep the memory of a parse near the size of its file.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "server/files/ply.h"
#include "server/lucernad/configuration.h"
#include "server/pbrt/load_pbrt.h"
#include "server/rpc/token_file.h"
#include "server/runtime/text_file.h"
#include "tests/fuzz/input_files.h"

namespace lucerna::fuzz {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<SceneDescription> pbrt(const std::string& text) {
  AssetReader assets(std::make_unique<InputFiles>(text, "scene.pbrt"));
  return load_pbrt(assets, "scene.pbrt");
}

std::string message(const absl::Status& status) { return std::string(status.message()); }

std::string blocks(std::size_t count) {
  return "WorldBegin\n" + repeated("AttributeBegin\n", count) + repeated("AttributeEnd\n", count);
}

TEST(ParserLimits, BlocksOfASceneFileNestAtMost256Deep) {
  EXPECT_TRUE(pbrt(blocks(256)).ok()) << pbrt(blocks(256)).status();
  EXPECT_EQ(message(pbrt(blocks(257)).status()),
            "scene.pbrt:258:1: blocks are open 257 deep, allowed: at most 256");
}

TEST(ParserLimits, ADirectiveHasAtMost256Parameters) {
  const auto shape = [](int count) {
    std::string text = "WorldBegin Shape \"sphere\"";
    for (int i = 0; i < count; ++i) text += fmt::format(" \"float p{}\" 1", i);
    return text;
  };
  EXPECT_TRUE(pbrt(shape(256)).ok());
  EXPECT_THAT(message(pbrt(shape(257)).status()),
              HasSubstr("a directive with more than 256 parameters, allowed: at most 256"));
}

TEST(ParserLimits, AParameterHasAtMost256Strings) {
  const auto strings = [](int count) {
    std::string text = "WorldBegin Shape \"sphere\" \"string names\" [";
    for (int i = 0; i < count; ++i) text += "\"a\" ";
    return text + "]";
  };
  EXPECT_TRUE(pbrt(strings(256)).ok());
  EXPECT_THAT(message(pbrt(strings(257)).status()),
              HasSubstr("\"string names\" has more than 256 strings, allowed: at most 256"));
}

TEST(ParserLimits, ATargetHasAtMost64Attributes) {
  const auto attributes = [](int count) {
    std::string text = "WorldBegin";
    for (int i = 0; i < count; ++i) text += fmt::format(" Attribute \"shape\" \"float p{}\" 1", i);
    return text;
  };
  EXPECT_TRUE(pbrt(attributes(64)).ok());
  EXPECT_THAT(message(pbrt(attributes(65)).status()),
              HasSubstr("more than 64 attributes of \"shape\", allowed: at most 64"));
}

TEST(ParserLimits, ALaterAttributeReplacesAnEarlierOneOfItsNameAndType) {
  std::string text = "WorldBegin";
  for (int i = 1; i <= 1000; ++i)
    text += fmt::format(" Attribute \"shape\" \"float radius\" {}", i);
  // Another type does not replace it, and does not fit.
  text += " Attribute \"shape\" \"string radius\" \"wide\" Shape \"sphere\"";
  const auto scene = pbrt(text);
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->shapes.size(), 1u);
  EXPECT_EQ(std::get<SphereParams>(scene->shapes[0].geometry).radius_m, 1000);
}

TEST(ParserLimits, APlyHeaderHasAtMost256ElementsAndProperties) {
  const auto error = [](const std::string& header) {
    return message(parse_ply("ply\nformat ascii 1.0\n" + header + "end_header\n").status());
  };
  EXPECT_EQ(error(repeated("element a 0\n", 256)), "PLY: no element \"vertex\"");
  EXPECT_EQ(error(repeated("element a 0\n", 257)), "PLY: header line 259: more than 256 elements");
  EXPECT_EQ(error("element a 0\n" + repeated("property int x\n", 257)),
            "PLY: header line 260: more than 256 properties");
}

TEST(ParserLimits, SettingsFilesHaveAtMostAMebibyte) {
  const std::string comment = "#" + std::string(kMostTextFileBytes - 1, 'x');
  const UnnamedFile fits(comment), large(comment + "\n");
  EXPECT_THAT(config::configure({.flags = {}, .environment = {}, .file = fits.path()}).errors,
              ::testing::IsEmpty());
  const std::string what = ": cannot be read: it is too large, allowed: at most 1048576 bytes";
  EXPECT_THAT(config::configure({.flags = {}, .environment = {}, .file = large.path()}).errors,
              ::testing::ElementsAre(large.path() + what));
  EXPECT_EQ(message(access::read_token_file(large.path()).status()), large.path() + what);
  // It has no end.
  EXPECT_THAT(message(read_text_file("/dev/zero").status()), HasSubstr("it is a pipe or a device"));
}

}  // namespace
}  // namespace lucerna::fuzz
