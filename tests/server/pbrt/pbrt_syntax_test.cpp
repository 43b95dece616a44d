// Valid syntax, and the errors of invalid files.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pbrt_fixture.h"
#include "tests/server/files/gzip.h"

namespace lucerna {
namespace {

using testing::error_of;
using testing::gzipped;
using ::testing::HasSubstr;
using testing::load_text;
using testing::load_world;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;
using ::testing::StartsWith;
using testing::world_error_of;

TEST(PbrtSyntax, EveryDirectiveIsRead) {
  const auto scene = testing::value_of(load_text(R"(
    Option "disablepixeljitter" true
    ColorSpace "srgb"
    TransformTimes 0 1
    Identity Translate 0 0 0 Scale 1 1 1 Rotate 0 0 0 1
    Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]
    ActiveTransform StartTime ActiveTransform EndTime ActiveTransform All
    CoordinateSystem "here" CoordSysTransform "here"
    LookAt 0 0 5 0 0 0 0 1 0
    Camera "perspective" "float fov" 40
    Film "rgb" "integer xresolution" [ 20 ] "integer yresolution" 10
    Sampler "halton" "integer pixelsamples" 4
    PixelFilter "box"
    Integrator "path" "integer maxdepth" 3
    Accelerator "bvh" "integer maxnodeprims" 4
    MakeNamedMedium "fog" "string type" "homogeneous"
    WorldBegin
    AttributeBegin
      Attribute "shape" "float radius" 2
      ReverseOrientation
      Texture "t" "spectrum" "constant" "rgb value" [.25 .25 .25]
      Material "diffuse" "texture reflectance" "t"
      MakeNamedMaterial "m" "string type" "diffuse"
      NamedMaterial "m"
      MediumInterface "" ""
      Shape "sphere"
    AttributeEnd
    TransformBegin CoordSysTransform "camera" TransformEnd
    LightSource "point"
    ObjectBegin "o" Shape "disk" ObjectEnd
    ObjectInstance "o"
    AreaLightSource "diffuse" "bool twosided" true "spectrum L" "stdillum-D65"
    Shape "sphere")"));
  EXPECT_EQ(remarks_of(scene),
            "2:5 Option \"disablepixeljitter\" is not modelled -> it changes nothing\n"
            "16:5 scattering within medium \"fog\" is not modelled -> absorption only\n");
  EXPECT_EQ(scene.shapes.size(), 2U);
  EXPECT_EQ(std::get<SphereParams>(scene.shapes[0].geometry).radius_m, 2);
  EXPECT_TRUE(std::get<SphereParams>(scene.shapes[0].geometry).reverse_orientation);
  EXPECT_FALSE(std::get<SphereParams>(scene.shapes[1].geometry).reverse_orientation);
  EXPECT_EQ(std::get<SphereParams>(scene.shapes[1].geometry).radius_m, 1);
  EXPECT_EQ(scene.hints.max_depth, 3);
  EXPECT_EQ(scene.hints.samples_per_pixel, 4);
  EXPECT_EQ(scene.instances.size(), 1U);
}

TEST(PbrtSyntax, BracketsAreOptionalAndBooleansMayBeQuoted) {
  for (const char* value : {"true", "[true]", "\"true\"", "[ \"true\" ]"}) {
    const auto scene = testing::value_of(load_world(
        std::string("AreaLightSource \"diffuse\" \"bool twosided\" ") + value + " Shape \"disk\""));
    EXPECT_TRUE(scene.shapes[0].emission->two_sided) << value;
  }
}

TEST(PbrtSyntax, ErrorsNamePlaceAndExpectedSyntax) {
  const std::pair<const char*, const char*> kCases[] = {
      {"Shape \"trianglemesh\" \"point3 P\" [0 0 0 @Shape",
       "expected a number or ']' for \"point3 P\", found \"Shape\""},
      {"Shape \"sphere\" \"float radius\"@",
       "expected a number or ']' for \"float radius\", found the end of the file"},
      {"Shape \"sphere\" @\"float radius\" []",
       "\"float radius\" has 0 values, expected at least 1"},
      {"Shape \"sphere\" @\"float radius\" [1 2]", "parameter \"radius\" has 2 values, expected 1"},
      {"Shape \"sphere\" \"float radius\" @\"1\"",
       "expected a number or ']' for \"float radius\", found \"1\""},
      {"Shape \"sphere\" \"float radius\" @1..2", "expected a number, found \"1..2\""},
      {"Shape \"sphere\" @\"integer radius\" 1",
       "parameter \"radius\" has type \"integer\", expected \"float\""},
      {"Shape \"sphere\" \"float radius\" 1 @\"float radius\" 2",
       "parameter \"radius\" is given twice"},
      {"Shape \"sphere\" @\"double radius\" 1",
       "unknown parameter type \"double\", expected one of float integer bool string point2 "
       "vector2 point3 vector3 normal rgb spectrum blackbody texture"},
      {"Shape \"sphere\" @\"radius\" 1", "expected a parameter \"TYPE NAME\", found \"radius\""},
      {"Shape \"trianglemesh\" @\"point3 P\" [0 0 0 1]",
       "\"point3 P\" has 4 values, expected a multiple of 3"},
      {"Shape \"trianglemesh\" \"integer indices\" [@0.5]",
       "expected an integer of 32 bits or ']' for \"integer indices\", found \"0.5\""},
      {"Shape \"trianglemesh\" \"integer indices\" [@4294967296]",
       "expected an integer of 32 bits or ']' for \"integer indices\", found \"4294967296\""},
      {"AreaLightSource \"diffuse\" \"bool twosided\" @yes",
       "expected true or false or ']' for \"bool twosided\", found \"yes\""},
      {"Shape @sphere", "expected a quoted string for Shape, found \"sphere\""},
      {"@Shape \"cube\"",
       "unknown shape \"cube\", expected one of sphere disk trianglemesh plymesh "
       "bilinearmesh cylinder curve loopsubdiv"},
      {"@\"Shape\"", "expected a directive, found \"Shape\""},
      {"@Sphere", "expected a directive, found \"Sphere\""},
      {"@]", "expected a directive, found ']'"},
      {"@WorldEnd",
       "expected a directive, found \"WorldEnd\"; this is a pbrt-v3 file; pbrt-v4's "
       "--upgrade converts it"},
      {"Translate 1 2@", "expected a number for Translate, found the end of the file"},
      {"@Scale 1 0 1",
       "Scale 1 0 1 has no inverse, allowed: factors other than 0 whose reciprocals a double "
       "holds"},
      {"@Rotate 5 0 0 0", "Rotate about the axis 0 0 0, which has no direction"},
      {"@LookAt 0 0 0 0 0 0 0 1 0",
       "LookAt: eye and target coincide, or up is parallel to their difference"},
      {"@Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]",
       "Transform is not affine: its fourth, eighth and twelfth number must be 0, its last must "
       "not"},
      {"@Transform [1 0 0 0 2 0 0 0 0 0 1 0 0 0 0 1]", "this Transform has no inverse"},
      {"ObjectBegin \"a\" Shape \"disk\" ObjectEnd Scale 1e200 1e200 1e200 Scale 1e200 1e200 1e200 "
       "@ObjectInstance \"a\"",
       "ObjectInstance: the product of the transforms exceeds the range of a double"},
      {"Scale 1e200 1e200 1e200 Scale 1e200 1e200 1e200 Scale 1e200 1e200 1e200 @LightSource "
       "\"infinite\"",
       "LightSource: the product of the transforms exceeds the range of a double"},
      {"Scale @1e400 1 1",
       "number 1e400 of Scale does not fit a double, allowed: [-1.79769e+308, 1.79769e+308]"},
      {"LightSource \"point\" \"float scale\" @1e400",
       "number 1e400 of \"float scale\" does not fit a double, allowed: [-1.79769e+308, "
       "1.79769e+308]"},
      {"Transform @1", "expected '[' after Transform, found \"1\""},
      {"ActiveTransform @Start", "expected All, StartTime or EndTime, found \"Start\""},
      {"@Camera \"perspective\"", "Camera is not allowed after WorldBegin"},
      {"@WorldBegin", "WorldBegin is not allowed after WorldBegin"},
      {"@NamedMaterial \"m\" Shape \"sphere\"", "material \"m\" is not defined in this scene"},
      {"@ObjectInstance \"o\"", "no object \"o\" is defined in this scene"},
      {"@Texture \"t\" \"rgb\" \"constant\"",
       "texture \"t\" has type \"rgb\", expected \"float\" or \"spectrum\""},
      {"@Attribute \"lamp\" \"float x\" 1",
       "unknown attribute target \"lamp\", expected one of shape light material medium texture"},
  };
  for (const auto& [marked, expected] : kCases) {
    std::string text = marked;
    const std::size_t at = text.find('@');  // where the error is
    text.erase(at, 1);
    const std::string place = "scene.pbrt:1:" + std::to_string(sizeof("WorldBegin ") + at) + ": ";
    EXPECT_EQ(world_error_of(text), place + expected) << text;
  }
}

TEST(PbrtSyntax, UnmatchedBlocksNameTheOpenDirective) {
  const std::pair<const char*, const char*> kCases[] = {
      {"AttributeBegin", "1:12: AttributeBegin is not closed"},
      {"AttributeEnd", "1:12: AttributeEnd has nothing to close"},
      {"ObjectBegin \"o\" AttributeEnd",
       "1:28: AttributeEnd does not match the ObjectBegin of scene.pbrt:1:12"},
      {"AttributeBegin ObjectEnd",
       "1:27: ObjectEnd does not match the AttributeBegin of scene.pbrt:1:12"},
      {"ObjectBegin \"o\" ObjectBegin \"p\"", "1:28: ObjectBegin within an object definition"},
      {"ObjectBegin \"o\" ObjectEnd ObjectBegin \"o\"", "1:38: object \"o\" was defined before"},
      {"ObjectBegin \"o\" ObjectInstance \"o\"",
       "1:28: ObjectInstance within an object definition"},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_EQ(world_error_of(text), std::string("scene.pbrt:") + expected) << text;
}

TEST(PbrtSyntax, WorldDirectivesNeedWorldBegin) {
  EXPECT_EQ(error_of("Shape \"sphere\""), "scene.pbrt:1:1: Shape is not allowed before WorldBegin");
  EXPECT_EQ(error_of("Import \"x\""), "scene.pbrt:1:1: Import is not allowed before WorldBegin");
  EXPECT_EQ(error_of("# nothing\n"),
            "scene.pbrt:2:1: expected WorldBegin, found the end of the file");
}

TEST(PbrtSyntax, UnknownParametersGetRemarks) {
  const auto scene =
      testing::value_of(load_world("Shape \"sphere\" \"float foo\" 1 \"float radius\" 2"));
  EXPECT_EQ(remarks_of(scene),
            "1:27 parameter \"foo\" of Shape \"sphere\" is not known -> it changes nothing\n");
}

TEST(PbrtSyntax, IncludedFilesContinueTheFileThatIncludesThem) {
  const SceneFiles files;
  files.write("sub/main.pbrt",
              "WorldBegin Include \"parts/a.pbrt\" 3 Shape \"sphere\"\nInclude \"nothing\"");
  files.write("sub/parts/a.pbrt", "Translate 1 2");
  const auto missing = files.load("sub/main.pbrt");
  EXPECT_TRUE(absl::IsNotFound(missing.status()));
  EXPECT_EQ(message(missing.status()), "sub/main.pbrt:2:9: file \"nothing\" does not exist");

  files.write("sub/main.pbrt", "WorldBegin Include \"parts/a.pbrt\" 3 Shape \"sphere\"");
  const auto scene = testing::value_of(files.load("sub/main.pbrt"));
  EXPECT_EQ(std::get<SphereParams>(scene.shapes[0].geometry).world_from_object.point({0, 0, 0}),
            Vec3(1, 2, 3));
  ASSERT_EQ(scene.assets.size(), 2U);
  EXPECT_EQ(scene.assets[1].name, "sub/parts/a.pbrt");
}

TEST(PbrtSyntax, CompressedFilesReadAsTheirContent) {
  const SceneFiles files;
  const std::string main =
      "WorldBegin Include \"parts/a.pbrt.gz\" Shape \"plymesh\" \"string filename\" \"m.ply.gz\"";
  files.write("main.pbrt.gz", gzipped(main));
  files.write("parts/a.pbrt.gz", gzipped("Translate 1 2 3"));
  files.write(
      "m.ply.gz",
      gzipped("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
              "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
              "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  const auto scene = testing::value_of(files.load("main.pbrt.gz"));
  EXPECT_EQ(std::get<TriangleMeshData>(scene.shapes[0].geometry).positions[1], Vec3(2, 2, 3));
  ASSERT_EQ(scene.assets.size(), 3U);
  EXPECT_EQ(scene.assets[0].bytes, gzipped(main).size());

  // Errors name the compressed file and count the lines of its content.
  files.write("parts/a.pbrt.gz", gzipped("Translate 1 2 3\nFoo"));
  EXPECT_THAT(message(files.load("main.pbrt.gz").status()), HasSubstr("parts/a.pbrt.gz:2:1: "));
  files.write("parts/a.pbrt.gz", gzipped("Translate 1 2 3").substr(0, 20));
  EXPECT_EQ(message(files.load("main.pbrt.gz").status()),
            "main.pbrt.gz:1:20: file \"parts/a.pbrt.gz\": its gzip data are broken or incomplete");
}

TEST(PbrtSyntax, ErrorsAfterAnIncludedFileEndedInMidDirectiveStillNameIt) {
  const SceneFiles files;
  files.write("main.pbrt", "WorldBegin Include \"a.pbrt\" 0 1 1");
  files.write("a.pbrt", "\nScale");
  EXPECT_THAT(message(files.load("main.pbrt").status()),
              HasSubstr("a.pbrt:2:1: Scale 0 1 1 has no inverse"));
}

TEST(PbrtSyntax, NamesInIncludedFilesAreFoundFromTheSceneOrFromTheFileItself) {
  const SceneFiles files;
  files.write("main.pbrt", "WorldBegin Include \"sub/a.pbrt\"");
  files.write("sub/a.pbrt", "Include \"b.pbrt\"");
  files.write("sub/b.pbrt", "Shape \"disk\"");
  EXPECT_EQ(files.load("main.pbrt")->shapes.size(), 1U);
  files.write("b.pbrt", "Shape \"disk\" Shape \"disk\"");
  EXPECT_EQ(files.load("main.pbrt")->shapes.size(), 2U);  // pbrt-v4's directory comes first
}

TEST(PbrtSyntax, FilesThatIncludeThemselvesAreRefused) {
  const SceneFiles files;
  files.write("main.pbrt", "WorldBegin\nInclude \"a.pbrt\"");
  files.write("a.pbrt", "Import \"./main.pbrt\"");
  EXPECT_EQ(message(files.load("main.pbrt").status()),
            "a.pbrt:1:8: file \"main.pbrt\" includes itself");
  for (int i = 0; i < 100; ++i)
    files.write(fmt::format("f{}", i), fmt::format("Include \"f{}\"", i + 1));
  EXPECT_THAT(message(files.load("f0").status()), HasSubstr("more than 64 deep"));
}

TEST(PbrtSyntax, ImportKeepsItsStateToItself) {
  const SceneFiles files;
  files.write("main.pbrt",
              "WorldBegin Import \"a.pbrt\" Shape \"sphere\" NamedMaterial \"m\" Shape \"disk\"");
  files.write(
      "a.pbrt",
      "Translate 1 0 0 MakeNamedMaterial \"m\" \"string type\" \"diffuse\" Shape \"sphere\"");
  const auto scene = testing::value_of(files.load("main.pbrt"));
  EXPECT_EQ(std::get<SphereParams>(scene.shapes[0].geometry).world_from_object.point({0, 0, 0}),
            Vec3(1, 0, 0));
  EXPECT_EQ(std::get<SphereParams>(scene.shapes[1].geometry).world_from_object.point({0, 0, 0}),
            Vec3(0, 0, 0));
  files.write("a.pbrt", "AttributeBegin");
  EXPECT_EQ(message(files.load("main.pbrt").status()),
            "a.pbrt:1:1: AttributeBegin is not closed in this imported file");
  files.write("main.pbrt", "WorldBegin AttributeBegin Import \"a.pbrt\"");
  files.write("a.pbrt", "AttributeEnd");
  EXPECT_EQ(message(files.load("main.pbrt").status()),
            "a.pbrt:1:1: AttributeEnd has nothing to close in this imported file");
  files.write("a.pbrt", "Translate 1");
  EXPECT_EQ(message(files.load("main.pbrt").status()),
            "a.pbrt:1:12: expected a number for Translate, found the end of the file");
}

TEST(PbrtSyntax, FileNamesThatLeaveTheRootAreRefusedAtTheirPlace) {
  const SceneFiles files;
  files.write("secret", "SECRET");
  files.write("root/scene.pbrt",
              "WorldBegin\n  Shape \"plymesh\" \"string filename\" \"../secret\"");
  AssetReader reader = *AssetReader::open((files.path() / "root").string());
  const auto scene = load_pbrt(reader, "scene.pbrt");
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(message(scene.status()),
            "scene.pbrt:2:19: \"string filename\" = \"../secret\": file name \"../secret\" leaves "
            "the scene root, allowed: paths inside it");
  files.write("root/scene.pbrt", "WorldBegin Include \"/etc/passwd\"");
  EXPECT_THAT(message(load_pbrt(reader, "scene.pbrt").status()),
              StartsWith("scene.pbrt:1:20: file name \"/etc/passwd\" leaves the scene root"));
}

TEST(PbrtSyntax, AByteOrderMarkIsSkipped) {
  const std::string mark = "\xef\xbb\xbf";
  const SceneFiles files;
  files.write("scene.pbrt", mark + "WorldBegin Include \"a.pbrt\" Import \"b.pbrt\"");
  files.write("a.pbrt", mark + "Shape \"sphere\"");
  files.write("b.pbrt", mark + "LightSource \"point\" \"spectrum I\" \"a.spd\"");
  files.write("a.spd", mark + "400 1 700 1");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  EXPECT_EQ(scene.shapes.size(), 1U);
  ASSERT_EQ(scene.lights.size(), 1U);
  EXPECT_NE(scene.lights[0].spectrum, nullptr);
  // Columns are counted like in editors.
  files.write("a.pbrt", mark + "  Shape \"sphere\" 1");
  EXPECT_THAT(message(files.load("scene.pbrt").status()), StartsWith("a.pbrt:1:18: "));
  // Only at the start, and only once.
  files.write("a.pbrt", " " + mark + "Shape \"sphere\"");
  EXPECT_THAT(message(files.load("scene.pbrt").status()),
              StartsWith("a.pbrt:1:2: expected a directive"));
  files.write("a.pbrt", mark + mark + "Shape \"sphere\"");
  EXPECT_THAT(message(files.load("scene.pbrt").status()),
              StartsWith("a.pbrt:1:1: expected a directive"));
  files.write("a.pbrt", mark);
  EXPECT_TRUE(files.load("scene.pbrt").ok());
}

TEST(PbrtSyntax, LoadingStopsOnRequest) {
  const SceneFiles files;
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 5000; ++i) text += "Identity\n";
  files.write("scene.pbrt", text);
  std::stop_source source;
  EXPECT_TRUE(files.load("scene.pbrt", source.get_token()).ok());
  source.request_stop();
  EXPECT_TRUE(absl::IsCancelled(files.load("scene.pbrt", source.get_token()).status()));
}

TEST(PbrtSyntax, RemarksAreCountedBeyondAThousand) {
  std::string text;
  for (int i = 0; i < 1200; ++i)
    text += "Texture \"t" + std::to_string(i) + "\" \"float\" \"fbm\"\n";
  const auto scene = testing::value_of(load_world(text));
  ASSERT_EQ(scene.remarks.size(), 1001U);
  EXPECT_EQ(scene.remarks.back().what, "200 more things are not modelled");
}

}  // namespace
}  // namespace lucerna
