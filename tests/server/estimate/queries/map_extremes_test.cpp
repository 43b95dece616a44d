// Unusual pictures as the sky.  Each gets numbers as its answer, or an error with file, parameter,
// value and the allowed values.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "server/scene/scene.h"
#include "server/scene/scene_lights.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;

/// A grey .pfm file: `value` at (x, 0), `other` everywhere else.
std::string odd_texel_pfm(int width, int height, float other, float value, int x = 0) {
  std::string bytes = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  for (int row = height; row-- > 0;)
    for (int column = 0; column < width; ++column)
      for (int c = 0; c < 3; ++c) {
        const float v = row == 0 && column == x ? value : other;
        bytes.append(reinterpret_cast<const char*>(&v), sizeof v);
      }
  return bytes;
}

const std::string kLatLong = "\"string mapping\" \"latlong\" ";
const std::string kBilinear = "\"string filter\" \"bilinear\" ";
const std::string kPortal = "\"point3 portal\" [-1 -1 1  -1 1 1  1 1 1  1 -1 1] ";

absl::StatusOr<SceneDescription> load_sky(const std::string& name, const std::string& bytes,
                                          const std::string& parameters) {
  const SceneFiles files;
  files.write(name, bytes);
  files.write("scene.pbrt", "WorldBegin\nLightSource \"infinite\" \"string filename\" \"" + name +
                                "\" " + parameters);
  return files.load("scene.pbrt");
}

/// The irradiance at the origin without a cosine, as the mean of samples.  Checks that all numbers
/// are valid, also for the corners of the unit square.
template <typename Params>
double sampled_irradiance(const Params& params, bool incomplete = false) {
  double sum = 0;
  constexpr int kSide = 64;
  const auto light = create_light({.params = params, .where = {}}, {});
  EXPECT_TRUE(light.ok()) << light.status();
  visit(
      [&](const auto& l) {
        Receiver<double> receiver(0, 0, 0);
        receiver.incomplete = incomplete;
        for (int i = 0; i <= kSide + 1; ++i)
          for (int j = 0; j <= kSide + 1; ++j) {
            // The last two are the ends of the square.  They do not count in the mean.
            const auto u = [&](int k) {
              return k < kSide ? (k + 0.5) / kSide : static_cast<double>(k - kSide);
            };
            const auto s = l.sample_li(receiver, {u(i), u(j)});
            EXPECT_TRUE(is_finite(s.value) && std::isfinite(s.pdf.per_sr));
            EXPECT_GE(s.pdf.per_sr, 0);
            const double pdf = l.pdf_li(receiver, s.wi).per_sr;
            EXPECT_TRUE(std::isfinite(pdf) && pdf >= 0);
            if (s.reason != NoLight::kNone || i >= kSide || j >= kSide) continue;
            EXPECT_GT(s.pdf.per_sr, 0);
            sum += s.value.g / s.pdf.per_sr;
          }
        const Power power = l.power({{}, 1});
        EXPECT_TRUE(is_finite(power.lumens) && std::isfinite(power.error_lumens));
      },
      *light);
  return sum / (kSide * kSide);
}

/// Checks every mapping, filter and portal that takes the picture.
void expect_answers(int width, int height, float other, float value, int x, double expected,
                    double tolerance) {
  const std::string bytes = odd_texel_pfm(width, height, other, value, x);
  for (const std::string& filter : {std::string(), kBilinear})
    for (const std::string& mapping : {std::string(), kLatLong}) {
      if (mapping.empty() && width != height) continue;
      SCOPED_TRACE(filter + mapping);
      const auto scene = load_sky("sky.pfm", bytes, filter + mapping);
      ASSERT_TRUE(scene.ok()) << scene.status();
      const auto p = std::get<ImageInfiniteLightParams>(scene->lights.at(0).params);
      const double sr = p.map->integral().g;
      if (mapping.empty()) {
        EXPECT_NEAR(sr, expected, tolerance * expected);
      }
      EXPECT_NEAR(sampled_irradiance(p), sr, 0.02 * sr);
      sampled_irradiance(p, true);
      const auto through = load_sky("sky.pfm", bytes, filter + mapping + kPortal);
      ASSERT_TRUE(through.ok()) << through.status();
      sampled_irradiance(std::get<PortalLightParams>(through->lights.at(0).params));
    }
}

TEST(SkyExtremes, OneTexel) { expect_answers(1, 1, 0, 3, 0, 3 * 4 * kPi, 1e-12); }

TEST(SkyExtremes, AStripOfAHundredThousand) {
  expect_answers(100000, 1, 1, 1, 0, 0, 0);
  const auto scene = load_sky("sky.pfm", odd_texel_pfm(100000, 1, 1, 1), kLatLong);
  ASSERT_TRUE(scene.ok());
  EXPECT_NEAR(std::get<ImageInfiniteLightParams>(scene->lights.at(0).params).map->integral().g,
              4 * kPi, 1e-9);
}

TEST(SkyExtremes, OneBrightTexelAmongOnesAndAmongBlack) {
  expect_answers(16, 16, 1, 1e9F, 5, 4 * kPi * (1e9 + 255) / 256, 1e-9);
  expect_answers(16, 16, 0, 1e9F, 5, 4 * kPi * 1e9 / 256, 1e-9);
  expect_answers(16, 16, 0, 1e-30F, 5, 4 * kPi * 1e-30 / 256, 1e-6);
}

TEST(SkyExtremes, ABlackPictureIsReportedAsBlack) {
  for (const std::string& parameters : {std::string(), kLatLong, kBilinear, kPortal}) {
    const auto scene = load_sky("sky.pfm", odd_texel_pfm(8, 8, 0, 0), parameters);
    ASSERT_TRUE(scene.ok()) << scene.status();
    const auto light = create_light(scene->lights.at(0), {});
    ASSERT_TRUE(light.ok());
    visit(
        [](const auto& l) {
          EXPECT_EQ(l.sample_li(Receiver<double>(0, 0, 0), {0.5, 0.5}).reason, NoLight::kBlack);
          EXPECT_TRUE(l.power({{}, 1}).lumens.is_black());
        },
        *light);
  }
}

TEST(SkyExtremes, TexelsThatAreNotNumbersLeaveOutTheLightWithTheirPlace) {
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    for (const std::string& parameters : {std::string(), kPortal}) {
      const auto scene = load_sky("sky.pfm", odd_texel_pfm(4, 4, 1, bad, 2), parameters);
      ASSERT_TRUE(scene.ok()) << scene.status();
      EXPECT_TRUE(scene->lights.empty());
      const std::string remark = remarks_of(*scene);
      EXPECT_THAT(remark, HasSubstr("2:24 \"string filename\": sky.pfm: texel (2, 0)"));
      EXPECT_THAT(remark, HasSubstr("allowed: finite"));
    }
  }
}

TEST(SkyExtremes, NegativeTexelsCountAsBlackAndAreRemarkedOn) {
  const auto scene = load_sky("sky.pfm", odd_texel_pfm(4, 4, 1, -2, 2), "");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(remarks_of(*scene), HasSubstr("1 texel"));
  EXPECT_NEAR(std::get<ImageInfiniteLightParams>(scene->lights.at(0).params).map->integral().g,
              4 * kPi * 15 / 16, 1e-12);
}

TEST(SkyExtremes, AlphaIsIgnoredAndRemarkedOn) {
  const SceneFiles files;
  const std::string path = (files.path() / "sky.exr").string();
  const OIIO::ImageSpec spec(2, 2, 4, OIIO::TypeDesc::FLOAT);
  const std::vector<float> values(16, 0.25F);
  const auto file = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(file && file->open(path, spec) && file->write_image(spec.format, values.data()) &&
              file->close());
  files.write("scene.pbrt", "WorldBegin LightSource \"infinite\" \"string filename\" \"sky.exr\"");
  const auto scene = files.load("scene.pbrt");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(remarks_of(*scene), HasSubstr("alpha is ignored"));
  EXPECT_NEAR(std::get<ImageInfiniteLightParams>(scene->lights.at(0).params).map->integral().g,
              0.25 * 4 * kPi, 1e-12);
}

TEST(SkyExtremes, PicturesWithoutTexelsAreRefused) {
  const auto empty = load_sky("sky.pfm", odd_texel_pfm(0, 0, 1, 1), "");
  ASSERT_TRUE(empty.ok()) << empty.status();
  EXPECT_THAT(remarks_of(*empty), HasSubstr("sky.pfm"));
  EXPECT_THAT(message(load_sky("sky.pfm", odd_texel_pfm(100000, 1, 1, 1), "").status()),
              HasSubstr("an equal-area map of 100000 x 1 texels, allowed: square"));
}

TEST(SkyExtremes, ALevelThatOverflowsIsRefused) {
  EXPECT_THAT(
      message(load_sky("sky.pfm", odd_texel_pfm(4, 4, 1, 1e30F), "\"float scale\" 1e10").status()),
      HasSubstr("brightest texel"));
  EXPECT_THAT(
      message(load_sky("sky.pfm", odd_texel_pfm(4, 4, 1, 1e30F), "\"float scale\" 1e10 " + kPortal)
                  .status()),
      HasSubstr("brightest texel"));
}

}  // namespace
}  // namespace lucerna
