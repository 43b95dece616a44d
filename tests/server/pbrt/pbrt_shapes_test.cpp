// Shapes in world space: transforms, winding, instances.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "pbrt_fixture.h"
#include "server/description/scene_contents.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kPatch;
using testing::load_world;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;
using testing::world_error_of;

const std::string kTriangle = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] ";
const std::string kUp = "\"normal N\" [0 0 2  0 0 2  0 0 2] ";
const std::string kUp4 = "\"normal N\" [0 0 2  0 0 2  0 0 2  0 0 2] ";

/// The z of the first primitive's outside by its winding.
double outside_z(const std::string& text) {
  const auto scene = load_world(text);
  if (!scene.ok()) {
    ADD_FAILURE() << scene.status();
    return 0;
  }
  return std::visit(
      [](const auto& shape) -> double {
        if constexpr (requires { shape.indices; }) {
          const auto p = [&](int k) { return shape.positions[shape.indices[k]]; };
          return normalized(cross(p(1) - p(0), p(2) - p(0))).z;
        } else {
          return 0;
        }
      },
      scene->shapes[0].geometry);
}

TEST(PbrtShapes, WindingGivesTheOutsideAfterMirrorsAndReverseOrientation) {
  for (const std::string& shape : {kTriangle, kPatch}) {
    EXPECT_EQ(outside_z(shape), 1);
    EXPECT_EQ(outside_z("ReverseOrientation " + shape), -1);
    // The mirror reverses the winding in world space; pbrt-v4 keeps the outside in place.
    EXPECT_EQ(outside_z("Scale -1 1 1 " + shape), 1);
    EXPECT_EQ(outside_z("Scale -1 1 1 ReverseOrientation " + shape), -1);
    EXPECT_EQ(outside_z("Scale 1 1 -1 " + shape), -1);
  }
}

TEST(PbrtShapes, VertexNormalsDecideTheOutside) {
  const std::string down = "\"normal N\" [0 0 -1  0 0 -1  0 0 -1] ";
  EXPECT_EQ(outside_z(kTriangle + kUp), 1);
  EXPECT_EQ(outside_z(kTriangle + down), -1);
  EXPECT_EQ(outside_z("ReverseOrientation " + kTriangle + kUp), -1);
  EXPECT_EQ(outside_z("Scale -1 1 1 " + kTriangle + kUp), 1);
  EXPECT_EQ(outside_z("Scale 1 1 -1 " + kTriangle + kUp), -1);
  EXPECT_EQ(outside_z(kPatch + kUp4), 1);
  EXPECT_EQ(outside_z("ReverseOrientation " + kPatch + kUp4), -1);
}

TEST(PbrtShapes, NormalsAreUnitInWorldSpaceAndFollowTheOutside) {
  const auto scene = testing::value_of(
      load_world("Scale 1 1 4 Rotate 45 1 0 0 ReverseOrientation " + kTriangle + kUp));
  const auto& mesh = std::get<TriangleMeshData>(scene.shapes[0].geometry);
  // (0, -1, 1) / sqrt 2 after the rotation, (0, -4, 1) / sqrt 17 by the inverse transpose,
  // reversed.
  EXPECT_NEAR(mesh.normals[0].y, 4 / std::sqrt(17.0), 1e-7);
  EXPECT_NEAR(mesh.normals[0].z, -1 / std::sqrt(17.0), 1e-7);
}

TEST(PbrtShapes, PositionsAreInWorldSpace) {
  const auto scene =
      testing::value_of(load_world("Translate 10 0 0 Scale 2 3 4 Rotate 90 0 0 1 " + kTriangle));
  const auto& mesh = std::get<TriangleMeshData>(scene.shapes[0].geometry);
  // x rotates to y, then scales by 3; y rotates to -x, then scales by 2.
  EXPECT_NEAR(mesh.positions[1].x, 10, 1e-15);
  EXPECT_NEAR(mesh.positions[1].y, 3, 1e-15);
  EXPECT_NEAR(mesh.positions[2].x, 8, 1e-15);
}

TEST(PbrtShapes, InstancesComposeTheirTransformWithThoseInTheDefinition) {
  const auto scene = testing::value_of(load_world(
      "AttributeBegin Translate 1 0 0 ObjectBegin \"o\" Scale 2 2 2 Shape \"sphere\" " + kTriangle +
      "ObjectEnd AttributeEnd Translate 0 0 5 ObjectInstance \"o\" Translate 0 0 5 ObjectInstance "
      "\"o\""));
  EXPECT_TRUE(scene.shapes.empty());
  ASSERT_EQ(scene.objects.size(), 1U);
  ASSERT_EQ(scene.instances.size(), 2U);
  const auto& object = scene.objects[0];
  EXPECT_EQ(object.name, "o");
  // Translate 1 0 0 is in force at the definition: world = instance * definition.
  EXPECT_EQ(std::get<SphereParams>(object.shapes[0].geometry).world_from_object.point({1, 0, 0}),
            Vec3(3, 0, 0));
  EXPECT_EQ(std::get<TriangleMeshData>(object.shapes[1].geometry).positions[1], Vec3(3, 0, 0));
  EXPECT_EQ(scene.instances[1].world_from_object.point({3, 0, 0}), Vec3(3, 0, 10));
}

TEST(PbrtShapes, InstancesMayStandBeforeTheirObject) {
  const auto scene = testing::value_of(
      load_world("ObjectInstance \"b\" ObjectBegin \"a\" ObjectEnd ObjectBegin \"b\" ObjectEnd"));
  EXPECT_EQ(scene.instances[0].object, 1U);
}

// One triangle, whose corners end at 3/5 of themselves and 1/5 of each other corner.
const std::string kLoop =
    "Shape \"loopsubdiv\" \"point3 P\" [0 0 0  5 0 0  0 5 0] \"integer indices\" [0 1 2] ";

TEST(PbrtShapes, LoopSubdivisionGivesTrianglesOfTheLimitSurface) {
  const auto scene =
      testing::value_of(load_world("Translate 0 0 4 " + kLoop + "\"integer levels\" 0 " + kLoop));
  EXPECT_EQ(remarks_of(scene), "");
  const auto& coarse = std::get<TriangleMeshData>(scene.shapes[0].geometry);
  EXPECT_LT(length(coarse.positions[1] - Vec3{3, 1, 4}), 1e-14);
  EXPECT_EQ(std::get<TriangleMeshData>(scene.shapes[1].geometry).indices.size(), 3 * 64U);
  // The outside is against the winding of the control mesh, as in pbrt-v4.
  EXPECT_EQ(outside_z(kLoop), -1);
  EXPECT_EQ(outside_z("ReverseOrientation " + kLoop), 1);
  EXPECT_EQ(outside_z("Scale -1 1 1 " + kLoop), -1);
}

TEST(PbrtShapes, LoopSubdivisionNamesWhatIsWrong) {
  EXPECT_EQ(world_error_of(kLoop + "\"integer levels\" -1"),
            "scene.pbrt:1:90: \"integer levels\" = -1, allowed: 0 and more");
  EXPECT_EQ(
      world_error_of(kLoop + "\"integer levels\" 13"),
      "scene.pbrt:1:90: 1 triangles at \"integer levels\" = 13 become more than 16777216, the "
      "limit");
  EXPECT_EQ(
      world_error_of("Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer "
                     "indices\" [0 1 2 0 1 3]"),
      "scene.pbrt:1:12: triangles 0 and 1 have opposite windings at the edge from vertex 0 to "
      "1, allowed: the same winding");
  EXPECT_THAT(world_error_of("Shape \"loopsubdiv\""), HasSubstr("lacks \"point3 P\""));
}

const std::string kCurve = "Shape \"curve\" \"point3 P\" [0 0 0  0 0 1  0 0 2  0 0 3] ";

TEST(PbrtShapes, CurvesKeepTheirKindWidthAndPlace) {
  const auto scene = testing::value_of(load_world(
      "Translate 5 0 0 Scale 2 2 2 " + kCurve + kCurve +
      "\"string type\" \"cylinder\" \"float width0\" .5 \"float width1\" .25 \"integer "
      "splitdepth\" 3 " +
      kCurve +
      "\"string type\" \"ribbon\" \"string basis\" \"bspline\" \"integer degree\" 2 \"normal N\" "
      "[3 0 0 0 2 0 1 0 0]"));
  EXPECT_EQ(remarks_of(scene), "");
  const auto data = [&](int i) { return std::get<CurveData>(scene.shapes[i].geometry); };
  const auto curve = [&](int i, std::size_t k) { return cubic_curve(data(i), k); };
  EXPECT_EQ(data(0).kind, CurveKind::kFlat);
  EXPECT_NEAR(curve(0, 0).start_width_m, 2, 1e-15);
  EXPECT_EQ(curve(0, 0).points[3], Vec3(5, 0, 6));
  EXPECT_EQ(data(1).kind, CurveKind::kCylinder);
  EXPECT_NEAR(curve(1, 0).start_width_m, 1, 1e-15);
  EXPECT_NEAR(curve(1, 0).end_width_m, 0.5, 1e-15);
  EXPECT_EQ(data(2).kind, CurveKind::kRibbon);
  ASSERT_EQ(data(2).count(), 2U);
  EXPECT_EQ(curve(2, 0).normals[0], Vec3(1, 0, 0));
  EXPECT_EQ(curve(2, 1).normals[0], Vec3(0, 1, 0));
}

TEST(PbrtShapes, CurvesReportWhatIsNotModelled) {
  const auto scene = testing::value_of(load_world("AreaLightSource \"diffuse\" Scale 1 1 2 " +
                                                  kCurve + "\"normal N\" [1 0 0 1 0 0]"));
  EXPECT_FALSE(scene.shapes[0].emission);
  const std::string remarks = remarks_of(scene);
  EXPECT_THAT(remarks, HasSubstr("a curve that emits is not modelled -> the curve emits nothing"));
  EXPECT_THAT(remarks, HasSubstr("deforms the cross-section of a curve"));
  EXPECT_THAT(remarks, HasSubstr("of a curve that is no ribbon -> not used"));
}

TEST(PbrtShapes, CurvesNameWhatIsWrong) {
  EXPECT_EQ(world_error_of(kCurve + "\"string type\" \"hair\""),
            "scene.pbrt:1:66: \"string type\" = \"hair\", allowed: \"flat\", \"cylinder\", "
            "\"ribbon\"");
  EXPECT_THAT(world_error_of(kCurve + "\"string basis\" \"nurbs\""),
              HasSubstr("allowed: \"bezier\", \"bspline\""));
  EXPECT_THAT(world_error_of(kCurve + "\"integer degree\" 4"), HasSubstr("allowed: 2 or 3"));
  EXPECT_THAT(world_error_of(kCurve + "\"float width\" -1"), HasSubstr("allowed: at least 0"));
  EXPECT_THAT(world_error_of(kCurve + "\"string type\" \"ribbon\""),
              HasSubstr("a ribbon lacks \"normal N\""));
  EXPECT_THAT(world_error_of("Shape \"curve\" \"point3 P\" [0 0 0 1 1 1]"),
              HasSubstr("scene.pbrt:1:26: 2 control points, allowed: at least 4"));
  EXPECT_THAT(world_error_of("Shape \"curve\""), HasSubstr("0 control points"));
}

TEST(PbrtShapes, SpheresAndDisksKeepTheirParametersAndTransform) {
  const auto scene = testing::value_of(load_world(
      "Translate 1 2 3 Shape \"sphere\" \"float radius\" 2 \"float zmin\" 1 \"float zmax\" -.5 "
      "\"float phimax\" 90 ReverseOrientation Shape \"disk\" \"float radius\" 3 \"float "
      "innerradius\" 1 "
      "\"float height\" .5 Shape \"sphere\""));
  const auto& sphere = std::get<SphereParams>(scene.shapes[0].geometry);
  EXPECT_EQ(sphere.radius_m, 2);
  EXPECT_EQ(sphere.z_min_m, -.5);
  EXPECT_EQ(sphere.z_max_m, 1);
  EXPECT_NEAR(sphere.phi_max_rad, std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(sphere.world_from_object.point({0, 0, 0}), Vec3(1, 2, 3));
  const auto& disk = std::get<DiskParams>(scene.shapes[1].geometry);
  EXPECT_EQ(disk.radius_m, 3);
  EXPECT_EQ(disk.inner_radius_m, 1);
  EXPECT_EQ(disk.height_m, .5);
  EXPECT_TRUE(disk.reverse_orientation);
  const auto& whole = std::get<SphereParams>(scene.shapes[2].geometry);
  EXPECT_EQ(whole.z_max_m, 1);
  EXPECT_EQ(whole.phi_max_rad, 2 * std::numbers::pi);
}

TEST(PbrtShapes, CylindersKeepTheirParametersAndHavePbrtsDefaults) {
  const auto scene = testing::value_of(load_world(
      "Shape \"cylinder\" Translate 1 2 3 ReverseOrientation Shape \"cylinder\" \"float radius\" 2 "
      "\"float zmin\" 4 \"float zmax\" -.5 \"float phimax\" 180"));
  const auto& plain = std::get<CylinderParams>(scene.shapes[0].geometry);
  EXPECT_EQ(plain.radius_m, 1);
  EXPECT_EQ(plain.z_min_m, -1);
  EXPECT_EQ(plain.z_max_m, 1);
  EXPECT_EQ(plain.phi_max_rad, 2 * std::numbers::pi);
  EXPECT_FALSE(plain.reverse_orientation);
  const auto& part = std::get<CylinderParams>(scene.shapes[1].geometry);
  EXPECT_EQ(part.radius_m, 2);
  EXPECT_EQ(part.z_min_m, -.5);
  EXPECT_EQ(part.z_max_m, 4);
  EXPECT_NEAR(part.phi_max_rad, std::numbers::pi, 1e-15);
  EXPECT_TRUE(part.reverse_orientation);
  EXPECT_EQ(part.world_from_object.point({0, 0, 0}), Vec3(1, 2, 3));
}

TEST(PbrtShapes, WrongMeshesAreRefused) {
  const std::pair<std::string, std::string> kCases[] = {
      {"Shape \"trianglemesh\"", "lacks \"point3 P\""},
      {kPatch + "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0]", "lacks \"integer indices\""},
      {kTriangle + "\"integer indices\" [0 1 2 0]", "has 4 indices, expected a multiple of 3"},
      {kTriangle + "\"integer indices\" [0 1 3]",
       "index 2 names vertex 3, but there are 3 vertices"},
      {kTriangle + "\"integer indices\" [0 1 -1]", "\"indices\" holds -1, allowed: not negative"},
      {kTriangle + "\"normal N\" [0 0 1]", "has 1 normals for 3 vertices"},
      {"Scale 1e200 1 1 Scale 1e150 1 1 " + kTriangle, "is not finite after its transform"},
      {"Scale 1 2 1 AreaLightSource \"diffuse\" Shape \"cylinder\"", "by (1, 2, 1), allowed for"},
      {"Shape \"plymesh\"", "lacks \"string filename\""},
  };
  for (const auto& [text, expected] : kCases) {
    EXPECT_THAT(world_error_of(text), ::testing::StartsWith("scene.pbrt:1:")) << text;
    EXPECT_THAT(world_error_of(text), HasSubstr(expected)) << text;
  }
}

TEST(PbrtShapes, InvalidParametersAreNamedLikeInTheFile) {
  const std::pair<const char*, const char*> kCases[] = {
      {"Shape \"sphere\" \"float radius\" 0", "27: \"float radius\" = 0 m, allowed: positive"},
      {"Shape \"disk\" \"float radius\" -1", "25: \"float radius\" = -1 m, allowed: positive"},
      {"Shape \"cylinder\" \"float radius\" -1", "29: \"float radius\" = -1 m, allowed: positive"},
      {"Shape \"cylinder\" \"float phimax\" -20",
       "29: \"float phimax\" = -20 degrees, allowed: positive"},
      {"Shape \"sphere\" \"float phimax\" 0",
       "27: \"float phimax\" = 0 degrees, allowed: positive"},
      {"Shape \"disk\" \"float phimax\" 1e-323",
       "25: \"float phimax\" = 1e-323 degrees, allowed: positive"},
      {"Shape \"disk\" \"float radius\" 2 \"float innerradius\" 2",
       "42: \"float innerradius\" = 2 m, allowed: at least 0 and less than the radius, 2 m"},
      {"Shape \"disk\" \"float innerradius\" -.5",
       "25: \"float innerradius\" = -0.5 m, allowed: at least 0 and less than the radius, 1 m"},
      {"Shape \"sphere\" \"float zmin\" 3 \"float zmax\" 2",
       "27: \"float zmin\" = 3 m and \"float zmax\" = 2 m, allowed: two heights that have a part "
       "of [-1, 1] between them"},
      {"Shape \"sphere\" \"float zmax\" -1",
       "27: \"float zmin\" = -1 m and \"float zmax\" = -1 m, allowed: two heights that have a part "
       "of"},
      {"Shape \"cylinder\" \"float zmin\" 1",
       "29: \"float zmin\" = 1 m and \"float zmax\" = 1 m, allowed: two heights that differ"},
      {"Shape \"sphere\" \"float radius\" 1e400",
       "42: number 1e400 of \"float radius\" does not fit a double, allowed: [-1.79769e+308, 1.79"},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_THAT(world_error_of(text),
                ::testing::StartsWith(std::string("scene.pbrt:1:") + expected))
        << text;
}

// In ring order the two halves of z = 1 face opposite ways: x = u (1 - v) + (1 - u) v, y = v, so
// dp/du x dp/dv = 1 - 2 v along z.
TEST(PbrtShapes, CornersInRingOrderGetARemarkAndHaveArea) {
  const std::string mesh = "\nShape \"bilinearmesh\" \"point3 P\" ";
  const auto remarks = [&](const std::string& points) {
    const auto scene = load_world("AreaLightSource \"diffuse\"" + mesh + points);
    EXPECT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(scene->shapes.at(0).emission.has_value(),
              points.find("[0 0 1 1 0 1 2") == std::string::npos);
    return remarks_of(*scene);
  };
  const std::string bow_tie =
      "2:1 the edges of 1 of 1 patches of this mesh cross, which suggests corners in ring "
      "order; \"point3 P\" of a bilinearmesh needs rows: (u, v) = (0, 0), (1, 0), (0, 1), (1, 1) "
      "-> "
      "taken as rows: a bow tie, whose halves face opposite ways\n";
  EXPECT_EQ(remarks("[0 0 1 1 0 1 1 1 1 0 1 1]"), bow_tie);
  // Here the middle has a normal.
  EXPECT_EQ(remarks("[0 0 1 3 0 1 1 1 1 0 1 1]"), bow_tie);
  EXPECT_EQ(remarks("[0 0 1 0 1 1 1 1 1 1 0 1]"), bow_tie);
  // Rows, an arrowhead, a triangle, and a patch that is not flat: no edges cross.
  EXPECT_EQ(remarks("[0 0 1 1 0 1 0 1 1 1 1 1]"), "");
  EXPECT_EQ(remarks("[0 0 1 2 0 1 0 2 1 .5 .5 1]"), "");
  EXPECT_EQ(remarks("[0 0 1 1 0 1 0 1 1 0 1 1]"), "");
  EXPECT_EQ(remarks("[0 0 1 1 0 1 1 1 2 0 1 1]"), "");
  EXPECT_EQ(remarks("[0 0 1 1 0 1 2 0 1 3 0 1]"), "");  // without area, which is only counted
}

TEST(PbrtShapes, PartsOfShapesThatAreNotModelledGetRemarks) {
  const auto scene =
      testing::value_of(load_world("\n" + kTriangle + "\"float alpha\" .5\n" +
                                   "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0  0 1 0] "
                                   "\"integer indices\" [0 1 2 0 1 3]\n" +
                                   kTriangle + "\"normal N\" [0 0 0  0 0 1  0 0 1]\n"));
  EXPECT_EQ(remarks_of(scene),
            "4:1 1 of 3 vertex normals of this mesh have no direction -> the mean of the faces "
            "around each\n");
  EXPECT_EQ(contents_of(scene).shapes.at(0).without_area, 1U);
  ASSERT_EQ(scene.shapes.size(), 3U);
  EXPECT_EQ(scene.shapes[0].alpha.constant, .5);
  EXPECT_EQ(scene.shapes[1].alpha.constant, 1);
}

// pbrt-v4 takes any other alpha as a mask of the light.
TEST(PbrtShapes, OnlyAConstantAlphaOfZeroHidesAShapeThatShines) {
  const auto shape = [](const std::string& texture) {
    const auto scene = load_world(
        "Texture \"zero\" \"float\" \"constant\" \"float value\" 0\n"
        "Texture \"mix\" \"float\" \"mix\" \"float tex1\" 0 \"float tex2\" 0\n"
        "Texture \"a\" \"float\" " +
        texture + "\nAreaLightSource \"diffuse\"\n" + kTriangle + "\"texture alpha\" \"a\"");
    EXPECT_TRUE(scene.ok()) << scene.status();
    return scene->shapes.at(0);
  };
  for (const char* hidden : {"\"constant\" \"float value\" 0", "\"scale\" \"float tex\" 0",
                             "\"scale\" \"texture scale\" \"zero\""}) {
    const ShapeDescription s = shape(hidden);
    EXPECT_TRUE(s.emission->is_unseen) << hidden;
    EXPECT_EQ(s.alpha.constant, 1) << hidden;
  }
  for (const char* dark :
       {"\"mix\" \"texture tex1\" \"zero\" \"float amount\" 0",
        "\"scale\" \"float tex\" 0 \"float scale\" .5", "\"scale\" \"texture tex\" \"mix\""}) {
    const ShapeDescription s = shape(dark);
    EXPECT_FALSE(s.emission->is_unseen) << dark;
    EXPECT_TRUE(s.alpha.is_constant() && s.alpha.constant == 0) << dark;
  }
}

TEST(PbrtShapes, PlyMeshesComeFromTheirFileAndItsErrorsNameBoth) {
  const SceneFiles files;
  files.write("scene.pbrt",
              "WorldBegin Translate 0 0 1\nShape \"plymesh\" \"string filename\" \"m/a.ply\"");
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  files.write("m/a.ply", header + "0 0 0 1 0 0 0 1 0 3 0 1 2");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  EXPECT_EQ(std::get<TriangleMeshData>(scene.shapes[0].geometry).positions[2], Vec3(0, 1, 1));
  EXPECT_EQ(scene.assets[1].name, "m/a.ply");
  files.write("m/a.ply", header + "0 0 0 1 0 0 0 nan 0 3 0 1 2");
  EXPECT_EQ(message(files.load("scene.pbrt").status()),
            "scene.pbrt:2:17: file \"m/a.ply\": PLY: vertex 2 is not finite");
}

}  // namespace
}  // namespace lucerna
