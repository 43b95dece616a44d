#include "lights/shapes/shape_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/lights/area_helpers.h"
#include "tests/lights/grey_picture.h"

namespace lucerna::testing {
namespace {

TEST(MeanOverTriangle, IsThatOfManyPoints) {
  const Picture picture = grey(3, 2, {1, 5, 0, 3, 9, 2}, ImageFilter::kBilinear);
  // The last extends beyond the picture on three sides.
  const std::array<Vec2, 3> triangles[] = {
      {{{0.1, 0.2}, {0.9, 0.3}, {0.4, 0.95}}},
      {{{0, 0}, {1, 0}, {1, 1}}},
      {{{-0.5, 0.5}, {1.5, -0.25}, {0.75, 1.5}}},
  };
  for (const auto& t : triangles) {
    for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
      Picture p = picture;
      p.filter = filter;
      constexpr int kGrid = 1000;
      double sum = 0;
      for (int i = 0; i < kGrid * kGrid; ++i) {
        const double s = std::sqrt((i / kGrid + 0.5) / kGrid), r = (i % kGrid + 0.5) / kGrid;
        const double a = 1 - s, b = s * r, c = s * (1 - r);
        sum += p.at({a * t[0].x + b * t[1].x + c * t[2].x, a * t[0].y + b * t[1].y + c * t[2].y}).r;
      }
      // The points miss edges of texels by a thousandth of the triangle.
      const double tolerance = filter == ImageFilter::kNearest ? 5e-3 : 1e-5;
      EXPECT_NEAR(mean_over_triangle(p, t).r, sum / (kGrid * kGrid), tolerance);
    }
  }
}

TEST(MeanOverTriangle, TwoTrianglesMakeTheSquare) {
  for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
    const Picture picture = grey(3, 2, {1, 5, 0, 3, 9, 2}, filter);
    const Vec2 a{0, 0}, b{1, 0}, c{1, 1}, d{0, 1};
    EXPECT_NEAR(
        (mean_over_triangle(picture, {a, b, c}).r + mean_over_triangle(picture, {c, d, a}).r) / 2,
        picture.image->mean().r, 1e-13);
  }
}

TEST(MeanOverTriangle, OnALineWeighsEachPlaceByItsPoints) {
  // Corners at 0, 1/4 and 1: (1/2)^2 / (3/4) = 1/3 of the triangle's points lie beyond the middle.
  const Picture halves = grey(2, 1, {1, 5});
  const Vec2 a{0, 0.5}, b{1, 0.5}, c{0.25, 0.5}, above{0.25, 0.5 + 1e-11};
  for (const auto& t : {std::array{a, b, c}, std::array{c, b, a}, std::array{b, above, a}})
    EXPECT_NEAR(mean_over_triangle(halves, t).r, 7.0 / 3, 1e-9);
  // Between the centres the value rises from 1 to 5, and the mean place of the points is 5/12.  The
  // ends, cut off at 1/4 and 3/4, remove 4 / (1/2) times the integrals of their tails.  The tail
  // below is 1/48: t <= 1/4 has a quarter, its mean distance a third of 1/4.  The tail above is
  // 1/36 (1/12, 1/12).
  Picture ramp = halves;
  ramp.filter = ImageFilter::kBilinear;
  const double below = 0.25 * (0.25 / 3), beyond = (0.25 * 0.25 / 0.75) * (0.25 / 3);
  EXPECT_NEAR(mean_over_triangle(ramp, {a, b, c}).r, 1 + 8 * (5.0 / 12 - 0.25 + below - beyond),
              1e-13);
  // Along a diagonal through four texels, two of which it meets.
  const Picture four = grey(2, 2, {9, 5, 1, 9});
  EXPECT_NEAR(mean_over_triangle(four, {Vec2{0, 0}, {1, 1}, {0.25, 0.25}}).r, 7.0 / 3, 1e-13);
}

TEST(MeanOverTriangle, IsExactForThinTriangles) {
  // Widths of 1e-7 to 1e-12 of the length, across a picture of 8 x 5 texels, and along lines
  // between its columns and rows.  The means were computed by cutting the triangles in rational
  // numbers.
  std::vector<float> texels;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 8; ++x) texels.push_back(float((7 * x + 3 * y * y) % 11));
  struct Thin {
    std::array<Vec2, 3> uv;
    double nearest, bilinear;
  };
  const Thin all[] = {
      {{{{0.10000002384185791, 0.19999998807907104},
         {0.8500000834465027, 0.8100000023841858},
         {0.41046279668807983, 0.4525098204612732}}},
       3.9459413152749128,
       4.1496821899831788},
      {{{{0.10000002384185791, 0.19999998807907104},
         {0.8500000834465027, 0.8100000023841858},
         {0.2513951063156128, 0.3231346607208252}}},
       4.0301506787721673,
       4.1225857417956346},
      {{{{0.10000002384185791, 0.19999998807907104},
         {0.8500000834465027, 0.8100000023841858},
         {0.7302790880203247, 0.7126269340515137}}},
       4.3313296197405649,
       4.5053430955267908},
      {{{{0.10000002384185791, 0.19999998807907104},
         {0.8500000834465027, 0.8100000023841858},
         {0.5459535717964172, 0.562708854675293}}},
       4.3420942364909276,
       4.4716597541375185},
      {{{{0.10000002384185791, 0.19999998807907104},
         {0.8500000834465027, 0.8100000023841858},
         {0.38453954458236694, 0.43142545223236084}}},
       3.9716581269197682,
       4.1571222725111214},
      {{{{0.10000002384185791, 0.19999998807907104},
         {0.8500000834465027, 0.8100000023841858},
         {0.6581669449806213, 0.6539757251739502}}},
       4.463152772049912,
       4.586162957886839},
      {{{{0.4999999701976776, 0.10000000149011612},
         {0.5000000596046448, 0.8999999761581421},
         {0.49999991059303284, 0.6000000238418579}}},
       3.3518817537940513,
       4.1944437190000361},
      {{{{0.10000000149011612, 0.6000000238418579},
         {0.8999999761581421, 0.6000000834465027},
         {0.4000000059604645, 0.5999999642372131}}},
       5.0868750231763578,
       4.7724370785836108},
      {{{{0.15000000596046448, 1.2999999965401798e-09},
         {0.8299999833106995, 2.000000026702864e-10},
         {0.4000000059604645, 0.0}}},
       5.7240082535116388,
       5.6949956267668442},
  };
  for (const Thin& thin : all)
    for (int first = 0; first < 3; ++first)
      for (const int step : {1, 2}) {
        const auto corner = [&](int k) { return thin.uv[std::size_t(first + k * step) % 3]; };
        const std::array<Vec2, 3> uv{corner(0), corner(1), corner(2)};
        EXPECT_NEAR(mean_over_triangle(grey(8, 5, texels), uv).r, thin.nearest, 1e-13);
        EXPECT_NEAR(mean_over_triangle(grey(8, 5, texels, ImageFilter::kBilinear), uv).r,
                    thin.bilinear, 1e-13);
      }
}

TEST(MeanOverTriangle, OnALineBetweenTexelsUsesTheTexelOfItsPoints) {
  const Picture four = grey(2, 2, {1, 2, 4, 8});
  for (const double width : {0.0, 0.25}) {
    const std::array<Vec2, 3> upright{{{0.5, 0.5}, {0.5, 0.5 + width}, {0.5, 1}}};
    EXPECT_NEAR(mean_over_triangle(four, upright).r, four.at({0.5, 0.75}).r, 1e-14);
    const std::array<Vec2, 3> level{{{0, 0.5}, {0.25 + width / 2, 0.5}, {0.375, 0.5}}};
    EXPECT_NEAR(mean_over_triangle(four, level).r, four.at({0.25, 0.5}).r, 1e-14);
  }
}

TEST(MeanOverTriangle, WithoutExtentIsTheValueAtItsMiddle) {
  const Picture picture = grey(2, 1, {1, 5});
  EXPECT_EQ(mean_over_triangle(picture, {Vec2{0.75, 0.5}, {0.75, 0.5}, {0.75, 0.5}}).r, 5);
}

TEST(PictureMoments, AreExactForPolynomials) {
  // The integral of u^3 v over each texel of a 2 x 1 picture, by hand: u^4/4 and v^2/2.
  const Picture picture = grey(2, 1, {1, 5});
  const PaintedArea area =
      *PictureMoments(picture).times([](Vec2 p) { return p.x * p.x * p.x * p.y; }, 0);
  EXPECT_NEAR(area.m2.r, (1 * 1.0 / 64 + 5 * (1.0 / 4 - 1.0 / 64)) / 2, 1e-14);
  EXPECT_EQ(area.error_m2, 0);
  // v runs upwards: with 1 below and 5 above, v has more weight in the upper texel.
  const PaintedArea upwards =
      *PictureMoments(grey(1, 2, {5, 1})).times([](Vec2 p) { return p.y; }, 0);
  EXPECT_NEAR(upwards.m2.r, 5 * 3.0 / 8 + 1 * 1.0 / 8, 1e-14);
}

TEST(PictureMoments, StateTheirErrorForOthers) {
  // The integral of sqrt(w^2 + u^2): (h + w^2 asinh(1 / w)) / 2 with h = sqrt(w^2 + 1).  The
  // smaller w, the less the integrand is like a polynomial.
  const Picture picture = grey(1, 1, {3});
  for (double w : {2.0, 1.0, 0.7}) {
    const auto area =
        PictureMoments(picture).times([w](Vec2 p) { return std::sqrt(w * w + p.x * p.x); }, w);
    ASSERT_TRUE(area) << w;
    const double exact = 1.5 * (std::sqrt(w * w + 1) + w * w * std::asinh(1 / w));
    EXPECT_GT(area->error_m2, 0);
    EXPECT_LT(area->error_m2, 1e-3 * exact);
    EXPECT_NEAR(area->m2.r, exact, area->error_m2);
  }
  // Nearly a kink, in the middle.
  const auto kink = [](Vec2 p) { return std::hypot(1e-3, p.x - 0.5); };
  EXPECT_FALSE(PictureMoments(picture).times(kink, 1e-3));
}

TEST(SumOverPoints, StatesItsError) {
  // A ramp from 0 to 1 in the middle half of two texels, constant beyond.  Rotated by 45 degrees,
  // its integral is 1/2 by symmetry.  The second weight is sqrt(1 + s^2), constant along columns of
  // s.
  const Picture picture = grey(2, 1, {0, 1}, ImageFilter::kBilinear);
  const auto turned = [](Vec2 st) {
    return Vec2{0.5 + (st.x - st.y) / 2, 0.5 + (st.x + st.y) / 4};
  };
  const PaintedArea flat = sum_over_points(picture, turned, [](Vec2) { return 2.0; });
  EXPECT_NEAR(flat.m2.r, 1, flat.error_m2);
  EXPECT_GT(flat.error_m2, 0);
  EXPECT_LT(flat.error_m2, 0.02);
  const PaintedArea even =
      sum_over_points(grey(1, 1, {2}), turned, [](Vec2 st) { return std::sqrt(1 + st.x * st.x); });
  EXPECT_NEAR(even.m2.r, std::sqrt(2.0) + std::asinh(1.0), even.error_m2);
  EXPECT_LT(even.error_m2, 0.01);
}

}  // namespace
}  // namespace lucerna::testing
