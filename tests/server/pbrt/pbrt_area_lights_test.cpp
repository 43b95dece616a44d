// AreaLightSource "diffuse" with an emission image or a profile: position on each shape, levels,
// and memory of the scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/scene/scene.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::kPatch;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;

/// Two by two texels: 1 2 above, 3 4 below.
std::string four_texels() { return testing::pfm(2, 2, {1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}); }

/// A downlight that is brighter in plane C0 than in C90 and emits a little upwards.
const std::string kPanelIes =
    "IESNA:LM-63-2002\n[TEST] none\n[TESTLAB] none\n[ISSUEDATE] 2024\n[MANUFAC] none\nTILT=NONE\n"
    "1 1000 1 5 3 1 2 0.6 0.6 0\n1 1 10\n0 45 90 135 180\n0 90 180\n"
    "100 90 0 0 10\n100 50 0 0 10\n100 30 0 0 10\n";

absl::StatusOr<SceneDescription> load_lights(const std::string& world) {
  const SceneFiles files;
  files.write("four.pfm", four_texels());
  files.write("lamp.ies", kPanelIes);
  // A quad in the form of three programs, with its picture rotated by 180 degrees.
  files.write("quad.ply",
              "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
              "property float z\nproperty float s\nproperty float t\nelement face 1\n"
              "property list uchar int vertex_indices\nend_header\n"
              "0 0 0 1 1\n1 0 0 0 1\n1 1 0 0 0\n0 1 0 1 0\n4 0 1 2 3\n");
  files.write("scene.pbrt", "WorldBegin\n" + world);
  return files.load("scene.pbrt");
}

const std::string kImage =
    "AreaLightSource \"diffuse\" \"string filename\" \"four.pfm\" \"string filter\" \"nearest\" ";

/// Radiance of the first light at a point, towards its front.
float shown(const Scene& scene, const Vec3& world) {
  const auto& light = dynamic_cast<const AreaLight&>(*scene.lights()[0].light);
  const Vec3 p = world - scene.origin();
  const auto point = light.shape().locate(p, 0);
  if (!point) throw std::runtime_error("not on the light");
  return static_cast<float>(light.le(*point, point->normal).r);
}

std::shared_ptr<const Scene> scene_of(const std::string& world) {
  auto description = testing::value_of(load_lights(world));
  return testing::value_of(Scene::build(std::move(description)));
}

TEST(PbrtAreaImages, LieOnPatchesByTheirCorners) {
  const auto scene = scene_of(kImage + "\"float scale\" 10 " + kPatch);
  EXPECT_EQ(shown(*scene, {0.25, 0.75, 0}), 10);
  EXPECT_EQ(shown(*scene, {0.75, 0.75, 0}), 20);
  EXPECT_EQ(shown(*scene, {0.25, 0.25, 0}), 30);
  EXPECT_EQ(shown(*scene, {0.75, 0.25, 0}), 40);
}

TEST(PbrtAreaImages, KeepTheirPlaceWhenTheOutsideTurns) {
  // After a mirror and a reversal the winding changes, but corners keep their (u, v).
  for (const std::string turn : {"ReverseOrientation ", "Scale 1 1 -1 "}) {
    const auto scene = scene_of(kImage + turn + kPatch);
    EXPECT_EQ(shown(*scene, {0.25, 0.75, 0}), 1) << turn;
    EXPECT_EQ(shown(*scene, {0.75, 0.75, 0}), 2) << turn;
    EXPECT_EQ(shown(*scene, {0.25, 0.25, 0}), 3) << turn;
  }
  // pbrt-v4 gives a triangle without (u, v) the corners (0, 0), (1, 0), (1, 1).
  const std::string triangle = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0] ";
  for (const std::string turn : {"", "ReverseOrientation "}) {
    const auto scene = scene_of(kImage + turn + triangle);
    EXPECT_EQ(shown(*scene, {0.25, 0.125, 0}), 3) << turn;
    EXPECT_EQ(shown(*scene, {0.75, 0.25, 0}), 4) << turn;
    EXPECT_EQ(shown(*scene, {0.875, 0.75, 0}), 2) << turn;
  }
}

TEST(PbrtAreaImages, LieByTheUvOfVertices) {
  const std::string uv = "\"point2 uv\" [0.5 0 1 0 0.5 1 1 1] ";  // the right half
  const auto patch = scene_of(kImage + kPatch + uv);
  EXPECT_EQ(shown(*patch, {0.25, 0.75, 0}), 2);
  EXPECT_EQ(shown(*patch, {0.75, 0.25, 0}), 4);
  const auto mesh = scene_of(kImage +
                             "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] "
                             "\"integer indices\" [0 1 2 1 3 2] " +
                             uv);
  EXPECT_EQ(shown(*mesh, {0.25, 0.625, 0}), 2);
  EXPECT_EQ(shown(*mesh, {0.75, 0.625, 0}), 2);
  EXPECT_EQ(shown(*mesh, {0.25, 0.25, 0}), 4);
  const auto ply = scene_of(kImage + "Shape \"plymesh\" \"string filename\" \"quad.ply\"");
  EXPECT_EQ(shown(*ply, {0.25, 0.75, 0}), 4);
  EXPECT_EQ(shown(*ply, {0.75, 0.125, 0}), 1);
}

TEST(PbrtAreaImages, LieOnSpheresDisksAndCylindersLikeInPbrt4) {
  const auto sphere = scene_of(kImage + "Shape \"sphere\"");
  EXPECT_EQ(shown(*sphere, Vec3{0, 0.6, 0.8}), 1);
  EXPECT_EQ(shown(*sphere, Vec3{0, -0.6, -0.8}), 4);
  const auto disk = scene_of(kImage + "Shape \"disk\"");
  EXPECT_EQ(shown(*disk, {0, 0.25, 0}), 1);
  EXPECT_EQ(shown(*disk, {0, -0.75, 0}), 4);
  const auto tube = scene_of(kImage + "Shape \"cylinder\"");
  EXPECT_EQ(shown(*tube, {0, -1, 0.5}), 2);
  EXPECT_EQ(shown(*tube, {0, 1, -0.5}), 3);
}

TEST(PbrtAreaImages, TheDefaultFilterIsPbrt4s) {
  const auto scene =
      scene_of("AreaLightSource \"diffuse\" \"string filename\" \"four.pfm\" " + kPatch);
  EXPECT_EQ(shown(*scene, {0.5, 0.5, 0}), 2.5F);
}

TEST(PbrtAreaImages, PowerIsThatOfTheWholeLikeInPbrt4) {
  const auto lumens = [](const Scene& scene) {
    return luminance(scene.lights()[0].light->power(scene.sphere()).lumens);
  };
  // At level 1: pi A times the mean of 2.5.
  EXPECT_NEAR(lumens(*scene_of(kImage + kPatch)), 2.5 * kPi, 1e-6);
  const auto patch = load_lights(kImage + "\"float power\" 50 \"bool twosided\" true " + kPatch);
  EXPECT_EQ(remarks_of(*patch), "");
  EXPECT_NEAR(lumens(*scene_of(kImage + "\"float power\" 50 \"bool twosided\" true " + kPatch)), 50,
              1e-4);
  // On a disk v < 1/2 (texels 3 and 4) has three quarters of the area.
  const std::string disk = kImage + "\"float power\" 50 Shape \"disk\"";
  EXPECT_NEAR(lumens(*scene_of(disk)), 50 * (3.5 * 0.75 + 1.5 * 0.25) / 2.5, 1e-4);
  EXPECT_THAT(remarks_of(*load_lights(disk)),
              HasSubstr("\"power\" of a picture on a shape that shows its texels on unequal areas "
                        "-> that of the picture's mean, the same as in pbrt-v4"));
}

TEST(PbrtAreaImages, ErrorsHaveTheirPlace) {
  const std::pair<std::string, const char*> kCases[] = {
      {kImage + "\"rgb L\" [1 1 1] " + kPatch,
       "scene.pbrt:2:82: \"L\" and \"filename\" are both given, allowed: one of them, and "
       "\"scale\""},
      {"AreaLightSource \"diffuse\" \"string filename\" \"four.pfm\" \"string filter\" \"cubic\" " +
           kPatch,
       "scene.pbrt:2:56: \"string filter\" = \"cubic\", allowed: nearest, bilinear"},
      {"AreaLightSource \"diffuse\" \"string filename\" \"none.pfm\" " + kPatch,
       "scene.pbrt:2:27: \"string filename\" = \"none.pfm\": file \"none.pfm\" does not exist, "
       "allowed: a file inside the scene root"},
      {kImage + "\"float scale\" -1 " + kPatch, "\"float scale\" = -1, allowed: not negative"},
      {kImage + kPatch + "\"point2 uv\" [0 0 1 1]",
       "Shape \"bilinearmesh\" has 2 \"uv\" for 4 vertices"},
      {kImage + "\"float scale\" 1e38 " + kPatch,
       "the brightest texel of four.pfm times the light's level = (4e+38"},
  };
  for (const auto& [world, expected] : kCases) {
    auto scene = load_lights(world);
    absl::Status status = scene.status();
    if (scene.ok()) status = Scene::build(*std::move(scene)).status();
    EXPECT_THAT(message(status), HasSubstr(expected)) << world;
    EXPECT_THAT(message(status), HasSubstr("scene.pbrt:2:")) << world;
  }
}

// ---- Profiles: the photometry of luminaires on flat shapes. ----

const std::string kProfile = "AreaLightSource \"diffuse\" \"string profile\" \"lamp.ies\" ";

/// Luminous intensity of the whole panel towards the unit vector `w` [cd].
double intensity(const Scene& scene, const Vec3& w) {
  const auto& light = dynamic_cast<const AreaLight&>(*scene.lights()[0].light);
  if (light.profile() == nullptr) throw std::runtime_error("no panel");
  const LightSample s = light.sample_li(Vec3{0.1, 0.2, 50}, {0.5, 0.5});
  const double cosine = std::fabs(dot(s.normal, w));
  return light.le({s.point, s.normal, s.primitive}, w).r * cosine * light.shape().area();
}

const double kSlant = std::sqrt(0.5);

TEST(PbrtPanels, TakeTheirAxesFromTheShape) {
  // Normal +z, dp/du +x: C0 (90 cd at 45 degrees) towards +x, C180 (30 cd) towards -x, C90 and
  // C270 (50 cd) to the sides.
  for (const std::string& shape :
       {std::string("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]"),
        std::string("Shape \"trianglemesh\" \"point3 P\" [0 0 0 2 0 0 2 1 0 0 1 0] "
                    "\"integer indices\" [0 1 2 0 2 3]"),
        std::string("Shape \"disk\" \"float radius\" 2")}) {
    const auto scene = scene_of(kProfile + shape);
    EXPECT_NEAR(intensity(*scene, {0, 0, 1}), 100, 1e-3) << shape;
    EXPECT_NEAR(intensity(*scene, {kSlant, 0, kSlant}), 90, 1e-3) << shape;
    EXPECT_NEAR(intensity(*scene, {-kSlant, 0, kSlant}), 30, 1e-3) << shape;
    EXPECT_NEAR(intensity(*scene, {0, kSlant, kSlant}), 50, 1e-3) << shape;
    EXPECT_NEAR(intensity(*scene, {0, -kSlant, kSlant}), 50, 1e-3) << shape;
    EXPECT_EQ(intensity(*scene, {0, 0, -1}), 0) << shape;
  }
  // Flipped about dp/du.
  const auto over = scene_of(kProfile + "ReverseOrientation " +
                             "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]");
  EXPECT_NEAR(intensity(*over, {kSlant, 0, -kSlant}), 90, 1e-3);
  EXPECT_NEAR(intensity(*over, {-kSlant, 0, -kSlant}), 30, 1e-3);
  // The (u, v) of the vertices let u run along -y.
  const auto by_uv = scene_of(kProfile +
                              "Shape \"bilinearmesh\" "
                              "\"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0] "
                              "\"point2 uv\" [1 0 1 1 0 0 0 1]");
  EXPECT_NEAR(intensity(*by_uv, {0, -kSlant, kSlant}), 90, 1e-3);
}

TEST(PbrtPanels, ChartsOfAnySizeTurnTheFile) {
  // u runs along -y again, over a millionth of the picture.  A degenerate chart uses the first
  // edge, +x.
  const std::string square = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0] ";
  const auto tiny = scene_of(kProfile + square + "\"point2 uv\" [1e-6 0 1e-6 1e-6 0 0 0 1e-6]");
  EXPECT_NEAR(intensity(*tiny, {0, -kSlant, kSlant}), 90, 1e-3);
  EXPECT_NEAR(intensity(*tiny, {kSlant, 0, kSlant}), 50, 1e-3);
  const auto line = scene_of(kProfile + square + "\"point2 uv\" [0 0 1 1 2 2 3 3]");
  EXPECT_NEAR(intensity(*line, {kSlant, 0, kSlant}), 90, 1e-3);
}

TEST(PbrtPanels, LevelsMultiplyTheFilesCandela) {
  const std::string disk = "Shape \"disk\"";
  const auto lumens = [](const Scene& scene) {
    return luminance(scene.lights()[0].light->power(scene.sphere()).lumens);
  };
  const double front = lumens(*scene_of(kProfile + disk));
  const double both = lumens(*scene_of(kProfile + "\"bool twosided\" true " + disk));
  EXPECT_GT(front, 100);
  EXPECT_GT(both, front);
  EXPECT_NEAR(lumens(*scene_of(kProfile + "\"float scale\" 3 " + disk)), 3 * front, 1e-9);
  EXPECT_NEAR(lumens(*scene_of(kProfile + "\"float power\" 800 " + disk)), 800, 1e-9);
  const auto remarks = remarks_of(*load_lights(kProfile + disk));
  EXPECT_THAT(remarks, HasSubstr("lm go to the back of a panel that emits from its front only -> "
                                 "left out; \"bool twosided\" true includes them"));
  EXPECT_EQ(remarks_of(*load_lights(kProfile + "\"bool twosided\" true " + disk)), "");
}

TEST(PbrtPanels, APictureMultipliesTheProfile) {
  const std::string square = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]";
  const std::string filename = "\"string filename\" \"four.pfm\" \"string filter\" \"nearest\" ";
  const auto plain = scene_of(kProfile + square);
  const auto pictured = scene_of(kProfile + filename + square);
  const Light &a = *plain->lights()[0].light, &b = *pictured->lights()[0].light;
  // The texels are 1 2 above 3 4.
  EXPECT_NEAR(luminance(b.power({}).lumens), 2.5 * luminance(a.power({}).lumens), 1e-9);
  const Vec3 w{kSlant, 0, kSlant};
  const Vec3 first = Vec3{0.5, 0.25, 0} - plain->origin();
  EXPECT_NEAR(b.le({first, {0, 0, 1}}, w).g, 3 * a.le({first, {0, 0, 1}}, w).g, 1e-9);
  const auto with_power = scene_of(kProfile + filename + "\"float power\" 100 " + square);
  EXPECT_NEAR(luminance(with_power->lights()[0].light->power({}).lumens), 100, 1e-4);
}

TEST(PbrtPanels, ErrorsHaveTheirPlace) {
  const std::pair<std::string, const char*> kCases[] = {
      {kProfile + "\nShape \"sphere\"",
       "scene.pbrt:3:1: a light with \"profile\" on a sphere, allowed: flat shapes"},
      {kProfile + "\nShape \"cylinder\"",
       "scene.pbrt:3:1: a light with \"profile\" on a cylinder, allowed: flat shapes"},
      {kProfile + "\nShape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0.5]",
       "scene.pbrt:3:1: panel.surface has normals up to "},
      {"AreaLightSource \"diffuse\" \"string profile\" \"four.pfm\" Shape \"disk\"",
       "scene.pbrt:2:27: \"string profile\" = \"four.pfm\", allowed: the name of an .ies or .ldt "
       "file"},
      {"AreaLightSource \"diffuse\" \"string profile\" \"none.ldt\" Shape \"disk\"",
       "scene.pbrt:2:27: \"string profile\" = \"none.ldt\": file \"none.ldt\" does not exist, "
       "allowed: a file inside the scene root"},
      {kProfile + "\"float scale\" 1e30 Shape \"disk\" \"float radius\" 1e-9",
       "scene.pbrt:2:55: the radiance of a surface with the flux of lamp.ies times the light's "
       "level = ("},
  };
  for (const auto& [world, expected] : kCases)
    EXPECT_THAT(message(load_lights(world).status()), HasSubstr(expected)) << world;
}

}  // namespace
}  // namespace lucerna
