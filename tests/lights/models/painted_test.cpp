// Pictures on shapes: which points show what, and how they are chosen.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/area_helpers.h"
#include "tests/lights/grey_picture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// A shape with a picture on it.
template <typename S>
struct Painted {
  Painted(absl::StatusOr<S> of, Picture with)
      : shape(*std::move(of)),
        picture(std::move(with)),
        distribution(shape.distribution(picture)),
        painted_area(shape.painted_area(picture)) {}

  bool is_by_picture() const { return distribution.has_value(); }
  SurfacePoint sample(Vec2 u) const { return shape.sample_picture(picture, *distribution, u); }
  absl::StatusOr<AreaLight> light(const Rgb& level) const {
    return AreaLight::create({level}, shape, {.picture = picture});
  }
  Rgb tint(const SurfacePoint& point) const { return picture.at(shape.uv(point)); }

  S shape;
  Picture picture;
  std::optional<ImageDistribution> distribution;
  PaintedArea painted_area;
};

Painted<PatchMesh> screen(Picture picture, std::vector<Vec2f> corner_uv = {}) {
  return {PatchMesh::create({{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}}}, std::move(corner_uv)),
          std::move(picture)};
}

/// Value over density of position is the same for all rays.  Only the cosine varies, and it is not
/// part of the ratio.
template <typename S>
void expect_no_variance(const Painted<S>& painted) {
  RandomU random(3);
  double first = 0;
  for (int i = 0; i < 1000; ++i) {
    const SurfacePoint p = painted.sample(random.pair());
    const double ratio =
        luminance(painted.tint(p)) /
        painted.shape.pdf_picture(painted.picture, *painted.distribution, p).per_m2;
    if (i == 0) first = ratio;
    EXPECT_NEAR(ratio, first, 1e-9 * first);
  }
  EXPECT_NEAR(first, luminance(painted.painted_area.m2), 1e-9 * first);
}

TEST(Painted, PointsAreChosenInProportionWhereTheMapKeepsArea) {
  const std::vector<float> values{1, 5, 0.25, 3, 9, 2};
  for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
    expect_no_variance(screen(grey(3, 2, values, filter)));
    expect_no_variance(
        Painted<Cylinder>(Cylinder::create({.radius_m = 0.5, .reverse_orientation = true}),
                          grey(3, 2, values, filter)));
  }
  // Texel by texel on curved shapes too.
  expect_no_variance(Painted<Disk>(Disk::create({.radius_m = 2}), grey(3, 2, values)));
  expect_no_variance(Painted<Sphere>(Sphere::create({}), grey(3, 2, values)));
}

TEST(Painted, BlackTexelsAreNeverChosen) {
  const auto light = *screen(grey(4, 1, {0, 1e9, 1, 0})).light(Rgb(1));
  RandomU random(4);
  int faint = 0;
  for (int i = 0; i < 10000; ++i) {
    const auto s = light.sample_li(Vec3{1, 1, 1}, random.pair());
    EXPECT_GT(s.point.x, 0.5);
    EXPECT_LT(s.point.x, 1.5);
    faint += s.point.x > 1 ? 1 : 0;
  }
  EXPECT_LE(faint, 1);  // 1e-5 expected
  // A texel that is not negligible beside 1e9 is sampled by the matching u.
  const auto s = light.sample_li(Vec3{1, 1, 1}, Vec2{1, 0.5});
  EXPECT_GT(s.point.x, 1);
  EXPECT_GT(s.pdf.per_sr, 0);
}

TEST(Painted, ABlackPictureIsABlackLight) {
  const auto light = *screen(grey(2, 1, {0, 0})).light(Rgb(1));
  const auto s = light.sample_li(Vec3{1, 0.5, 1}, {0.25, 0.5});
  EXPECT_EQ(s.reason, NoLight::kBlack);
  EXPECT_GT(s.pdf.per_sr, 0);
  EXPECT_EQ(light.sample_le({0.5, 0.5}, {0.5, 0.5}, {}).reason, NoLight::kBlack);
  EXPECT_TRUE(light.power({}).lumens.is_black());
}

TEST(Painted, PowerOfADiskWeighsRowsByTheirRings) {
  // v = 1 - r on a whole disk.  The upper row is the inner half of the radius, a quarter of the
  // area.
  const auto light = *Painted<Disk>(Disk::create({}), grey(1, 2, {4, 1})).light(Rgb(10));
  EXPECT_NEAR(light.power({}).lumens.g, 10 * kPi * kPi * (4 * 0.25 + 1 * 0.75), 1e-10);
  EXPECT_EQ(light.power({}).error_lumens, 0);
  // pbrt's Phi weights both halves equally.
  const Power phi = light.power_approximate({});
  EXPECT_NEAR(phi.lumens.g, 10 * kPi * kPi * 2.5, 1e-10);
  EXPECT_NEAR(phi.error_lumens, 10 * kPi * kPi * 0.75, 1e-10);
}

/// The integral of `weight` times `area` over [from, to], by Simpson's rule in long double.  Both
/// are polynomials in between, or nearly so.
template <typename Weight, typename Area>
long double integral(long double from, long double to, const Weight& weight, const Area& area) {
  constexpr int kSteps = 100;
  long double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const long double at = from + (to - from) * i / kSteps;
    sum += weight(at) * area(at) * (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2);
  }
  return sum * (to - from) / (3 * kSteps);
}

TEST(Painted, OneRowOfManyIsWeighedToTheLastDigits) {
  // The row's part extends over its own height; for the bilinear filter, from the centre above to
  // the centre below.  `area` is the share of the surface in a unit of the row coordinate.  Rows
  // count from the end `upper`.
  const auto row_share = [](ImageFilter filter, int k, const auto& area) {
    const auto one = [](long double) { return 1.0L; };
    if (filter == ImageFilter::kNearest) return integral(k, k + 1.0L, one, area);
    const long double middle = k + 0.5L;
    const auto tent = [middle](long double at) { return 1 - std::fabs(at - middle); };
    return (k == 0 ? integral(0, middle, one, area) : integral(middle - 1, middle, tent, area)) +
           integral(middle, middle + 1, tent, area);
  };
  constexpr long double kWidePi = std::numbers::pi_v<long double>;
  for (const int n : {4096, 32768})
    for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear})
      for (const int k : {0, 1, n / 8})
        for (const bool from_top : {true, false}) {
          std::vector<float> rows(static_cast<std::size_t>(n));
          rows[static_cast<std::size_t>(from_top ? k : n - 1 - k)] = 1;
          const Picture picture = grey(1, n, rows, filter);
          const std::string where =
              fmt::format("row {} of {} from the {}", k, n, from_top ? "top" : "bottom");
          const double sphere =
              Painted<Sphere>(Sphere::create({}), picture).painted_area.m2.g / (4 * kPi);
          const long double zone = row_share(filter, k, [n](long double at) {
            return std::sin(kWidePi * at / n) * kWidePi / (2 * n);
          });
          EXPECT_NEAR(sphere / static_cast<double>(zone), 1, 2e-15) << where;
          // The top row of a picture is at the disk's inner edge.
          const double disk = Painted<Disk>(Disk::create({}), picture).painted_area.m2.g / kPi;
          const long double ring = row_share(
              filter, k, [&](long double at) { return 2 * (from_top ? at : n - at) / n / n; });
          EXPECT_NEAR(disk / static_cast<double>(ring), 1, 2e-15) << where;
        }
}

TEST(Painted, PowerOfASaddleIsWithinItsError) {
  const auto p = [](double x, double y) { return Vec3{x, y, x * y}; };
  const Picture picture = grey(2, 2, {1, 6, 3, 2}, ImageFilter::kBilinear);
  const auto saddle =
      Painted<PatchMesh>(PatchMesh::create({{p(-1, -1), p(1, -1), p(-1, 1), p(1, 1)}}), picture);
  constexpr int kGrid = 2000;
  double sum = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double u = (i + 0.5) / kGrid, v = (j + 0.5) / kGrid;
      const double x = 2 * u - 1, y = 2 * v - 1;
      sum += picture.at({u, v}).r * std::sqrt(1 + x * x + y * y) * 4 / (double(kGrid) * kGrid);
    }
  const PaintedArea& area = saddle.painted_area;
  EXPECT_GT(area.error_m2, 0);
  EXPECT_LT(area.error_m2, 1e-3 * sum);
  EXPECT_NEAR(area.m2.r, sum, area.error_m2 + 1e-6 * sum);
}

TEST(Painted, PatchesThatShowAPartAreSampledByAreaAndMeasuredByPoints) {
  // The right half of the picture on a square: texels 5 and 9.
  const auto shape = screen(grey(2, 2, {1, 5, 2, 9}), {{0.5, 0}, {1, 0}, {0.5, 1}, {1, 1}});
  EXPECT_FALSE(shape.is_by_picture());
  const PaintedArea& area = shape.painted_area;
  EXPECT_NEAR(area.m2.r, 5 + 9, area.error_m2);
  EXPECT_LT(area.error_m2, 0.02 * 14);
}

TEST(Painted, PartsFinerThanThePointsAreMeasuredWithinTheirError) {
  // Half of a picture in which every other column is lit, the first or the second, or one texel.
  std::vector<float> even(1024), odd(1024), one(1024);
  for (std::size_t x = 0; x < 1024; ++x) (x % 2 == 0 ? even : odd)[x] = 1;
  one[301] = 1;
  const auto measured = [](const std::vector<float>& texels) {
    return screen(grey(1024, 1, texels), {{0, 0}, {1, 0}, {0, 0.5}, {1, 0.5}}).painted_area;
  };
  for (const auto& texels : {even, odd}) {
    const PaintedArea area = measured(texels);
    EXPECT_NEAR(area.m2.r, 1, area.error_m2);
    EXPECT_GT(area.m2.r, 0);
  }
  const PaintedArea area = measured(one);
  EXPECT_NEAR(area.m2.r, 2.0 / 1024, area.error_m2);
  EXPECT_GT(area.m2.r, 0);  // a light that shines must be found
}

TEST(Painted, TwoTrianglesThatShowItTogetherAreSampledByThePicture) {
  const std::vector<float> values{1, 5, 0.25, 3, 9, 2};
  const auto two = [&](std::vector<Vec2f> uv) {
    return Painted<TriangleMesh>(
        TriangleMesh::create({{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}}, {{0, 0, 0}, {2, 1, 0}, {0, 1, 0}}},
                             std::move(uv)),
        grey(3, 2, values));
  };
  expect_no_variance(two({{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}));
  expect_no_variance(two({{1, 1}, {1, 0}, {0, 0}, {1, 1}, {0, 0}, {0, 1}}));
  // The same half twice, and a part.
  EXPECT_FALSE(two({{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 0}, {1, 1}}).is_by_picture());
  EXPECT_FALSE(two({{0, 0}, {0.5, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}).is_by_picture());
}

TEST(Painted, TrianglesOfAnySizeShowThePictureAtItsPlace) {
  for (const double size : {1e-100, 1e-70, 1.0, 1e78, 1e100, 1e150}) {
    const auto shape =
        Painted<TriangleMesh>(TriangleMesh::create({{{0, 0, 0}, {2 * size, 0, 0}, {0, size, 0}}},
                                                   {{0, 0}, {1, 0}, {0, 1}}),
                              grey(2, 1, {1, 5}));
    const Vec2 uv = shape.shape.uv({{0.5 * size, 0.25 * size, 0}});
    EXPECT_NEAR(uv.x, 0.25, 1e-14) << size;
    EXPECT_NEAR(uv.y, 0.25, 1e-14) << size;
  }
}

TEST(Painted, AZoneThinnerThanItsAnglesShowsThePicture) {
  for (double z = 0.4; z < 0.6; z += 0.01) {
    const auto sphere = *Sphere::create({.z_min_m = z, .z_max_m = std::nextafter(z, 1.0)});
    const auto shape = Painted<Sphere>(sphere, grey(1, 2, {2, 2}));
    EXPECT_NEAR(shape.painted_area.m2.r, 2 * sphere.area(), 1e-12 * sphere.area()) << z;
    const SurfacePoint p = shape.sample({0.25, 0.75});
    EXPECT_EQ(shape.tint(p).r, 2) << z;
    EXPECT_TRUE(std::isfinite(sphere.uv(p).y)) << z;
    EXPECT_GT(shape.light(Rgb(1))->sample_li(Vec3{0, 0, 3}, {0.25, 0.75}).pdf.per_sr, 0) << z;
  }
}

TEST(Painted, AFoldedPatchIsSampledByArea) {
  // A bow tie: its sides cross.
  const auto bow = Painted<PatchMesh>(
      PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}), grey(2, 1, {1, 2}));
  EXPECT_FALSE(bow.is_by_picture());
}

TEST(Painted, RefusesInvalidCorners) {
  const std::vector<Triangle> triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const auto few = TriangleMesh::create(triangle, {{0, 0}, {1, 0}});
  EXPECT_THAT(std::string(few.status().message()),
              HasSubstr("corner_uv has 2 entries, allowed: one for each of 3 corners"));
  const auto bad = TriangleMesh::create(triangle, {{0, 0}, {1, 0}, {0, INFINITY}});
  EXPECT_THAT(std::string(bad.status().message()), HasSubstr("corner_uv[2]"));
}

TEST(Painted, ATexelTimesTheLevelMustFit) {
  const auto light = Painted<Disk>(Disk::create({}), grey(1, 1, {1e10})).light(Rgb(1e300));
  EXPECT_THAT(std::string(light.status().message()),
              HasSubstr("area.radiance of the brightest texel = (inf"));
}

}  // namespace
}  // namespace lucerna::testing
