// Errors about files of pbrt-v2 and pbrt-v3.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using testing::error_of;
using ::testing::HasSubstr;
using testing::load_text;
using ::testing::Not;
using testing::remarks_of;
using testing::world_error_of;
using testing::world_remarks_of;

constexpr const char* kVersion3 = "; this is a pbrt-v3 file; pbrt-v4's --upgrade converts it";

TEST(OlderPbrt, WordsOfVersion3AreNamed) {
  for (const char* material : {"matte", "plastic", "mirror", "glass", "metal", "substrate", "uber",
                               "translucent", "disney", "fourier", "kdsubsurface"}) {
    EXPECT_THAT(world_error_of("Material \"" + std::string(material) + "\" \"rgb Kd\" [1 1 1]"),
                EndsWith(kVersion3));
    EXPECT_THAT(
        world_error_of("MakeNamedMaterial \"a\" \"string type\" \"" + std::string(material) + "\""),
        EndsWith(kVersion3));
  }
  for (const char* text :
       {"Film \"image\" \"integer xresolution\" 10\nWorldBegin",
        "Sampler \"02sequence\"\nWorldBegin", "Integrator \"directlighting\"\nWorldBegin",
        "Camera \"environment\"\nWorldBegin", "WorldBegin Shape \"paraboloid\"",
        "WorldBegin Texture \"t\" \"color\" \"constant\"",
        "WorldBegin LightSource \"point\" \"color I\" [1 1 1]",
        "WorldBegin LightSource \"point\" \"rgb scale\" [1 1 1]",
        "WorldBegin LightSource \"point\" \"spectrum scale\" [400 1 700 1]",
        "WorldBegin LightSource \"point\" \"blackbody I\" [5000 10]",
        "WorldBegin Material \"mix\" \"string namedmaterial1\" \"a\" Shape \"sphere\"",
        "WorldBegin LightSource \"point\" WorldEnd"})
    EXPECT_THAT(error_of(text), EndsWith(kVersion3)) << text;
}

TEST(OlderPbrt, DirectivesOfVersion2AreNamed) {
  EXPECT_EQ(error_of("SurfaceIntegrator \"path\" WorldBegin"),
            "scene.pbrt:1:1: expected a directive, found \"SurfaceIntegrator\"; this is a pbrt-v2 "
            "file, allowed: files of pbrt-v4");
}

TEST(OlderPbrt, OtherWordsAreNot) {
  for (const char* text : {"Material \"gold\"", "Shape \"cube\"", "Sphere", "LightSource \"lamp\"",
                           "Shape \"sphere\" \"double radius\" 1", "Material \"image\""})
    EXPECT_THAT(world_error_of(text), Not(HasSubstr("pbrt-v3"))) << text;
}

TEST(OlderPbrt, RenamedParametersHaveTheirNewName) {
  EXPECT_EQ(
      world_error_of("\nLightSource \"infinite\" \"string mapname\" \"sky.exr\""),
      "scene.pbrt:2:24: parameter \"mapname\" of LightSource \"infinite\" is not known; it is "
      "of pbrt-v2 and pbrt-v3, use \"filename\"");
  EXPECT_EQ(
      world_remarks_of("\nLightSource \"infinite\" \"integer nsamples\" 4"),
      "2:24 parameter \"nsamples\" of LightSource \"infinite\" is not known; it is of pbrt-v2 "
      "and pbrt-v3, use \"samples\" -> it changes nothing\n");
  EXPECT_THAT(
      world_remarks_of("Texture \"t\" \"float\" \"scale\" \"float tex1\" 1 \"float tex2\" 1"),
      AllOf(HasSubstr("use \"tex\""), HasSubstr("use \"scale\"")));
  EXPECT_THAT(
      world_remarks_of("Shape \"loopsubdiv\" \"integer nlevels\" 1 \"integer indices\" [0 1 2] "
                       "\"point3 P\" [0 0 0 1 0 0 0 1 0]"),
      HasSubstr("use \"levels\""));
  EXPECT_THAT(remarks_of(*load_text(
                  "PixelFilter \"box\" \"float xwidth\" 2 \"float ywidth\" 2\nWorldBegin")),
              AllOf(HasSubstr("use \"xradius\""), HasSubstr("use \"yradius\"")));
}

}  // namespace
}  // namespace lucerna
