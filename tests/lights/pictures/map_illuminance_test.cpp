#include "lights/pictures/map_illuminance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lights/maths/vec.h"

namespace lucerna {
namespace {

std::shared_ptr<const SphereMap> map_of(int width, int height, std::vector<Rgbf> texels,
                                        SphereMapping mapping, ImageFilter filter) {
  return *SphereMap::create(*Image::create(width, height, std::move(texels)), mapping, filter);
}

std::shared_ptr<const SphereMap> constant(int width, int height, SphereMapping mapping,
                                          ImageFilter filter) {
  std::vector<Rgbf> texels(static_cast<std::size_t>(width * height), Rgbf(1));
  return map_of(width, height, std::move(texels), mapping, filter);
}

const std::vector<Vec3> kNormals{
    {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, normalized(Vec3{1, -2, 0.5}), normalized(Vec3{-0.3, 0.2, -1})};

/// The exact value is within the stated bound, and that bound is small.
void expect_within(const MapIlluminance& got, const Rgb& lx, double largest_error) {
  EXPECT_LE(std::fabs(luminance(got.lx - lx)), got.error_lx);
  EXPECT_LE(got.error_lx, largest_error * luminance(lx));
}

TEST(MapIlluminance, OfAConstantMapIsPi) {
  for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear})
    for (const Vec3& n : kNormals) {
      for (const auto& map : {constant(4, 4, SphereMapping::kEqualArea, filter),
                              constant(5, 5, SphereMapping::kEqualArea, filter),
                              constant(600, 600, SphereMapping::kEqualArea, filter),
                              constant(8, 3, SphereMapping::kLatitudeLongitude, filter)}) {
        const MapIlluminance got = illuminance_of(*map, Rgb(1, 2, 3), n);
        expect_within(got, Rgb(1, 2, 3) * kPi, 2e-3);
        // Cells of up to 0.0066 rad on each side of the horizon count wholly or not at all.
        EXPECT_NEAR(got.without_cosine.g, 2 * (2 * kPi), 2 * (2 * kPi * 0.0066));
      }
    }
}

TEST(MapIlluminance, OfTheUpperHalfIsThatOfAHemisphereUnderATilt) {
  // A sky of 1 above +y, seen by a surface tilted by t: pi (1 + cos t) / 2.
  std::vector<Rgbf> rows(16 * 8);
  std::fill(rows.begin(), rows.begin() + 16 * 4, Rgbf(1));
  const auto map = map_of(16, 8, rows, SphereMapping::kLatitudeLongitude, ImageFilter::kNearest);
  for (const Vec3& n : kNormals)
    expect_within(illuminance_of(*map, Rgb(1), n), Rgb(kPi * (1 + n.y) / 2), 2e-3);
}

TEST(MapIlluminance, OfARampOverThePolarAngleIsItsIntegral) {
  // Two rows of values 1 and 3 with the bilinear filter.  It is 1 down to pi/4, then rises by 2
  // (theta - pi/4) / (pi/2).  From above y = 0, this is pi times the integral of L sin 2 theta over
  // [0, pi/2].
  const auto map = map_of(2, 2, {Rgbf(1), Rgbf(1), Rgbf(3), Rgbf(3)},
                          SphereMapping::kLatitudeLongitude, ImageFilter::kBilinear);
  // Integral over [pi/4, pi/2] of (theta - pi/4) sin 2 theta, by parts: [-(theta - pi/4) cos(2
  // theta) / 2] + [sin(2 theta) / 4] = pi/8 - 1/4.
  const double slope = 2 / (kPi / 2);
  const double expected = kPi * (1 + slope * (kPi / 8 - 0.25));
  expect_within(illuminance_of(*map, Rgb(1), {0, 1, 0}), Rgb(expected), 1e-3);
}

TEST(MapIlluminance, AStripIsNotCutIntoBillionsOfCells) {
  const auto map = constant(100000, 1, SphereMapping::kLatitudeLongitude, ImageFilter::kNearest);
  expect_within(illuminance_of(*map, Rgb(1), {0.6, 0, 0.8}), Rgb(kPi), 0.05);
}

}  // namespace
}  // namespace lucerna
