// Gives every parameter that takes a picture every kind of unusual or broken file.  Either the
// light is right, or an error has the place of the parameter, its name, the file, and what is
// allowed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/server/formats/picture_texts.h"
#include "tests/server/pbrt/bad_files.h"

namespace lucerna {
namespace {

using ::testing::AnyOf;
using testing::even_pfm;
using testing::expect_error;
using ::testing::HasSubstr;
using testing::load;
using testing::message;
using testing::Outcome;
using testing::pfm;
using testing::SceneFiles;
using ::testing::StartsWith;
using testing::written;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct PictureUser {
  const char* name;
  std::string source;
  /// Flux of an even picture of 1e5 x 1 texels over that of one texel; 0: pictures must be square.
  double of_a_row;
};

// A picture of one row extends to 1e5 on each side, one of a texel to 1: 4 asin(a b / sqrt((1 + a2)
// (1 + b2))).
const double kRow = std::asin(1 / std::sqrt(2.0)) / std::asin(1 / std::sqrt(2.0) / std::sqrt(2.0));

const std::vector<PictureUser>& picture_users() {
  const std::string infinite = "LightSource \"infinite\" \"string filename\" FILE ";
  const std::string portal = "\"point3 portal\" [-1 -1 2  -1 1 2  1 1 2  1 -1 2] ";
  const std::string goniometric =
      "Translate 0 0 2 LightSource \"goniometric\" \"string filename\" FILE ";
  const std::string projection =
      "Translate 0 0 2 Rotate 180 1 0 0 LightSource \"projection\" \"string filename\" FILE ";
  const std::string area =
      "AreaLightSource \"diffuse\" \"string filename\" FILE "
      "\"bool twosided\" true Translate 0 0 2 ";
  const std::string latlong = "\"string mapping\" \"latlong\" ";
  static const std::vector<PictureUser> users{
      {"infinite, equal-area", infinite, 0},
      {"infinite, latitude-longitude", infinite + latlong, 1},
      {"infinite, bilinear", infinite + latlong + "\"string filter\" \"bilinear\"", 1},
      {"portal, equal-area", infinite + portal, 0},
      {"portal, latitude-longitude", infinite + latlong + portal, 1},
      {"goniometric, equal-area", goniometric, 0},
      {"goniometric, latitude-longitude", goniometric + latlong, 1},
      {"projection", projection, kRow},
      {"beam", projection + "\"string projection\" \"orthographic\"", 1e5},
      {"area, patch", area + "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]",
       1},
      {"area, triangles", area + "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 1 1 0]", 1},
      {"area, sphere", area + "Shape \"sphere\" \"float radius\" 0.5", 1},
      {"area, disk", area + "Shape \"disk\"", 1},
      {"area, cylinder", area + "Shape \"cylinder\"", 1},
  };
  return users;
}

/// Calls `check(load)` for every user; `load(name, bytes)` returns the result for it.
template <typename Check>
void for_every_picture_user(Check&& check) {
  for (const PictureUser& user : picture_users()) {
    SCOPED_TRACE(user.name);
    check(user, [&](const std::string& name, const std::string& bytes) {
      return load(user.source, "filename", name, bytes);
    });
  }
}

TEST(PbrtBadFiles, LightsWithInvalidPicturesAreLeftOutWithARemark) {
  const OIIO::ImageSpec floats(4, 4, 3, OIIO::TypeDesc::FLOAT);
  const OIIO::ImageSpec bytes(4, 4, 3, OIIO::TypeDesc::UINT8);
  OIIO::ImageSpec normals(4, 4, 3, OIIO::TypeDesc::FLOAT);
  normals.channelnames = {"n.x", "n.y", "n.z"};
  const std::vector<float> even(48, 1);
  const std::string exr = written("a.exr", floats, even);
  const std::string png = written("a.png", bytes, std::vector<std::uint8_t>(48, 200));
  const std::string whole = even_pfm(4, 4, 1);
  const auto with = [](float v) {
    std::vector<float> values(48, 1);
    values[3 * 6 + 1] = v;  // texel (2, 1)
    return pfm(4, 4, values);
  };
  const std::pair<std::string, std::string> kFiles[] = {
      {"no.pfm", even_pfm(0, 0, 1)},
      {"claims.pfm", "PF\n4 0\n-1.0\n"},
      {"nan.pfm", with(std::numeric_limits<float>::quiet_NaN())},
      {"inf.pfm", with(kInfinity)},
      {"minus_inf.pfm", with(-kInfinity)},
      {"short.pfm", whole.substr(0, whole.size() / 2)},
      {"short.exr", exr.substr(0, exr.size() / 2)},
      {"short.png", png.substr(0, png.size() / 2)},
      {"empty.exr", ""},
      {"words.png", "not a picture"},
      {"words.txt", "not a picture"},
      {"normals.exr", written("a.exr", normals, even)},
  };
  for_every_picture_user([&](const PictureUser&, const auto& load) {
    for (const auto& [name, content] : kFiles) {
      SCOPED_TRACE(name);
      const Outcome o = load(name, content);
      ASSERT_TRUE(o.status.ok()) << o.status;
      EXPECT_TRUE(o.is_left_out);
      // "2:24 ..." is the place of the parameter.
      EXPECT_THAT("scene.pbrt:" + o.remarks, StartsWith(o.place.substr(0, o.place.size() - 2) +
                                                        " \"string filename\": " + name));
      EXPECT_THAT(o.remarks, HasSubstr(" -> the light is left out\n"));
      if (name.find("inf") != std::string::npos || name == "nan.pfm") {
        EXPECT_THAT(o.remarks, HasSubstr("texel (2, 1)"));
      }
    }
    const Outcome huge = load("huge.pfm", "PF\n64000 64000\n-1.0\n");
    expect_error(huge, "filename", "huge.pfm");
    EXPECT_EQ(huge.status.code(), absl::StatusCode::kResourceExhausted);
  });
}

TEST(PbrtBadFiles, OnePixelAndOneRowAreEvenLightsWhereAllowed) {
  for_every_picture_user([&](const PictureUser& user, const auto& load) {
    const Outcome even = load("even.pfm", even_pfm(8, 8, 2));
    ASSERT_TRUE(even.status.ok()) << even.status;
    EXPECT_GT(even.lumens, 0);
    EXPECT_TRUE(even.lit);
    const Outcome one = load("one.pfm", even_pfm(1, 1, 2));
    ASSERT_TRUE(one.status.ok()) << one.status;
    // 1e-4 allows for the sums of portals and panels.
    EXPECT_NEAR(one.lumens, even.lumens, 1e-4 * even.lumens);
    EXPECT_TRUE(one.lit);
    const Outcome row = load("row.pfm", even_pfm(100000, 1, 2));
    if (user.of_a_row == 0) {
      expect_error(row, "filename", "row.pfm");
      EXPECT_THAT(message(row.status), HasSubstr("100000 x 1 texels, allowed: square"));
    } else {
      ASSERT_TRUE(row.status.ok()) << row.status;
      EXPECT_NEAR(row.lumens, user.of_a_row * one.lumens, 1e-4 * row.lumens);
      EXPECT_TRUE(row.lit);
    }
  });
}

TEST(PbrtBadFiles, BlackPicturesAreDarkLights) {
  for_every_picture_user([&](const PictureUser&, const auto& load) {
    const Outcome black = load("black.pfm", even_pfm(4, 4, 0));
    ASSERT_TRUE(black.status.ok()) << black.status;
    EXPECT_EQ(black.lumens, 0);
    EXPECT_FALSE(black.lit);
  });
}

TEST(PbrtBadFiles, NegativeTexelsCountAsZeroAndAreRemarkedOn) {
  std::vector<float> values(48, 2);
  for (std::size_t i = 0; i < 24; ++i) values[i] = 0;
  const std::string half = pfm(4, 4, values);
  for (std::size_t i = 0; i < 24; ++i) values[i] = -5;
  const std::string negative = pfm(4, 4, values);
  for_every_picture_user([&](const PictureUser&, const auto& load) {
    const Outcome zero = load("half.pfm", half), below = load("below.pfm", negative);
    ASSERT_TRUE(zero.status.ok() && below.status.ok()) << below.status;
    EXPECT_EQ(below.lumens, zero.lumens);
    EXPECT_THAT(below.remarks, HasSubstr("below.pfm has 8 texels with a value below 0"));
    EXPECT_EQ(zero.remarks, "");
  });
}

TEST(PbrtBadFiles, GreyIsGreyAndAlphaIsLeftOut) {
  const OIIO::ImageSpec grey(4, 4, 1, OIIO::TypeDesc::FLOAT);
  const OIIO::ImageSpec half_seen(4, 4, 4, OIIO::TypeDesc::FLOAT);
  std::vector<float> one, three, four;
  for (int i = 0; i < 16; ++i) {
    const float v = 1 + static_cast<float>(i * 5 % 16) / 8;
    one.push_back(v);
    three.insert(three.end(), 3, v);
    four.insert(four.end(), 3, v);
    four.push_back(0.5F);
  }
  const std::string with_grey = written("a.exr", grey, one);
  const std::string with_alpha = written("a.exr", half_seen, four);
  for_every_picture_user([&](const PictureUser&, const auto& load) {
    const Outcome colours = load("rgb.pfm", pfm(4, 4, three));
    const Outcome g = load("grey.exr", with_grey), a = load("alpha.exr", with_alpha);
    ASSERT_TRUE(colours.status.ok() && g.status.ok() && a.status.ok()) << g.status << a.status;
    EXPECT_EQ(g.lumens, colours.lumens);
    EXPECT_EQ(a.lumens, colours.lumens);
    EXPECT_EQ(g.remarks, "");
    EXPECT_THAT(a.remarks, HasSubstr("alpha.exr has an alpha channel -> alpha is ignored"));
  });
}

TEST(PbrtBadFiles, TexelsTimesScaleBeyondAFloatAreAnErrorForEveryLight) {
  const std::string bright = even_pfm(4, 4, 1e30F);
  for (PictureUser user : picture_users()) {
    SCOPED_TRACE(user.name);
    const std::size_t at = user.source.find("FILE") + 4;
    user.source.insert(at, " \"float scale\" 1e20");
    const Outcome o = load(user.source, "filename", "sun.pfm", bright);
    ASSERT_FALSE(o.status.ok());
    EXPECT_EQ(o.status.code(), absl::StatusCode::kInvalidArgument);
    const std::string name = "\"sun.pfm\"";
    const std::size_t column = at + name.size() - std::string("FILE").size() + 2;
    EXPECT_THAT(message(o.status), StartsWith("scene.pbrt:2:" + std::to_string(column) + ": "));
    EXPECT_THAT(message(o.status), HasSubstr("allowed: each channel finite"));
    EXPECT_THAT(message(o.status), AnyOf(HasSubstr("brightest texel"), HasSubstr("largest")));
  }
}

TEST(PbrtBadFiles, NamesOfMissingFilesAreErrorsForEveryLight) {
  for_every_picture_user([&](const PictureUser& user, const auto&) {
    const auto error = [&](const std::string& names) {
      std::string text = user.source;
      text.replace(text.find("FILE"), 4, names);
      const SceneFiles files;
      std::filesystem::create_directory(files.path() / "folder.exr");
      files.write("scene.pbrt", "WorldBegin\n" + text);
      const std::string place = std::to_string(text.find("\"string filename") + 1);
      const std::string what = message(files.load("scene.pbrt").status());
      EXPECT_THAT(what, StartsWith("scene.pbrt:2:" + place + ": ")) << names;
      return what;
    };
    EXPECT_THAT(error("\"none.exr\""), HasSubstr("file \"none.exr\" does not exist"));
    EXPECT_THAT(error("\"folder.exr\""), HasSubstr("\"folder.exr\" is not a regular file"));
    EXPECT_THAT(error("\"../a.exr\""), HasSubstr("leaves the scene root, allowed: paths inside"));
    EXPECT_THAT(error("\"\""), HasSubstr("file name \"\" is empty"));
    EXPECT_THAT(error("[\"a.exr\" \"b.exr\"]"), HasSubstr("\"string filename\" takes one name"));
  });
}

}  // namespace
}  // namespace lucerna
