#include "lights/models/image_infinite_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lights/maths/vec.h"
#include "lights/pictures/map_illuminance.h"
#include "lights/sampling/sampling.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

std::shared_ptr<const SphereMap> map_of(int n, std::vector<Rgbf> texels,
                                        SphereMapping mapping = SphereMapping::kEqualArea) {
  return *SphereMap::create(*Image::create(n, n, std::move(texels)), mapping,
                            ImageFilter::kNearest);
}

/// 1 towards +z (the middle texels), 0.125 elsewhere.
std::vector<Rgbf> lit_above() {
  std::vector<Rgbf> texels(16, Rgbf(0.125));
  for (const int i : {5, 6, 9, 10}) texels[static_cast<std::size_t>(i)] = Rgbf(4, 2, 1);
  return texels;
}

TEST(ImageInfiniteLight, TurnsMirrorsAndIgnoresEqualScaleAndTranslation) {
  const Transform turned = Transform::translate({5, 6, 7}) * *Transform::scale({3, 3, 3}) *
                           *Transform::rotate(kPi / 2, {0, 1, 0});  // +z to +x
  const auto light = *ImageInfiniteLight::create(
      {.map = map_of(4, lit_above()), .world_from_map = turned, .radiance_cd_m2 = {1, 2, 3}});
  EXPECT_EQ(light.le_escaped({9, 9, 9}, {1, 0, 0}), Rgb(4, 4, 3));
  EXPECT_EQ(light.le_escaped({0, 0, 0}, {0, 0, 1}), Rgb(0.125, 0.25, 0.375));
  const auto mirrored = *ImageInfiniteLight::create(
      {.map = map_of(4, lit_above()), .world_from_map = *Transform::scale({1, 1, -1})});
  EXPECT_EQ(mirrored.le_escaped({}, {0, 0, -1}), Rgb(4, 2, 1));
  EXPECT_EQ(mirrored.le_escaped({}, {0, 0, 1}), Rgb(0.125));
}

TEST(ImageInfiniteLight, AnIncompleteDensityLeavesOutRadianceBelowTheMean) {
  const auto light = *ImageInfiniteLight::create({.map = map_of(4, lit_above())});
  Receiver receiver(0, 0, 0);
  EXPECT_GT(light.pdf_li(receiver, {0, 0, -1}).per_sr, 0);
  receiver.incomplete = true;
  EXPECT_EQ(light.pdf_li(receiver, {0, 0, -1}).per_sr, 0);
  // All samples lie in the four middle texels, pi sr.
  EXPECT_NEAR(light.pdf_li(receiver, {0, 0, 1}).per_sr, 1 / kPi, 1e-6);
  EXPECT_NEAR(light.sample_li(receiver, {0.3, 0.9}).pdf.per_sr, 1 / kPi, 1e-6);
  // A constant map is nowhere above its mean: all of it is sampled.
  const auto constant =
      *ImageInfiniteLight::create({.map = map_of(4, std::vector<Rgbf>(16, Rgbf(2)))});
  EXPECT_NEAR(constant.pdf_li(receiver, {0, 0, -1}).per_sr, 1 / (4 * kPi), 1e-7);
}

/// The illuminance on a surface that faces +z, from a light sample and a cosine-distributed
/// direction, combined by the power heuristic: mean and standard error.
struct Weighted {
  double lx, error;
};
Weighted weighted_illuminance(const ImageInfiniteLight& light, bool incomplete) {
  constexpr int kSamples = 200000;
  testing::RandomU random(17);
  Receiver receiver(0, 0, 0);
  receiver.incomplete = incomplete;
  const auto weight = [](double a, double b) { return a * a / (a * a + b * b); };
  double sum = 0, squares = 0;
  for (int i = 0; i < kSamples; ++i) {
    double x = 0;
    if (const auto s = light.sample_li(receiver, random.pair());
        s.reason == NoLight::kNone && s.wi.z > 0) {
      const double pdf = s.pdf.per_sr, by_cosine = s.wi.z / kPi;
      x += s.value.g * s.wi.z / pdf * weight(pdf, by_cosine);
    }
    const Vec2 d = sample_concentric_disk(random.pair());
    const Vec3 w{d.x, d.y, std::sqrt(std::fmax(1e-12, 1 - d.x * d.x - d.y * d.y))};
    x += light.le_escaped({}, w).g * kPi * weight(w.z / kPi, light.pdf_li(receiver, w).per_sr);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kSamples;
  return {mean, std::sqrt((squares / kSamples - mean * mean) / kSamples)};
}

TEST(ImageInfiniteLight, AnIncompleteDensityWithCosineDirectionsIsUnbiasedAndBetter) {
  // A sun and a sky whose upper half is ten times the lower, on a plane that sees half of each.
  std::vector<Rgbf> texels(16 * 16, Rgbf(1));
  std::fill(texels.begin(), texels.begin() + 8 * 16, Rgbf(0.1));
  texels[8 * 16 + 5] = Rgbf(300);
  const auto map = map_of(16, texels);
  const auto light = *ImageInfiniteLight::create({.map = map});
  const MapIlluminance expected = illuminance_of(*map, Rgb(1), {0, 0, 1});
  const Weighted complete = weighted_illuminance(light, false);
  const Weighted incomplete = weighted_illuminance(light, true);
  // 5.5 standard errors, each exceeded by chance less than once in 1e7.
  EXPECT_NEAR(complete.lx, expected.lx.g, 5.5 * complete.error + expected.error_lx);
  EXPECT_NEAR(incomplete.lx, expected.lx.g, 5.5 * incomplete.error + expected.error_lx);
  RecordProperty("variance_ratio", std::to_string(std::pow(incomplete.error / complete.error, 2)));
  EXPECT_LT(incomplete.error, complete.error);
}

TEST(ImageInfiniteLight, ApproximatePowerOfLatitudeLongitudeLacksFourPi) {
  const auto map = map_of(2, std::vector<Rgbf>(4, Rgbf(3)), SphereMapping::kLatitudeLongitude);
  const auto light = *ImageInfiniteLight::create({.map = map});
  const SceneSphere scene{{}, 2};
  EXPECT_NEAR(light.power(scene).lumens.r, 3 * 4 * kPi * (4 * kPi), 1e-10);
  EXPECT_NEAR(light.power_approximate(scene).lumens.r, 3 * (4 * kPi), 1e-12);
  EXPECT_NEAR(light.power_approximate(scene).error_lumens, 3 * (4 * kPi - 1) * (4 * kPi), 1e-9);
}

TEST(ImageInfiniteLight, CreateNamesTheInvalidParameter) {
  const auto error = [](const ImageInfiniteLightParams& p) {
    return std::string(ImageInfiniteLight::create(p).status().message());
  };
  EXPECT_THAT(error({}), ::testing::HasSubstr("infinite.map"));
  const auto map = map_of(4, lit_above());
  EXPECT_THAT(error({.map = map, .radiance_cd_m2 = {-1, 0, 0}}), ::testing::HasSubstr("-1"));
  EXPECT_THAT(error({.map = map, .radiance_cd_m2 = Rgb(1e308)}),
              ::testing::HasSubstr("brightest texel"));
}

}  // namespace
}  // namespace lucerna
