// The surface of glTF files, against closed forms.
#include "server/materials/metallic_roughness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/materials/conductor.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

using Params = MetallicRoughnessParams;
using Surface = MetallicRoughness;
struct Sheet : MetallicRoughness {
  explicit Sheet(const Params& params) : MetallicRoughness(params, Side::kBoth) {}
};
using Direction = Vec3;
using Colour = Rgb;

constexpr Direction kUp{0, 0, 1};

Direction tilted(double degrees) {
  const double a = degrees * kPi / 180;
  return {std::sin(a), 0, std::cos(a)};
}

double schlick(double cosine) { return std::pow(1 - cosine, 5); }

struct Albedo {
  double reflected, passed, error;
};

/// The mean weight on each side, green, with the larger standard error of both.
template <typename S>
Albedo albedo(const S& surface, const Direction& wo, int samples = 20'000) {
  RandomU random(1);
  double sums[2]{}, squares[2]{};
  for (int i = 0; i < samples; ++i) {
    const double choice = double{random.next()}, x = double{random.next()},
                 y = double{random.next()};
    const auto s = surface.sample(wo, {choice, {x, y}});
    if (!s) continue;
    const int side = same_side(wo, s->wi) ? 0 : 1;
    sums[side] += s->weight.g;
    squares[side] += s->weight.g * s->weight.g;
  }
  const auto error = [&](int side) {
    const double mean = sums[side] / samples;
    return std::sqrt(std::fmax(0, squares[side] / samples - mean * mean) / samples);
  };
  return {sums[0] / samples, sums[1] / samples, std::fmax(error(0), error(1))};
}

// At the normal the density of facets is 1 / (pi alpha^2), and none is hidden.
TEST(MetallicRoughness, AMetalHasItsBaseColourAlongTheNormal) {
  const Surface metal(Params{.base = {0.9, 0.6, 0.2}, .metallic = 1, .alpha = {0.25, 0.25}});
  const Colour value = metal.value(kUp, kUp);
  const double facets = 1 / (4 * kPi * 0.25 * 0.25);
  EXPECT_NEAR(value.r, 0.9 * facets, 1e-12);
  EXPECT_NEAR(value.b, 0.2 * facets, 1e-12);
}

TEST(MetallicRoughness, AMetalIsWhiteAtGrazingAngles) {
  const Surface mirror(Params{.base = {0.5, 0.2, 0}, .metallic = 1});
  EXPECT_TRUE(mirror.all_delta());
  for (const double degrees : {0.0, 45.0, 80.0, 89.9}) {
    const auto s = mirror.sample(tilted(degrees), {0.5, {}});
    ASSERT_TRUE(s && s->delta);
    const double white = schlick(tilted(degrees).z);
    EXPECT_NEAR(s->weight.g, 0.2 + 0.8 * white, 1e-12);
    EXPECT_NEAR(s->weight.b, white, 1e-12);
  }
}

TEST(MetallicRoughness, WithoutReflectingFacetsItIsDiffuse) {
  const Params p{.base = {0.8, 0.5, 0.1}, .alpha = {0.3, 0.3}, .f0 = Colour(0.0), .f90 = 0};
  const Surface surface(p);
  for (const double degrees : {0.0, 40.0, 85.0}) {
    const Direction wi = tilted(degrees);
    EXPECT_NEAR(surface.value(kUp, wi).g, 0.5 * wi.z / kPi, 1e-15);
    EXPECT_NEAR(surface.pdf(kUp, wi).per_sr, wi.z / kPi, 1e-15);
  }
}

// The specification's sum along the normal: 0.04 + 0.96 base.
TEST(MetallicRoughness, ASmoothDielectricReflectsWhatItsFacetsLeave) {
  for (const double base : {1.0, 0.5})
    for (const double degrees : {0.0, 45.0, 75.0, 89.0}) {
      const Direction wo = tilted(degrees);
      const double facets = 0.04 + 0.96 * schlick(wo.z);
      const Albedo a = albedo(Surface(Params{.base = Colour(base)}), wo);
      EXPECT_NEAR(a.reflected, facets + base * (1 - facets), 4 * a.error + 1e-9) << degrees;
    }
}

TEST(MetallicRoughness, AWhiteDielectricReflectsAllLightAtAnyRoughness) {
  for (const double roughness : {0.1, 0.2, 0.5, 0.8, 1.0})
    for (const double degrees : {0.0, 30.0, 60.0, 80.0, 88.0})
      for (const double f0 : {0.0, 0.04, 0.3}) {
        const double alpha = roughness * roughness;
        const Albedo a = albedo(Surface(Params{.alpha = {alpha, alpha}, .f0 = Colour(f0)}),
                                tilted(degrees), 100'000);
        EXPECT_NEAR(a.reflected, 1, 4 * a.error + 4e-3)
            << roughness << " at " << degrees << " degrees, f0 " << f0;
      }
}

TEST(MetallicRoughness, APaneReflectsOrPasses) {
  const Sheet pane(Params{.base = Colour(0.5), .transmission = 1});
  EXPECT_TRUE(pane.all_delta());
  for (const double degrees : {0.0, 60.0, 120.0}) {
    const Direction wo = tilted(degrees);
    const double facets = 0.04 + 0.96 * schlick(std::fabs(wo.z));
    const Albedo a = albedo(pane, wo);
    EXPECT_NEAR(a.reflected, facets, 4 * a.error + 1e-9) << degrees;
    EXPECT_NEAR(a.passed, 0.5 * (1 - facets), 4 * a.error + 1e-9) << degrees;
    const auto last = pane.sample(wo, {0.999, {}});
    ASSERT_TRUE(last && last->delta);
    EXPECT_NEAR(length(last->wi + wo), 0, 1e-15);
  }
}

TEST(MetallicRoughness, TransmissionIsAShareOfTheDiffusePart) {
  const Sheet sheet(Params{.transmission = 0.25});
  const Albedo a = albedo(sheet, kUp, 100'000);
  EXPECT_NEAR(a.passed, 0.25 * 0.96, 4 * a.error);
  EXPECT_NEAR(a.reflected, 0.04 + 0.75 * 0.96, 4 * a.error);
  // Rough sheets spread light about the direction straight on.
  const Sheet rough(Params{.alpha = {0.2, 0.2}, .f0 = Colour(0.0), .f90 = 0, .transmission = 1});
  EXPECT_NEAR(rough.value(kUp, -kUp).g, 1 / (4 * kPi * 0.04), 1e-12);
  EXPECT_EQ(rough.value(kUp, kUp).g, 0);
  // Metals let nothing through.
  EXPECT_EQ(albedo(Sheet(Params{.metallic = 1, .transmission = 1}), kUp).passed, 0);
}

TEST(MetallicRoughness, ACoatDarkensWhatIsBelow) {
  for (const double degrees : {0.0, 50.0, 85.0}) {
    const Direction wo = tilted(degrees);
    const double coat = 0.5 * (0.04 + 0.96 * schlick(wo.z));
    const Params mirror{.base = Colour(0.3), .metallic = 1, .coat = 0.5};
    const double below = 0.3 + 0.7 * schlick(wo.z);
    const Albedo a = albedo(Surface(mirror), wo);
    EXPECT_NEAR(a.reflected, coat + (1 - coat) * below, 4 * a.error + 1e-9) << degrees;
  }
  // A rough coat has facets of its own.
  const Params black{.base = Colour(0.0),
                     .alpha = {1, 1},
                     .f0 = Colour(0.0),
                     .f90 = 0,
                     .coat = 1,
                     .coat_alpha = 0.1};
  EXPECT_NEAR(Surface(black).value(kUp, kUp).g, 0.04 / (4 * kPi * 0.01), 1e-12);
}

TEST(MetallicRoughness, ATurnMovesTheAxesOfRoughness) {
  const Params along{.metallic = 1, .alpha = {0.4, 0.1}};
  Params turned = along, across = along;
  turned.turn_rad = kPi / 2;
  std::swap(across.alpha.x, across.alpha.y);
  const Direction wo = tilted(20), wi = normalized(Direction{0.3, 0.2, 0.9});
  EXPECT_NEAR(Surface(turned).value(wo, wi).g, Surface(across).value(wo, wi).g, 1e-12);
  EXPECT_GT(std::fabs(Surface(along).value(wo, wi).g - Surface(across).value(wo, wi).g), 0.01);
  // An eighth of a turn, counter-clockwise: wide along (1, 1).
  turned.turn_rad = kPi / 4;
  const double s = std::sin(0.5) / std::sqrt(2), c = std::cos(0.5);
  EXPECT_GT(Surface(turned).value(kUp, {s, s, c}).g, 5 * Surface(turned).value(kUp, {s, -s, c}).g);
}

TEST(FacetAlbedo, OfSmoothSurfacesIsSchlicksFormula) {
  for (const double cosine : {0.0, 0.02, 0.5, 1.0}) {
    EXPECT_EQ(facet_albedo(cosine, 0.0).all, 1);
    EXPECT_NEAR(facet_albedo(cosine, 0.0).schlick, schlick(cosine), 2e-3) << cosine;
  }
  // The integral of 2 c (1 - c)^5.
  EXPECT_NEAR(mean_facet_albedo(0.0).schlick, 1 / 21.0, 1e-3);
  EXPECT_NEAR(mean_facet_albedo(0.0).all, 1, 1e-12);
}

TEST(FacetAlbedo, IsWhatWhiteMetalsReflect) {
  // A metal of infinite index reflects all light at each facet.
  for (const double alpha : {0.04, 0.3, 1.0})
    for (const double degrees : {0.0, 33.0, 60.0, 85.0}) {
      const Direction wo = tilted(degrees);
      const Albedo a = albedo(Conductor(Colour(1.0), Colour(1e9), alpha, alpha), wo, 200'000);
      EXPECT_NEAR(facet_albedo(wo.z, alpha).all, a.reflected, 4 * a.error + 2e-3)
          << alpha << " at " << degrees << " degrees";
    }
}

TEST(FacetAlbedo, MeansAreIntegralsOverTheHemisphere) {
  constexpr int kSteps = 4000;
  for (const double alpha : {0.0, 0.1, 0.7}) {
    FacetAlbedo sum;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = (i + 0.5) / kSteps;
      sum.all += facet_albedo(cosine, alpha).all * 2 * cosine / kSteps;
      sum.schlick += facet_albedo(cosine, alpha).schlick * 2 * cosine / kSteps;
    }
    EXPECT_NEAR(mean_facet_albedo(alpha).all, sum.all, 1e-6);
    EXPECT_NEAR(mean_facet_albedo(alpha).schlick, sum.schlick, 1e-6);
  }
}

}  // namespace
}  // namespace lucerna::testing
