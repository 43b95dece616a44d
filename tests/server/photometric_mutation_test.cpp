// Broken photometric files and pictures: whatever they hold, there is a light or an error that says
// where, and nothing of the scene is loaded with an error.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "server/eulumdat.h"
#include "server/ies.h"
#include "server/pbrt/place.h"
#include "tests/server/pbrt_fixture.h"
#include "tests/server/photometric_texts.h"

namespace lucerna {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using testing::Ies;
using testing::planes;
using testing::SceneFiles;
using ::testing::StartsWith;

/// Some bytes changed, inserted, removed or repeated.
std::string mutated(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  static const char* kWords[] = {"-1", "1e308",          "999999999", "nan",
                                 "\r", "TILT=INCLUDE\n", "0 ",        "-"};
  for (std::size_t edits = 1 + below(3); edits > 0; --edits) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.insert(at, kWords[below(std::size(kWords))]);
        break;
      case 2:
        text.erase(at, 1 + below(10));
        break;
      default:
        text.insert(at, text.substr(below(text.size()), below(20)));
    }
    if (text.empty()) text.push_back(' ');
  }
  return text;
}

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
      // Each says where and what is allowed, if not that there should be more.
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
  for (int i = 0; i < 5000; ++i) check(mutated(whole, random));
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

/// A small picture of a format, of some colours.
std::string picture(const std::string& name, OIIO::TypeDesc type) {
  const SceneFiles files;
  const std::string path = (files.path() / name).string();
  const OIIO::ImageSpec spec(4, 4, 3, type);
  std::vector<float> values;
  for (int i = 0; i < 48; ++i) values.push_back(0.02F * static_cast<float>(i % 29));
  if (name.ends_with(".pfm"))  // which OpenImageIO reads, but does not write
    return "PF\n4 4\n-1.0\n" + std::string(reinterpret_cast<const char*>(values.data()), 48 * 4);
  const auto file = OIIO::ImageOutput::create(path);
  if (!file || !file->open(path, spec) ||
      !file->write_image(OIIO::TypeDesc::FLOAT, values.data()) || !file->close())
    throw std::runtime_error(file ? file->geterror() : OIIO::geterror());
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Loads a scene of one light with `name` many times, broken in some other way each.
void check_scenes(const std::string& name, const std::string& whole, const std::string& source) {
  const SceneFiles files;
  files.write("scene.pbrt", "WorldBegin\n" + source);
  files.write(name, whole);
  ASSERT_TRUE(files.load("scene.pbrt").ok()) << files.load("scene.pbrt").status();
  std::mt19937 random(2019);
  int errors = 0;
  for (int i = 0; i < 300; ++i) {
    const std::string broken =
        i % 3 == 0 ? whole.substr(0, random() % whole.size()) : mutated(whole, random);
    files.write(name, broken);
    const auto scene = files.load("scene.pbrt");
    if (scene.ok()) {
      const auto& params = std::get<GoniometricLightParams>(scene->lights.at(0).params);
      const auto light = *GoniometricLight<float>::create(params);
      const Power power = light.power({});
      ASSERT_TRUE(is_finite(power.lumens) && power.lumens.g >= 0) << name;
      for (const Remark& remark : scene->remarks)
        ASSERT_TRUE(pbrt::is_printable(remark.what) && pbrt::is_printable(remark.instead));
      continue;
    }
    ++errors;
    const std::string message = testing::message(scene.status());
    ASSERT_THAT(message, StartsWith("scene.pbrt:2:"));
    ASSERT_THAT(message, HasSubstr(name));
    ASSERT_TRUE(pbrt::is_printable(message)) << message;
  }
  EXPECT_GT(errors, 30) << name;
}

TEST(PhotometricMutations, ScenesOfBrokenPhotometricFilesNameThemOrLoad) {
  const std::string source = "LightSource \"goniometric\" \"string filename\" ";
  check_scenes("lamp.ies", Ies().text(), source + "\"lamp.ies\"");
  check_scenes("lamp.ldt", planes(3, {"1", "2", "3", "4", "5"}).text(), source + "\"lamp.ldt\"");
}

TEST(PhotometricMutations, ScenesOfBrokenPicturesNameThemOrLoad) {
  using OIIO::TypeDesc;
  for (const auto& [name, type] : {std::pair<std::string, TypeDesc>{"lamp.pfm", TypeDesc::FLOAT},
                                   {"lamp.exr", TypeDesc::HALF},
                                   {"lamp.png", TypeDesc::UINT16},
                                   {"lamp.hdr", TypeDesc::FLOAT},
                                   {"lamp.tif", TypeDesc::UINT8},
                                   {"lamp.jpg", TypeDesc::UINT8}})
    check_scenes(name, picture(name, type),
                 "LightSource \"goniometric\" \"string mapping\" \"latlong\" \"string filename\" "
                 "\"" +
                     name + "\"");
}

}  // namespace
}  // namespace lucerna
