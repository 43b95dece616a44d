// The contract suites on area lights with an emission image, for each shape.  The expected image
// comes from hat functions and each shape's own coordinates.
#include <cmath>
#include <optional>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/area_helpers.h"
#include "tests/lights/contract/contract.h"
#include "tests/lights/contract/contract_emission.h"

namespace lucerna::testing {
namespace {

constexpr Rgb kLevel{1, 2, 4};
constexpr int kColumns = 4, kRows = 3;

/// Rows from the top.
Rgbf texel(int x, int y) {
  constexpr float kLuminance[kRows][kColumns] = {{1, 6, 2, 0.5}, {3, 0.25, 5, 4}, {8, 2, 1, 7}};
  const float v = kLuminance[y][x];
  return {v, 0.5 * v + 0.125 * float(x), 0.25 + 0.25 * float(y)};
}

Picture picture(ImageFilter filter) {
  std::vector<Rgbf> texels;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x) texels.push_back(texel(x, y));
  return {*Image::create(kColumns, kRows, std::move(texels)), filter, "test"};
}

/// The picture at (u, v), v upwards: a sum of hats about the texels' centres.
Rgb shown(double u, double v, ImageFilter filter = ImageFilter::kBilinear) {
  const auto share = [&](double at, int n, int i) {
    const double c = std::fmin(std::fmax(at * n - 0.5, 0), n - 1);
    if (filter == ImageFilter::kNearest) return std::lround(c) == i ? 1.0 : 0.0;
    return std::fmax(0, 1 - std::fabs(c - i));
  };
  Rgb sum;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      sum += Rgb(texel(x, y)) * (share(u, kColumns, x) * share(1 - v, kRows, y));
  return sum * kLevel;
}

/// pi times the integral of `shown` over the surface; `element(u, v)` is its share of area.  The
/// grid is a multiple of twice the texels, so the function is smooth between its points.
template <typename Element>
Rgb painted_power(Element&& element, ImageFilter filter = ImageFilter::kBilinear) {
  constexpr int kGrid = 1200;
  Rgb sum;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double u = (i + 0.5) / kGrid, v = (j + 0.5) / kGrid;
      sum += shown(u, v, filter) * (element(u, v) / (kGrid * kGrid));
    }
  return sum * kPi;
}

struct PaintedCase : CaseDefaults {
  static constexpr bool kConfined = true;
  static Region hemisphere(const Vec3& n) { return {normalized(n), kPi / 2}; }
  static std::optional<Vec3> in_plane(const Vec3& r, const Vec3& wi) {
    const double t = -r.z / wi.z;
    if (!(t > 0)) return std::nullopt;
    return r + wi * t;
  }
  /// All within `reach` of the origin.
  static Region seen(const Vec3& receiver, double reach) {
    return {normalized(-receiver), 1.05 * std::asin(reach / length(receiver))};
  }
};

/// A parallelogram that faces +z.
struct ScreenCase : PaintedCase {
  using Light = AreaLight;
  static Vec3 at(double u, double v) { return {2 * u + 0.5 * v - 1.25, v - 0.5, 0}; }
  static Vec2 uv(const Vec3& p) { return {(p.x + 1.25 - 0.5 * (p.y + 0.5)) / 2, p.y + 0.5}; }
  static Light make(const Placement& placement) {
    const auto p = [&](double u, double v) { return placement.point(at(u, v)); };
    return *Light::create({kLevel}, *PatchMesh::create({{p(0, 0), p(1, 0), p(0, 1), p(1, 1)}}),
                          {.picture = picture(ImageFilter::kBilinear)});
  }
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}}; }
  static Region region(const Vec3& r) { return seen(r, 1.4); }
  static Rgb emitted(const Vec3& p, const Vec3&) { return shown(uv(p).x, uv(p).y); }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    const auto [u, v] = uv(p);
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(u - 0.5), std::fabs(v - 0.5)) - 0.5);
  }
  static Vec3 emission_position(const Vec3&, double x, double y) { return at(x, y); }
  static Vec2 emission_where(const Vec3& p, const Vec3&) { return uv(p); }
  static double emission_area_m2() { return 2; }
  static Region emission_region(const Vec3&) { return hemisphere({0, 0, 1}); }
  static Rgb power_by_quadrature() {
    return painted_power([](double, double) { return 2.0; });
  }
};

/// The same as two triangles, cut from corner to corner.
struct TwoTrianglesCase : ScreenCase {
  using Light = AreaLight;
  static Light make(const Placement& placement) {
    const auto p = [&](double u, double v) { return placement.point(at(u, v)); };
    return *Light::create(
        {kLevel},
        *TriangleMesh::create({{p(1, 0), p(1, 1), p(0, 0)}, {p(0, 1), p(0, 0), p(1, 1)}},
                              {{1, 0}, {1, 1}, {0, 0}, {0, 1}, {0, 0}, {1, 1}}),
        {.picture = picture(ImageFilter::kBilinear)});
  }
};

/// A two-sided trapezoid.  The picture lies on its side and shows its texels without a filter.
struct TrapezoidCase : PaintedCase {
  using Light = AreaLight;
  static Vec3 at(double s, double t) { return {(2 * s - 1) * (1 - t / 2), 2 * t - 1, 0}; }
  static Vec2 st(const Vec3& p) {
    const double t = (p.y + 1) / 2;
    return {(p.x / (1 - t / 2) + 1) / 2, t};
  }
  static Light make(const Placement& placement) {
    const auto p = [&](double s, double t) { return placement.point(at(s, t)); };
    return *Light::create({kLevel, true},
                          *PatchMesh::create({{p(0, 0), p(1, 0), p(0, 1), p(1, 1)}},
                                             {{1, 0}, {1, 1}, {0, 0}, {0, 1}}),
                          {.picture = picture(ImageFilter::kNearest)});
  }
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {0.5, -1, -2.5}}; }
  static Region region(const Vec3& r) { return seen(r, 1.42); }
  static Rgb emitted(const Vec3& p, const Vec3&) {
    return shown(1 - st(p).y, st(p).x, ImageFilter::kNearest);
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    const auto [s, t] = st(p);
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(s - 0.5), std::fabs(t - 0.5)) - 0.5);
  }
  /// The area below t is 4 t - t^2, of 3.
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return at(x, 2 - std::sqrt(4 - 3 * y));
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    const auto [s, t] = st(p);
    return {s, (4 * t - t * t) / 3};
  }
  static double emission_area_m2() { return 3; }
  static Region emission_region(const Vec3&) { return {}; }
  static constexpr bool kConfined = false;
  /// |dp/ds x dp/dt| = 4 - 2 t, t = 1 - u; both sides.
  static Rgb power_by_quadrature() {
    return painted_power([](double u, double) { return 2 * (4 - 2 * (1 - u)); },
                         ImageFilter::kNearest);
  }
};

/// Two triangles of one plane.  The picture's border continues beyond u = 1.
struct PaintedTriangleCase : PaintedCase {
  using Light = AreaLight;
  static Vec2 uv(const Vec3& p) { return {0.25 + 1.0 * p.x, 0.125 + 0.25 * p.x + 0.75 * p.y}; }
  static Light make(const Placement& at) {
    std::vector<Triangle> triangles;
    std::vector<Vec2f> corner_uv;
    const double corners[2][3][2] = {{{0, 0}, {0.25, 0}, {0, 1}}, {{0.25, 0}, {1, 0}, {0, 1}}};
    for (const auto& t : corners) {
      Vec3 p[3];
      for (int k = 0; k < 3; ++k) {
        const Vec3 corner{t[k][0], t[k][1], 0};
        p[k] = at.point(corner);
        corner_uv.push_back({float(uv(corner).x), float(uv(corner).y)});
      }
      triangles.push_back({p[0], p[1], p[2]});
    }
    return *Light::create({kLevel},
                          *TriangleMesh::create(std::move(triangles), std::move(corner_uv)),
                          {.picture = picture(ImageFilter::kBilinear)});
  }
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {0, 3, 1.5}}; }
  /// A cone about the middle: about a corner, edges would run along the cells of the quadrature.
  static Region region(const Vec3& r) {
    const Vec3 to_middle = Vec3{0.31, 0.29, 0} - r;
    return {normalized(to_middle), 1.05 * std::asin(0.79 / length(to_middle))};
  }
  static Rgb emitted(const Vec3& p, const Vec3&) { return shown(uv(p).x, uv(p).y); }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z), std::fmax(std::fmax(-p.x, -p.y), p.x + p.y - 1));
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return {1 - std::sqrt(x), std::sqrt(x) * y, 0};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(1 - p.x) * (1 - p.x), p.y / (1 - p.x)};
  }
  static double emission_area_m2() { return 0.5; }
  static Region emission_region(const Vec3&) { return hemisphere({0, 0, 1}); }
  static constexpr double kPowerTolerance = 1e-5;  // of the quadrature, across kinks
  static Rgb power_by_quadrature() {
    constexpr int kGrid = 2000;
    Rgb sum;
    for (int i = 0; i < kGrid; ++i)
      for (int j = 0; j < kGrid; ++j) {
        const Vec3 p = emission_position({}, (i + 0.5) / kGrid, (j + 0.5) / kGrid);
        sum += shown(uv(p).x, uv(p).y) * (0.5 * kPi / (double(kGrid) * kGrid));
      }
    return sum;
  }
};

/// Half of an annulus of 0.5 to 1.
struct PaintedDiskCase : PaintedCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create({kLevel},
                          *Disk::create({.radius_m = 1,
                                         .inner_radius_m = 0.5,
                                         .phi_max_rad = kPi,
                                         .world_from_object = at.world_from_light()}),
                          {.picture = picture(ImageFilter::kBilinear)});
  }
  static std::vector<Vec3> receivers() { return {{0, 0.5, 2}, {2, -1, 1.5}}; }
  static Region region(const Vec3& r) { return seen(r, 1.02); }
  static Rgb emitted(const Vec3& p, const Vec3&) {
    return shown(std::atan2(p.y, p.x) / kPi, (1 - std::hypot(p.x, p.y)) / 0.5);
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = in_plane(r, wi);
    return p ? emitted(*p, wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    const double r = std::hypot(p.x, p.y);
    return std::fmax(std::fabs(p.z), std::fmax(std::fmax(r - 1, 0.5 - r), -p.y));
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const double r = std::sqrt(0.25 + 0.75 * x);
    return {r * std::cos(kPi * y), r * std::sin(kPi * y), 0};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.x * p.x + p.y * p.y - 0.25) / 0.75, std::atan2(p.y, p.x) / kPi};
  }
  static double emission_area_m2() { return kPi * 0.75 / 2; }
  static Region emission_region(const Vec3&) { return hemisphere({0, 0, 1}); }
  /// r dr dphi, r = 1 - v / 2.
  static Rgb power_by_quadrature() {
    return painted_power([](double, double v) { return (1 - v / 2) * 0.5 * kPi; });
  }
};

/// A quarter of the cap z > 0.75 of a sphere of radius 1, seen without its silhouette.
struct PaintedCapCase : PaintedCase {
  using Light = AreaLight;
  static double widest() { return std::acos(0.75); }
  static Light make(const Placement& at) {
    return *Light::create({kLevel},
                          *Sphere::create({.radius_m = 1,
                                           .z_min_m = 0.75,
                                           .phi_max_rad = kPi / 2,
                                           .world_from_object = at.world_from_light()}),
                          {.picture = picture(ImageFilter::kBilinear)});
  }
  static std::vector<Vec3> receivers() { return {{0, 0.5, 3}, {1, 0, 3}}; }
  static Region region(const Vec3& r) { return seen(r, 1); }
  static Rgb emitted(const Vec3& p, const Vec3&) {
    const double theta = std::atan2(std::hypot(p.x, p.y), p.z);
    return shown(std::atan2(p.y, p.x) / (kPi / 2), 1 - theta / widest());
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const double b = dot(r, wi), c = dot(r, r) - 1;
    if (!(b * b > c)) return {};
    return emitted(r + wi * (-b - std::sqrt(b * b - c)), wi);
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fmax(std::fabs(length(p) - 1), 0.75 - p.z), std::fmax(-p.x, -p.y));
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const double z = 0.75 + 0.25 * x, r = std::sqrt(1 - z * z);
    return {r * std::cos(kPi / 2 * y), r * std::sin(kPi / 2 * y), z};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.z - 0.75) / 0.25, std::atan2(p.y, p.x) / (kPi / 2)};
  }
  static double emission_area_m2() { return kPi / 2 * 0.25; }
  static Vec3 emission_direction(const Vec3& p) { return normalized(p); }
  static Region emission_region(const Vec3& p) { return hemisphere(p); }
  static Rgb power_by_quadrature() {
    return painted_power(
        [](double, double v) { return std::sin(widest() * (1 - v)) * widest() * (kPi / 2); });
  }
};

/// A quarter of a tube of radius 0.5, -0.75 < z < 0.75.
struct PaintedTubeCase : PaintedCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create({kLevel},
                          *Cylinder::create({.radius_m = 0.5,
                                             .z_min_m = -0.75,
                                             .z_max_m = 0.75,
                                             .phi_max_rad = kPi / 2,
                                             .world_from_object = at.world_from_light()}),
                          {.picture = picture(ImageFilter::kBilinear)});
  }
  static std::vector<Vec3> receivers() { return {{2, 1.5, 0.25}, {1, 2, -2}}; }
  static Region region(const Vec3& r) { return seen(r, 0.91); }
  static Rgb emitted(const Vec3& p, const Vec3&) {
    return shown(std::atan2(p.y, p.x) / (kPi / 2), p.z / 1.5 + 0.5);
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const double a = wi.x * wi.x + wi.y * wi.y, b = r.x * wi.x + r.y * wi.y;
    const double root = b * b - a * (r.x * r.x + r.y * r.y - 0.25);
    return root > 0 ? emitted(r + wi * ((-b - std::sqrt(root)) / a), wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    const double off = std::fabs(std::hypot(p.x, p.y) - 0.5);
    return std::fmax(std::fmax(off, std::fabs(p.z) - 0.75), std::fmax(-p.x, -p.y));
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return {0.5 * std::cos(kPi / 2 * y), 0.5 * std::sin(kPi / 2 * y), 0.75 * (2 * x - 1)};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.z / 0.75 + 1) / 2, std::atan2(p.y, p.x) / (kPi / 2)};
  }
  static double emission_area_m2() { return kPi / 2 * 0.5 * 1.5; }
  static Region emission_region(const Vec3& p) { return hemisphere({p.x, p.y, 0}); }
  static Vec3 emission_direction(const Vec3& p) { return normalized(Vec3{p.x, p.y, 0}); }
  static Vec3 far_direction() { return normalized(Vec3{1, 1, 0.5}); }
  static Rgb power_by_quadrature() {
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
