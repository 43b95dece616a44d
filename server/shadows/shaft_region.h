// The region that shadow rays from a receiver to a light pass through, by planes.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "lights/maths/transform.h"
#include "server/rays/ray.h"
#include "server/rays/surface_table.h"
#include "server/shadows/light_outline.h"

namespace lucerna {

/// What is within has dot(n, x) <= at.
struct HalfSpace {
  Vec3<double> n;
  double at;
  bool is_side = false;  ///< neither the horizon nor the end
};

struct ShaftRegion {
  /// A dozen sides, the horizon and the end.
  std::array<HalfSpace, 16> planes;
  int count = 0;
  Vec3<double> apex;        ///< where shadow rays start
  Vec3<double> up, normal;  ///< the receiver's, geometric and as light is counted; unit
  double lowest = -1;       ///< sine of the lowest corner over either one's horizon
  Bounds box;               ///< of what of it may hold anything; empty: not known
  double largest_m = 0;     ///< coordinate within

  void add(const Vec3<double>& n, double at, bool is_side = false) {
    planes[count++] = {n, at, is_side};
  }
  std::span<const HalfSpace> half_spaces() const {
    return {planes.data(), static_cast<std::size_t>(count)};
  }
};

/// Of the rays from `receiver` on the side of `normal`; `hittable`: what can be hit is within,
/// empty where nothing can.  Nothing where it is not known, as Shafts::is_empty says.
std::optional<ShaftRegion> shaft_region(const LightOutline& light, const SurfaceHit& receiver,
                                        const Vec3<float>& normal, const Bounds& hittable);

/// The same in the space of an instance's object, but for apex, normals and box.
ShaftRegion in_object(const ShaftRegion& region, const Transform& scene_from_object);

}  // namespace lucerna
