#include "lights/maths/spectrum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "lights/maths/cie.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

template <typename Source>
Spectrum spectrum(Source source) {
  absl::StatusOr<Spectrum> made = Spectrum::create(std::move(source));
  if (!made.ok()) throw std::runtime_error(std::string(made.status().message()));
  return *std::move(made);
}

template <typename Source>
std::string error(Source source) {
  return std::string(Spectrum::create(std::move(source)).status().message());
}

/// The colour that a client computes from all wavelengths of the table: 683 lm/W times the 5 nm
/// sum.
template <typename F>
Vec3 summed(F&& value) {
  Vec3 xyz{};
  for (std::size_t k = 0; k < 95; ++k)
    xyz += cie::observer()[k] * (683 * 5 * value(360 + 5 * static_cast<double>(k)));
  return xyz;
}

Vec2 chromaticity(const Vec3& c) { return {c.x / (c.x + c.y + c.z), c.y / (c.x + c.y + c.z)}; }

// CIE 15, table T.4: entries, and the sum 21.371 of each function from 380 nm on.
TEST(Cie, ObserverIsTheTable) {
  const auto o = cie::observer();
  EXPECT_EQ(o[(420 - 360) / 5], (Vec3{0.13438, 0.0040, 0.6456}));
  EXPECT_EQ(o[(555 - 360) / 5].y, 1);
  EXPECT_EQ(o[(600 - 360) / 5], (Vec3{1.0622, 0.6310, 0.0008}));
  Vec3 sum{};
  for (std::size_t k = (380 - 360) / 5; k < o.size(); ++k) sum += o[k];
  EXPECT_NEAR(sum.x, 21.371, 1e-3);
  EXPECT_NEAR(sum.y, 21.371, 1e-3);
  EXPECT_NEAR(sum.z, 21.371, 1e-3);
}

TEST(Cie, IlluminantsAreLinearBetweenEntriesAndZeroBeyond) {
  const cie::Illuminant& d65 = *cie::find_illuminant("D65");
  EXPECT_EQ(cie::value_at(d65, 560), 1);
  EXPECT_EQ(cie::value_at(d65, 300), 0.000341);
  EXPECT_EQ(cie::value_at(d65, 830), 0.603125);
  EXPECT_NEAR(cie::value_at(d65, 562), 1 + 0.4 * (0.981671 - 1), 1e-12);
  EXPECT_EQ(cie::value_at(d65, 299.9), 0);
  EXPECT_EQ(cie::value_at(d65, 830.1), 0);
  EXPECT_EQ(cie::value_at(d65, NAN), 0);
  EXPECT_EQ(cie::find_illuminant("D64"), nullptr);
}

// Chromaticities of CIE 15, tables T.3 and T.6, to the four digits given there.  (F10 is left out,
// because the table of colord-data is off by 3e-4.)
TEST(Spectrum, IlluminantsHaveTheChromaticitiesOfTheCie) {
  const std::tuple<const char*, double, double> kTable[] = {
      {"A", 0.4476, 0.4074},   {"D50", 0.3457, 0.3585}, {"D65", 0.3127, 0.3290},
      {"F1", 0.3131, 0.3371},  {"F2", 0.3721, 0.3751},  {"F3", 0.4091, 0.3941},
      {"F4", 0.4402, 0.4031},  {"F5", 0.3138, 0.3452},  {"F6", 0.3779, 0.3882},
      {"F7", 0.3129, 0.3292},  {"F8", 0.3458, 0.3586},  {"F9", 0.3741, 0.3727},
      {"F11", 0.3805, 0.3769}, {"F12", 0.4370, 0.4042},
  };
  for (const auto& [name, x, y] : kTable) {
    const Spectrum s = spectrum(CieIlluminant{name});
    const Vec3 xyz = summed([&](double nm) { return s.per_lumen(nm); });
    EXPECT_NEAR(xyz.y, 1, 1e-12) << name;
    EXPECT_NEAR(chromaticity(xyz).x, x, 1e-4) << name;
    EXPECT_NEAR(chromaticity(xyz).y, y, 1e-4) << name;
  }
}

// Planckian locus [Wyszecki82]; 2856 K is illuminant A.
TEST(Spectrum, BlackBodiesLieOnThePlanckianLocus) {
  const std::tuple<double, double, double> kLocus[] = {
      {2000, 0.5267, 0.4133}, {2856, 0.4476, 0.4074},  {4000, 0.3805, 0.3768},
      {6500, 0.3135, 0.3237}, {10000, 0.2807, 0.2884},
  };
  for (const auto& [kelvin, x, y] : kLocus) {
    const Spectrum s = spectrum(BlackBody{kelvin});
    const Vec3 xyz = summed([&](double nm) { return s.per_lumen(nm); });
    EXPECT_NEAR(xyz.y, 1, 1e-12) << kelvin;
    EXPECT_NEAR(chromaticity(xyz).x, x, 2e-4) << kelvin;
    EXPECT_NEAR(chromaticity(xyz).y, y, 2e-4) << kelvin;
  }
}

// Computed independently: Planck's law in SI units by quadrature from 10 nm to 0.1 m, with the
// observer a cubic spline at 0.1 nm.  Illuminants are sums of their tables.
TEST(Spectrum, LuminousEfficacyIsThatOfIndependentQuadrature) {
  const std::pair<double, double> kBlackBodies[] = {
      {2000, 1.60588627}, {2700, 12.35567007}, {4000, 54.71259409}, {6500, 95.36296739}};
  for (const auto& [kelvin, lumens_per_watt] : kBlackBodies)
    EXPECT_NEAR(1 / spectrum(BlackBody{kelvin}).watts_per_lumen() / lumens_per_watt, 1, 1e-6)
        << kelvin;
  EXPECT_NEAR(1 / spectrum(BlackBody{6504}).watts_per_lumen(), 95.36706223, 1e-4);
  EXPECT_NEAR(1 / spectrum(CieIlluminant{"D65"}).watts_per_lumen(), 176.80321391, 1e-6);
  EXPECT_NEAR(1 / spectrum(CieIlluminant{"F2"}).watts_per_lumen(), 336.83940055, 1e-6);
}

TEST(Spectrum, BlackBodiesFollowPlanck) {
  // The ratio at two wavelengths depends on c1 and c2 only in exp: at 3000 K.
  const Spectrum s = spectrum(BlackBody{3000});
  const auto planck = [](double nm) {
    return std::pow(nm, -5.0) / (std::exp(1.438776877e7 / (nm * 3000)) - 1);
  };
  for (const double nm : {200.0, 380.0, 700.0, 1500.0, 20000.0})
    EXPECT_NEAR(s.per_lumen(nm) / s.per_lumen(555), planck(nm) / planck(555),
                1e-11 * planck(nm) / planck(555));
  EXPECT_EQ(s.per_lumen(0), 0);
}

TEST(Spectrum, ColoursHaveLuminanceOneAndNoChannelBelowZero) {
  for (const double kelvin : {100.0, 1000.0, 3000.0, 1e7}) {
    const Spectrum s = spectrum(BlackBody{kelvin});
    EXPECT_TRUE(is_finite(s.rgb())) << kelvin;
    EXPECT_GE(std::min({s.rgb().r, s.rgb().g, s.rgb().b}), 0) << kelvin;
    EXPECT_NEAR(luminance(s.rgb()), 1, 1e-12) << kelvin;
    EXPECT_TRUE(std::isfinite(s.watts_per_lumen())) << kelvin;
  }
  EXPECT_TRUE(spectrum(BlackBody{1000}).clipped());
  EXPECT_FALSE(spectrum(BlackBody{3000}).clipped());
}

TEST(Spectrum, TheTableOfD65IsWhite) {
  const Spectrum s = spectrum(CieIlluminant{"D65"});
  EXPECT_NEAR(s.rgb().r, 1, 1e-9);
  EXPECT_NEAR(s.rgb().g, 1, 1e-9);
  EXPECT_NEAR(s.rgb().b, 1, 1e-9);
  EXPECT_FALSE(s.clipped());
}

// Flat from 400 to 700 nm: (x, y) come from the sum of the table with half of its end entries.
TEST(Spectrum, SamplesAreIntegratedExactly) {
  const Spectrum s = spectrum(SampledSpectrum{{400, 700}, {5, 5}});
  double y = 0;
  for (int nm = 400; nm <= 700; nm += 5)
    y += cie::observer()[static_cast<std::size_t>(nm - 360) / 5].y *
         (nm == 400 || nm == 700 ? 0.5 : 1);
  EXPECT_NEAR(s.per_lumen(500), 1 / (683 * 5 * y), 1e-15);
  EXPECT_NEAR(s.watts_per_lumen(), 300 / (683 * 5 * y), 1e-12);
  EXPECT_EQ(s.per_lumen(399), 0);
  EXPECT_EQ(s.per_lumen(701), 0);
  // A line of 0.02 nm between two entries of the table: y is halfway between theirs.
  const Spectrum line = spectrum(SampledSpectrum{{552.49, 552.5, 552.51}, {0, 3, 0}});
  EXPECT_NEAR(1 / line.watts_per_lumen(), 683 * (0.9949501 + 1.0) / 2, 1e-2);
  EXPECT_GT(line.per_lumen(552.5), 0);
}

// A spectrum is refused if its flux factor exceeds the allowed range.  All others have finite
// numbers.
TEST(Spectrum, NumbersAreFiniteUpToTheDarkestSpectra) {
  for (const double kelvin : {100.0, 101.0, 300.0, 1e4, 1e7}) {
    const Spectrum s = spectrum(BlackBody{kelvin});
    EXPECT_GT(s.watts_per_lumen(), 0) << kelvin;
    EXPECT_LT(s.watts_per_lumen(), kMostWattsPerLumen) << kelvin;
    for (double nm = 100; nm <= 1e6; nm *= 1.25) {
      EXPECT_TRUE(std::isfinite(s.per_lumen(nm))) << kelvin << " " << nm;
      EXPECT_GE(s.per_lumen(nm), 0) << kelvin << " " << nm;
    }
  }
  // Almost all of it is invisible: the line at 555 nm has 1e-90 of the power of an infrared line.
  const Spectrum dark =
      spectrum(SampledSpectrum{{554, 555, 556, 1999, 2000, 2001}, {0, 1e-90, 0, 0, 1, 0}});
  EXPECT_NEAR(dark.watts_per_lumen() / (1e90 / 683), 1, 1e-3);
  EXPECT_NEAR(dark.per_lumen(2000) / (1e90 / 683), 1, 1e-3);
  EXPECT_THAT(error(SampledSpectrum{{554, 555, 556, 1999, 2000, 2001}, {0, 1e-110, 0, 0, 1, 0}}),
              HasSubstr("no visible light"));
}

// A single line of the least width in doubles, and 100 000 samples.
TEST(Spectrum, NarrowAndLongTablesAreIntegrated) {
  const double next = std::nextafter(555.0, 1e3), previous = std::nextafter(555.0, 0.0);
  const Spectrum line = spectrum(SampledSpectrum{{previous, 555, next}, {0, 1, 0}});
  EXPECT_NEAR(683 * line.watts_per_lumen(), 1, 1e-9);
  SampledSpectrum samples;
  for (int i = 0; i < 100000; ++i) {
    samples.wavelengths_nm.push_back(300 + 0.01 * i);
    samples.values.push_back(2);
  }
  const Spectrum flat = spectrum(samples);
  const Spectrum two = spectrum(SampledSpectrum{{300, 1299.99}, {1, 1}});
  EXPECT_NEAR(flat.watts_per_lumen() / two.watts_per_lumen(), 1, 1e-9);
  EXPECT_NEAR(flat.per_lumen(600) / two.per_lumen(600), 1, 1e-9);
}

TEST(Spectrum, ScaleOfSamplesChangesNothing) {
  const Spectrum one = spectrum(SampledSpectrum{{400, 500, 700}, {1, 2, 0.5}});
  for (const double scale : {1e-300, 1e300}) {
    const Spectrum s = spectrum(SampledSpectrum{{400, 500, 700}, {scale, 2 * scale, scale / 2}});
    EXPECT_NEAR(s.per_lumen(450) / one.per_lumen(450), 1, 1e-12);
    EXPECT_NEAR(s.watts_per_lumen() / one.watts_per_lumen(), 1, 1e-12);
  }
}

TEST(Spectrum, RefusesInvalidSpectra) {
  EXPECT_THAT(error(BlackBody{99}), HasSubstr("black body of 99 K, allowed: [100, 1e7] K"));
  EXPECT_THAT(error(BlackBody{NAN}), HasSubstr("allowed"));
  EXPECT_THAT(error(CieIlluminant{"F13"}), HasSubstr("unknown illuminant \"F13\", allowed: A B C"));
  EXPECT_THAT(error(SampledSpectrum{{500, 400}, {1, 1}}), HasSubstr("400 nm follows 500"));
  EXPECT_THAT(error(SampledSpectrum{{400, 500}, {1, -1}}), HasSubstr("value -1 at 500 nm"));
  EXPECT_THAT(error(SampledSpectrum{{400, INFINITY}, {1, 1}}), HasSubstr("wavelength inf"));
  EXPECT_THAT(error(SampledSpectrum{{400}, {1, 1}}), HasSubstr("equal numbers"));
  EXPECT_THAT(error(SampledSpectrum{{900, 1000}, {5, 5}}), HasSubstr("no visible light"));
  EXPECT_THAT(error(SampledSpectrum{{400, 700}, {0, 0}}), HasSubstr("no visible light"));
  EXPECT_THAT(error(SampledSpectrum{{555}, {1}}), HasSubstr("no visible light"));
}

TEST(RgbBasis, AddsUpToD65AndIsNeverNegative) {
  const Spectrum d65 = spectrum(CieIlluminant{"D65"});
  for (int nm = 290; nm <= 840; ++nm) {
    const Rgb b = rgb_basis_per_lumen(nm);
    EXPECT_GE(std::min({b.r, b.g, b.b}), 0) << nm;
    EXPECT_NEAR(b.r + b.g + b.b, d65.per_lumen(nm), 1e-12 * d65.per_lumen(nm)) << nm;
  }
}

// The 5 nm sum of each channel's spectrum is that channel, and no other.
TEST(RgbBasis, IntegratesBackToTheSameRgb) {
  const Rgb kColours[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {9, 6, 3}};
  for (const Rgb& c : kColours) {
    const Vec3 xyz = summed([&](double nm) {
      const Rgb b = rgb_basis_per_lumen(nm) * c;
      return b.r + b.g + b.b;
    });
    const Rgb back = rgb_from_xyz(xyz);
    EXPECT_NEAR(back.r, c.r, 1e-9);
    EXPECT_NEAR(back.g, c.g, 1e-9);
    EXPECT_NEAR(back.b, c.b, 1e-9);
    EXPECT_NEAR(xyz.y, luminance(c), 1e-9);
    // By the matrix of Rec. 709 itself, whose white differs from the table's in the fifth digit.
    const double r =
        3.2409699419045213 * xyz.x - 1.5373831775700935 * xyz.y - 0.4986107602930033 * xyz.z;
    const double b =
        0.0556300796969936 * xyz.x - 0.2039769588889765 * xyz.y + 1.0569715142428786 * xyz.z;
    EXPECT_NEAR(r, c.r, 1e-3 * c.max_component());
    EXPECT_NEAR(b, c.b, 1e-3 * c.max_component());
  }
}

// Smooth like reflectances, without spikes: no step between neighbours exceeds a sixth.
TEST(RgbBasis, IsSmooth) {
  const Spectrum d65 = spectrum(CieIlluminant{"D65"});
  for (int nm = 365; nm <= 830; nm += 5) {
    const Rgb step = rgb_basis_per_lumen(nm) / d65.per_lumen(nm) -
                     rgb_basis_per_lumen(nm - 5) / d65.per_lumen(nm - 5);
    EXPECT_LT(std::max({std::fabs(step.r), std::fabs(step.g), std::fabs(step.b)}), 1.0 / 6) << nm;
  }
}

}  // namespace
}  // namespace lucerna
