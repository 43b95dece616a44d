// Row 21: pictures that are black, dark except for one texel, or dominated by one texel.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "tests/lights/extremes/map_pictures.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;

const char* const kPictures = "1e9 and 1e30 among 1, 1 among 1e30, 1e-30 ... 1e9 among 0";

std::string texel_of(const Row& row) {
  return row.text("mapping") + ", " + row.text("bright") + " in " + row.text("background");
}

/// The probability of a texel by running sums in float, over rows and within a row.
float textbook_chance(const Row& row) {
  const auto of = [](const std::array<float, 8>& weights, int k) {
    std::array<float, 9> sums{};
    for (std::size_t i = 0; i < 8; ++i) sums[i + 1] = sums[i] + weights[i];
    const auto i = static_cast<std::size_t>(k);
    return (sums[i + 1] - sums[i]) / sums[8];
  };
  const auto texel = [&](int i, int j) {
    return static_cast<float>(i == 5 && j == 2 ? row["bright"] : row["background"]);
  };
  std::array<float, 8> rows{}, line{};
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) rows[static_cast<std::size_t>(j)] += texel(i, j);
  const int column = static_cast<int>(row["column"]), at = static_cast<int>(row["row"]);
  for (int i = 0; i < 8; ++i) line[static_cast<std::size_t>(i)] = texel(i, at);
  return of(rows, at) * of(line, column);
}

TEST(TexelExtremes, ProbabilitiesOfTexels) {
  Sweep sweep(21, "environment map with one different texel", kPictures, "probability of a texel");
  const ReferenceTable table("bright_texels");
  for (const auto& row : table.rows()) {
    const auto light = sky(spotted_image(row), mapping_of(row), ImageFilter::kNearest);
    const Vec2 middle{(row["column"] + 0.5) / 8, (row["row"] + 0.5) / 8};
    const Vec3 w = direction_from_square(mapping_of(row), middle);
    const double per_sr = light.pdf_li({0, 0, 0}, w).per_sr;
    const double pi = std::numbers::pi, top = pi * row["row"] / 8;
    const double texel_sr = mapping_of(row) == SphereMapping::kEqualArea
                                ? 4 * pi / 64
                                : pi / 4 * 2 * std::sin(top + pi / 16) * std::sin(pi / 16);
    sweep.compare(per_sr * texel_sr, row["chance"], texel_of(row));
    if (mapping_of(row) == SphereMapping::kEqualArea)
      sweep.compare_textbook(textbook_chance(row), row["chance"]);
  }
  sweep.expect_within(1e-14);
}

TEST(TexelExtremes, SampleValuesLeadToTheirTexels) {
  Sweep sweep(21, "environment map with one different texel", kPictures,
              "texel that sample values select");
  const ReferenceTable table("bright_texels");
  for (const auto& row : table.rows()) {
    const auto light = sky(spotted_image(row), mapping_of(row), ImageFilter::kNearest);
    const auto sample = light.sample_li({0, 0, 0}, {row["ux"], row["uy"]});
    const Vec2 p = square_from_direction(mapping_of(row), sample.wi);
    const bool right = std::floor(p.x * 8) == row["column"] && std::floor(p.y * 8) == row["row"];
    sweep.answer(right ? "the right one" : "another: " + texel_of(row));
  }
  sweep.expect_answers("the right one");
}

TEST(TexelExtremes, EverySampleEstimatesTheIntegral) {
  Sweep sweep(21, "environment map with one different texel", kPictures,
              "integral of radiance, estimated by each sample");
  const ReferenceTable table("bright_texels");
  for (const auto& row : table.rows()) {
    const auto light = sky(spotted_image(row), mapping_of(row), ImageFilter::kNearest);
    const auto sample = light.sample_li({0, 0, 0}, {row["ux"], row["uy"]});
    sweep.compare(sample.value.g / sample.pdf.per_sr, row["integral"], texel_of(row));
  }
  sweep.expect_within(1e-14);
}

TEST(TexelExtremes, EveryBilinearSampleEstimatesTheIntegral) {
  Sweep sweep(21, "equal-area environment map, bilinear, with one different texel", kPictures,
              "integral of radiance, estimated by each sample");
  const ReferenceTable table("bright_texels");
  RandomU random(21);
  for (const auto& row : table.rows()) {
    if (mapping_of(row) != SphereMapping::kEqualArea) continue;
    const auto light = sky(spotted_image(row), mapping_of(row), ImageFilter::kBilinear);
    for (int i = 0; i < 100; ++i) {
      const auto sample = light.sample_li({0, 0, 0}, random.pair());
      sweep.compare(sample.value.g / sample.pdf.per_sr, row["integral"], texel_of(row));
    }
  }
  sweep.expect_within(1e-12);
}

/// Compares the powers of the lights that `make(image, row)` makes of the table's pictures with
/// `scale` times their integrals over the sphere.
template <typename F>
void sweep_powers(Sweep& sweep, const SceneSphere& scene, double scale, F&& make) {
  const ReferenceTable table("map_integrals");
  for (const auto& row : table.rows()) {
    const auto image = row["background"] < 0 ? patchy_image(row) : spotted_image(row);
    const auto light = make(image, row);
    const Power exact = light.power(scene), approximate = light.power_approximate(scene);
    const double truth = row["integral"] * scale;
    sweep.compare(exact.lumens.g, truth, texel_of(row));
    EXPECT_LE(std::fabs(approximate.lumens.g - truth), approximate.error_lumens + 1e-12 * truth);
    // The formula of pbrt-v2 and v3: the mean texel times pi R^2 for a sky, 4 pi for a lamp; R is
    // 2.
    if (truth > 0)
      sweep.compare_textbook(static_cast<float>(4 * std::numbers::pi * image->mean().g), truth);
  }
  sweep.expect_within(1e-14);
}

TEST(TexelExtremes, Integrals) {
  Sweep sweep(29, "environment map", "uneven, black, one texel of 1e-30 ... 1e30",
              "power through a disk of 2 m");
  sweep_powers(sweep, {{}, 2}, 4 * std::numbers::pi, [](const auto& image, const Row& row) {
    return sky(image, mapping_of(row), filter_of(row));
  });
}

TEST(TexelExtremes, FluxOfLamps) {
  Sweep sweep(29, "goniometric map", "uneven, black, one texel of 1e-30 ... 1e30", "power");
  sweep_powers(sweep, {}, 1, [](const auto& image, const Row& row) {
    return lamp(image, mapping_of(row), filter_of(row));
  });
}

TEST(TexelExtremes, BlackPictures) {
  Sweep sweep(21, "environment and goniometric map, all black", "both mappings and filters",
              "answer of sample_li and sample_le");
  for (const SphereMapping mapping : {SphereMapping::kEqualArea, SphereMapping::kLatitudeLongitude})
    for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
      const auto black = grey_image(8, 8, [](int, int) { return 0; });
      const auto light = sky(black, mapping, filter);
      const auto lamp_light = lamp(black, mapping, filter);
      for (const double u : {0.0, 0.5, 1.0}) {
        sweep.answer(light.sample_li({0, 0, 0}, {u, u}).reason);
        sweep.answer(light.sample_le({u, u}, {u, u}, {{}, 1}).reason);
        sweep.answer(lamp_light.sample_li({0, 0, 1}, {u, u}).reason);
        sweep.answer(lamp_light.sample_le({u, u}, {u, u}, {}).reason);
        EXPECT_EQ(light.pdf_li({0, 0, 0}, {u, u, 1}).per_sr, 0);
        EXPECT_TRUE(light.le_escaped({}, {u, u, 1}).is_black());
      }
      EXPECT_TRUE(light.power({{}, 1}).lumens.is_black());
    }
  sweep.expect_answers(NoLight::kBlack);
}

}  // namespace
}  // namespace lucerna::testing
