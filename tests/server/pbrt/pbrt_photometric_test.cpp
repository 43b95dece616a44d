// LightSource "goniometric" with photometric files, and without any file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pbrt_fixture.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;

/// 100 cd over the lower half: 200 pi lm.
constexpr char kIes[] =
    "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n";

absl::StatusOr<SceneDescription> load_luminaire(const std::string& text,
                                                const std::string& ies = kIes,
                                                const std::string& name = "lamp.ies") {
  const SceneFiles files;
  files.write(name, ies);
  files.write("scene.pbrt", "WorldBegin " + text);
  return files.load("scene.pbrt");
}

GoniometricLightParams luminaire(const std::string& text) {
  const auto scene = load_luminaire(text);
  if (!scene.ok() || scene->lights.size() != 1) {
    ADD_FAILURE() << text << ": " << scene.status();
    return {};
  }
  EXPECT_EQ(remarks_of(*scene), "");
  return std::get<GoniometricLightParams>(scene->lights[0].params);
}

TEST(PbrtPhotometric, ALuminaireShinesAlongZ) {
  const auto p = luminaire("LightSource \"goniometric\" \"string filename\" \"lamp.ies\"");
  EXPECT_EQ(p.file, "lamp.ies");
  EXPECT_EQ(p.format, "IES LM-63-2002, type C");
  const auto l = *GoniometricLight::create(p);
  EXPECT_EQ(l.intensity({0, 0, 1}), Rgb(100));
  EXPECT_EQ(l.intensity({0, 0, -1}), Rgb());
  EXPECT_NEAR(luminance(l.power({}).lumens), 200 * kPi, 1e-9);
}

// Type B shines along +z with its pole along y.  A headlamp of type A shines along +x, and up is
// -z.
TEST(PbrtPhotometric, TypesAAndBHaveTheirPoles) {
  const auto light = [](const std::string& type, const std::string& candela) {
    const auto scene =
        load_luminaire("LightSource \"goniometric\" \"string filename\" \"lamp.ies\"",
                       "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 3 " + type +
                           " 2 0 0 0\n1 1 50\n-90 0 90\n-90 0 90\n" + candela);
    EXPECT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(remarks_of(*scene), "");
    return *GoniometricLight::create(std::get<GoniometricLightParams>(scene->lights.at(0).params));
  };
  // All V at H = -90, 0, 90.
  const auto b = light("2", "3 3 3\n1 9 5\n7 7 7\n");
  EXPECT_NEAR(b.intensity({0, 0, 1}).g, 9, 1e-6);
  EXPECT_NEAR(b.intensity({1, 0, 1e-9}).g, 5, 1e-6);
  EXPECT_NEAR(b.intensity({-1, 0, 1e-9}).g, 1, 1e-6);
  EXPECT_NEAR(b.intensity({0, 1, 1e-9}).g, 7, 1e-6);
  EXPECT_NEAR(b.intensity({0, -1, 1e-9}).g, 3, 1e-6);
  const auto a = light("3", "1 3 5\n1 9 5\n1 7 5\n");
  EXPECT_NEAR(a.intensity({1, 0, 0}).g, 9, 1e-6);
  EXPECT_NEAR(a.intensity({1e-9, 0, -1}).g, 5, 1e-6);
  EXPECT_NEAR(a.intensity({1e-9, 0, 1}).g, 1, 1e-6);
  EXPECT_NEAR(a.intensity({1e-9, 1, 0}).g, 7, 1e-6);
  EXPECT_NEAR(a.intensity({1e-9, -1, 0}).g, 3, 1e-6);
}

TEST(PbrtPhotometric, APointHasARemarkAboutItsOpeningAndAPanelHasNone) {
  const std::string ies =
      "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0.5 0.25 0\n1 1 10\n0 90\n0\n100 100\n";
  const std::string lamp = "LightSource \"goniometric\" \"string filename\" \"lamp.ies\" ";
  // Equal remarks of several lights are one, with the number of places.
  auto scene = load_luminaire(lamp + lamp, ies);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(remarks_of(*scene),
            "1:38 lamp.ies:3: a luminous opening of 0.5 x 0.25 m -> a point; right from about 5 "
            "times that size on\n");
  EXPECT_EQ(scene->remarks.at(0).count, 2U);
  scene = load_luminaire(
      "AreaLightSource \"diffuse\" \"string profile\" \"lamp.ies\" Shape \"disk\"", ies);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(remarks_of(*scene), "");
}

TEST(PbrtPhotometric, ScaleMultipliesTheCandelaAndPowerSetsTheTotal) {
  const std::string source = "LightSource \"goniometric\" \"string filename\" \"lamp.ies\" ";
  EXPECT_EQ(luminaire(source + "\"float scale\" 3").intensity, Rgb(3));
  EXPECT_EQ(luminaire(source + "\"rgb I\" [1 2 3]").intensity, Rgb(1, 2, 3));
  const auto l = *GoniometricLight::create(luminaire(source + "\"float power\" 5000"));
  EXPECT_NEAR(luminance(l.power({}).lumens), 5000, 1e-8);
  const auto black = load_luminaire(source + "\"float power\" 5000",
                                    "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n0 0\n");
  EXPECT_THAT(message(black.status()), HasSubstr("a light that illuminates nothing"));
}

TEST(PbrtPhotometric, TransformsMoveRotateMirrorAndStretch) {
  const std::string source = "LightSource \"goniometric\" \"string filename\" \"lamp.ies\"";
  const auto p = luminaire("Translate 1 2 3 Rotate 180 1 0 0 Scale 2 2 2 " + source);
  EXPECT_EQ(p.position_m, Vec3(1, 2, 3));
  const auto l = *GoniometricLight::create(p);
  EXPECT_EQ(l.intensity({0, 0, -1}), Rgb(100));
  EXPECT_EQ(l.intensity({0, 0, 1}), Rgb());
  luminaire("Scale 1 1 -1 " + source);
  const auto stretched = *GoniometricLight::create(luminaire("Scale 1 1 2 " + source));
  const auto plain = *GoniometricLight::create(luminaire(source));
  for (const double x : {0.0, 0.25, 0.5, 1.0})
    EXPECT_NEAR(stretched.intensity(normalized(Vec3{x, 0, 2})).g,
                plain.intensity(normalized(Vec3{x, 0, 1})).g, 1e-9);
}

TEST(PbrtPhotometric, WithoutAFileItIsAPointLight) {
  const auto p = luminaire("LightSource \"goniometric\" \"rgb I\" [1 1 1] \"float power\" 150");
  EXPECT_EQ(p.web, nullptr);
  EXPECT_NEAR(p.intensity.g, 150 / (4 * kPi), 1e-12);
}

TEST(PbrtPhotometric, ErrorsAndNotesNameBothFiles) {
  const std::string source = "LightSource \"goniometric\" \"string filename\" \"lamp.ies\"";
  EXPECT_EQ(message(load_luminaire(source, "TILT=NONE\n1 -1 1 2 1 4").status()),
            "scene.pbrt:1:38: \"string filename\": lamp.ies:2: photometric type = 4, allowed: 1 "
            "(type C), 2 (type B), 3 (type A)");
  const auto tilted = testing::value_of(
      load_luminaire(source, "TILT=x.tlt\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n"));
  EXPECT_EQ(remarks_of(tilted),
            "1:38 lamp.ies:1: tilt factors in \"x.tlt\" are not read -> the factor 1, for a "
            "luminaire without tilt\n");
  EXPECT_THAT(message(load_luminaire("LightSource \"goniometric\" \"string filename\" \"LAMP.LDT\"",
                                     "x\n", "LAMP.LDT")
                          .status()),
              HasSubstr("LAMP.LDT:1: the file ends before the symmetry Isym"));
}

}  // namespace
}  // namespace lucerna
