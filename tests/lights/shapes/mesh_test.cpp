#include "lights/shapes/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unordered_set>

#include "tests/lights/area_helpers.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// A right triangle of legs 1 and `2 area` in the plane z = height.
Triangle flat_triangle(float area, float height = 0) {
  return {{0, 0, height}, {1, 0, height}, {0, 2 * area, height}};
}

TEST(Mesh, PrimitivesAreChosenByArea) {
  const std::vector<float> areas{1, 0, 4, 0, 0, 2, 0.5, 0};
  std::vector<Triangle> triangles;
  for (const float a : areas) triangles.push_back(flat_triangle(a));
  const auto mesh = *TriangleMesh::create(triangles);
  EXPECT_DOUBLE_EQ(mesh.area(), 7.5);
  EXPECT_EQ(mesh.size(), 8U);
  RandomU random(51);
  std::vector<double> observed(8), expected, uniform;
  constexpr int kSamples = 50000;
  for (int i = 0; i < kSamples; ++i)
    ++observed[mesh.sample({0, 0, 1}, random.pair()).point.primitive];
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_TRUE(areas[i] > 0 || observed[i] == 0);
    expected.push_back(kSamples * areas[i] / 7.5);
    uniform.push_back(areas[i] == 0 ? 0 : kSamples / 4.);
  }
  EXPECT_GT(chi_square_p_value(observed, expected), kUnlikely);
  EXPECT_LT(chi_square_p_value(observed, uniform), kUnlikely);
}

TEST(Mesh, PrimitivesWithoutAreaAreNotSampledAtExtremeSampleValues) {
  const auto mesh = *TriangleMesh::create(
      {flat_triangle(0), flat_triangle(1), flat_triangle(0), flat_triangle(2), flat_triangle(0)});
  for (const float x : {0.0, 1 - 0x1p-24, 1.0})
    for (const float y : {0.0, 0.3, 1 - 0x1p-24, 1.0}) {
      const auto s = mesh.sample({0, 0, 1}, {x, y});
      EXPECT_TRUE(s.point.primitive == 1 || s.point.primitive == 3);
      EXPECT_TRUE(std::isfinite(s.pdf.per_sr) && s.pdf.per_sr > 0);
    }
}

TEST(Mesh, SamplesWithinAPrimitiveAreUniformAmongAMillion) {
  // One primitive of 2^20 is tested in detail.  Only 16 of the float values of u.x lead there, but
  // its samples must fill it.
  constexpr std::size_t kCount = 1U << 20;
  const auto mesh = *TriangleMesh::create(std::vector<Triangle>(kCount, flat_triangle(0.5)));
  const auto base = static_cast<float>(kCount / 3) / kCount;  // a multiple of 2^-20
  RandomU random(52);
  std::size_t inside = 0;
  const double p = uniformity_p_value([&] {
    Vec2 u = random.pair();
    u.x = base + std::floor(u.x * 16) * 0x1p-24;
    const auto s = mesh.sample(by_area(Vec3{0, 0, 1}), u);
    inside += s.point.primitive == kCount / 3;
    const double x = s.point.position.x, y = s.point.position.y;
    return Vec2{1 - (1 - x) * (1 - x), y / (1 - x)};
  });
  EXPECT_GT(p, kUnlikely);
  EXPECT_EQ(inside, 50000U);
}

TEST(Mesh, PrimitivesOfLessThan2ToMinus24OfTheAreaAreAllReachable) {
  // 256 small ones of 2^-26 each before one large one.  Like among 2^26 equal ones, four share each
  // value of u.x.
  std::vector<Triangle> triangles(256, flat_triangle(1));
  triangles.push_back(flat_triangle(0x1p26 - 256));
  const auto mesh = *TriangleMesh::create(triangles);
  EXPECT_EQ(mesh.area(), 0x1p26);
  RandomU random(53);
  std::unordered_set<std::uint32_t> seen;
  for (int k = 0; k < 64; ++k) {
    // The probability that 256 draws miss one of four is 4 (3/4)^256 < 1e-31.
    for (int i = 0; i < 256; ++i)
      seen.insert(
          mesh.sample({0, 0, 1}, {static_cast<float>(k) * 0x1p-24, random.next()}).point.primitive);
    EXPECT_EQ(seen.size(), 4U * (k + 1));
  }
  EXPECT_EQ(seen.count(256), 0U);
}

TEST(Mesh, DensityIsThatOfTheSampleForBothPrimitives) {
  const auto triangles = *TriangleMesh::create({flat_triangle(1), flat_triangle(3, -1)});
  const auto patches = *PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}},
                                           {{0, 0, -2}, {4, 0, -2}, {0, 3, -2}, {1, 2, -2}}});
  const Vec3 position{0.3, 0.1, 5};
  const auto receiver = by_area(position);
  RandomU random(54);
  for (int i = 0; i < 500; ++i) {
    const auto t = triangles.sample(receiver, random.pair());
    EXPECT_EQ(t.pdf, triangles.pdf(receiver, t.point));
    const Vec3 d = Vec3(position) - Vec3(t.point.position);
    const double cosine = d.z / std::sqrt(dot(d, d));
    EXPECT_NEAR(t.pdf.per_sr / (dot(d, d) / cosine / 4), 1, 1e-6);
    const auto p = patches.sample(receiver, random.pair());
    EXPECT_EQ(p.pdf, patches.pdf(receiver, p.point));
    // With any sampling method.
    const auto a = triangles.sample(position, random.pair());
    EXPECT_EQ(a.pdf, triangles.pdf(position, a.point));
    const auto b = patches.sample(position, random.pair());
    EXPECT_EQ(b.pdf, patches.pdf(position, b.point));
  }
  EXPECT_EQ(triangles.pdf(receiver, {{0, 0, 0}, {0, 0, 1}, 2}).per_sr, 0);  // no such primitive
}

TEST(Mesh, AllPrimitivesAlongADirectionAreVisited) {
  const auto mesh = *TriangleMesh::create(
      {flat_triangle(1, 1), flat_triangle(1, -1), flat_triangle(1, 2), flat_triangle(0, 3)});
  std::vector<std::uint32_t> seen;
  mesh.for_each_hit({0.25, 0.25, 0}, {0, 0, 1},
                    [&](const SurfacePoint& p) { seen.push_back(p.primitive); });
  EXPECT_THAT(seen, ::testing::ElementsAre(0, 2));
}

TEST(Mesh, BoundsAndBytesCoverAllPrimitives) {
  const auto mesh = *TriangleMesh::create({flat_triangle(1, 1), flat_triangle(2, -3)});
  const auto [lower, upper] = mesh.bounds();
  EXPECT_EQ(lower, Vec3(0, 0, -3));
  EXPECT_EQ(upper, Vec3(1, 4, 1));
  EXPECT_GE(mesh.bytes(), 2 * (sizeof(Triangle) + sizeof(double)));
}

TEST(Mesh, RefusesInvalidMeshes) {
  const auto message = [](std::vector<Triangle> t) {
    return std::string(TriangleMesh::create(std::move(t)).status().message());
  };
  EXPECT_THAT(message({}), HasSubstr("mesh.primitives has 0 entries, allowed: at least 1"));
  EXPECT_THAT(message({flat_triangle(0)}), HasSubstr("mesh.area = 0 m2"));
  EXPECT_THAT(message({flat_triangle(1), flat_triangle(NAN)}), HasSubstr("mesh.primitives[1]"));
  EXPECT_THAT(message({flat_triangle(INFINITY)}), HasSubstr("mesh.primitives[0]"));
}

}  // namespace
}  // namespace lucerna::testing
