// Every parameter of a scene that takes a picture or a photometric file, given every kind of file
// that is odd or broken: the light is right, or an error says where the parameter stands, its name,
// the file, and what is allowed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "server/pbrt/place.h"
#include "server/scene.h"
#include "tests/server/photometric_texts.h"
#include "tests/server/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::AnyOf;
using testing::even_pfm;
using ::testing::HasSubstr;
using testing::Ies;
using testing::Ldt;
using testing::message;
using testing::pfm;
using testing::SceneFiles;
using ::testing::StartsWith;
using testing::written;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// What came of one light, and of its file.
struct Outcome {
  absl::Status status;
  std::string place;  ///< of the parameter, "scene.pbrt:2:24: "
  std::string remarks;
  double lumens = 0;
  bool lit = false;
};

/// `source` names its file by FILE after the parameter `parameter`.
Outcome load(const std::string& source, const std::string& parameter, const std::string& name,
             const std::string& bytes) {
  const SceneFiles files;
  files.write(name, bytes);
  std::string text = source;
  text.replace(text.find("FILE"), 4, "\"" + name + "\"");
  // A floor gives the scene a size, and with that lights at infinity a flux.
  files.write(
      "scene.pbrt",
      "WorldBegin Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n" + text);
  Outcome outcome;
  outcome.place = "scene.pbrt:2:" + std::to_string(text.find("\"string " + parameter) + 1) + ": ";
  auto description = files.load("scene.pbrt");
  outcome.status = description.status();
  if (!description.ok()) return outcome;
  outcome.remarks = testing::remarks_of(*description);
  const auto scene = Scene::build(*std::move(description));
  outcome.status = scene.status();
  if (!scene.ok()) return outcome;
  EXPECT_EQ((*scene)->lights().size(), 1U);
  visit_light((*scene)->lights()[0], 0, [&](const auto& light) {
    outcome.lumens = luminance(light.power((*scene)->sphere()).lumens);
    // From where all of them are seen.
    for (int i = 0; i < 16; ++i) {
      const auto s =
          light.sample_li(Receiver<float>{{0.1F, 0.2F, 0.7F}},
                          {static_cast<float>(i % 4) / 4, static_cast<float>(i / 4) / 4});
      outcome.lit |= s.reason == NoLight::kNone && s.value.g > 0;
      EXPECT_TRUE(is_finite(s.value) && std::isfinite(s.pdf.per_sr));
    }
  });
  return outcome;
}

void expect_error(const Outcome& o, const std::string& parameter, const std::string& name) {
  EXPECT_FALSE(o.status.ok());
  const std::string text = message(o.status);
  EXPECT_THAT(text, StartsWith(o.place));
  EXPECT_THAT(text, HasSubstr("\"string " + parameter + "\""));
  EXPECT_THAT(text, HasSubstr(name));
  EXPECT_THAT(text, AnyOf(HasSubstr("allowed"), HasSubstr("the file ends before")));
  EXPECT_TRUE(pbrt::is_printable(text)) << text;
}

// ---- Pictures ----

struct PictureUser {
  const char* name;
  std::string source;
  /// The flux of an even picture of 1e5 x 1 texels over that of one texel; 0: it must be square.
  double of_a_row;
};

// The picture of a row reaches 1e5 to either side where one of a texel reaches 1: 4 asin(a b /
// sqrt((1 + a2) (1 + b2))).
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

/// Calls `check(load)` for every user, where `load(name, bytes)` is what becomes of it.
template <typename Check>
void for_every_picture_user(Check&& check) {
  for (const PictureUser& user : picture_users()) {
    SCOPED_TRACE(user.name);
    check(user, [&](const std::string& name, const std::string& bytes) {
      return load(user.source, "filename", name, bytes);
    });
  }
}

TEST(PbrtBadFiles, PicturesThatAreNoneAreErrorsForEveryLight) {
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
    values[3 * 6 + 1] = v;  // of texel (2, 1)
    return pfm(4, 4, values);
  };
  const std::pair<std::string, std::string> kFiles[] = {
      {"no.pfm", even_pfm(0, 0, 1)},
      {"claims.pfm", "PF\n4 0\n-1.0\n"},
      {"nan.pfm", with(kNan)},
      {"inf.pfm", with(kInfinity)},
      {"minus_inf.pfm", with(-kInfinity)},
      {"short.pfm", whole.substr(0, whole.size() / 2)},
      {"short.exr", exr.substr(0, exr.size() / 2)},
      {"short.png", png.substr(0, png.size() / 2)},
      {"empty.exr", ""},
      {"words.png", "not a picture"},
      {"other_kind.exr", png},
      {"words.txt", "not a picture"},
      {"normals.exr", written("a.exr", normals, even)},
      {"huge.pfm", "PF\n64000 64000\n-1.0\n"},
  };
  for_every_picture_user([&](const PictureUser&, const auto& load) {
    for (const auto& [name, content] : kFiles) {
      SCOPED_TRACE(name);
      const Outcome o = load(name, content);
      expect_error(o, "filename", name);
      EXPECT_EQ(o.status.code(), name == "huge.pfm" ? absl::StatusCode::kResourceExhausted
                                                    : absl::StatusCode::kInvalidArgument);
      if (name.find("inf") != std::string::npos || name == "nan.pfm") {
        EXPECT_THAT(message(o.status), HasSubstr("texel (2, 1)"));
      }
    }
  });
}

TEST(PbrtBadFiles, OnePixelAndOneRowAreEvenLightsWhereTheyMayBe) {
  for_every_picture_user([&](const PictureUser& user, const auto& load) {
    const Outcome even = load("even.pfm", even_pfm(8, 8, 2));
    ASSERT_TRUE(even.status.ok()) << even.status;
    EXPECT_GT(even.lumens, 0);
    EXPECT_TRUE(even.lit);
    const Outcome one = load("one.pfm", even_pfm(1, 1, 2));
    ASSERT_TRUE(one.status.ok()) << one.status;
    // 1e-4: the sums of portals and panels.
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

TEST(PbrtBadFiles, NamesThatLeadNowhereAreErrorsForEveryLight) {
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
    EXPECT_THAT(error("\"../a.exr\""), HasSubstr("leaves the scene root, allowed: files beneath"));
    EXPECT_THAT(error("\"\""), HasSubstr("file name \"\" is empty"));
    EXPECT_THAT(error("[\"a.exr\" \"b.exr\"]"), HasSubstr("\"string filename\" takes one name"));
  });
}

// ---- Photometric files ----

struct ProfileUser {
  const char* parameter;
  std::string source;
};

const std::vector<ProfileUser>& profile_users() {
  static const std::vector<ProfileUser> users{
      {"filename",
       "Translate 0 0 2 Rotate 180 1 0 0 LightSource \"goniometric\" \"string filename\" FILE"},
      {"profile",
       "AreaLightSource \"diffuse\" \"string profile\" FILE \"bool twosided\" true "
       "ReverseOrientation Translate 0 0 2 Shape \"disk\""},
      {"profile",
       "AreaLightSource \"diffuse\" \"string profile\" FILE \"bool twosided\" true "
       "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [-1 -1 2 1 -1 2 -1 1 2 1 1 2]"},
  };
  return users;
}

template <typename File, typename Change>
std::string changed(Change&& change) {
  File f;
  change(f);
  return f.text();
}

TEST(PbrtBadFiles, BrokenPhotometricFilesAreErrorsForEveryParameter) {
  const auto ies = [](auto change) { return changed<Ies>(change); };
  const auto ldt = [](auto change) { return changed<Ldt>(change); };
  const std::string whole_ies = Ies().text(), whole_ldt = Ldt().text();
  struct Case {
    const char* name;
    std::string bytes;
    const char* what;
  };
  const Case kFiles[] = {
      {"empty.ies", "", "empty.ies:0: no line \"TILT=\", allowed: TILT=NONE"},
      {"words.ies", "no photometry\n", "words.ies:1: no line \"TILT=\""},
      {"picture.ies", even_pfm(2, 2, 1), "no line \"TILT=\", allowed"},
      {"short.ies", whole_ies.substr(0, whole_ies.size() / 2), "the file ends before "},
      {"short_values.ies", whole_ies.substr(0, whole_ies.size() - 4),
       "the file ends before candela value 3"},
      {"angles.ies", ies([](Ies& f) { f.angles = "0 90 45\n0\n"; }),
       "angles.ies:7: vertical angle 3 = 45 degrees, allowed: above the one before, which is 90"},
      {"plane.ies", ies([](Ies& f) { f.angles = "0 45 90\n0 0\n", f.counts = "3 2"; }),
       "plane.ies:8: horizontal angle 2 = 0 degrees, allowed: above the one before"},
      {"nan.ies", ies([](Ies& f) { f.candela = "100 nan 10\n"; }),
       "nan.ies:9: candela value 2 is \"nan\", allowed: a finite number"},
      {"infinite.ies", ies([](Ies& f) { f.candela = "100 1e999 10\n"; }),
       "infinite.ies:9: candela value 2 is \"1e999\", allowed: a finite number"},
      {"negative.ies", ies([](Ies& f) { f.candela = "100 -50 10\n"; }),
       "negative.ies:9: candela value 2 = -50, allowed: finite, not negative"},
      {"none.ies", ies([](Ies& f) { f.counts = "0 1"; }),
       "none.ies:5: the number of vertical angles = 0, allowed: 2 or more"},
      {"fraction.ies", ies([](Ies& f) { f.counts = "3 1.5"; }),
       "fraction.ies:5: the number of horizontal angles = 1.5, allowed: 1 or more"},
      {"more.ies", ies([](Ies& f) { f.counts = "4 1"; }), "allowed"},
      {"huge.ies", ies([](Ies& f) { f.counts = "1000000000 1000000000"; }),
       "numbers are claimed to follow, allowed: as many as"},
      {"million.ies", ies([](Ies& f) { f.counts = "1000 1000"; }),
       "1002000 numbers are claimed to follow, allowed: as many as"},
      {"multiplier.ies", ies([](Ies& f) { f.lamps = "1 1000 0"; }),
       "multiplier.ies:5: candela multiplier = 0, allowed: positive"},
      {"empty.ldt", "", "empty.ldt:0: the file ends before the symmetry Isym"},
      {"picture.ldt", even_pfm(2, 2, 1),
       "picture.ldt:3: the symmetry Isym = -1, allowed: 0, 1, 2, 3 or 4"},
      {"short.ldt", whole_ldt.substr(0, whole_ldt.size() / 2), "short.ldt:"},
      {"short_values.ldt", whole_ldt.substr(0, whole_ldt.size() - 3),
       "short_values.ldt:48: the file ends before an intensity per 1000 lm (line 49)"},
      {"angles.ldt", ldt([](Ldt& f) {
         f.gamma = {"0", "90", "45"};
       }),
       "allowed"},
      {"nan.ldt", ldt([](Ldt& f) { f.intensities[1] = "nan"; }),
       "nan.ldt:48: an intensity per 1000 lm is \"nan\", allowed: a finite number"},
      {"negative.ldt", ldt([](Ldt& f) { f.intensities[1] = "-1"; }),
       "negative.ldt:48: an intensity per 1000 lm = -1, allowed: finite, not negative"},
      {"none.ldt", ldt([](Ldt& f) { f.mc = 0; }),
       "none.ldt:4: the number Mc of C-planes = 0, allowed: a positive whole number"},
      {"more.ldt", ldt([](Ldt& f) { f.ng = 30; }),
       "more.ldt:6: 1 angles and 1 planes of 30 intensities are claimed to follow, allowed"},
      {"huge.ldt", ldt([](Ldt& f) { f.mc = f.ng = 1000000000; }),
       "are claimed to follow, allowed: as many as"},
      {"symmetry.ldt", ldt([](Ldt& f) { f.symmetry = 5; }),
       "symmetry.ldt:3: the symmetry Isym = 5, allowed: 0, 1, 2, 3 or 4"},
  };
  for (const ProfileUser& user : profile_users())
    for (const Case& c : kFiles) {
      SCOPED_TRACE(std::string(user.parameter) + ", " + c.name);
      const Outcome o = load(user.source, user.parameter, c.name, c.bytes);
      expect_error(o, user.parameter, c.name);
      EXPECT_EQ(o.status.code(), absl::StatusCode::kInvalidArgument);
      EXPECT_THAT(message(o.status), HasSubstr(c.what));
    }
}

TEST(PbrtBadFiles, OddPhotometricFilesAreWhatTheySayForEveryParameter) {
  const auto ies = [](auto change) { return changed<Ies>(change); };
  const auto crlf = [](std::string text, const std::string& end) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += end.size())
      text.replace(at, 1, end);
    return text;
  };
  const std::string whole = Ies().text();
  const std::pair<const char*, std::string> kSame[] = {
      {"crlf.ies", crlf(whole, "\r\n")},
      {"cr.ies", crlf(whole, "\r")},
      {"no_end.ies", whole.substr(0, whole.size() - 1)},
      {"one_a_line.ies", ies([](Ies& f) { f.candela = "\n100\n\n50,\t10"; })},
      {"marked.IES", "\xef\xbb\xbf" + whole},
      {"absolute.ies", ies([](Ies& f) { f.lamps = "1 -1 1"; })},
  };
  for (const ProfileUser& user : profile_users()) {
    const Outcome plain = load(user.source, user.parameter, "lamp.ies", whole);
    ASSERT_TRUE(plain.status.ok()) << plain.status;
    EXPECT_GT(plain.lumens, 0);
    EXPECT_TRUE(plain.lit);
    for (const auto& [name, bytes] : kSame) {
      SCOPED_TRACE(name);
      const Outcome o = load(user.source, user.parameter, name, bytes);
      ASSERT_TRUE(o.status.ok()) << o.status;
      EXPECT_EQ(o.lumens, plain.lumens);
      EXPECT_TRUE(o.lit);
    }
    const Outcome black =
        load(user.source, user.parameter, "black.ies", ies([](Ies& f) { f.candela = "0 0 0\n"; }));
    ASSERT_TRUE(black.status.ok()) << black.status;
    EXPECT_EQ(black.lumens, 0);
    EXPECT_FALSE(black.lit);
  }
}

}  // namespace
}  // namespace lucerna
