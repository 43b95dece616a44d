// The contract suites on every area sampling method.  Here each method makes a light of its own,
// whose receivers request it.
#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/area_cases.h"

namespace lucerna::testing {
namespace {

/// Facing the light at an angle, so that some corners have larger weights.
constexpr Vec3 kNormal{0.6, 0, -0.8};

template <AreaSampling kWay>
struct SampledCase : CaseDefaults {
  static Receiver receiver(const Vec3& p, const Placement& at) {
    Receiver r(p);
    r.normal = at.direction(kNormal);
    r.area_sampling = kWay;
    return r;
  }
};

template <AreaSampling kWay>
struct TriangleBy : SampledCase<kWay> {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, 0}); };
    // The triangle (0, 0), (1, 0), (0, 1) in two parts of unequal area.
    return *AreaLight::create({kLevel}, *TriangleMesh::create({{p(0, 0), p(0.25, 0), p(0, 1)},
                                                               {p(0.25, 0), p(1, 0), p(0, 1)}}));
  }
  /// The last receiver is near: the light covers a quarter of its sphere.
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}, {0.25, 0.25, 0.25}}; }
  static Region region(const Vec3& r) {
    const Vec3 to_middle = Vec3{0.31, 0.29, 0} - r;
    if (length(to_middle) < 0.79) return {{0, 0, -1}, kPi / 2};
    return {normalized(to_middle), 1.05 * std::asin(0.79 / length(to_middle))};
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = from_above(r, wi);
    const bool lit = p && p->x > -1e-6 && p->y > -1e-6 && p->x + p->y < 1 + 1e-6;
    return lit ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z), std::fmax(std::fmax(-p.x, -p.y), p.x + p.y - 1));
  }
  static Rgb power_by_quadrature() { return lambertian_power(0.5); }
};

template <AreaSampling kWay>
struct RectangleBy : SampledCase<kWay> {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, 0}); };
    return *AreaLight::create(
        {kLevel}, *PatchMesh::create({{p(-1, -0.5), p(1, -0.5), p(-1, 0.5), p(1, 0.5)}}));
  }
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}, {0.25, 0.25, 0.25}}; }
  static Region region(const Vec3& r) {
    if (length(r) < 1.2) return {{0, 0, -1}, kPi / 2};
    return {normalized(-r), 1.05 * std::asin(1.12 / length(r))};
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = from_above(r, wi);
    const bool lit = p && std::fabs(p->x) < 1 + 1e-6 && std::fabs(p->y) < 0.5 + 1e-6;
    return lit ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(p.x) - 1, std::fabs(p.y) - 0.5));
  }
  static Rgb power_by_quadrature() { return lambertian_power(2); }
};

/// A whole disk of radius 1 that emits upwards.  The second receiver is below its rim, the last one
/// close.
template <AreaSampling kWay>
struct DiskBy : SampledCase<kWay> {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *AreaLight::create({kLevel},
                              *Disk::create({.world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() {
    return {{0, 0, 2}, {1, 0, 1}, {-2, 1, 0.5}, {0.25, 0.125, 0.375}};
  }
  static Region region(const Vec3& r) {
    if (length(r) < 1.5) return {{0, 0, -1}, kPi / 2};
    return {normalized(-r), 1.05 * std::asin(1 / length(r))};
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = from_above(r, wi);
    return p && std::hypot(p->x, p->y) < 1 + 1e-6 ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z), std::hypot(p.x, p.y) - 1);
  }
  static Rgb power_by_quadrature() { return lambertian_power(kPi); }
};

/// A whole sphere, seen from inside.
template <AreaSampling kWay>
struct InwardSphereBy : SampledCase<kWay> {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *AreaLight::create({kLevel},
                              *Sphere::create({.radius_m = 0.75,
                                               .reverse_orientation = true,
                                               .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {0.25, -0.25, 0.375}}; }
  static Region region(const Vec3&) { return {}; }
  static Rgb value(const Vec3&, const Vec3&) { return kLevel; }
  static double distance_to_surface(const Vec3& p) { return std::fabs(length(p) - 0.75); }
  /// Seen from outside, points of its far wall are sampled by area, and the near wall hides them.
  static constexpr bool kEnclosed = kWay == AreaSampling::kSolidAngle;
  static Rgb power_by_quadrature() { return lambertian_power(4 * kPi * 0.75 * 0.75); }
};

/// The directions from outside to a ball about the origin, by the visible part of its surface.  The
/// cells have equal area on the surface.  The density by area has a pole at the silhouette; that of
/// these cells is 0 there.
struct SeenBall {
  Vec3 receiver;
  double radius;

  double distance() const { return length(receiver); }
  /// The cosine at the centre, between the receiver and a visible point, is 1 minus x times this.
  double one_minus_cos() const { return 1 - radius / distance(); }
  Vec3 at(double x, double y) const { return normalized(point(x, y) - receiver); }
  Vec2 where(const Vec3& w) const {
    // The nearer of two hits.  A direction that is rounded past the silhouette counts as on it.
    const double b = -dot(receiver, w);
    const double half_chord =
        std::sqrt(std::fmax(0, radius * radius - dot(cross(receiver, w), cross(receiver, w))));
    const Vec3 n = normalized(receiver + w * (b - half_chord));
    const Vec3 local = Frame::around(normalized(receiver)).local_from_world(n);
    const double y = std::atan2(local.y, local.x) / (2 * kPi);
    return {(1 - local.z) / one_minus_cos(), y < 0 ? y + 1 : y};
  }
  /// dA cos / d^2; the area is 2 pi r^2 (1 - cos) for x and y from 0 to 1.
  double element_sr(double x, double y) const {
    const Vec3 p = point(x, y), to_receiver = receiver - p;
    const double d2 = dot(to_receiver, to_receiver);
    const double cos = dot(p, to_receiver) / (radius * std::sqrt(d2));
    return 2 * kPi * radius * radius * one_minus_cos() * cos / d2;
  }

 private:
  Vec3 point(double x, double y) const {
    const double z = 1 - x * one_minus_cos(), r = std::sqrt((1 - z) * (1 + z));
    return Frame::around(normalized(receiver))
               .world_from_local({r * std::cos(2 * kPi * y), r * std::sin(2 * kPi * y), z}) *
           radius;
  }
};

/// A whole sphere, seen from outside; at least half of it faces away.  Near its silhouette the
/// densities of rounded directions differ much from each other.  So it takes part only in tests of
/// their sums and counts.
struct SphereByArea : SampledCase<AreaSampling::kLowDistortion> {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *AreaLight::create(
        {kLevel}, *Sphere::create({.radius_m = 0.75, .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{2, 1, 2}, {0, 0, -1}, {0.5, 0.5, 0.5}}; }
  static SeenBall region(const Vec3& r) { return {r, 0.75}; }
};

using Sampled = ::testing::Types<
    TriangleBy<AreaSampling::kSquareRoot>, TriangleBy<AreaSampling::kKraemer>,
    TriangleBy<AreaSampling::kParallelogram>, TriangleBy<AreaSampling::kRejection>,
    TriangleBy<AreaSampling::kLowDistortion>, TriangleBy<AreaSampling::kSolidAngle>,
    TriangleBy<AreaSampling::kCosineSolidAngle>, RectangleBy<AreaSampling::kLowDistortion>,
    RectangleBy<AreaSampling::kSolidAngle>, RectangleBy<AreaSampling::kCosineSolidAngle>,
    TriangleBy<AreaSampling::kAutomatic>, RectangleBy<AreaSampling::kAutomatic>,
    DiskBy<AreaSampling::kLowDistortion>, DiskBy<AreaSampling::kSolidAngle>,
    DiskBy<AreaSampling::kAutomatic>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Sampled, AnyLight, Sampled);
INSTANTIATE_TYPED_TEST_SUITE_P(Sampled, LightWithDensity, Sampled);
INSTANTIATE_TYPED_TEST_SUITE_P(Sampled, LocalLight, Sampled);

using SampledInside = ::testing::Types<InwardSphereBy<AreaSampling::kSolidAngle>,
                                       InwardSphereBy<AreaSampling::kLowDistortion>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Inside, AnyLight, SampledInside);
INSTANTIATE_TYPED_TEST_SUITE_P(Inside, LightWithDensity, SampledInside);
INSTANTIATE_TYPED_TEST_SUITE_P(Inside, LocalLight, SampledInside);
INSTANTIATE_TYPED_TEST_SUITE_P(Outside, LightWithDensity, SphereByArea);

}  // namespace
}  // namespace lucerna::testing
