// Where smooth surfaces send light that no solved path brings.
//
// Lenses, water and bent panes gather light in spots.  Directions of a receiver rarely meet the
// part of such a surface in which it sees a lamp.  Rays from the lamps show these parts, as the
// photons of [Jensen95] do.  They only say where to look: the estimate has the right mean whatever
// they find.
#pragma once

#include <absl/container/inlined_vector.h>

#include <cstddef>
#include <span>
#include <vector>

#include "lights/maths/vec.h"
#include "server/scene/scene.h"

namespace lucerna {

/// A ray of light as it leaves the last smooth surface.
struct LampRay {
  Vec3f from;  ///< on the surface, about the scene's origin [m]
  Vec3f along;
};

/// Rays from all lights with a size.  Immutable.
class LampRays {
 public:
  explicit LampRays(const Scene& scene);

  std::span<const LampRay> rays() const { return rays_; }
  std::size_t bytes() const { return rays_.capacity() * sizeof(LampRay); }

 private:
  std::vector<LampRay> rays_;
};

/// The rays of a scene by way of surfaces without computed paths, made at the first call.  Empty
/// without such surfaces.  LazyPart states the rules for callers.
std::span<const LampRay> lamp_rays(const Scene& scene);

/// Directions from a receiver to where the rays that pass it closest left the last surface.
class GuidedDirections {
 public:
  GuidedDirections() = default;
  /// `n`: unit; directions below the horizon are left out.
  GuidedDirections(std::span<const LampRay> rays, const Vec3& receiver, const Vec3& n);

  bool any() const { return !cones_.empty(); }
  /// Adds directions within an angle of `axis`, unit.
  void add(const Vec3& axis, double angle_rad);
  /// Unit.  `u` in [0, 1)^2.  Only if there are any.
  Vec3f sample(Vec2f u) const;
  double pdf(const Vec3f& w) const;  ///< [1/sr]

 private:
  struct Cone {
    Vec3f axis;
    float one_minus_cos;
  };
  static constexpr std::size_t kCones = 32;
  absl::InlinedVector<Cone, kCones + 1> cones_;
};

}  // namespace lucerna
