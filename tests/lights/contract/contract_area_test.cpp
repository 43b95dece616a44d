// The contract suites on area lights: flat ones and those of several parts.  The expected answers
// come from solid geometry, not from the code of the shapes.
#include <algorithm>
#include <cmath>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/area_cases.h"
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/contract_irradiance.h"

namespace lucerna::testing {
namespace {

struct TriangleCase : AreaCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, 0}); };
    // The triangle (0, 0), (1, 0), (0, 1) in two parts of unequal area.
    return *Light::create({kLevel}, *TriangleMesh::create({{p(0, 0), p(0.25, 0), p(0, 1)},
                                                           {p(0.25, 0), p(1, 0), p(0, 1)}}));
  }
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}, {0, 3, 1.5}}; }
  /// A cone about the middle: about a corner, edges would run along the cells of the quadrature.
  static Region region(const Vec3& r) {
    const Vec3 to_middle = Vec3{0.31, 0.29, 0} - r;
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
  /// The width shrinks linearly to the corner (1, 0), so s^2 is a share of area.
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return {1 - std::sqrt(x), std::sqrt(x) * y, 0};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(1 - p.x) * (1 - p.x), p.y / (1 - p.x)};
  }
  static double emission_area_m2() { return 0.5; }
  static Region emission_region(const Vec3&) { return hemisphere({0, 0, 1}); }
  static Rgb power_by_quadrature() { return lambertian_power(0.5); }
};

/// A saddle z = x y / 2 over |x|, |y| < 1 that emits on both sides.
struct PatchCase : AreaCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, x * y / 2}); };
    return *Light::create({kLevel, true},
                          *PatchMesh::create({{p(-1, -1), p(1, -1), p(-1, 1), p(1, 1)}}));
  }
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 3}, {0.5, -1, -2.5}}; }
  static Rgb value(const Vec3&, const Vec3&) { return kLevel; }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z - p.x * p.y / 2), std::fmax(std::fabs(p.x), std::fabs(p.y)) - 1);
  }
  /// The area from -1 to y on the line of constant x, where dA = sqrt(1 + (x^2 + y^2) / 4) dx dy.
  /// With s = y / 2 it is the integral of 2 sqrt(c + s^2), c = 1 + x^2 / 4.
  static double area_of_line(double x, double y) {
    const double c = 1 + x * x / 4;
    const auto to = [&](double s) {
      return s * std::sqrt(c + s * s) + c * std::asinh(s / std::sqrt(c));
    };
    return to(y / 2) - to(-0.5);
  }
  /// The area from -1 to x, by the trapezoidal rule in 4096 steps.  Its error is below 1e-8.
  static const std::vector<double>& area_of_strips() {
    static const std::vector<double> sums = [] {
      std::vector<double> sums{0};
      for (int i = 0; i < 4096; ++i) {
        const double x = i / 2048. - 1;
        sums.push_back(sums.back() + (area_of_line(x, 1) + area_of_line(x + 1 / 2048., 1)) / 4096);
      }
      return sums;
    }();
    return sums;
  }
  static double emission_area_m2() { return area_of_strips().back(); }
  static Vec3 emission_position(const Vec3&, double u, double v) {
    const auto& sums = area_of_strips();
    const double target = u * sums.back();
    const auto i = std::clamp<std::ptrdiff_t>(
        std::upper_bound(sums.begin(), sums.end(), target) - sums.begin(), 1, 4096);
    const auto at = static_cast<std::size_t>(i);
    const double x =
        (double(i - 1) + (target - sums[at - 1]) / (sums[at] - sums[at - 1])) / 2048 - 1;
    double low = -1, high = 1;
    for (int step = 0; step < 50; ++step) {
      const double y = (low + high) / 2;
      (area_of_line(x, y) < v * area_of_line(x, 1) ? low : high) = y;
    }
    return {x, low, x * low / 2};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    const auto& sums = area_of_strips();
    const double at = std::clamp((p.x + 1) * 2048, 0.0, 4095.999);
    const auto i = static_cast<std::size_t>(at);
    const double below = std::lerp(sums[i], sums[i + 1], at - double(i));
    return {below / sums.back(), area_of_line(p.x, p.y) / area_of_line(p.x, 1)};
  }
  static Region emission_region(const Vec3&) { return {}; }
  static constexpr bool kConfined = false;
  static Rgb power_by_quadrature() {
    constexpr int kGrid = 1000;
    double area = 0;
    for (int i = 0; i < kGrid; ++i)
      for (int j = 0; j < kGrid; ++j) {
        const double x = 2 * (i + 0.5) / kGrid - 1, y = 2 * (j + 0.5) / kGrid - 1;
        area += std::sqrt(1 + (x * x + y * y) / 4) * 4 / (kGrid * kGrid);
      }
    return lambertian_power(2 * area);
  }
};

/// A closed box, |x| < 1, |y| < 1/2, |z| < 1/4, that emits outwards.  Parts of it always face away.
struct BoxCase : AreaCase {
  using Light = AreaLight;
  static Vec3 half_size() { return {1, 0.5, 0.25}; }
  static Light make(const Placement& at) {
    std::vector<BilinearPatch> faces;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1., 1.}) {
        const auto corner = [&](double s, double t) {
          // The handedness of the face changes with its side.
          const double v[3] = {side, side * s, t};
          return at.point({half_size().x * v[(3 - axis) % 3], half_size().y * v[(4 - axis) % 3],
                           half_size().z * v[(5 - axis) % 3]});
        };
        faces.push_back({corner(-1, -1), corner(1, -1), corner(-1, 1), corner(1, 1)});
      }
    }
    return *Light::create({kLevel}, *PatchMesh::create(std::move(faces)));
  }
  static std::vector<Vec3> receivers() { return {{2, 1.5, 1}, {0.125, 0.25, -2.5}}; }
  static Region region(const Vec3& r) {
    return {normalized(-r), 1.05 * std::asin(1.15 / length(r))};
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    double enter = 0, leave = INFINITY;  // between the planes of each pair
    for (int axis = 0; axis < 3; ++axis) {
      const double slack = half_size()[axis] + 1e-6;
      const double a = (slack - r[axis]) / wi[axis], b = (-slack - r[axis]) / wi[axis];
      enter = std::fmax(enter, std::fmin(a, b)), leave = std::fmin(leave, std::fmax(a, b));
    }
    return enter < leave ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    double outside = -INFINITY;
    for (int axis = 0; axis < 3; ++axis)
      outside = std::fmax(outside, std::fabs(p[axis]) - half_size()[axis]);
    return std::fabs(outside);
  }
  /// Faces one after the other, the two across x first, each with its share of the area.
  static double emission_area_m2() { return 8 * (0.5 * 0.25 + 0.25 * 1 + 1 * 0.5); }
  struct Face {
    int axis;
    double side, begin, end;  ///< its interval of the first coordinate
  };
  static std::vector<Face> faces() {
    std::vector<Face> all;
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1., 1.}) {
        const double area = 4 * half_size()[(axis + 1) % 3] * half_size()[(axis + 2) % 3];
        const double share = area / emission_area_m2();
        all.push_back({axis, side, sum, sum + share});
        sum += share;
      }
    return all;
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const auto all = faces();
    Face face = all.back();
    for (const Face& f : all)
      if (x >= f.begin && x < f.end) face = f;
    double v[3];
    v[face.axis] = face.side * half_size()[face.axis];
    const int s = (face.axis + 1) % 3, t = (face.axis + 2) % 3;
    v[s] = half_size()[s] * (2 * (x - face.begin) / (face.end - face.begin) - 1);
    v[t] = half_size()[t] * (2 * y - 1);
    return {v[0], v[1], v[2]};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    for (const Face& f : faces()) {
      if (std::fabs(p[f.axis] - f.side * half_size()[f.axis]) > 1e-6) continue;
      const int s = (f.axis + 1) % 3, t = (f.axis + 2) % 3;
      return {std::lerp(f.begin, f.end, (p[s] / half_size()[s] + 1) / 2),
              (p[t] / half_size()[t] + 1) / 2};
    }
    return {NAN, NAN};
  }
  static Vec3 emission_direction(const Vec3& p) { return emission_region(p).axis; }
  static Region emission_region(const Vec3& p) {
    // The normal of the face that the position lies on.
    Vec3 n;
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(std::fabs(p[axis]) - half_size()[axis]) < 1e-6)
        n = Vec3{axis == 0 ? p.x : 0, axis == 1 ? p.y : 0, axis == 2 ? p.z : 0};
    return hemisphere(n);
  }
  static constexpr bool kConfined = false;
  static Rgb power_by_quadrature() { return lambertian_power(8 * (0.5 + 0.25 + 0.125)); }
};

/// Half of an annulus of 0.5 to 1 that emits upwards.
struct DiskCase : AreaCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create({kLevel}, *Disk::create({.radius_m = 1,
                                                   .inner_radius_m = 0.5,
                                                   .phi_max_rad = kPi,
                                                   .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{0, 0.5, 2}, {2, -1, 1.5}}; }
  static double outside(const Vec3& p) {
    const double r = std::hypot(p.x, p.y);
    return std::fmax(std::fmax(r - 1, 0.5 - r), -p.y);
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto p = from_above(r, wi);
    return p && outside(*p) < 1e-6 ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) { return std::fmax(std::fabs(p.z), outside(p)); }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const double r = std::sqrt(0.25 + 0.75 * x);
    return {r * std::cos(kPi * y), r * std::sin(kPi * y), 0};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.x * p.x + p.y * p.y - 0.25) / 0.75, share_of_turn(p, kPi)};
  }
  static double emission_area_m2() { return kPi * 0.75 / 2; }
  static Region emission_region(const Vec3&) { return hemisphere({0, 0, 1}); }
  static Rgb power_by_quadrature() { return lambertian_power(kPi * 0.75 / 2); }
};

using AreaCases = ::testing::Types<TriangleCase, PatchCase, BoxCase, DiskCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Area, AnyLight, AreaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Area, LightWithDensity, AreaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Area, LocalLight, AreaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Area, EmittingLight, AreaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Area, EmittingDirections, AreaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Area, BoundedLight, AreaCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Area, EmittingSurface, AreaCases);

using AreasInClosedForm = ::testing::Types<TriangleCase, BoxCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Area, LightWithIrradiance, AreasInClosedForm);

TEST(LightWithIrradiance, CutOrBentShapesHaveNoClosedForm) {
  EXPECT_TRUE(has_irradiance<TriangleCase>());
  EXPECT_FALSE(has_irradiance<DiskCase>());
  EXPECT_FALSE(has_irradiance<PatchCase>());
}

TEST(LightWithIrradiance, OnlyLightsInSeveralPlanesHideThemselves) {
  EXPECT_TRUE(BoxCase::make({}).hides_itself());
  // Rotated and shifted, so that no corner is exactly in the plane of the others.
  EXPECT_FALSE(TriangleCase::make(moved()).hides_itself());
  EXPECT_FALSE(DiskCase::make({}).hides_itself());
  for (const double bend : {1e-12, 1e-6, 0.5}) {
    const auto mesh = *TriangleMesh::create(
        {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{1, 0, 0}, {1, 1, bend}, {0, 1, 0}}});
    EXPECT_TRUE(mesh.hides_itself()) << bend;
  }
}

}  // namespace
}  // namespace lucerna::testing
