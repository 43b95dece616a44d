// The contract suites on area lights with an emission image, for each shape.  The expected image
// comes from hat functions and each shape's own coordinates.
#include <cmath>
#include <optional>

#include "lights/models/light.h"
#include "tests/lights/contract/area_helpers.h"
#include "tests/lights/contract/contract.h"
#include "tests/lights/contract/contract_emission.h"

namespace lucerna::testing {
namespace {

constexpr Rgb<double> kLevel{1, 2, 4};
constexpr int kColumns = 4, kRows = 3;

/// Rows from the top.
Rgb<float> texel(int x, int y) {
  constexpr float kLuminance[kRows][kColumns] = {{1, 6, 2, 0.5F}, {3, 0.25F, 5, 4}, {8, 2, 1, 7}};
  const float v = kLuminance[y][x];
  return {v, 0.5F * v + 0.125F * float(x), 0.25F + 0.25F * float(y)};
}

Picture picture(ImageFilter filter) {
  std::vector<Rgb<float>> texels;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x) texels.push_back(texel(x, y));
  return {*Image::create(kColumns, kRows, std::move(texels)), filter, "test"};
}

/// The picture at (u, v), v upwards: a sum of hats about the texels' centres.
Rgb<double> shown(double u, double v, ImageFilter filter = ImageFilter::kBilinear) {
  const auto share = [&](double at, int n, int i) {
    const double c = std::fmin(std::fmax(at * n - 0.5, 0), n - 1);
    if (filter == ImageFilter::kNearest) return std::lround(c) == i ? 1.0 : 0.0;
    return std::fmax(0, 1 - std::fabs(c - i));
  };
  Rgb<double> sum;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      sum += Rgb<double>(texel(x, y)) * (share(u, kColumns, x) * share(1 - v, kRows, y));
  return sum * kLevel;
}

/// pi times the integral of `shown` over the surface; `element(u, v)` is its share of area.  The
/// grid is a multiple of twice the texels, so the function is smooth between its points.
template <typename Element>
Rgb<double> painted_power(Element&& element, ImageFilter filter = ImageFilter::kBilinear) {
  constexpr int kGrid = 1200;
  Rgb<double> sum;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double u = (i + 0.5) / kGrid, v = (j + 0.5) / kGrid;
      sum += shown(u, v, filter) * (element(u, v) / (kGrid * kGrid));
    }
  return sum * kPi;
}

struct PaintedCase : CaseDefaults {
  /// Positions have a rounding of float, which the picture's slopes amplify.
  static constexpr double kTolerance = 2e-5;
  static constexpr bool kConfined = true;
  static Region hemisphere(const Vec3<double>& n) { return {normalized(n), kPi / 2}; }
  static std::optional<Vec3<double>> in_plane(const Vec3<double>& r, const Vec3<double>& wi) {
    const double t = -r.z / wi.z;
    if (!(t > 0)) return std::nullopt;
    return r + wi * t;
  }
  /// All within `reach` of the origin.
  static Region seen(const Vec3<double>& receiver, double reach) {
    return {normalized(-receiver), 1.05 * std::asin(reach / length(receiver))};
  }
};

/// A parallelogram that faces +z.
struct ScreenCase : PaintedCase {
  template <typename Real>
  using Light = PaintedPatchMeshLight<Real>;
  static Vec3<double> at(double u, double v) { return {2 * u + 0.5 * v - 1.25, v - 0.5, 0}; }
  static Vec2<double> uv(const Vec3<double>& p) {
    return {(p.x + 1.25 - 0.5 * (p.y + 0.5)) / 2, p.y + 0.5};
  }
  template <typename Real>
  static Light<Real> make(const Placement& placement) {
    const auto p = [&](double u, double v) { return Vec3<Real>(placement.point(at(u, v))); };
    return *Light<Real>::create(
        {kLevel}, *PaintedPatchMesh<Real>::create(
                      *PatchMesh<Real>::create({{p(0, 0), p(1, 0), p(0, 1), p(1, 1)}}),
                      picture(ImageFilter::kBilinear)));
  }
  static std::vector<Vec3<double>> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 1.4); }
  static Rgb<double> emitted(const Vec3<double>& p, const Vec3<double>&) {
    return shown(uv(p).x, uv(p).y);
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    const auto [u, v] = uv(p);
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(u - 0.5), std::fabs(v - 0.5)) - 0.5);
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    return at(x, y);
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) { return uv(p); }
  static double emission_area_m2() { return 2; }
  static Region emission_region(const Vec3<double>&) { return hemisphere({0, 0, 1}); }
  static Rgb<double> power_by_quadrature() {
    return painted_power([](double, double) { return 2.0; });
  }
};

/// The same as two triangles, cut from corner to corner.
struct TwoTrianglesCase : ScreenCase {
  template <typename Real>
  using Light = PaintedTriangleMeshLight<Real>;
  template <typename Real>
  static Light<Real> make(const Placement& placement) {
    const auto p = [&](double u, double v) { return Vec3<Real>(placement.point(at(u, v))); };
    return *Light<Real>::create(
        {kLevel},
        *PaintedTriangleMesh<Real>::create(
            *TriangleMesh<Real>::create({{p(1, 0), p(1, 1), p(0, 0)}, {p(0, 1), p(0, 0), p(1, 1)}}),
            picture(ImageFilter::kBilinear), {{1, 0}, {1, 1}, {0, 0}, {0, 1}, {0, 0}, {1, 1}}));
  }
};

/// A two-sided trapezoid.  The picture lies on its side and shows its texels without a filter.
struct TrapezoidCase : PaintedCase {
  template <typename Real>
  using Light = PaintedPatchMeshLight<Real>;
  static Vec3<double> at(double s, double t) { return {(2 * s - 1) * (1 - t / 2), 2 * t - 1, 0}; }
  static Vec2<double> st(const Vec3<double>& p) {
    const double t = (p.y + 1) / 2;
    return {(p.x / (1 - t / 2) + 1) / 2, t};
  }
  template <typename Real>
  static Light<Real> make(const Placement& placement) {
    const auto p = [&](double s, double t) { return Vec3<Real>(placement.point(at(s, t))); };
    return *Light<Real>::create(
        {kLevel, true}, *PaintedPatchMesh<Real>::create(
                            *PatchMesh<Real>::create({{p(0, 0), p(1, 0), p(0, 1), p(1, 1)}}),
                            picture(ImageFilter::kNearest), {{1, 0}, {1, 1}, {0, 0}, {0, 1}}));
  }
  static std::vector<Vec3<double>> receivers() { return {{0.5, 0.25, 2}, {0.5, -1, -2.5}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 1.42); }
  static Rgb<double> emitted(const Vec3<double>& p, const Vec3<double>&) {
    return shown(1 - st(p).y, st(p).x, ImageFilter::kNearest);
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    const auto [s, t] = st(p);
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(s - 0.5), std::fabs(t - 0.5)) - 0.5);
  }
  /// The area below t is 4 t - t^2, of 3.
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    return at(x, 2 - std::sqrt(4 - 3 * y));
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    const auto [s, t] = st(p);
    return {s, (4 * t - t * t) / 3};
  }
  static double emission_area_m2() { return 3; }
  static Region emission_region(const Vec3<double>&) { return {}; }
  static constexpr bool kConfined = false;
  /// |dp/ds x dp/dt| = 4 - 2 t, t = 1 - u; both sides.
  static Rgb<double> power_by_quadrature() {
    return painted_power([](double u, double) { return 2 * (4 - 2 * (1 - u)); },
                         ImageFilter::kNearest);
  }
};

/// Two triangles of one plane.  The picture's border continues beyond u = 1.
struct PaintedTriangleCase : PaintedCase {
  template <typename Real>
  using Light = PaintedTriangleMeshLight<Real>;
  static Vec2<double> uv(const Vec3<double>& p) {
    return {0.25 + 1.0 * p.x, 0.125 + 0.25 * p.x + 0.75 * p.y};
  }
  template <typename Real>
  static Light<Real> make(const Placement& at) {
    std::vector<Triangle<Real>> triangles;
    std::vector<Vec2<float>> corner_uv;
    const double corners[2][3][2] = {{{0, 0}, {0.25, 0}, {0, 1}}, {{0.25, 0}, {1, 0}, {0, 1}}};
    for (const auto& t : corners) {
      Vec3<Real> p[3];
      for (int k = 0; k < 3; ++k) {
        const Vec3<double> corner{t[k][0], t[k][1], 0};
        p[k] = Vec3<Real>(at.point(corner));
        corner_uv.push_back({float(uv(corner).x), float(uv(corner).y)});
      }
      triangles.push_back({p[0], p[1], p[2]});
    }
    return *Light<Real>::create(
        {kLevel},
        *PaintedTriangleMesh<Real>::create(*TriangleMesh<Real>::create(std::move(triangles)),
                                           picture(ImageFilter::kBilinear), std::move(corner_uv)));
  }
  static std::vector<Vec3<double>> receivers() { return {{0.5, 0.25, 2}, {0, 3, 1.5}}; }
  /// A cone about the middle: about a corner, edges would run along the cells of the quadrature.
  static Region region(const Vec3<double>& r) {
    const Vec3<double> to_middle = Vec3<double>{0.31, 0.29, 0} - r;
    return {normalized(to_middle), 1.05 * std::asin(0.79 / length(to_middle))};
  }
  static Rgb<double> emitted(const Vec3<double>& p, const Vec3<double>&) {
    return shown(uv(p).x, uv(p).y);
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    return std::fmax(std::fabs(p.z), std::fmax(std::fmax(-p.x, -p.y), p.x + p.y - 1));
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    return {1 - std::sqrt(x), std::sqrt(x) * y, 0};
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    return {(1 - p.x) * (1 - p.x), p.y / (1 - p.x)};
  }
  static double emission_area_m2() { return 0.5; }
  static Region emission_region(const Vec3<double>&) { return hemisphere({0, 0, 1}); }
  static constexpr double kPowerTolerance = 1e-5;  // of the quadrature, across kinks
  static Rgb<double> power_by_quadrature() {
    constexpr int kGrid = 2000;
    Rgb<double> sum;
    for (int i = 0; i < kGrid; ++i)
      for (int j = 0; j < kGrid; ++j) {
        const Vec3<double> p = emission_position({}, (i + 0.5) / kGrid, (j + 0.5) / kGrid);
        sum += shown(uv(p).x, uv(p).y) * (0.5 * kPi / (double(kGrid) * kGrid));
      }
    return sum;
  }
};

/// Half of an annulus of 0.5 to 1.
struct PaintedDiskCase : PaintedCase {
  template <typename Real>
  using Light = PaintedDiskLight<Real>;
  template <typename Real>
  static Light<Real> make(const Placement& at) {
    return *Light<Real>::create(
        {kLevel}, *PaintedDisk<Real>::create(
                      *Disk<Real>::create({.radius_m = 1,
                                           .inner_radius_m = 0.5,
                                           .phi_max_rad = kPi,
                                           .world_from_object = at.world_from_light()}),
                      picture(ImageFilter::kBilinear)));
  }
  static std::vector<Vec3<double>> receivers() { return {{0, 0.5, 2}, {2, -1, 1.5}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 1.02); }
  static Rgb<double> emitted(const Vec3<double>& p, const Vec3<double>&) {
    return shown(std::atan2(p.y, p.x) / kPi, (1 - std::hypot(p.x, p.y)) / 0.5);
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    const double r = std::hypot(p.x, p.y);
    return std::fmax(std::fabs(p.z), std::fmax(std::fmax(r - 1, 0.5 - r), -p.y));
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    const double r = std::sqrt(0.25 + 0.75 * x);
    return {r * std::cos(kPi * y), r * std::sin(kPi * y), 0};
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    return {(p.x * p.x + p.y * p.y - 0.25) / 0.75, std::atan2(p.y, p.x) / kPi};
  }
  static double emission_area_m2() { return kPi * 0.75 / 2; }
  static Region emission_region(const Vec3<double>&) { return hemisphere({0, 0, 1}); }
  /// r dr dphi, r = 1 - v / 2.
  static Rgb<double> power_by_quadrature() {
    return painted_power([](double, double v) { return (1 - v / 2) * 0.5 * kPi; });
  }
};

/// A quarter of the cap z > 0.75 of a sphere of radius 1, seen without its silhouette.
struct PaintedCapCase : PaintedCase {
  template <typename Real>
  using Light = PaintedSphereLight<Real>;
  static double widest() { return std::acos(0.75); }
  template <typename Real>
  static Light<Real> make(const Placement& at) {
    return *Light<Real>::create(
        {kLevel}, *PaintedSphere<Real>::create(
                      *Sphere<Real>::create({.radius_m = 1,
                                             .z_min_m = 0.75,
                                             .phi_max_rad = kPi / 2,
                                             .world_from_object = at.world_from_light()}),
                      picture(ImageFilter::kBilinear)));
  }
  static std::vector<Vec3<double>> receivers() { return {{0, 0.5, 3}, {1, 0, 3}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 1); }
  static Rgb<double> emitted(const Vec3<double>& p, const Vec3<double>&) {
    const double theta = std::atan2(std::hypot(p.x, p.y), p.z);
    return shown(std::atan2(p.y, p.x) / (kPi / 2), 1 - theta / widest());
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    const double b = dot(r, wi), c = dot(r, r) - 1;
    if (!(b * b > c)) return {};
    return emitted(r + wi * (-b - std::sqrt(b * b - c)), wi);
  }
  static double distance_to_surface(const Vec3<double>& p) {
    return std::fmax(std::fmax(std::fabs(length(p) - 1), 0.75 - p.z), std::fmax(-p.x, -p.y));
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    const double z = 0.75 + 0.25 * x, r = std::sqrt(1 - z * z);
    return {r * std::cos(kPi / 2 * y), r * std::sin(kPi / 2 * y), z};
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    return {(p.z - 0.75) / 0.25, std::atan2(p.y, p.x) / (kPi / 2)};
  }
  static double emission_area_m2() { return kPi / 2 * 0.25; }
  static Vec3<double> emission_direction(const Vec3<double>& p) { return normalized(p); }
  static Region emission_region(const Vec3<double>& p) { return hemisphere(p); }
  static Rgb<double> power_by_quadrature() {
    return painted_power(
        [](double, double v) { return std::sin(widest() * (1 - v)) * widest() * (kPi / 2); });
  }
};

/// A quarter of a tube of radius 0.5, -0.75 < z < 0.75.
struct PaintedTubeCase : PaintedCase {
  template <typename Real>
  using Light = PaintedCylinderLight<Real>;
  template <typename Real>
  static Light<Real> make(const Placement& at) {
    return *Light<Real>::create(
        {kLevel}, *PaintedCylinder<Real>::create(
                      *Cylinder<Real>::create({.radius_m = 0.5,
                                               .z_min_m = -0.75,
                                               .z_max_m = 0.75,
                                               .phi_max_rad = kPi / 2,
                                               .world_from_object = at.world_from_light()}),
                      picture(ImageFilter::kBilinear)));
  }
  static std::vector<Vec3<double>> receivers() { return {{2, 1.5, 0.25}, {1, 2, -2}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 0.91); }
  static Rgb<double> emitted(const Vec3<double>& p, const Vec3<double>&) {
    return shown(std::atan2(p.y, p.x) / (kPi / 2), p.z / 1.5 + 0.5);
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    const double a = wi.x * wi.x + wi.y * wi.y, b = r.x * wi.x + r.y * wi.y;
    const double root = b * b - a * (r.x * r.x + r.y * r.y - 0.25);
    return root > 0 ? emitted(r + wi * ((-b - std::sqrt(root)) / a), wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    const double off = std::fabs(std::hypot(p.x, p.y) - 0.5);
    return std::fmax(std::fmax(off, std::fabs(p.z) - 0.75), std::fmax(-p.x, -p.y));
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    return {0.5 * std::cos(kPi / 2 * y), 0.5 * std::sin(kPi / 2 * y), 0.75 * (2 * x - 1)};
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    return {(p.z / 0.75 + 1) / 2, std::atan2(p.y, p.x) / (kPi / 2)};
  }
  static double emission_area_m2() { return kPi / 2 * 0.5 * 1.5; }
  static Region emission_region(const Vec3<double>& p) { return hemisphere({p.x, p.y, 0}); }
  static Vec3<double> emission_direction(const Vec3<double>& p) {
    return normalized(Vec3<double>{p.x, p.y, 0});
  }
  static Vec3<double> far_direction() { return normalized(Vec3<double>{1, 1, 0.5}); }
  static Rgb<double> power_by_quadrature() {
    return painted_power([](double, double) { return kPi / 2 * 0.5 * 1.5; });
  }
};

using PaintedCases =
    ::testing::Types<ScreenCase, TwoTrianglesCase, TrapezoidCase, PaintedTriangleCase,
                     PaintedDiskCase, PaintedCapCase, PaintedTubeCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, AnyLight, PaintedCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, LightWithDensity, PaintedCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, LocalLight, PaintedCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, EmittingLight, PaintedCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, EmittingSurface, PaintedCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, EmittingDirections, PaintedCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, BoundedLight, PaintedCases);

}  // namespace
}  // namespace lucerna::testing
