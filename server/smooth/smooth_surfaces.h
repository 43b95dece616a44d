// The surfaces of a scene that send light on in single directions: mirrors, panes, glass, coats.
//
// Samples of surface directions meet a lamp behind such a surface by chance only, and never meet a
// lamp without a size.  So faces in one plane, and whole mirror balls, become parts.  For these a
// path from a receiver to a lamp is computed (specular_path.h).  All other smooth surfaces are
// listed as unsolved.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lights/maths/vec.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Faces in one plane, or a whole sphere, of one material.  About the scene's origin [m].
struct SmoothPart {
  bool is_sphere = false;  ///< reflects on its outside only
  bool reflects = false;
  /// Whether light passes it in a single direction.  Panes that direct light passes do not count.
  bool refracts = false;
  /// Of a plane that is nearly a mirror: the roughness alpha of its facets; else 0.
  double glossy_alpha = 0;
  /// The index on the side to which -n points, over that to which n points.
  double eta = 1;
  /// The share of light that it reflects along its normal, at some point of it.  For choices only.
  double reflected = 0;
  std::uint32_t material = 0;
  /// Of a plane: unit, on the outside.
  Vec3<double> n{};
  /// Of a plane: the middle of a rectangle that contains the faces, and half its edges.  Of a
  /// sphere: its centre.
  Vec3<double> middle{}, half_u{}, half_v{};
  double radius_m = 0;  ///< of a sphere

  /// The height of `p` over the plane, on the side of n [m].
  double height(const Vec3<double>& p) const { return dot(n, p - middle); }
  /// The lowest and the highest corner of this rectangle over the plane of `other` [m].
  std::pair<double, double> heights_over(const SmoothPart& other) const;
  /// Whether a point of the plane lies within the rectangle, or within a thousandth of it.
  bool may_contain(const Vec3<double>& p) const;
};

/// A smooth surface by way of which paths are not computed.
struct UnsolvedSurface {
  SourceLocation where;
  Bounds bounds_m;  ///< about the scene's origin
  /// Nearly a mirror: directions find lamps with a size by way of it, but hardly delta lights.
  bool is_glossy = false;
};

/// The smooth surfaces of a scene.  Immutable; may be read from any thread.
class SmoothSurfaces {
 public:
  explicit SmoothSurfaces(const Scene& scene);

  bool empty() const { return parts_.empty() && unsolved_.empty(); }
  std::span<const SmoothPart> parts() const { return parts_; }
  std::span<const UnsolvedSurface> unsolved() const { return unsolved_; }
  /// The part that a ray hit; kNone where it is no part.
  static constexpr std::int32_t kNone = -1;
  std::int32_t part_of(const SurfaceHit& hit) const;
  /// Whether any material of the scene scatters light in more than single directions.
  bool has_rough_surfaces() const { return has_rough_surfaces_; }
  std::size_t bytes() const;

 private:
  class Collector;
  /// The parts of consecutive primitives of one kind that belong to one shape.
  struct ShapeParts {
    std::uint32_t first = 0;
    std::vector<std::int32_t> parts;
  };
  static std::uint64_t key(std::uint64_t shape, HitKind kind) {
    return shape * kHitKinds + static_cast<std::uint64_t>(kind);
  }

  std::vector<SmoothPart> parts_;
  std::vector<UnsolvedSurface> unsolved_;
  std::unordered_map<std::uint64_t, ShapeParts> of_shape_;
  bool has_rough_surfaces_ = false;
};

/// The smooth surfaces of a scene, collected at the first call.  LazyPart states the rules for
/// callers.
const SmoothSurfaces& smooth_surfaces(const Scene& scene);

}  // namespace lucerna
