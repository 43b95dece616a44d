// The surfaces of a scene that send light on in single directions: mirrors, panes, glass, coats.
//
// Samples of surface directions meet a lamp behind such a surface by chance only, and never meet a
// lamp without a size.  So faces in one plane, and whole mirror balls, become parts.  For these a
// path from a receiver to a lamp is computed (specular_path.h).  All other smooth surfaces are
// listed as unsolved.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/scene/scene.h"
#include "server/visibility/part_tree.h"
#include "server/visibility/smooth_part.h"

namespace lucerna {

/// A smooth surface by way of which paths are not computed.
struct UnsolvedSurface {
  enum class Kind : std::uint8_t {
    kSmooth,
    kNearlySmooth,
    /// Planes that are nearly mirrors, with other parts: paths by way of several.
    kNearlySmoothChain,
    /// Parts of which a solved path has one at most: many, or mirror balls.
    kCrowd
  };
  SourceLocation where;
  Bounds bounds_m;  ///< about the scene's origin
  Kind kind = Kind::kSmooth;
};

/// The smooth surfaces of a scene.  Immutable; may be read from any thread.
class SmoothSurfaces {
 public:
  static constexpr const char* kPartName = "smooth surfaces";
  explicit SmoothSurfaces(const Scene& scene);

  bool empty() const { return parts_.empty() && unsolved_.empty(); }
  std::span<const SmoothPart> parts() const { return parts_; }
  /// With this many parts or fewer, paths by way of several are computed.  Else only those by way
  /// of one, and all parts together are one more unsolved surface.
  static constexpr std::size_t kFewParts = 16;
  /// With more pairs of a plane that is nearly a mirror and a light with a size, no direction is
  /// guided, and these planes are unsolved.
  static constexpr std::size_t kMostGuidedPairs = 4096;
  /// Of the parts.  Empty if they are few.
  const PartTree& tree() const { return tree_; }
  std::span<const UnsolvedSurface> unsolved() const { return unsolved_; }
  /// The part that a ray hit; kNone where it is no part.
  static constexpr std::int32_t kNone = -1;
  std::int32_t part_of(const SurfaceHit& hit) const;
  /// Whether any material of the scene scatters light in more than single directions.
  bool has_rough_surfaces() const { return has_rough_surfaces_; }
  std::size_t bytes() const;
  std::string why() const;

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
  PartTree tree_;
  std::vector<UnsolvedSurface> unsolved_;
  std::unordered_map<std::uint64_t, ShapeParts> of_shape_;
  bool has_rough_surfaces_ = false;
};

/// The smooth surfaces of a scene, collected at the first call.  LazyPart states the rules for
/// callers.
const SmoothSurfaces& smooth_surfaces(const Scene& scene);

}  // namespace lucerna
