// Companions of the contract: what its checkers accept and reject.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "lights/models/infinite_light.h"
#include "lights/models/spot_light.h"
#include "tests/lights/contract/emission_checks.h"

namespace lucerna::testing {
namespace {

// ---- A sampler that is correct by construction, and wrong ones. ----

/// A square of side 2 in the plane z = 1 about the axis, seen from the origin, sampled by area.
struct SquareSampler {
  LightSample operator()(Vec2 u) const {
    const Vec3 p{2 * u.x - 1, 2 * u.y - 1, 1};
    LightSample s;
    s.wi = normalized(p);
    s.distance = length(p);
    s.value = Rgb(1);
    s.pdf.per_sr = pdf(s.wi);
    return s;
  }
  static double pdf(const Vec3& w) {
    if (w.z <= 0 || std::fabs(w.x) > w.z || std::fabs(w.y) > w.z) return 0;
    return 1 / (4 * w.z * w.z * w.z);  // d^2 / (A cos), d = 1 / cos
  }
  static double pdf_without_cosine(const Vec3& w) { return pdf(w) * w.z; }
  static Region region() { return {{0, 0, 1}, 1}; }  // the corners lie at 0.9553 rad
};

TEST(ContractCheckers, AcceptACorrectSampler) {
  const SquareSampler square;
  const Verdict integral = check_density_integrates(square.region(), square, square.pdf);
  EXPECT_TRUE(integral.ok()) << integral.failure;
  const Verdict chi_square = check_samples_follow_density(square.region(), square, square.pdf);
  EXPECT_TRUE(chi_square.ok()) << chi_square.failure;
}

TEST(ContractCheckers, RejectADensityTenPercentTooHigh) {
  const SquareSampler square;
  const auto wrong = [](const Vec3& w) { return 1.1 * SquareSampler::pdf(w); };
  EXPECT_FALSE(check_density_integrates(square.region(), square, wrong).ok());
  EXPECT_FALSE(check_samples_follow_density(square.region(), square, wrong).ok());
}

TEST(ContractCheckers, RejectAnAreaDensityWithoutItsCosine) {
  const SquareSampler square;
  const auto wrong = SquareSampler::pdf_without_cosine;
  EXPECT_FALSE(check_density_integrates(square.region(), square, wrong).ok());
  EXPECT_FALSE(check_samples_follow_density(square.region(), square, wrong).ok());
}

TEST(ContractCheckers, RejectAWrongDensityThatIntegratesToOne) {
  const auto light = *UniformInfiniteLight::create({.radiance_cd_m2 = Rgb(1)});
  const auto sample = [&](Vec2 u) { return light.sample_li({0, 0, 0}, u); };
  const auto tilted = [](const Vec3& w) { return (1 + 0.1 * w.x) / (4 * kPi); };
  EXPECT_TRUE(check_density_integrates({}, sample, tilted).ok());
  EXPECT_FALSE(check_samples_follow_density({}, sample, tilted).ok());
}

TEST(ContractCheckers, RejectSamplesOutsideOfTheRegion) {
  const SquareSampler square;
  EXPECT_FALSE(check_samples_follow_density({{0, 0, 1}, 0.9}, square, square.pdf).ok());
}

TEST(ContractCheckers, RejectAWrongValueOrDensity) {
  const SquareSampler square;
  const auto pdf = [](const Vec3& w) { return SquareSampler::pdf(Vec3(w)); };
  const auto value = [](const Vec3&) { return Rgb(1); };
  EXPECT_TRUE(check_sample_agrees(square, pdf, value, 1e-5).ok());
  EXPECT_FALSE(check_sample_agrees(
                   square, [&](const Vec3& w) { return 1.0001 * pdf(w); }, value, 1e-5)
                   .ok());
  EXPECT_FALSE(check_sample_agrees(
                   square, pdf, [](const Vec3&) { return Rgb(1, 1, 1.0001); }, 1e-5)
                   .ok());
}

TEST(ContractCheckers, RejectInvalidNumbers) {
  const auto broken = [](auto&& change) {
    LightSample s = SquareSampler()({0.25, 0.75});
    change(s);
    return !check_well_formed(s).ok();
  };
  EXPECT_FALSE(broken([](auto&) {}));
  EXPECT_TRUE(broken([](auto& s) { s.value.g = NAN; }));
  EXPECT_TRUE(broken([](auto& s) { s.value.b = -1; }));
  EXPECT_TRUE(broken([](auto& s) { s.value = {}; }));
  EXPECT_TRUE(broken([](auto& s) { s.reason = NoLight::kBehind; }));
  EXPECT_TRUE(broken([](auto& s) { s.wi.x += 1e-5; }));
  EXPECT_TRUE(broken([](auto& s) { s.pdf.per_sr = INFINITY; }));
  EXPECT_TRUE(broken([](auto& s) { s.pdf.per_sr = 0; }));
  EXPECT_TRUE(broken([](auto& s) { s.delta = true; }));
  EXPECT_TRUE(broken([](auto& s) { s.distance = NAN; }));
}

// Q(1, x) = exp(-x) and Q(1/2, x) = erfc(sqrt(x)).  The others are from tables of the chi-square
// distribution with 10 degrees of freedom: 18.307 and 29.588 are its upper 5% and 0.1% points.  Its
// density there is 0.0155 and 3.8e-4, so half a unit of the last digit is 8e-6 and 2e-7.
TEST(Statistics, UpperGammaAgreesWithClosedFormsAndTables) {
  for (const double x : {0.01, 0.5, 1., 1.9, 2.1, 10., 40.}) {
    EXPECT_NEAR(upper_gamma_q(1, x) / std::exp(-x), 1, 1e-12) << x;
    EXPECT_NEAR(upper_gamma_q(0.5, x) / std::erfc(std::sqrt(x)), 1, 1e-12) << x;
  }
  EXPECT_NEAR(upper_gamma_q(5, 18.307 / 2), 0.05, 8e-6);
  EXPECT_NEAR(upper_gamma_q(5, 29.588 / 2), 0.001, 2e-7);
}

// ---- Rays that are correct by construction, and wrong ones. ----

/// A square of side 2 about the origin, facing +z, radiance 1.  Its rays have a cosine density.
struct SquareRays {
  EmissionSample operator()(Vec2 up, Vec2 ud) const {
    EmissionSample s;
    s.origin = {2.0 * up.x - 1, 2.0 * up.y - 1, 0};
    s.normal = {0, 0, 1};
    const double r = std::sqrt(double{ud.x}), phi = 2 * kPi * ud.y;
    s.direction = {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - double{ud.x})};
    s.value = Rgb(1);
    s.pdf_position = {0.25};
    s.pdf_direction = pdf(s.origin, s.direction).direction;
    return s;
  }
  static EmissionPdf pdf(const Vec3&, const Vec3& w) { return {{0.25}, {std::fmax(0, w.z) / kPi}}; }
  static Rgb value(const Vec3&, const Vec3&) { return Rgb(1); }
};

TEST(EmissionCheckers, AcceptCorrectRays) {
  const SquareRays rays;
  EXPECT_TRUE(check_emission_agrees(rays, rays.pdf, rays.value, 1e-9, 1e-9).ok());
  // pi L A
  EXPECT_TRUE(check_emission_mean(rays, Rgb(4 * kPi), 1e-9).ok());
}

TEST(EmissionCheckers, RejectWrongDensitiesAndValues) {
  const SquareRays rays;
  const auto position = [](const Vec3& p, const Vec3& w) {
    auto pdf = SquareRays::pdf(p, w);
    pdf.position.per_m2 *= 1.0001;
    return pdf;
  };
  EXPECT_FALSE(check_emission_agrees(rays, position, rays.value, 1e-5, 1e-5).ok());
  const auto direction = [](const Vec3& p, const Vec3& w) {
    auto pdf = SquareRays::pdf(p, w);
    pdf.direction.per_sr *= 1.0001;
    return pdf;
  };
  EXPECT_FALSE(check_emission_agrees(rays, direction, rays.value, 1e-5, 1e-5).ok());
  const auto value = [](const Vec3&, const Vec3&) { return Rgb(1, 1, 1.0001); };
  EXPECT_FALSE(check_emission_agrees(rays, rays.pdf, value, 1e-5, 1e-5).ok());
}

TEST(EmissionCheckers, RejectAWrongPower) {
  // Uniform instead of cosine-distributed directions: the mean has a variance.
  const auto uniform = [](Vec2 up, Vec2 ud) {
    auto s = SquareRays{}(up, ud);
    s.direction = Region{{0, 0, 1}, kPi / 2}.at(ud.x, ud.y);
    s.pdf_direction = {1 / (2 * kPi)};
    return s;
  };
  EXPECT_TRUE(check_emission_mean(uniform, Rgb(4 * kPi), 1e-9).ok());
  EXPECT_FALSE(check_emission_mean(uniform, Rgb(4 * kPi * 1.02), 1e-9).ok());
  EXPECT_FALSE(check_emission_mean(SquareRays{}, Rgb(4 * kPi * 1.00001), 1e-9).ok());
  const auto without_normal = [](Vec2 up, Vec2 ud) {
    auto s = SquareRays{}(up, ud);
    s.normal = {};
    return s;
  };
  EXPECT_FALSE(check_emission_mean(without_normal, Rgb(4 * kPi), 1e-9).ok());
}

TEST(EmissionCheckers, RejectRaysThatDoNotFollowTheirDensity) {
  const Region region{{0, 0, 1}, kPi / 2};
  const auto check = [&](auto&& density) {
    RandomU random(1);
    return check_follows_on_square(
        [&]() -> std::optional<Vec2> {
          return region.where(SquareRays{}({0.5, 0.5}, random.pair()).direction);
        },
        [&](double x, double y) { return density(region.at(x, y)) * region.solid_angle_sr(); });
  };
  const auto right = [](const Vec3& w) { return SquareRays::pdf({}, w).direction.per_sr; };
  EXPECT_TRUE(check(right).ok());
  EXPECT_FALSE(check([](const Vec3&) { return 1 / (2 * kPi); }).ok());
  EXPECT_FALSE(check([&](const Vec3& w) { return right(w) * 1.1; }).ok());
  EXPECT_FALSE(check([&](const Vec3& w) { return right(w) * (1 + 0.1 * w.x); }).ok());
}

TEST(EmissionCheckers, RejectBoundsThatAreTooSmall) {
  const Vec3 center{0.25, -0.5, 1};
  const auto light = *SpotLight::create({.position_m = center,
                                         .axis = {0, 0, -1},
                                         .intensity_cd = Rgb(1),
                                         .cone_half_angle_rad = 0.7,
                                         .falloff_start_rad = 0.3});
  const auto arrives = [&](const Vec3& p, Vec2 u) {
    return light.sample_li(p, u).reason == NoLight::kNone;
  };
  const auto rays = [&](Vec2 up, Vec2 ud) { return light.sample_le(up, ud, {}); };
  LightBounds bounds = *light.bounds();
  EXPECT_TRUE(check_bounds_reach(bounds, center, 1, arrives).ok());
  EXPECT_TRUE(check_bounds_hold(bounds, rays).ok());
  bounds.cone_rad -= 1e-4;
  EXPECT_FALSE(check_bounds_reach(bounds, center, 1, arrives).ok());
  bounds.cone_rad -= 0.05;
  EXPECT_FALSE(check_bounds_hold(bounds, rays).ok());
  bounds = *light.bounds();
  bounds.lower.x = bounds.upper.x += 1e-3;
  EXPECT_FALSE(check_bounds_reach(bounds, center, 1, arrives).ok());
  EXPECT_FALSE(check_bounds_hold(bounds, rays).ok());
}

TEST(EmissionCheckers, RejectAStatedErrorThatIsTooSmall) {
  EXPECT_TRUE(check_stated_error({Rgb(11), 1}, Rgb(10), 1e-9).ok());
  EXPECT_FALSE(check_stated_error({Rgb(11), 0.99}, Rgb(10), 1e-9).ok());
}

TEST(EmissionCheckers, RejectRaysWithInvalidNumbers) {
  const auto broken = [](auto&& change) {
    auto s = SquareRays{}({0.25, 0.75}, {0.5, 0.25});
    change(s);
    return !check_well_formed(s).ok();
  };
  EXPECT_FALSE(broken([](auto&) {}));
  EXPECT_TRUE(broken([](auto& s) { s.value.g = NAN; }));
  EXPECT_TRUE(broken([](auto& s) { s.value = {}; }));
  EXPECT_TRUE(broken([](auto& s) { s.reason = NoLight::kBehind; }));
  EXPECT_TRUE(broken([](auto& s) { s.direction.x += 1e-5; }));
  EXPECT_TRUE(broken([](auto& s) { s.normal.z = 0.5; }));
  EXPECT_TRUE(broken([](auto& s) { s.origin.z = INFINITY; }));
  EXPECT_TRUE(broken([](auto& s) { s.pdf_position.per_m2 = -1; }));
  EXPECT_TRUE(broken([](auto& s) { s.pdf_direction.per_sr = INFINITY; }));
}

}  // namespace
}  // namespace lucerna::testing
