// Broken pictures on surfaces: each is read, or is grey with a remark that names it, or beyond a
// limit.
#include <gmock/gmock.h>

#include <random>

#include "server/scene/scene.h"
#include "tests/mutated.h"
#include "tests/server/formats/picture_texts.h"

namespace lucerna::testing {
namespace {

constexpr const char* kWords[] = {"\x89PNG",          "IHDR", "IDAT", "-1", "1e308", "nan",
                                  "\xff\xff\xff\xff", "\n"};

constexpr char kScene[] = R"(WorldBegin
Texture "c" "spectrum" "imagemap" "string filename" "PICTURE" "string wrap" "WRAP"
Texture "a" "float" "imagemap" "string filename" "PICTURE" "string wrap" "WRAP" "float uscale" 3 "bool invert" true
Material "diffuse" "texture reflectance" "c" "texture displacement" "a"
Shape "sphere" "texture alpha" "a"
)";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at; (at = text.find(what)) != std::string::npos;)
    text.replace(at, what.size(), by);
  return text;
}

/// Whether the picture is read.  The textures of the scene are finite everywhere.
bool loads(const SceneFiles& files, const std::string& picture) {
  auto description = files.load("scene.pbrt");
  if (!description.ok()) {
    EXPECT_THAT(message(description.status()), ::testing::HasSubstr(picture));
    EXPECT_THAT(message(description.status()), ::testing::HasSubstr("scene.pbrt:2"));
    return false;
  }
  const std::string remarks = remarks_of(*description);
  const bool is_read = remarks.find("-> grey 0.5") == std::string::npos;
  EXPECT_TRUE(is_read || remarks.find("\"string filename\": " + picture) != std::string::npos)
      << remarks;
  const auto scene = Scene::build(*std::move(description));
  EXPECT_TRUE(scene.ok()) << scene.status();
  const Textures& textures = (*scene)->textures();
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(textures.size()); ++t)
    for (const double u : {-1e300, -0.3, 0.0, 0.5, 1.0, 7.25, 1e300})
      for (const double v : {-1e300, 0.0, 0.75, 1.0, 1e300}) {
        const TexturePoint p{.uv = {u, v}, .position = {u, v, 0.5}, .normal = {0, 0, 1}};
        EXPECT_TRUE(is_finite(textures(ColourValue{{}, t}, p))) << u << ", " << v;
      }
  return is_read;
}

TEST(TextureMutations, BrokenPicturesAreReadOrNamed) {
  std::vector<float> floats;
  std::vector<unsigned char> bytes;
  for (int i = 0; i < 6 * 4 * 3; ++i) {
    floats.push_back(0.1F * static_cast<float>(i % 10));
    bytes.push_back(static_cast<unsigned char>(7 * i));
  }
  const std::pair<std::string, std::string> kPictures[] = {
      {"picture.pfm", pfm(6, 4, floats)},
      {"picture.png", written("a.png", OIIO::ImageSpec(6, 4, 3, OIIO::TypeDesc::UINT8), bytes)},
      {"picture.exr", written("a.exr", OIIO::ImageSpec(6, 4, 3, OIIO::TypeDesc::HALF), floats)}};
  std::mt19937 random(17);
  for (const auto& [name, whole] : kPictures) {
    const SceneFiles files;
    int good = 0, bad = 0;
    for (int i = 0; i < 150; ++i) {
      const char* const wraps[] = {"repeat", "black", "clamp", "octahedralsphere"};
      files.write("scene.pbrt", replaced(replaced(kScene, "PICTURE", name), "WRAP", wraps[i % 4]));
      files.write(name, i == 0       ? whole
                        : i % 5 == 1 ? whole.substr(0, random() % whole.size())
                                     : mutated(whole, random, kWords));
      const bool is_good = loads(files, name);
      good += is_good, bad += !is_good;
      if (i == 0) {
        EXPECT_TRUE(is_good) << name;
      }
    }
    EXPECT_GT(good, 0) << name;
    EXPECT_GT(bad, 20) << name;
  }
}

}  // namespace
}  // namespace lucerna::testing
