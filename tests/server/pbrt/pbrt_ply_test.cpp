// Shapes "plymesh" from files with defects.
#include <gtest/gtest.h>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using testing::remarks_of;

/// A roof of two faces.  The normals of its ridge are those of `ridge`.
std::string roof(const std::string& ridge) {
  return "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty "
         "float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 2\n"
         "property list uchar int vertex_indices\nend_header\n"
         "-1 0 0 -1 0 1\n-1 1 0 -1 0 1\n0 0 1 " +
         ridge + "\n0 1 1 " + ridge + "\n1 0 0 1 0 1\n1 1 0 1 0 1\n4 0 2 3 1\n4 2 4 5 3\n";
}

TEST(PbrtPly, NormalsWithoutDirectionBecomeTheMeanOfTheFacesAround) {
  for (const char* ridge : {"nan nan nan", "0 0 0"}) {
    const testing::SceneFiles files;
    files.write("roof.ply", roof(ridge));
    files.write("scene.pbrt", "WorldBegin Shape \"plymesh\" \"string filename\" \"roof.ply\"");
    const auto scene = testing::value_of(files.load("scene.pbrt"));
    EXPECT_EQ(remarks_of(scene),
              "1:12 2 of 6 vertex normals of this mesh have no direction -> the mean of the faces "
              "around each\n");
    const auto& mesh = std::get<TriangleMeshData>(scene.shapes.at(0).geometry);
    ASSERT_EQ(mesh.normals.size(), 6U);
    for (const std::size_t vertex : {2, 3})
      EXPECT_NEAR(length(mesh.normals[vertex] - Vec3f(0, 0, 1)), 0, 0.35) << ridge;
    // The other normals decide the winding.
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto p = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
      EXPECT_GT(cross(p(1) - p(0), p(2) - p(0)).z, 0) << ridge;
    }
  }
}

TEST(PbrtPly, FacesThatPbrt4LeavesOutAreCountedInRemarks) {
  const testing::SceneFiles files;
  files.write("m.ply",
              "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
              "property float z\nproperty float u\nproperty float v\nelement face 6\nproperty list "
              "uchar int vertex_indices\nend_header\n0 0 0 0 nan\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n"
              "-1 0 0 0 0\n0\n1 7\n2 0 1\n3 0 1 2\n5 0 1 2 3 4\n4 0 1 2 3\n");
  files.write("scene.pbrt", "WorldBegin Shape \"plymesh\" \"string filename\" \"m.ply\"");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  EXPECT_EQ(remarks_of(scene),
            "1:28 3 faces of mesh \"m.ply\" have fewer than 3 corners -> left out, as in pbrt-v4\n"
            "1:28 1 faces of mesh \"m.ply\" have more than 4 corners -> left out, as in pbrt-v4; "
            "triangles keep them\n"
            "1:28 the (u, v) of 1 vertices of mesh \"m.ply\" are not finite -> (u, v) 0, 0\n");
  EXPECT_EQ(std::get<TriangleMeshData>(scene.shapes.at(0).geometry).indices.size(), 9U);
}

}  // namespace
}  // namespace lucerna
