// The contract suites on lights without a surface.  Companion tests show what the checkers reject.
#include "lights/sampling/sampling.h"
#include "tests/lights/contract/delta_cases.h"

namespace lucerna::testing {
namespace {

using LocalDeltaCases = ::testing::Types<PointCase, SoftSpotCase, HardSpotCase, WideSpotCase,
                                         QuadraticSpotCase, QuarticSpotCase, DeformedSpotCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, AnyLight, LocalDeltaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, DeltaLight, LocalDeltaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, LocalLight, LocalDeltaCases);
using FarCases = ::testing::Types<DistantCase, InfiniteCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Far, AnyLight, FarCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Distant, DeltaLight, DistantCase);
INSTANTIATE_TYPED_TEST_SUITE_P(Infinite, LightWithDensity, InfiniteCase);

// ---- Companions: a sampler that is correct by construction, and wrong ones. ----

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
  const auto light = InfiniteCase::make({});
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

}  // namespace
}  // namespace lucerna::testing
