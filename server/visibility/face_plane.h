// A plane with the faces of one material that lie in it.
#pragma once

#include <absl/container/inlined_vector.h>

#include <algorithm>
#include <cmath>

#include "server/rays/error_bounds.h"
#include "server/visibility/smooth_part.h"

namespace lucerna {

/// Distance of a face from a plane that it may have by the rounding of its corners.
inline double plane_error(const Vec3& p) { return 8 * kFloatRoundoff * max_abs(p) + kLeastError; }

/// The corners of a flat face.
using Face = absl::InlinedVector<Vec3, 4>;

/// A plane with the faces that were found in it so far.
struct FacePlane {
  SmoothPart part;  // `middle` is a corner until it is finished
  Vec3 u, v;        // unit axes of the rectangle
  double u_min = 0, u_max = 0, v_min = 0, v_max = 0;

  FacePlane(const SmoothPart& like, const Vec3& normal, const Face& face) : part(like) {
    part.n = normal;
    part.middle = face[0];
    Vec3 longest;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vec3 edge = face[(i + 1) % face.size()] - face[i];
      if (length(edge) > length(longest)) longest = edge;
    }
    u = normalized(longest - normal * dot(longest, normal));
    v = cross(normal, u);
    add(face);
  }
  explicit FacePlane(const SmoothPart& sphere) : part(sphere) {}
  bool contains(const Vec3& normal, const Face& face) const {
    if (part.is_sphere) return false;
    // Rounding of the corners turns small faces, far from the origin.
    double longest = 0;
    for (const Vec3& p : face) longest = std::fmax(longest, length(p - face[0]));
    const double turned = 2 * plane_error(face[0]) / longest;
    if (!(length(normal - part.n) < 1e-3 + std::fmin(turned, 0.04))) return false;
    return std::ranges::all_of(face, [&](const Vec3& p) {
      return std::fabs(part.height(p)) <= plane_error(p) + plane_error(part.middle);
    });
  }
  void add(const Face& face) {
    for (const Vec3& p : face) {
      const double a = dot(p - part.middle, u), b = dot(p - part.middle, v);
      u_min = std::fmin(u_min, a), u_max = std::fmax(u_max, a);
      v_min = std::fmin(v_min, b), v_max = std::fmax(v_max, b);
    }
  }
  Face rectangle() const {
    const auto corner = [&](double a, double b) { return part.middle + u * a + v * b; };
    return {corner(u_min, v_min), corner(u_max, v_min), corner(u_max, v_max), corner(u_min, v_max)};
  }
  /// Whether another plane is the same one, with the same material.
  bool joins(const FacePlane& other) const {
    return !other.part.is_sphere && part.material == other.part.material &&
           part.refracts == other.part.refracts && part.glossy_alpha == other.part.glossy_alpha &&
           contains(other.part.n, other.rectangle());
  }
  SmoothPart finished() const {
    SmoothPart p = part;
    if (p.is_sphere) return p;
    p.middle += u * ((u_min + u_max) / 2) + v * ((v_min + v_max) / 2);
    p.half_u = u * ((u_max - u_min) / 2);
    p.half_v = v * ((v_max - v_min) / 2);
    return p;
  }
};

}  // namespace lucerna
