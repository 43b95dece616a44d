// The contract of emission, bounds and approximate power on lights without a surface.  Companion
// tests show what its checkers reject.
#include "tests/lights/contract/contract_emission.h"

#include "tests/lights/contract/contract_irradiance.h"
#include "tests/lights/contract/delta_cases.h"

namespace lucerna::testing {
namespace {

struct EmittingPoint : PointCase {
  static constexpr bool kConfined = false;
  static Region emission_region(const Vec3&) { return {}; }
};
template <typename Spot>
struct EmittingSpot : Spot {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3&) { return {Spot::axis(), Spot::kCone}; }
};
struct EmittingDistant : DistantCase, SceneDiskCase {};
struct EmittingInfinite : InfiniteCase, SceneDiskCase {};

struct EmittingDeformedSpot : DeformedSpotCase {
  static constexpr bool kConfined = true;
  // The widest direction is along y: tan(0.7) 2 / 0.5 is the tangent of 1.282.
  static Region emission_region(const Vec3&) { return {axis(), 1.283}; }
};
using LocalCases =
    ::testing::Types<EmittingPoint, EmittingSpot<SoftSpotCase>, EmittingSpot<HardSpotCase>,
                     EmittingSpot<WideSpotCase>, EmittingSpot<QuadraticSpotCase>,
                     EmittingSpot<QuarticSpotCase>, EmittingDeformedSpot>;
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, EmittingLight, LocalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, EmittingDirections, LocalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelta, BoundedLight, LocalCases);
using FarCases = ::testing::Types<EmittingDistant, EmittingInfinite>;
INSTANTIATE_TYPED_TEST_SUITE_P(Far, EmittingLight, FarCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Far, EmittingSurface, FarCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Far, UnboundedLight, FarCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Infinite, EmittingDirections, EmittingInfinite);
INSTANTIATE_TYPED_TEST_SUITE_P(Infinite, LightWithIrradiance, InfiniteCase);

// ---- Companions: rays that are correct by construction, and wrong ones. ----

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
  EXPECT_TRUE(check_emission_agrees(rays, rays.pdf, rays.value, 1e-9).ok());
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
  EXPECT_FALSE(check_emission_agrees(rays, position, rays.value, 1e-5).ok());
  const auto direction = [](const Vec3& p, const Vec3& w) {
    auto pdf = SquareRays::pdf(p, w);
    pdf.direction.per_sr *= 1.0001;
    return pdf;
  };
  EXPECT_FALSE(check_emission_agrees(rays, direction, rays.value, 1e-5).ok());
  const auto value = [](const Vec3&, const Vec3&) { return Rgb(1, 1, 1.0001); };
  EXPECT_FALSE(check_emission_agrees(rays, rays.pdf, value, 1e-5).ok());
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
  const auto light = SoftSpotCase::make({});
  const auto arrives = [&](const Vec3& p, Vec2 u) {
    return light.sample_li(p, u).reason == NoLight::kNone;
  };
  const auto rays = [&](Vec2 up, Vec2 ud) {
    return light.sample_le(up, ud, SoftSpotCase::scene());
  };
  const Vec3 center = SoftSpotCase::position();
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
