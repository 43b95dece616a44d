// Any broken photometric file or picture gives a light or an error with its place.  After an error
// nothing of the scene is loaded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "server/formats/eulumdat.h"
#include "server/formats/ies.h"
#include "server/pbrt/syntax/place.h"
#include "server/scene/scene.h"
#include "tests/mutated.h"
#include "tests/server/formats/photometric_texts.h"
#include "tests/server/formats/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using testing::Ies;
using testing::mutated;
using testing::planes;
using testing::SceneFiles;
using ::testing::StartsWith;

constexpr const char* kWords[] = {"-1", "1e308",          "999999999", "nan",
                                  "\r", "TILT=INCLUDE\n", "0 ",        "-"};

template <typename Parse>
void check_mutations(const std::string& whole, Parse&& parse) {
  std::mt19937 random(1963);
  int errors = 0, good = 0;
  const auto check = [&](const std::string& text) {
    const auto file = parse(text);
    if (!file.ok()) {
      ++errors;
      const std::string message = testing::message(file.status());
      for (const char c : message) ASSERT_TRUE(c >= ' ' && c <= '~');
      // Each error has a line and the allowed values, unless the file is too short.
      int line = -1;
      ASSERT_EQ(std::sscanf(message.c_str(), "lamp:%d: ", &line), 1) << message;
      ASSERT_TRUE(line >= 0 &&
                  line <= 1 + std::count_if(text.begin(), text.end(),
                                            [](char c) { return c == '\n' || c == '\r'; }))
          << message;
      ASSERT_THAT(message, AnyOf(HasSubstr("allowed: "), HasSubstr("allowed for "),
                                 HasSubstr("the file ends before ")));
      return;
    }
    ++good;
    const double flux = file->web->flux_lm();
    ASSERT_TRUE(std::isfinite(flux) && flux >= 0) << flux;
    for (int i = 0; i < 20; ++i) {
      const Vec3<double> w{double(random()) - 2e9, double(random()) - 2e9, double(random()) - 2e9};
      const double cd = file->web->at(w);
      ASSERT_TRUE(cd >= 0 && cd <= file->web->max_cd()) << cd;
    }
  };
  for (std::size_t size = 0; size <= whole.size(); ++size) check(whole.substr(0, size));
  for (int i = 0; i < 5000; ++i) check(mutated(whole, random, kWords));
  EXPECT_GT(errors, 500);
  EXPECT_GT(good, 500);
}

TEST(PhotometricMutations, BrokenIesFilesEndWithAWebOrAnError) {
  Ies f;
  f.tilt = "TILT=INCLUDE\n1\n2\n0 90\n1 0.9\n";
  f.counts = "3 2";
  f.angles = "0 45 90\n0 90\n";
  f.candela = "100 50 10\n100 60 20\n";
  check_mutations(f.text(), [](const std::string& t) { return parse_ies(t, "lamp"); });
}

TEST(PhotometricMutations, BrokenEulumdatFilesEndWithAWebOrAnError) {
  const std::string whole = planes(3, {"1", "2", "3", "4", "5"}).text();
  check_mutations(whole, [](const std::string& t) { return parse_eulumdat(t, "lamp"); });
}

/// A small picture in some format, with several colours.
std::string picture(const std::string& name, OIIO::TypeDesc type) {
  std::vector<float> values;
  for (int i = 0; i < 48; ++i) values.push_back(0.02F * static_cast<float>(i % 29));
  // OpenImageIO reads this format, but does not write it.
  if (name.ends_with(".pfm")) return testing::pfm(4, 4, values);
  return testing::written(name, OIIO::ImageSpec(4, 4, 3, type), values);
}

/// Loads and builds a scene with one light many times, each time with another broken file FILE.
void check_scenes(const std::string& name, const std::string& whole, const std::string& light,
                  int times) {
  SCOPED_TRACE(light + " with " + name);
  const SceneFiles files;
  std::string source = light;
  source.replace(source.find("FILE"), 4, "\"" + name + "\"");
  files.write("scene.pbrt", "WorldBegin\n" + source);
  files.write(name, whole);
  ASSERT_TRUE(files.load("scene.pbrt").ok()) << files.load("scene.pbrt").status();
  std::mt19937 random(2019);
  int errors = 0;
  for (int i = 0; i < times; ++i) {
    const std::string broken =
        i % 3 == 0 ? whole.substr(0, random() % whole.size()) : mutated(whole, random, kWords);
    files.write(name, broken);
    const auto description = files.load("scene.pbrt");
    absl::Status status = description.status();
    if (description.ok()) {
      for (const Remark& remark : description->remarks)
        ASSERT_TRUE(pbrt::is_printable(remark.what) && pbrt::is_printable(remark.instead));
      const auto scene = Scene::build(*description);
      status = scene.status();
      if (scene.ok()) {
        // A light without its picture is left out, with a remark.
        if ((*scene)->lights().empty()) {
          ASSERT_FALSE(description->remarks.empty());
          ++errors;
          continue;
        }
        ASSERT_EQ((*scene)->lights().size(), 1U);
        visit_light((*scene)->lights()[0], 0, [&](const auto& made) {
          const Power power = made.power({{}, 1});
          EXPECT_TRUE(is_finite(power.lumens) && power.lumens.g >= 0);
        });
        ASSERT_FALSE(::testing::Test::HasFailure());
        continue;
      }
    }
    ++errors;
    const std::string message = testing::message(status);
    ASSERT_THAT(message, StartsWith("scene.pbrt:2:"));
    // An error in the file, or in the scene's use of its numbers.
    ASSERT_THAT(message, AnyOf(HasSubstr(name), HasSubstr("allowed: each channel finite")));
    ASSERT_TRUE(pbrt::is_printable(message)) << message;
  }
  EXPECT_GT(errors, times / 10);
}

const char* const kGoniometric = "LightSource \"goniometric\" \"string filename\" FILE";

TEST(PhotometricMutations, ScenesOfBrokenPhotometricFilesNameThemOrLoad) {
  const std::string ies = Ies().text(), ldt = planes(3, {"1", "2", "3", "4", "5"}).text();
  const std::string panel = "AreaLightSource \"diffuse\" \"string profile\" FILE Shape ";
  for (const std::string& light :
       {std::string(kGoniometric), panel + "\"disk\"",
        panel + "\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]"}) {
    check_scenes("lamp.ies", ies, light, 120);
    check_scenes("lamp.ldt", ldt, light, 120);
  }
}

TEST(PhotometricMutations, ScenesOfBrokenPicturesNameThemOrLoad) {
  using OIIO::TypeDesc;
  const std::string latlong = " \"string mapping\" \"latlong\"";
  const std::string infinite = "LightSource \"infinite\" \"string filename\" FILE" + latlong;
  const std::string projection = "LightSource \"projection\" \"string filename\" FILE";
  const std::string area = "AreaLightSource \"diffuse\" \"string filename\" FILE Shape ";
  for (const auto& [name, type] : {std::pair<std::string, TypeDesc>{"lamp.pfm", TypeDesc::FLOAT},
                                   {"lamp.exr", TypeDesc::HALF},
                                   {"lamp.png", TypeDesc::UINT16},
                                   {"lamp.hdr", TypeDesc::FLOAT},
                                   {"lamp.tif", TypeDesc::UINT8},
                                   {"lamp.jpg", TypeDesc::UINT8}}) {
    const std::string whole = picture(name, type);
    check_scenes(name, whole, kGoniometric + latlong, 120);
    for (const std::string& light :
         {infinite, infinite + " \"point3 portal\" [0 0 1 0 1 1 1 1 1 1 0 1]", projection,
          projection + " \"string projection\" \"orthographic\"", area + "\"disk\"",
          area + "\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0]"})
      check_scenes(name, whole, light, 30);
  }
}

}  // namespace
}  // namespace lucerna
