#include "server/description/loop_subdivision.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lucerna {
namespace {

using ::testing::HasSubstr;
std::string error_of(const ControlMesh& mesh, int levels = 1) {
  const absl::Status status = loop_subdivide(mesh, levels).status();
  return std::string(status.message());
}

LimitMesh limit_of(const ControlMesh& mesh, int levels) {
  auto limit = loop_subdivide(mesh, levels);
  EXPECT_TRUE(limit.ok()) << limit.status();
  return limit.ok() ? *std::move(limit) : LimitMesh{};
}

/// A vertex at `top` with `valence` triangles about it, and a second ring about these, so that the
/// vertex and its neighbours are inside.
ControlMesh umbrella(int valence, const Vec3& top) {
  ControlMesh mesh{{top}, {}};
  const auto n = static_cast<std::uint32_t>(valence);
  for (const double radius : {1.0, 2.0})
    for (std::uint32_t k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * k / n + (radius - 1) * std::numbers::pi / n;
      mesh.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t a = 1 + k, b = 1 + (k + 1) % n, outside_a = a + n, outside_b = b + n;
    for (const std::uint32_t i : {0U, a, b, a, outside_a, b, b, outside_a, outside_b})
      mesh.indices.push_back(i);
  }
  return mesh;
}

/// Vertices (x, y, 0) of a square of `n` x `n` cells, each cut along one diagonal.
ControlMesh grid(std::uint32_t n) {
  ControlMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y)
    for (std::uint32_t x = 0; x <= n; ++x) mesh.positions.push_back({double(x), double(y), 0});
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      for (const std::uint32_t i : {a, b, d, a, d, c}) mesh.indices.push_back(i);
    }
  return mesh;
}

// The limit of a vertex at height 1 above neighbours at 0 is 1 - n g, with g of the subdivision
// matrix's left eigenvector for 1: g = 1 / (n + 3 / (8 beta)) and n beta = 3/8 (9/16 for n = 3).
// So the height is 1/2 for each n, and 2/5 for n = 3.  The levels do not change it.
TEST(LoopSubdivision, LimitOfAVertexDoesNotDependOnLevels) {
  for (int valence = 3; valence <= 12; ++valence)
    for (int levels = 0; levels <= 4; ++levels) {
      const LimitMesh limit = limit_of(umbrella(valence, {0, 0, 1}), levels);
      EXPECT_NEAR(limit.positions[0].z, valence == 3 ? 0.4 : 0.5, 1e-14)
          << valence << " neighbours, " << levels << " levels";
      EXPECT_NEAR(limit.positions[0].x, 0, 1e-14);
    }
}

TEST(LoopSubdivision, FlatMeshStaysFlatAndRegularPointsStayInPlace) {
  const std::uint32_t n = 5;
  const LimitMesh limit = limit_of(grid(n), 3);
  EXPECT_EQ(limit.indices.size(), 3 * 2 * n * n * 64);
  for (std::size_t v = 0; v < limit.positions.size(); ++v) {
    EXPECT_EQ(limit.positions[v].z, 0);
    const Vec3 normal = normalized(limit.normals[v]);
    EXPECT_NEAR(normal.z, -1, 1e-12) << "vertex " << v << " points against the winding";
  }
  // The mesh is regular, so a linear function stays what it is: vertex (2, 3) does not move.
  EXPECT_LT(length(limit.positions[3 * (n + 1) + 2] - Vec3{2, 3, 0}), 1e-14);
}

// The boundary of the refined mesh is a cubic B-spline, so a straight edge stays straight.
TEST(LoopSubdivision, BoundariesDependOnlyOnThemselves) {
  ControlMesh mesh = grid(4);
  for (Vec3& p : mesh.positions)
    if (p.x > 0 && p.x < 4 && p.y > 0 && p.y < 4) p.z = 7;
  const LimitMesh limit = limit_of(mesh, 2);
  int on_boundary = 0;
  for (const Vec3& p : limit.positions)
    if (p.y == 0) {
      EXPECT_EQ(p.z, 0);
      ++on_boundary;
    }
  // The corners of the square are rounded off, so fewer than all 17 points keep y = 0.
  EXPECT_GE(on_boundary, 9);
  // One corner by hand: (0, 0), neighbours (1, 0) and (0, 1), each with 1/5.
  EXPECT_LT(length(limit_of(mesh, 0).positions[0] - Vec3{0.2, 0.2, 0}), 1e-15);
}

TEST(LoopSubdivision, EveryBoundaryValenceHasANormalAcrossTheSurface) {
  for (int triangles = 1; triangles <= 8; ++triangles) {
    ControlMesh fan{{{0, 0, 0}}, {}};
    for (int k = 0; k <= triangles; ++k) {
      const double angle = std::numbers::pi * k / 9;
      fan.positions.push_back({std::cos(angle), std::sin(angle), 0});
    }
    for (int k = 1; k <= triangles; ++k)
      for (const int i : {0, k, k + 1}) fan.indices.push_back(static_cast<std::uint32_t>(i));
    for (const Vec3& n : limit_of(fan, 0).normals) EXPECT_NEAR(normalized(n).z, -1, 1e-12);
  }
}

// The limit surface of an octahedron is symmetric, so its normals at the six first vertices are the
// axes.  All normals agree with differences of the surface.
TEST(LoopSubdivision, NormalsAreThoseOfTheLimitSurface) {
  ControlMesh octahedron{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                         {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5}};
  const LimitMesh limit = limit_of(octahedron, 5);
  EXPECT_EQ(limit.positions.size(), 2 + 4 * 1024U);  // Euler: V = F / 2 + 2
  for (int i = 0; i < 6; ++i)
    EXPECT_LT(length(normalized(limit.normals[i]) + octahedron.positions[i]), 1e-12);
  std::vector<Vec3> sums(limit.positions.size());
  for (std::size_t i = 0; i < limit.indices.size(); i += 3) {
    const auto p = [&](std::size_t k) { return limit.positions[limit.indices[i + k]]; };
    for (std::size_t k = 0; k < 3; ++k)
      sums[limit.indices[i + k]] += cross(p(1) - p(0), p(2) - p(0));
  }
  for (std::size_t v = 0; v < sums.size(); ++v)
    EXPECT_GT(-dot(normalized(sums[v]), normalized(limit.normals[v])), 0.9997) << v;
}

TEST(LoopSubdivision, RefusesMeshesThatAreNoSurface) {
  const std::vector<Vec3> five{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}};
  EXPECT_EQ(error_of({five, {0, 1, 5}}), "index 2 names vertex 5, but there are 5 vertices");
  EXPECT_EQ(error_of({five, {0, 1, 2, 3, 3, 4}}), "triangle 1 has vertex 3 twice");
  EXPECT_THAT(error_of({five, {0, 1, 2, 1, 0, 3, 0, 1, 4}}),
              HasSubstr("from vertex 0 to 1 has three triangles or more (0, 1, 2)"));
  EXPECT_THAT(error_of({five, {0, 1, 2, 0, 1, 3}}),
              HasSubstr("triangles 0 and 1 have opposite windings at the edge from vertex 0 to 1"));
  EXPECT_THAT(error_of({{{}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {0, 1, 2, 0, 3, 4}}),
              HasSubstr("touch only at vertex 0"));
  EXPECT_EQ(limit_of({five, {0, 1, 2}}, 0).positions.size(), 3U);  // without unused vertices
  EXPECT_TRUE(limit_of({}, 3).indices.empty());
}

TEST(LoopSubdivision, RefusesTooManyTriangles) {
  const ControlMesh one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2}};
  for (const int levels : {13, 31, 2'000'000'000})
    EXPECT_TRUE(absl::IsResourceExhausted(loop_subdivide(one, levels).status()));
  EXPECT_EQ(error_of(umbrella(3, {}), 12),
            "9 triangles at \"integer levels\" = 12 become more than 16777216, the limit");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(loop_subdivide(one, 3, stop.get_token()).status()));
}

}  // namespace
}  // namespace lucerna
