// The contract suites on portal lights: those of every light, of lights with a density, of
// emission, and of lights at infinity, which have no bounds.
#include "lights/models/portal_light.h"
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/contract_irradiance.h"
#include "tests/lights/contract/map_cases.h"

namespace lucerna::testing {
namespace {

/// A window of 2 x 1.5 m in the plane z = 1; light comes from above.  `Sky` is the case of a map.
/// Its value is that of the sky without the portal.
template <typename Sky>
struct PortalCase : CaseDefaults {
  using Light = PortalLight;
  // The light states an error of 3e-4 of its power.  Midpoints on 1200 x 1200 cells that a
  // picture's edges cut have as large an error.
  static constexpr double kPowerTolerance = Sky::kConstant ? 1e-6 : 6e-4;

  static PortalLight make(const Placement& placement) {
    PortalLightParams params{.world_from_map = placement.rigid, .radiance_cd_m2 = kMapLevel};
    if constexpr (!Sky::kConstant) params.map = Sky::map();
    params.rectified = Sky::kRectified;
    const Vec3 corners[] = {{-1, -0.75, 1}, {-1, 0.75, 1}, {1, 0.75, 1}, {1, -0.75, 1}};
    for (std::size_t i = 0; i < 4; ++i) params.corners_m[i] = placement.point(corners[i]);
    return *PortalLight::create(params);
  }
  static std::vector<Vec3> receivers() {
    return {{0, 0, 0}, {0.5, -0.25, -2}, {3, 1, 0}, {0.25, 0.125, 0.75}, {-8, 3, -20}};
  }
  static Region region(const Vec3& receiver) {
    const Vec3 axis = normalized(Vec3{0, 0, 1} - receiver);
    double angle = 0;
    for (const Vec3& c :
         {Vec3{-1, -0.75, 1}, Vec3{-1, 0.75, 1}, Vec3{1, 0.75, 1}, Vec3{1, -0.75, 1}}) {
      const Vec3 to = c - receiver;
      angle = std::fmax(angle, std::atan2(length(cross(axis, to)), dot(axis, to)));
    }
    return {axis, angle + 1e-6};
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const double t = (1 - receiver.z) / wi.z;
    const Vec3 through = receiver + wi * t;
    // Because wi is rounded, the ray may miss the window by a little.
    const double slack = 1e-6 * std::fabs(t);
    if (!(t > 0) || std::fabs(through.x) > 1 + slack || std::fabs(through.y) > 0.75 + slack)
      return {};
    return Sky::value({}, wi);
  }
  /// The area times the illuminance of the sky on it.
  static Rgb power_by_quadrature() {
    if constexpr (Sky::kConstant) return kMapLevel * (3 * kPi);
    static const Rgb lumens = integrate(Region{{0, 0, 1}, kPi / 2}, 1200, [](const Vec3& w) {
      return Sky::value({}, w) * (3 * w.z);
    });
    return lumens;
  }

  static Vec3 emission_position(const Vec3&, double x, double y) {
    return {2 * x - 1, 1.5 * y - 0.75, 1};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    if (std::fabs(p.z - 1) > 1e-6) return {NAN, NAN};
    return {(p.x + 1) / 2, (p.y + 0.75) / 1.5};
  }
  static double emission_area_m2() { return 3; }
  static Region emission_region(const Vec3&) { return {{0, 0, -1}, kPi / 2}; }
  static Rgb emitted(const Vec3&, const Vec3& direction) {
    return direction.z < 0 ? Sky::value({}, -direction) : Rgb();
  }
};

struct ConstantSky {
  static constexpr bool kConstant = true, kRectified = false;
  static Rgb value(const Vec3&, const Vec3&) { return kMapLevel; }
};
struct EqualAreaSky : EqualAreaCase {
  static constexpr bool kConstant = false, kRectified = false;
};
struct LatitudeLongitudeSky : LatitudeLongitudeCase {
  static constexpr bool kConstant = false, kRectified = false;
};
/// The same map of four rows, resampled at the middles of 4 x 4 cells of both angles.
struct RectifiedSky : LatitudeLongitudeCase {
  static constexpr bool kConstant = false, kRectified = true;
  static Rgb value(const Vec3& receiver, const Vec3& w) {
    const auto middle = [&](double c) {
      const int cell = std::clamp(int((std::atan2(c, w.z) / kPi + 0.5) * 4), 0, 3);
      return std::tan(((cell + 0.5) / 4 - 0.5) * kPi);
    };
    return LatitudeLongitudeCase::value(receiver, normalized(Vec3{middle(w.x), middle(w.y), 1}));
  }
};

using PortalCases = ::testing::Types<PortalCase<ConstantSky>, PortalCase<EqualAreaSky>,
                                     PortalCase<LatitudeLongitudeSky>, PortalCase<RectifiedSky>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, AnyLight, PortalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, LightWithDensity, PortalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, EmittingLight, PortalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, EmittingSurface, PortalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, EmittingDirections, PortalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, UnboundedLight, PortalCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Portals, LightWithIrradiance, PortalCase<ConstantSky>);

TEST(LightWithIrradiance, PortalsWithAMapHaveNoClosedForm) {
  Receiver receiver(0, 0, 0);
  receiver.normal = {0, 0, 1};
  EXPECT_FALSE(PortalCase<RectifiedSky>::make({}).irradiance(receiver));
}

}  // namespace
}  // namespace lucerna::testing
