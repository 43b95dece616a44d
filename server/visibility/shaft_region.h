// The region of all shadow rays from a receiver to a light, bounded by planes.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "lights/maths/transform.h"
#include "server/rays/ray.h"
#include "server/rays/surface_table.h"
#include "server/visibility/light_outline.h"

namespace lucerna {

/// The points x with dot(n, x) <= at.
struct HalfSpace {
  Vec3 n;
  double at;
  bool is_side = false;  ///< false for the horizon and the end
};

struct ShaftRegion {
  /// At most a dozen sides, the horizon and the end.
  std::array<HalfSpace, 16> planes;
  int count = 0;
  Vec3 apex;  ///< the start of the shadow rays
  /// The receiver's geometric normal, and the normal of the side on which light counts; unit.
  Vec3 up, normal;
  double lowest = -1;    ///< smallest sine of a corner over either horizon
  Bounds box;            ///< of the part that may contain surfaces; empty: unknown
  double largest_m = 0;  ///< largest coordinate within

  void add(const Vec3& n, double at, bool is_side = false) { planes[count++] = {n, at, is_side}; }
  std::span<const HalfSpace> half_spaces() const {
    return {planes.data(), static_cast<std::size_t>(count)};
  }
};

/// The region of the rays from `receiver` on the side of `normal`.  `hittable`: box of everything
/// that can be hit; empty if there is nothing.  Nothing if the region is unknown, as in
/// Shafts::is_empty.
std::optional<ShaftRegion> shaft_region(const LightOutline& light, const SurfaceHit& receiver,
                                        const Vec3f& normal, const Bounds& hittable);

/// The region in the space of an instance's object, except apex, normals and box.
ShaftRegion in_object(const ShaftRegion& region, const Transform& scene_from_object);

}  // namespace lucerna
