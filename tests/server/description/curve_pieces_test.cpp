#include "server/description/curve_pieces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lucerna {
namespace {

using ::testing::HasSubstr;
Vec3 at(const CubicCurve& c, double u) {
  const double v = 1 - u;
  return c.points[0] * (v * v * v) + c.points[1] * (3 * v * v * u) + c.points[2] * (3 * v * u * u) +
         c.points[3] * (u * u * u);
}

std::vector<CubicCurve> curves_of(const CurveData& data) {
  std::vector<CubicCurve> curves;
  const absl::Status status = check_curves(data);
  EXPECT_TRUE(status.ok()) << status;
  for (std::size_t i = 0; status.ok() && i < data.count(); ++i)
    curves.push_back(cubic_curve(data, i));
  return curves;
}

std::string error_of(const CurveData& data) { return std::string(check_curves(data).message()); }

// The values of the uniform basis functions at the middle of a span: (1, 23, 23, 1) / 48 and
// (1, 6, 1) / 8; those of Bezier: (1, 3, 3, 1) / 8 and (1, 2, 1) / 4.
TEST(CurvePieces, HaveTheValuesOfTheirBasis) {
  const std::vector<Vec3> p{{0, 0, 0}, {1, 4, 0}, {3, -2, 5}, {7, 1, 1}};
  const Vec3 cubic = p[0] + p[1] * 3.0 + p[2] * 3.0 + p[3];
  EXPECT_LT(length(at(curves_of({.points = p})[0], 0.5) - cubic / 8.0), 1e-14);
  const std::vector<Vec3> three(p.begin(), p.end() - 1);
  EXPECT_LT(length(at(curves_of({.points = three, .degree = 2})[0], 0.5) -
                   (p[0] + p[1] * 2.0 + p[2]) / 4.0),
            1e-14);
  EXPECT_LT(length(at(curves_of({.points = p, .is_b_spline = true})[0], 0.5) -
                   (p[0] + p[1] * 23.0 + p[2] * 23.0 + p[3]) / 48.0),
            1e-14);
  EXPECT_LT(length(at(curves_of({.points = p, .degree = 2, .is_b_spline = true})[1], 0.5) -
                   (p[1] + p[2] * 6.0 + p[3]) / 8.0),
            1e-14);
}

TEST(CurvePieces, JoinInPointAndWidth) {
  std::vector<Vec3> p;
  for (int i = 0; i < 13; ++i) p.push_back({double(i), double(i * i % 7), double(i % 3)});
  for (const bool is_b_spline : {false, true})
    for (const int degree : {2, 3}) {
      const auto curves = curves_of({.points = p,
                                     .degree = degree,
                                     .is_b_spline = is_b_spline,
                                     .start_width_m = 1,
                                     .end_width_m = 4});
      ASSERT_EQ(curves.size(), static_cast<std::size_t>(is_b_spline ? 13 - degree : 12 / degree));
      EXPECT_EQ(curves.front().start_width_m, 1);
      EXPECT_EQ(curves.back().end_width_m, 4);
      for (std::size_t i = 1; i < curves.size(); ++i) {
        EXPECT_LT(length(curves[i - 1].points[3] - curves[i].points[0]), 1e-14);
        EXPECT_EQ(curves[i - 1].end_width_m, curves[i].start_width_m);
        if (!is_b_spline) continue;
        // The tangents of a B-spline join too.
        EXPECT_LT(length(curves[i - 1].points[3] - curves[i - 1].points[2] - curves[i].points[1] +
                         curves[i].points[0]),
                  1e-14);
      }
    }
}

TEST(CurvePieces, RefuseWrongNumbers) {
  const auto points = [](std::size_t n) { return std::vector<Vec3>(n); };
  EXPECT_EQ(error_of({.points = points(3)}), "3 control points, allowed: at least 4 for degree 3");
  EXPECT_THAT(error_of({.points = points(6)}), HasSubstr("allowed: 1 more than a multiple of 3"));
  EXPECT_EQ(error_of({.points = points(7), .normals = points(2)}),
            "2 normals of a ribbon with 2 curves, allowed: 3");
  const auto status = check_curves({.points = points(kMostCurves + 4), .is_b_spline = true});
  EXPECT_TRUE(absl::IsResourceExhausted(status));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("1048577 curves in one shape, allowed: at most 1048576"));
}

}  // namespace
}  // namespace lucerna
