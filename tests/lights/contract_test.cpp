// The contract suite on lights without a surface, and the companions that show what it rejects.
#include "tests/lights/contract.h"

#include <numbers>

#include "lights/distant_light.h"
#include "lights/infinite_light.h"
#include "lights/point_light.h"
#include "lights/sampling.h"
#include "lights/spot_light.h"

namespace lucerna::testing {
namespace {

constexpr double kPi = std::numbers::pi;
const Rgb<double> kLevel{3, 5, 7};

/// Composite Simpson's rule on 2 n intervals.
template <typename F>
double simpson(double a, double b, int n, F&& f) {
  const double h = (b - a) / (2 * n);
  double sum = f(a) + f(b);
  for (int i = 1; i < 2 * n; ++i) sum += f(a + i * h) * (i % 2 == 1 ? 4 : 2);
  return sum * h / 3;
}

/// 0 where `wi` points from `receiver` to `target`, not a number elsewhere: a wrong direction
/// spoils the expected value.
double zero_if_towards(const Vec3<double>& target, const Vec3<double>& receiver,
                       const Vec3<double>& wi) {
  const Vec3<double> d = target - receiver;
  const bool towards = length(cross(d, wi)) < 1e-6 * length(d) && dot(d, wi) > 0;
  return towards ? 0 : NAN;
}

struct LocalDeltaCase : CaseDefaults {
  static constexpr int kValueLengthPower = -2;
  static constexpr int kPowerLengthPower = 0;
  // The light's arithmetic is in double; one rounding to float is left.
  static constexpr double kTolerance = 0x1p-23;
  static Vec3<double> position() { return {0.25, -0.5, 1}; }
  static double distance_to_surface(const Vec3<double>& p) { return length(p - position()); }
};

struct PointCase : LocalDeltaCase {
  template <typename Real>
  using Light = PointLight<Real>;
  template <typename Real>
  static PointLight<Real> make(const Placement& placement) {
    return *PointLight<Real>::create(
        {.position_m = placement.point(position()), .intensity_cd = kLevel});
  }
  static std::vector<Vec3<double>> receivers() {
    return {{0, 0, 0}, {1, 2, 3}, {-100, 50.5, 3}, {0.25, -0.5, 1 + 0x1p-10}};
  }
  static Rgb<double> value(const Vec3<double>& receiver, const Vec3<double>& wi) {
    const Vec3<double> d = position() - receiver;
    return kLevel * (1 / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  /// The flux through a cube of side 2 about the light: six times that through one face.
  static Rgb<double> power_by_quadrature() {
    return kLevel * (6 * simpson(-1, 1, 100, [](double x) {
                       return simpson(-1, 1, 100,
                                      [x](double y) { return std::pow(1 + x * x + y * y, -1.5); });
                     }));
  }
};

/// Angles as a spot's edge; the falloff from pbrt-v4's description: smoothstep in the cosine.
template <int kConeMilliradians, int kStartMilliradians>
struct SpotCase : LocalDeltaCase {
  static constexpr double kCone = kConeMilliradians * 1e-3, kStart = kStartMilliradians * 1e-3;
  template <typename Real>
  using Light = SpotLight<Real>;
  static Vec3<double> axis() { return {0, 0, -1}; }
  static Vec3<double> far_direction() { return axis(); }
  template <typename Real>
  static SpotLight<Real> make(const Placement& placement) {
    return *SpotLight<Real>::create({.position_m = placement.point(position()),
                                     .axis = placement.direction(axis()) * 2.0,
                                     .intensity_cd = kLevel,
                                     .cone_half_angle_rad = kCone,
                                     .falloff_start_rad = kStart});
  }
  static std::vector<Vec3<double>> receivers() {
    return {{0.25, -0.5, -2}, {0.75, -0.25, -1}, {1, -0.5, -0.5}, {0, 0.5, -100}};
  }
  static double falloff(double theta) {
    if (theta <= kStart) return 1;
    if (theta >= kCone) return 0;
    const double t = (std::cos(theta) - std::cos(kCone)) / (std::cos(kStart) - std::cos(kCone));
    return 3 * t * t - 2 * t * t * t;
  }
  static Rgb<double> value(const Vec3<double>& receiver, const Vec3<double>& wi) {
    const Vec3<double> d = position() - receiver;
    const double theta = std::atan2(length(cross(-d, axis())), dot(-d, axis()));
    return kLevel * (falloff(theta) / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  static Rgb<double> power_by_quadrature() {
    const auto ring = [](double theta) { return falloff(theta) * 2 * kPi * std::sin(theta); };
    // Not across the hard edge itself, where Simpson's rule would be wrong.
    const double edge = kStart < kCone ? simpson(kStart, kCone, 500, ring) : 0;
    return kLevel * (simpson(0, kStart, 500, ring) + edge);
  }
};
using SoftSpotCase = SpotCase<700, 300>;
using HardSpotCase = SpotCase<600, 600>;
using WideSpotCase = SpotCase<3000, 1800>;

struct DistantCase : CaseDefaults {
  template <typename Real>
  using Light = DistantLight<Real>;
  static Vec3<double> to_light() { return {1, 2, 2}; }
  template <typename Real>
  static DistantLight<Real> make(const Placement& placement) {
    return *DistantLight<Real>::create(
        {.to_light = placement.direction(to_light()), .illuminance_lx = kLevel});
  }
  static std::vector<Vec3<double>> receivers() { return {{0, 0, 0}, {1e6, -3, 0x1p-40}}; }
  static Rgb<double> value(const Vec3<double>&, const Vec3<double>& wi) {
    return kLevel * (1 + zero_if_towards(to_light(), {}, wi));
  }
  /// Through the disk that the scene's sphere of radius 4 covers, ring by ring.
  static Rgb<double> power_by_quadrature() {
    return kLevel * simpson(0, 4, 10, [](double r) { return 2 * kPi * r; });
  }
};

struct InfiniteCase : CaseDefaults {
  template <typename Real>
  using Light = UniformInfiniteLight<Real>;
  template <typename Real>
  static UniformInfiniteLight<Real> make(const Placement&) {
    return *UniformInfiniteLight<Real>::create({.radiance_cd_m2 = kLevel});
  }
  static std::vector<Vec3<double>> receivers() { return {{0, 0, 0}, {1e6, -3, 5}}; }
  static Region region(const Vec3<double>&) { return {}; }
  static Rgb<double> value(const Vec3<double>&, const Vec3<double>&) { return kLevel; }
  /// What enters the scene's sphere of radius 4: at each point of its surface the radiance of a
  /// hemisphere, weighted with the cosine.
  static Rgb<double> power_by_quadrature() {
    const Vec3<double> n{0, 0, 1};
    const double area = 4 * kPi * 4 * 4;
    return integrate(Region{n, kPi / 2}, 400,
                     [&](const Vec3<double>& w) { return kLevel * (area * dot(w, n)); });
  }
};

using LocalDeltaCases = ::testing::Types<PointCase, SoftSpotCase, HardSpotCase, WideSpotCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, AnyLight, LocalDeltaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, DeltaLight, LocalDeltaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, LocalLight, LocalDeltaCases);
using FarCases = ::testing::Types<DistantCase, InfiniteCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Far, AnyLight, FarCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Distant, DeltaLight, DistantCase);
INSTANTIATE_TYPED_TEST_SUITE_P(Infinite, LightWithDensity, InfiniteCase);

// ---- Companions: a sampler that is right by construction, and ways of being wrong. ----

/// A square of side 2 in the plane z = 1 about the axis, seen from the origin, sampled by area.
struct SquareSampler {
  LightSample<float> operator()(Vec2<float> u) const {
    const Vec3<float> p{2 * u.x - 1, 2 * u.y - 1, 1};
    LightSample<float> s;
    s.wi = normalized(p);
    s.distance = length(p);
    s.value = Rgb<float>(1);
    s.pdf.per_sr = static_cast<float>(pdf(Vec3<double>(s.wi)));
    return s;
  }
  static double pdf(const Vec3<double>& w) {
    if (w.z <= 0 || std::fabs(w.x) > w.z || std::fabs(w.y) > w.z) return 0;
    return 1 / (4 * w.z * w.z * w.z);  // d^2 / (A cos), d = 1 / cos
  }
  static double pdf_without_cosine(const Vec3<double>& w) { return pdf(w) * w.z; }
  static Region region() { return {{0, 0, 1}, 1}; }  // the corners lie at 0.9553 rad
};

TEST(ContractCheckers, AcceptASamplerThatIsRight) {
  const SquareSampler square;
  const Verdict integral = check_density_integrates(square.region(), square, square.pdf);
  EXPECT_TRUE(integral.ok()) << integral.failure;
  const Verdict chi_square = check_samples_follow_density(square.region(), square, square.pdf);
  EXPECT_TRUE(chi_square.ok()) << chi_square.failure;
}

TEST(ContractCheckers, RejectADensityTenPercentTooHigh) {
  const SquareSampler square;
  const auto wrong = [](const Vec3<double>& w) { return 1.1 * SquareSampler::pdf(w); };
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
  const auto light = InfiniteCase::make<float>({});
  const auto sample = [&](Vec2<float> u) { return light.sample_li({0, 0, 0}, u); };
  const auto tilted = [](const Vec3<double>& w) { return (1 + 0.1 * w.x) / (4 * kPi); };
  EXPECT_TRUE(check_density_integrates({}, sample, tilted).ok());
  EXPECT_FALSE(check_samples_follow_density({}, sample, tilted).ok());
}

TEST(ContractCheckers, RejectSamplesOutsideOfTheRegion) {
  const SquareSampler square;
  EXPECT_FALSE(check_samples_follow_density({{0, 0, 1}, 0.9}, square, square.pdf).ok());
}

TEST(ContractCheckers, RejectAValueOrADensityThatDisagrees) {
  const SquareSampler square;
  const auto pdf = [](const Vec3<float>& w) { return SquareSampler::pdf(Vec3<double>(w)); };
  const auto value = [](const Vec3<double>&) { return Rgb<double>(1); };
  EXPECT_TRUE(check_sample_agrees(square, pdf, value, 1e-5).ok());
  EXPECT_FALSE(check_sample_agrees(
                   square, [&](const Vec3<float>& w) { return 1.0001 * pdf(w); }, value, 1e-5)
                   .ok());
  EXPECT_FALSE(check_sample_agrees(
                   square, pdf, [](const Vec3<double>&) { return Rgb<double>(1, 1, 1.0001); }, 1e-5)
                   .ok());
}

TEST(ContractCheckers, RejectNumbersThatAreNone) {
  const auto broken = [](auto&& change) {
    LightSample<float> s = SquareSampler()({0.25F, 0.75F});
    change(s);
    return !check_well_formed(s).ok();
  };
  EXPECT_FALSE(broken([](auto&) {}));
  EXPECT_TRUE(broken([](auto& s) { s.value.g = NAN; }));
  EXPECT_TRUE(broken([](auto& s) { s.value.b = -1; }));
  EXPECT_TRUE(broken([](auto& s) { s.value = {}; }));
  EXPECT_TRUE(broken([](auto& s) { s.reason = NoLight::kBehind; }));
  EXPECT_TRUE(broken([](auto& s) { s.wi.x += 1e-5F; }));
  EXPECT_TRUE(broken([](auto& s) { s.pdf.per_sr = INFINITY; }));
  EXPECT_TRUE(broken([](auto& s) { s.pdf.per_sr = 0; }));
  EXPECT_TRUE(broken([](auto& s) { s.delta = true; }));
  EXPECT_TRUE(broken([](auto& s) { s.distance = NAN; }));
}

// Q(1, x) = exp(-x) and Q(1/2, x) = erfc(sqrt(x)); the rest from tables of the chi-square
// distribution: 18.307 and 29.588 are its upper 5% and 0.1% points for 10 degrees of freedom, where
// its density is 0.0155 and 3.8e-4 and half a unit of the last digit makes 8e-6 and 2e-7.
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
