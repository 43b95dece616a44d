// MakeNamedMedium and MediumInterface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

const std::string kInk =
    "MakeNamedMedium \"ink\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 2 3] "
    "\"rgb sigma_s\" [0 0 0] ";

TEST(PbrtMedia, CoefficientsAreAbsorptionPerMetreTimesTheScale) {
  const auto scene = value_of(
      load_world("MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 2 3] "
                 "\"rgb sigma_s\" [0 0 0] \"float scale\" 2 "
                 "MakeNamedMedium \"b\" \"string type\" \"homogeneous\" "
                 "\"spectrum sigma_a\" [360 0.8 830 0.8] \"spectrum sigma_s\" [360 0 830 0]"));
  ASSERT_EQ(scene.media.size(), 2U);
  EXPECT_EQ(scene.media[0].absorption_per_m, Rgb(2, 4, 6));
  EXPECT_EQ(scene.media[1].absorption_per_m, Rgb(0.8));
  EXPECT_EQ(remarks_of(scene), "");
}

TEST(PbrtMedia, AttributesApplyAndTheDefaultIsThatOfPbrt) {
  const auto scene = value_of(
      load_world("AttributeBegin Attribute \"medium\" \"float scale\" 10 MakeNamedMedium \"a\" "
                 "\"string type\" \"homogeneous\" \"rgb sigma_s\" [0 0 0] AttributeEnd"));
  EXPECT_EQ(scene.media[0].absorption_per_m, Rgb(.0011, .0024, .014) * 10.0);
}

TEST(PbrtMedia, SurfacesSeparateTheMediaOfTheInterface) {
  const auto scene = value_of(load_world(
      "AttributeBegin MediumInterface \"ink\" \"\" Shape \"sphere\" Material \"interface\" "
      "Shape \"sphere\" AttributeEnd MediumInterface \"ink\" Shape \"disk\" " +
      kInk));
  ASSERT_EQ(scene.shapes.size(), 3U);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(scene.shapes[i].media.has_value());
    EXPECT_EQ(scene.shapes[i].media->inside, 0);
    EXPECT_EQ(scene.shapes[i].media->outside, -1);
    EXPECT_EQ(scene.shapes[i].is_interface, i == 1);
  }
  EXPECT_FALSE(scene.shapes[2].media.has_value());  // ink on both sides
  EXPECT_EQ(remarks_of(scene), "");
}

TEST(PbrtMedia, TheMediumOfTheCameraSurroundsTheScene) {
  const auto scene = value_of(load_text("MediumInterface \"\" \"ink\" Camera \"perspective\" " +
                                        kInk + "WorldBegin MediumInterface \"\" Shape \"disk\""));
  EXPECT_EQ(scene.surrounding_medium, 0);
  EXPECT_EQ(load_world("Shape \"disk\"")->surrounding_medium, -1);
}

TEST(PbrtMedia, WhatIsNotModelledIsReported) {
  const auto scene = value_of(load_world(
      "MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 1 1]\n"
      "MakeNamedMedium \"b\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 1 1]\n"
      "MakeNamedMedium \"c\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [0 0 0] \"rgb Le\" "
      "[1 1 1]\n"
      "MakeNamedMedium \"d\" \"string type\" \"homogeneous\" \"string preset\" \"Skimmilk\"\n"
      "MakeNamedMedium \"e\" \"string type\" \"cloud\""));
  EXPECT_EQ(remarks_of(scene),
            "1:12 scattering within medium \"a\" is not modelled -> absorption only\n"
            "2:49 scattering within medium \"b\" is not modelled -> absorption only\n"
            "3:71 emission of medium \"c\" is not modelled -> absorption only\n"
            "4:49 the preset of medium \"d\" is not modelled -> no absorption\n"
            "5:1 medium \"e\" of type \"cloud\" is not modelled -> no absorption\n");
}

TEST(PbrtMedia, InvalidMediaAreErrors) {
  const std::pair<std::string, const char*> kCases[] = {
      {"MediumInterface \"fog\" \"\" Shape \"disk\"",
       "scene.pbrt:1:12: medium \"fog\" is not defined in this scene"},
      {kInk + kInk, "medium \"ink\" is already defined, at scene.pbrt:1:12"},
      {"MakeNamedMedium \"a\"", "\"string type\" = \"\" of medium \"a\", allowed: homogeneous"},
      {"MakeNamedMedium \"a\" \"string type\" \"soup\"",
       "\"string type\" = \"soup\" of medium \"a\", allowed: homogeneous"},
      {"MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 -1 1]",
       "\"rgb sigma_a\" = [1 -1 1], allowed: not negative"},
      {"MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"spectrum sigma_a\" [360 1 830 -1]",
       "\"sigma_a\": value -1 at 830 nm, allowed: finite, not negative"},
      {"MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"float scale\" -1",
       "\"float scale\" = -1, allowed: at least 0"},
      {"MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 nan 1]", "nan"}};
  for (const auto& [text, expected] : kCases)
    EXPECT_THAT(world_error_of(text), ::testing::HasSubstr(expected)) << text;
}

}  // namespace
}  // namespace lucerna::testing
