#include "lights/models/projection_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "lights/maths/vec.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna {
namespace {

using testing::relative_difference;

constexpr SceneSphere kScene{{}, 1};

std::shared_ptr<const Image> image(int width, int height, std::vector<Rgbf> texels) {
  return *Image::create(width, height, std::move(texels));
}

ProjectionLightParams thrown(const ProjectedPictureParams& picture) {
  return {.picture = *ProjectedPicture::create(picture), .intensity_cd = Rgb(1)};
}

ProjectionLight light(const ProjectedPictureParams& picture) {
  return *ProjectionLight::create(thrown(picture));
}

double lumens(const ProjectionLight& light) { return luminance(light.power(kScene).lumens); }

/// The solid angle of a rectangle of half sides a and b at distance 1, seen from before its middle.
/// A pyramid of half apex angles alpha and beta covers 4 asin(sin alpha sin beta).
double pyramid_sr(double a, double b) {
  return 4 * std::asin(a / std::hypot(1, a) * b / std::hypot(1, b));
}

TEST(ProjectionLight, UpperLeftOfThePictureIsUpAndLeft) {
  const auto corners = image(2, 2, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}});
  const auto l = light({.image = corners, .fov_rad = 1});
  EXPECT_EQ(l.intensity({-0.1, 0.1, 1}), Rgb(1, 0, 0));
  EXPECT_EQ(l.intensity({0.1, 0.1, 1}), Rgb(0, 1, 0));
  EXPECT_EQ(l.intensity({-0.1, -0.1, 1}), Rgb(0, 0, 1));
  EXPECT_EQ(l.intensity({0.1, -0.1, 1}), Rgb(1, 1, 1));
  EXPECT_EQ(l.intensity({0.1, -0.1, -1}), Rgb());
  // A mirror keeps the picture's own axes: what was right is left.
  auto params = thrown({.image = corners, .fov_rad = 1});
  params.axes.s = {-1, 0, 0};
  EXPECT_EQ(ProjectionLight::create(params)->intensity({-0.1, 0.1, 1}), Rgb(0, 1, 0));
}

// Texels are (7 x + 5 y + 3) mod 11, or a single lit one.  The sums are computed with 60 digits
// (mpmath) from F(x, y) = atan(x y / sqrt(1 + x^2 + y^2)) over each texel's corners in the plane.
// The half side there is tan(fov / 2) for fov = degrees / 180 pi as double rounds it.
TEST(ProjectionLight, PowerNear180DegreesAgreesWithSixtyDigits) {
  constexpr int kMixed = -1;
  const struct {
    double degrees;
    int n, x, y;
    double sr;
  } cases[] = {
      {179.9, 8, kMixed, kMixed, 23.566053204748660475},
      {179.9, 8, 0, 0, 2.9235722847440466368e-5},
      {179.9, 8, 7, 3, 8.1388601928729640379e-5},
      {179.9, 1024, 3, 500, 3.3955614579483081156e-9},
      {179.9999, 8, kMixed, kMixed, 23.561949010368406008},
      {179.9999, 8, 0, 0, 2.9235737849480152128e-8},
      {179.9999, 8, 7, 3, 8.1388706749670433489e-8},
      {179.9999, 1024, 3, 500, 3.3955645262126056712e-12},
      {1 / kPi * 180, 4096, 100, 2000, 4.9714496239098900859e-8},
  };
  for (const auto& c : cases) {
    std::vector<Rgbf> texels;
    for (int y = 0; y < c.n; ++y)
      for (int x = 0; x < c.n; ++x)
        texels.emplace_back(c.x == kMixed ? static_cast<float>((7 * x + 5 * y + 3) % 11)
                                          : (x == c.x && y == c.y ? 1.0 : 0.0));
    const double fov = c.degrees / 180 * kPi;
    const auto l = light({image(c.n, c.n, std::move(texels)), ImageFilter::kNearest, fov});
    EXPECT_LE(relative_difference(lumens(l), c.sr), 2e-15)
        << c.degrees << " degrees, " << c.n << " texels, of them (" << c.x << ", " << c.y << ")";
  }
}

// Row 29 of docs/extremes.md: the cone about a picture of 3:1 is 2.5 times too large.
TEST(ProjectionLight, TextbookPowerWithoutAPictureStatesItsError) {
  const auto l = light({.fov_rad = 0.5, .aspect = 3});
  const double b = std::tan(0.25), a = 3 * b;
  const double cone = 2 * kPi * (1 - 1 / std::sqrt(1 + a * a + b * b));
  const Power approximate = l.power_approximate(kScene);
  EXPECT_NEAR(luminance(approximate.lumens), cone, 1e-12);
  EXPECT_NEAR(approximate.error_lumens, cone - pyramid_sr(a, b), 1e-12);
  EXPECT_GT(cone / pyramid_sr(a, b), 2.3);
}

TEST(ProjectionLight, PbrtsPowerOfAPictureSumsTexelsAtTheirCentres) {
  // One texel of 90 degrees: an area of 4 with cos^3 = 1 at its centre.  It is a face of a cube.
  const auto l = light({.image = image(1, 1, {Rgbf(1)}), .fov_rad = kPi / 2});
  EXPECT_NEAR(luminance(l.power_approximate(kScene).lumens), 4, 1e-12);
  EXPECT_NEAR(lumens(l), 4 * kPi / 6, 1e-12);
  EXPECT_NEAR(l.power_approximate(kScene).error_lumens, 4 - 4 * kPi / 6, 1e-12);
}

TEST(ProjectionLight, ATexelOf1e9LeavesTheOthersTheirShare) {
  std::vector<Rgbf> texels(64 * 64, Rgbf(1));
  texels[64 * 20 + 30] = Rgbf(1e9);
  const auto l = light({.image = image(64, 64, texels), .fov_rad = 1});
  // The others have a share of about 64^2 / 1e9: u is past the bright texel's.
  const auto s = l.sample_le({}, {0.5, 1.0}, kScene);
  EXPECT_EQ(s.value, Rgb(1));
  EXPECT_NEAR(s.pdf_direction.per_sr * lumens(l), 1, 1e-6);
  EXPECT_EQ(l.sample_le({}, {0.5, 0.5}, kScene).value, Rgb(1e9));
}

TEST(ProjectionLight, GivesTheReasonForNoLight) {
  const auto l = *ProjectionLight::create(
      thrown({.image = image(2, 1, {Rgbf(0), Rgbf(1)}), .fov_rad = 1, .aspect = 2}));
  EXPECT_EQ(l.sample_li({0, 0, 0}, {}).reason, NoLight::kDegenerate);
  EXPECT_EQ(l.sample_li({0.1, 0, 1}, {}).reason, NoLight::kNone);
  EXPECT_EQ(l.sample_li({-0.1, 0, 1}, {}).reason, NoLight::kOutsideCone);  // the black texel
  EXPECT_EQ(l.sample_li({0, 5, 1}, {}).reason, NoLight::kOutsideCone);
  EXPECT_EQ(l.sample_li({0.1, 0, -1}, {}).reason, NoLight::kOutsideCone);
  EXPECT_EQ(l.sample_li({1, 0, 0}, {}).reason, NoLight::kOutsideCone);  // in the plane of the point
  EXPECT_EQ(l.sample_li({1e-161, 0, 1e-160}, {}).reason, NoLight::kOutOfRange);
  const auto black =
      *ProjectionLight::create(thrown({.image = image(1, 1, {Rgbf(0)}), .fov_rad = 1}));
  EXPECT_EQ(black.sample_li({0, 0, 1}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(black.sample_le({}, {0.5, 0.5}, kScene).reason, NoLight::kBlack);
  EXPECT_EQ(black.pdf_le({}, {0, 0, 1}, kScene), EmissionPdf{});
  EXPECT_EQ(black.power(kScene).lumens, Rgb());
}

TEST(ProjectionLight, CreateNamesTheInvalidParameter) {
  const auto picture_error = [](const ProjectedPictureParams& p) {
    return std::string(ProjectedPicture::create(p).status().message());
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(picture_error({.fov_rad = 0}), HasSubstr("projection.fov = 0 rad, allowed (0, pi)"));
  EXPECT_THAT(picture_error({.fov_rad = 3.2}), HasSubstr("3.2 rad"));
  EXPECT_THAT(picture_error({.fov_rad = NAN}), HasSubstr("nan rad"));
  EXPECT_THAT(picture_error({.fov_rad = 1, .aspect = 0}), HasSubstr("projection.aspect = 0"));
  EXPECT_THAT(picture_error({.fov_rad = 1e-200}), HasSubstr("1e-200"));
  const auto error = [](const ProjectionLightParams& p) {
    return std::string(ProjectionLight::create(p).status().message());
  };
  EXPECT_THAT(error({}), HasSubstr("projection.picture is missing"));
  auto p = thrown({.image = image(1, 1, {Rgbf(1e30)}), .fov_rad = 1});
  p.intensity_cd = Rgb(1e300);
  EXPECT_THAT(error(p), HasSubstr("intensity of the brightest texel"));
  p = thrown({.fov_rad = 1});
  p.intensity_cd.g = -1;
  EXPECT_THAT(error(p), HasSubstr("projection.intensity = (1, -1, 1) cd"));
  p = thrown({.fov_rad = 1});
  p.axes.t = {0, 1, 0.1};
  EXPECT_THAT(error(p), HasSubstr("at right angles"));
  p.axes.t = {0, 0, 0};
  EXPECT_THAT(error(p), HasSubstr("of any length but 0"));
  p = thrown({.fov_rad = 1});
  p.position_m.x = INFINITY;
  EXPECT_THAT(error(p), HasSubstr("projection.position"));
}

}  // namespace
}  // namespace lucerna
