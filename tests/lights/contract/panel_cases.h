// Panels with a luminaire's photometry for the contract suites.  The photometry is looked up here,
// on a grid of right angles and half right angles.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/area_helpers.h"
#include "tests/lights/contract/contract.h"

namespace lucerna::testing {

inline constexpr Rgb kPanelLevel{1, 2, 4};
inline constexpr int kPolar = 5, kPlanes = 4;
/// Intensity at 0, 45, 90, 135 and 180 degrees from +z, in the planes C0, C90, C180 and C270 [cd].
inline constexpr double kIntensity[kPlanes][kPolar] = {
    {100, 80, 30, 15, 10}, {100, 120, 20, 25, 10}, {100, 60, 10, 5, 10}, {100, 40, 40, 35, 10}};

inline std::shared_ptr<const PhotometricWeb> web() {
  PhotometricWebParams params;
  params.vertical_deg = {0, 45, 90, 135, 180};
  params.horizontal_deg = {0, 90, 180, 270, 360};
  for (int plane = 0; plane <= kPlanes; ++plane)
    for (const double cd : kIntensity[plane % kPlanes]) params.intensity_cd.push_back(cd);
  return *PhotometricWeb::create(params);
}

/// Intensity towards `w` in photometric axes: C0 is +x, C90 is -y.
inline double intensity(const Vec3& w) {
  const double theta = std::atan2(std::hypot(w.x, w.y), w.z) / (kPi / 4);
  double phi = std::atan2(-w.y, w.x) / (kPi / 2);
  if (phi < 0) phi += 4;
  const int row = std::min(int(theta), 3), plane = std::min(int(phi), 3);
  const double t = theta - row, s = phi - plane;
  const auto at = [&](int p, int r) { return kIntensity[p % kPlanes][r]; };
  return (at(plane, row) * (1 - t) + at(plane, row + 1) * t) * (1 - s) +
         (at(plane + 1, row) * (1 - t) + at(plane + 1, row + 1) * t) * s;
}

/// The integral of the intensity over the angles up to `widest` from +z.  The grid's lines fall
/// between its steps.
inline Rgb flux(double widest) {
  constexpr int kGrid = 2000;
  double sum = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double theta = widest * (i + 0.5) / kGrid, phi = 2 * kPi * (j + 0.5) / kGrid;
      const double r = std::sin(theta);
      sum += intensity({r * std::cos(phi), r * std::sin(phi), std::cos(theta)}) * r;
    }
  return kPanelLevel * (sum * widest * 2 * kPi / (double(kGrid) * kGrid));
}

/// The web with C0 towards `tangent`.
inline PanelProfile profile(std::shared_ptr<const PhotometricWeb> of,
                            const Vec3& tangent = {1, 0, 0}, bool mirrored = false) {
  PanelProfile made;
  made.web = std::move(of);
  made.tangent = tangent;
  made.mirrored = mirrored;
  return made;
}

struct PanelCase : CaseDefaults {
  static std::optional<Vec3> in_plane(const Vec3& r, const Vec3& wi) {
    const double t = -r.z / wi.z;
    if (!(t > 0)) return std::nullopt;
    return r + wi * t;
  }
  static Region seen(const Vec3& receiver, double reach) {
    return {normalized(-receiver), 1.05 * std::asin(reach / length(receiver))};
  }
};

/// A rectangle of 2 x 1 m that faces +z, with C0 along its longer side.
struct RectanglePanelCase : PanelCase {
  using Light = AreaLight;
  static constexpr double kArea = 2;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, 0}); };
    return *Light::create({kPanelLevel},
                          *PatchMesh::create({{p(-1, -0.5), p(1, -0.5), p(-1, 0.5), p(1, 0.5)}}),
                          {.profile = profile(web(), at.direction({1, 0, 0}))});
  }
  /// The candela of the file do not depend on the size.
  static constexpr int kValueLengthPower = -2;
  static constexpr int kPowerLengthPower = 0;
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}, {1, -3, 1}}; }
  static Region region(const Vec3& r) { return seen(r, 1.12); }
  static Rgb emitted(const Vec3&, const Vec3& w) {
    return kPanelLevel * (intensity(w) / (kArea * w.z));
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    return in_plane(r, wi) ? emitted({}, -wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(p.x) - 1, std::fabs(p.y) - 0.5));
  }
  static Vec3 emission_position(const Vec3&, double x, double y) { return {2 * x - 1, y - 0.5, 0}; }
  static Vec2 emission_where(const Vec3& p, const Vec3&) { return {(p.x + 1) / 2, p.y + 0.5}; }
  static double emission_area_m2() { return kArea; }
  static Region emission_region(const Vec3&) { return {{0, 0, 1}, kPi / 2}; }
  static constexpr bool kConfined = true;
  static Rgb power_by_quadrature() { return flux(kPi / 2); }
};

/// The same as three triangles of unequal area, with C0 towards (1, 2).
struct TrianglePanelCase : RectanglePanelCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, 0}); };
    return *Light::create({kPanelLevel},
                          *TriangleMesh::create({{p(-1, -0.5), p(0.5, -0.5), p(-1, 0.5)},
                                                 {p(0.5, -0.5), p(1, -0.5), p(1, 0.5)},
                                                 {p(0.5, -0.5), p(1, 0.5), p(-1, 0.5)}}),
                          {.profile = profile(web(), at.direction({1, 2, 0}))});
  }
  static Rgb emitted(const Vec3&, const Vec3& w) {
    const double s = std::sqrt(0.2);
    // y = z cross x = (-2, 1).
    const Vec3 local{(w.x + 2 * w.y) * s, (w.y - 2 * w.x) * s, w.z};
    return kPanelLevel * (intensity(local) / (kArea * w.z));
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    return in_plane(r, wi) ? emitted({}, -wi) : Rgb{};
  }
};

/// A disk of radius 0.75 that emits on both sides, mirrored, with C0 towards (1, 1).
struct DiskPanelCase : PanelCase {
  using Light = AreaLight;
  static constexpr double kArea = kPi * 0.75 * 0.75;
  static Light make(const Placement& at) {
    return *Light::create(
        {kPanelLevel, true},
        *Disk::create({.radius_m = 0.75, .world_from_object = at.world_from_light()}),
        {.profile = profile(web(), at.direction({1, 1, 0.5}), true)});
  }
  static constexpr int kValueLengthPower = -2;
  static constexpr int kPowerLengthPower = 0;
  static std::vector<Vec3> receivers() { return {{0.5, 0.25, 2}, {0.5, -1, -1.5}}; }
  static Region region(const Vec3& r) { return seen(r, 0.76); }
  static Rgb emitted(const Vec3&, const Vec3& w) {
    const double s = std::sqrt(0.5);
    // x towards (1, 1), y = x cross z = (1, -1).
    const Vec3 local{(w.x + w.y) * s, (w.x - w.y) * s, w.z};
    return kPanelLevel * (intensity(local) / (kArea * std::fabs(w.z)));
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    return in_plane(r, wi) ? emitted({}, -wi) : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(p.z), std::hypot(p.x, p.y) - 0.75);
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const double r = 0.75 * std::sqrt(x);
    return {r * std::cos(2 * kPi * y), r * std::sin(2 * kPi * y), 0};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    const double y = std::atan2(p.y, p.x) / (2 * kPi);
    return {(p.x * p.x + p.y * p.y) / (0.75 * 0.75), y < 0 ? y + 1 : y};
  }
  static double emission_area_m2() { return kArea; }
  static Region emission_region(const Vec3&) { return {}; }
  static constexpr bool kConfined = false;
  static Rgb power_by_quadrature() { return flux(kPi); }
};

}  // namespace lucerna::testing
