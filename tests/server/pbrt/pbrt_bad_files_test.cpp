// Levels beyond floats, and names of missing files, in every parameter that takes a picture.
// PictureExtremes and PhotometricExtremes give them unusual and broken files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/server/extremes/file_scenes.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Calls `check` with the text of every light that takes a picture.  FILE stands for its name.
template <typename Check>
void for_every_picture_user(Check&& check) {
  const std::string infinite = "LightSource \"infinite\" \"string filename\" FILE ";
  const std::string portal = "\"point3 portal\" [-1 -1 2  -1 1 2  1 1 2  1 -1 2] ";
  const std::string goniometric = "LightSource \"goniometric\" \"string filename\" FILE ";
  const std::string projection = "LightSource \"projection\" \"string filename\" FILE ";
  const std::string area = "AreaLightSource \"diffuse\" \"string filename\" FILE ";
  const std::string latlong = "\"string mapping\" \"latlong\" ";
  const std::map<std::string, std::string> users{
      {"infinite, equal-area", infinite},
      {"infinite, latitude-longitude", infinite + latlong},
      {"infinite, bilinear", infinite + latlong + "\"string filter\" \"bilinear\""},
      {"portal, equal-area", infinite + portal},
      {"portal, latitude-longitude", infinite + latlong + portal},
      {"goniometric, equal-area", goniometric},
      {"goniometric, latitude-longitude", goniometric + latlong},
      {"projection", projection},
      {"beam", projection + "\"string projection\" \"orthographic\""},
      {"area, patch", area + "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]"},
      {"area, triangles", area + "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 1 1 0]"},
      {"area, sphere", area + "Shape \"sphere\" \"float radius\" 0.5"},
      {"area, disk", area + "Shape \"disk\""},
      {"area, cylinder", area + "Shape \"cylinder\""},
  };
  for (const auto& [name, source] : users) {
    SCOPED_TRACE(name);
    check(source);
  }
}

/// The place of a parameter of the light, as errors have it.
std::string place_of(const std::string& parameter, const std::string& text) {
  return "scene.pbrt:2:" + std::to_string(text.find(parameter) + 1) + ": ";
}

TEST(PbrtBadFiles, TexelsTimesScaleBeyondAFloatAreAnErrorForEveryLight) {
  const std::string bright = even_pfm(4, 4, 1e30F);
  for_every_picture_user([&](std::string text) {
    text.replace(text.find("FILE"), 4, "\"sun.pfm\" \"float scale\" 1e20");
    const absl::Status status = scene_of(text, {{"sun.pfm", bright}}).status;
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(message(status), StartsWith(place_of("\"float scale", text)));
    EXPECT_THAT(message(status), HasSubstr("allowed: each channel finite"));
    EXPECT_THAT(message(status), AnyOf(HasSubstr("brightest texel"), HasSubstr("largest")));
  });
}

TEST(PbrtBadFiles, NamesOfMissingFilesAreErrorsForEveryLight) {
  const std::pair<const char*, const char*> kCases[] = {
      {"\"none.exr\"", "file \"none.exr\" does not exist"},
      {"\"folder.exr\"", "\"folder.exr\" is not a regular file"},
      {"\"../a.exr\"", "leaves the scene root, allowed: paths inside"},
      {"\"\"", "file name \"\" is empty"},
      {"[\"a.exr\" \"b.exr\"]", "\"string filename\" takes one name"},
  };
  for_every_picture_user([&](const std::string& source) {
    for (const auto& [names, expected] : kCases) {
      std::string text = source;
      text.replace(text.find("FILE"), 4, names);
      const std::string error =
          message(scene_of(text, {{"folder.exr/a.exr", "in a folder"}}).status);
      EXPECT_THAT(error, StartsWith(place_of("\"string filename", text))) << names;
      EXPECT_THAT(error, HasSubstr(expected)) << names;
    }
  });
}

}  // namespace
}  // namespace lucerna::testing
