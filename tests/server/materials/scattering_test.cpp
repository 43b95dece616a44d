// What every scattering function must satisfy: densities, weights, reciprocity, energy.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/sampling/sampling.h"
#include "server/materials/fresnel.h"
#include "tests/lights/sample_statistics.h"
#include "tests/server/materials/every_scattering.h"

namespace lucerna::testing {
namespace {

using Direction = Vec3;

Direction at_angle(double degrees, double azimuth = 0.7) {
  const double a = degrees * kPi / 180;
  return {std::sin(a) * std::cos(azimuth), std::sin(a) * std::sin(azimuth), std::cos(a)};
}

/// Both sides, from the normal to grazing.
std::vector<Direction> eyes() {
  std::vector<Direction> all;
  for (const double degrees : {0.0, 50.0, 85.0, 110.0, 180.0}) all.push_back(at_angle(degrees));
  return all;
}

ScatterValues random_values(RandomU& random) {
  const double choice = double{random.next()}, x = double{random.next()}, y = double{random.next()};
  return {choice, {x, y}};
}

constexpr int kRows = 24, kColumns = 24;

/// The equal-area bin of a direction: height, and azimuth.
std::size_t bin_of(const Direction& w) {
  const int row = std::clamp(static_cast<int>((w.z + 1) / 2 * kRows), 0, kRows - 1);
  const double turn = std::atan2(w.y, w.x) / (2 * kPi);
  const int column =
      std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kColumns), 0, kColumns - 1);
  return static_cast<std::size_t>(row * kColumns + column);
}

/// The integral of the density over each bin, by a midpoint rule.
std::vector<double> integrals(const Bsdf& bsdf, const Direction& wo) {
  constexpr int kFiner = 80, kTurns = 24;
  std::vector<double> sums(kRows * kColumns);
  for (int row = 0; row < kRows; ++row) {
    // Equal steps of the angle, since lobes near the poles are narrow.
    const double from = std::acos(2.0 * (row + 1) / kRows - 1),
                 to = std::acos(2.0 * row / kRows - 1);
    for (int i = 0; i < kFiner; ++i) {
      const double angle = from + (to - from) * (i + 0.5) / kFiner;
      const double area = std::sin(angle) * (to - from) / kFiner * 2 * kPi / (kColumns * kTurns);
      for (int j = 0; j < kColumns * kTurns; ++j) {
        const double turn = 2 * kPi * (j + 0.5) / (kColumns * kTurns);
        const Direction wi{std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                           std::cos(angle)};
        sums[static_cast<std::size_t>(row * kColumns + j / kTurns)] +=
            bsdf.pdf(wo, wi).per_sr * area;
      }
    }
  }
  return sums;
}

TEST(Scattering, SamplesFollowTheirDensity) {
  for (const auto& s : every_scattering()) {
    if (s.bsdf.all_delta()) continue;
    for (const Direction& wo : eyes()) {
      RandomU random(1);
      constexpr int kSamples = 50'000;
      std::vector<double> counts(kRows * kColumns), expected = integrals(s.bsdf, wo);
      // The last bin counts tries without a direction of a density.
      double rest = 1;
      for (double& e : expected) {
        rest -= e;
        e *= kSamples;
      }
      expected.push_back(std::max(0.0, rest) * kSamples);
      counts.push_back(0);
      int found = 0;
      for (int i = 0; i < kSamples; ++i) {
        const auto sample = s.bsdf.sample(wo, random_values(random));
        if (!sample || sample->delta) {
          ++counts.back();
          continue;
        }
        ++found;
        ++counts[bin_of(sample->wi)];
      }
      ASSERT_GT(found, 0) << s.name;
      EXPECT_GT(chi_square_p_value(counts, expected), 1e-5) << s.name << " from z = " << wo.z;
    }
  }
}

// The mean over all choices of what samples of single directions bring is the share of these.
TEST(Scattering, SingleDirectionsHaveTheShareOfTheirSamples) {
  int smooth = 0;
  for (const auto& s : every_scattering())
    for (const Direction& wo : eyes()) {
      constexpr int kChoices = 100'000;
      Rgb sampled[2];
      for (int i = 0; i < kChoices; ++i) {
        const auto sample = s.bsdf.sample(wo, {(i + 0.5) / kChoices, {0.3, 0.6}});
        if (!sample || !sample->delta) continue;
        sampled[same_side(wo, sample->wi) ? 0 : 1] += sample->weight * (1.0 / kChoices);
      }
      for (const int side : {0, 1}) {
        const Rgb share = s.bsdf.single(wo, side == 0 ? Side::kReflected : Side::kTransmitted);
        smooth += share.is_black() ? 0 : 1;
        // A choice at the limit between two lobes.
        const double error = 1e-12 + 4e-5 * std::fmax(1, share.max_component());
        EXPECT_NEAR(share.r, sampled[side].r, error) << s.name << " from z = " << wo.z;
        EXPECT_NEAR(share.g, sampled[side].g, error) << s.name << " from z = " << wo.z;
        EXPECT_NEAR(share.b, sampled[side].b, error) << s.name << " from z = " << wo.z;
      }
    }
  EXPECT_GT(smooth, 20);
}

TEST(Scattering, WeightsAreValueOverDensity) {
  for (const auto& s : every_scattering()) {
    RandomU random(2);
    for (const Direction& wo : eyes())
      for (int i = 0; i < 2000; ++i) {
        const auto sample = s.bsdf.sample(wo, random_values(random));
        if (!sample) continue;
        ASSERT_NEAR(length(sample->wi), 1, 1e-12) << s.name;
        const double pdf = s.bsdf.pdf(wo, sample->wi).per_sr;
        if (sample->delta) {
          ASSERT_EQ(sample->pdf.per_sr, 0) << s.name;
          continue;
        }
        ASSERT_NEAR(pdf / sample->pdf.per_sr, 1, 1e-9) << s.name;
        const Rgb value = s.bsdf.value(wo, sample->wi);
        for (const auto channel : {&Rgb::r, &Rgb::g, &Rgb::b})
          ASSERT_NEAR(value.*channel / pdf, sample->weight.*channel,
                      1e-7 * (sample->weight.*channel) + 1e-12)
              << s.name << " from z = " << wo.z << " to z = " << sample->wi.z;
      }
  }
}

/// f, as the mean over directions nearby where it is an estimate.
double f_of(const NamedScattering& s, const Direction& wo, const Direction& wi) {
  const int repeats = s.is_estimate ? 100'000 : 1;
  double sum = 0;
  RandomU random(3);
  for (int i = 0; i < repeats; ++i) {
    Direction o = wo, w = wi;
    if (s.is_estimate) {
      // Each change of the directions is another random walk.
      o = normalized(o + Direction{1e-6 * double{random.next()}, 1e-6 * double{random.next()}, 0});
      w = normalized(w + Direction{1e-6 * double{random.next()}, 1e-6 * double{random.next()}, 0});
    }
    sum += s.bsdf.value(o, w).g / std::fabs(w.z);
  }
  return sum / repeats;
}

TEST(Scattering, IsReciprocal) {
  for (const auto& s : every_scattering()) {
    RandomU random(4);
    const int pairs = s.is_estimate ? 3 : 400;
    for (int i = 0; i < pairs; ++i) {
      const Direction wo = sample_uniform_sphere(random.pair());
      const Direction wi = sample_uniform_sphere(random.pair());
      // Radiance over the square of the index is what refraction keeps.
      const auto squared_index = [&](const Direction& w) { return w.z < 0 ? s.eta * s.eta : 1; };
      const double there = f_of(s, wo, wi) / squared_index(wo),
                   back = f_of(s, wi, wo) / squared_index(wi);
      const double tolerance = s.is_estimate ? 0.05 : 1e-9;
      EXPECT_NEAR(there, back, tolerance * std::max(there, back) + 1e-12) << s.name;
    }
  }
}

TEST(Scattering, ScattersAtMostAllLight) {
  for (const auto& s : every_scattering())
    for (const Direction& wo : eyes()) {
      RandomU random(5);
      constexpr int kSamples = 40'000;
      double sum = 0, squares = 0;
      for (int i = 0; i < kSamples; ++i) {
        const auto sample = s.bsdf.sample(wo, random_values(random));
        if (!sample) continue;
        double x = sample->weight.max_component();
        // Refraction compresses radiance.
        if (!same_side(wo, sample->wi)) x *= wo.z > 0 ? s.eta * s.eta : 1 / (s.eta * s.eta);
        sum += x;
        squares += x * x;
      }
      const double mean = sum / kSamples,
                   error = std::sqrt(std::fmax(0, squares / kSamples - mean * mean) / kSamples);
      EXPECT_LE(mean, 1 + 5 * error + 1e-9) << s.name << " from z = " << wo.z;
      EXPECT_GT(mean, 0) << s.name;
      if (s.absorbs_nothing && s.bsdf.all_delta()) {
        EXPECT_NEAR(mean, 1, 1e-9) << s.name;
      }
    }
}

TEST(Scattering, NumbersAreFiniteAtAllRoughnessAndGrazingAngles) {
  for (const double x : {0.0, 1e-4, 1.1e-3, 0.01, 0.5, 1.0})
    for (const double y : {0.0, 1.1e-3, 1.0})
      for (const auto& s : every_scattering(x, y)) {
        RandomU random(6);
        for (const double z : {1e-6, -1e-6, 1e-3, 1.0})
          for (int i = 0; i < 200; ++i) {
            const Direction wo{std::sqrt(1 - z * z), 0, z};
            const auto sample = s.bsdf.sample(wo, random_values(random));
            if (!sample) continue;
            ASSERT_TRUE(is_finite(sample->weight) && is_finite(sample->wi) &&
                        std::isfinite(sample->pdf.per_sr))
                << s.name << " of roughness " << x << ", " << y << " from z = " << z;
            const Direction low = normalized(Direction{-1, 1e-3 * i, i % 2 == 0 ? 1e-6 : -1e-6});
            ASSERT_TRUE(is_finite(s.bsdf.value(wo, low)) &&
                        std::isfinite(s.bsdf.pdf(wo, low).per_sr))
                << s.name << " of roughness " << x << ", " << y << " from z = " << z;
          }
      }
}

TEST(Scattering, LightGoesStraightOnBetweenAlmostEqualIndices) {
  for (const double more : {0.0, 1e-12, 1e-9, 1e-6}) {
    const Dielectric glass(1 + more, 0, 0);
    for (const double degrees : {0.0, 30.0, 80.0, 100.0, 179.0}) {
      const Direction wo = at_angle(degrees);
      const auto sample = glass.sample(wo, {0.5, {}});
      ASSERT_TRUE(sample.has_value());
      // Snell's law turns the direction by the change of the index times the tangent.
      const double turn = more * std::fabs(std::tan(degrees * kPi / 180)) * 1.1 + 1e-15;
      EXPECT_LE(length(sample->wi + wo), turn) << more << " at " << degrees << " degrees";
    }
  }
}

/// A boundary that nothing absorbs, over a base of reflectance 1, returns all light.  Else: a
/// series of reflections below the boundary.  Its means over the cosine are integrals of one
/// variable.
TEST(Scattering, CoatedDiffuseSurfacesReflectAsTheSeriesOfReflections) {
  struct Coat {
    double reflectance, alpha, thickness;
  };
  for (const Coat& c : {Coat{1, 0, 0}, Coat{0.5, 0, 0}, Coat{0.5, 2e-3, 0}, Coat{0.5, 0, 0.2},
                        Coat{0.8, 2e-3, 1}}) {
    // Light that the base scatters: what returns to it, and what leaves the coat.
    double back = 0, out = 0;
    constexpr int kSteps = 100'000;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = std::sqrt((i + 0.5) / kSteps), left = std::exp(-c.thickness / cosine);
      const double fresnel = fresnel_dielectric(-cosine, 1.5);
      back += fresnel * left * left / kSteps;
      out += (1 - fresnel) * left / kSteps;
    }
    for (const double degrees : {5.0, 45.0, 75.0}) {
      const auto coat = coated_diffuse(c.alpha, c.reflectance, c.thickness);
      const Direction wo = at_angle(degrees);
      RandomU random(8);
      constexpr int kSamples = 60'000;
      double sum = 0, squares = 0;
      for (int i = 0; i < kSamples; ++i) {
        const auto sample = coat.sample(wo, random_values(random));
        const double x = sample ? sample->weight.g : 0;
        sum += x;
        squares += x * x;
      }
      const double mean = sum / kSamples,
                   error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
      const double outside = fresnel_dielectric(wo.z, 1.5);
      const double in = std::exp(-c.thickness * 1.5 / std::sqrt(1.25 + wo.z * wo.z));
      const double right =
          outside + (1 - outside) * in * c.reflectance * out / (1 - c.reflectance * back);
      EXPECT_NEAR(mean, right, 4 * error + 2e-3) << c.reflectance << ", " << c.alpha << ", "
                                                 << c.thickness << ", " << degrees << " degrees";
    }
  }
}

/// Reflectances of walks that connect to the light from its end only, which need no weights: means
/// of 2 million samples, +- 1e-4.
TEST(Scattering, RoughCoatsAgreeWithConnectionsFromOneEnd) {
  struct Case {
    double alpha, degrees, reflected;
  };
  for (const Case& c : {Case{0.1, 10, 0.29934}, Case{0.1, 45, 0.30652}, Case{0.1, 75, 0.40378},
                        Case{0.3, 10, 0.27102}, Case{0.3, 45, 0.27256}, Case{0.3, 75, 0.29982}}) {
    const auto coat = coated_diffuse(c.alpha, 0.5, 0.01);
    RandomU random(9);
    constexpr int kSamples = 200'000;
    double sum = 0, squares = 0;
    for (int i = 0; i < kSamples; ++i) {
      const auto sample = coat.sample(at_angle(c.degrees), random_values(random));
      const double x = sample ? sample->weight.g : 0;
      sum += x;
      squares += x * x;
    }
    const double mean = sum / kSamples,
                 error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
    EXPECT_NEAR(mean, c.reflected, 4 * error + 1e-4) << c.alpha << ", " << c.degrees << " degrees";
  }
}

TEST(Fresnel, RefractionFollowsSnellsLaw) {
  for (const double eta : {1.0 / 2.4, 0.9, 1.0, 1.33, 2.4})
    for (const double degrees : {0.0, 20.0, 60.0, 89.0, 120.0, 170.0}) {
      const Direction w = at_angle(degrees);
      const double relative = w.z > 0 ? eta : 1 / eta;  // beyond over this side
      const double sine = std::hypot(w.x, w.y) / relative;
      const auto refracted = refract(w, Direction{0, 0, 1}, eta);
      ASSERT_EQ(refracted.has_value(), sine < 1) << eta << ", " << degrees << " degrees";
      if (!refracted) continue;
      const Direction& t = refracted->w;
      EXPECT_NEAR(t.x, -w.x / relative, 1e-12) << eta << ", " << degrees << " degrees";
      EXPECT_NEAR(t.y, -w.y / relative, 1e-12);
      EXPECT_NEAR(t.z, (w.z > 0 ? -1 : 1) * std::sqrt(1 - sine * sine), 1e-12);
      EXPECT_EQ(refracted->eta, relative);
    }
}

TEST(Fresnel, MatchesKnownReflectances) {
  EXPECT_NEAR(fresnel_dielectric(1.0, 1.5), 0.04, 1e-15);
  EXPECT_NEAR(fresnel_dielectric(-1.0, 1.5), 0.04, 1e-15);
  EXPECT_EQ(fresnel_dielectric(-0.5, 1.5), 1);  // total reflection
  // No light polarised in the plane of incidence returns at Brewster's angle.
  const double brewster = 1 / std::sqrt(1 + 1.5 * 1.5);
  const double across = (brewster - 1.5 * (brewster * 1.5)) / (brewster + 1.5 * (brewster * 1.5));
  EXPECT_NEAR(fresnel_dielectric(brewster, 1.5), across * across / 2, 1e-12);
  // ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)
  EXPECT_NEAR(fresnel_conductor(1.0, Rgb(0.2), Rgb(3)).g, 9.64 / 10.44, 1e-12);
  // Without absorption a metal is a dielectric.
  for (const double cosine : {0.01, 0.3, 0.9})
    EXPECT_NEAR(fresnel_conductor(cosine, Rgb(1.5), Rgb(0)).g, fresnel_dielectric(cosine, 1.5),
                1e-12);
}

}  // namespace
}  // namespace lucerna::testing
