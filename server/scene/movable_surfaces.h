// The shapes of lights that edits can move.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "lights/maths/bounds.h"
#include "server/description/scene_description.h"

namespace lucerna {

class SceneLights;
struct SceneLight;

/// What a scene keeps so that edits can move surfaces of its lights.
class MovableSurfaces {
 public:
  /// Memory that a scene may take for this: a hundredth of its geometry, and at least this.
  static constexpr std::uint64_t kLeastBytes = 1 << 20;

  void reserve(std::size_t count) { kept_.reserve(count); }
  /// Adds a shape that emits.  Call in the order of their lights.  Those that move by themselves
  /// have no geometry here.
  void add(ShapeDescription&& shape);
  void clear() { kept_ = std::vector<Kept>(); }  // {} would keep its room

  std::size_t size() const { return kept_.size(); }
  bool empty() const { return kept_.empty(); }
  /// The shape as it was added, with all that depends on its place.  `light` is its light in
  /// `loaded`.
  ShapeDescription shape(std::size_t i, const SceneLights& loaded, const SceneLight& light) const;
  /// The bounds of its geometry, world [m]; none if it moves by itself.
  absl::StatusOr<std::optional<Bounds>> still_bounds(std::size_t i) const;
  std::uint64_t bytes() const;

  bool is_complete = true;     ///< false if the shapes took too much memory; then there are none
  Bounds others_m;             ///< of all other shapes, over their motion, world [m]
  double others_detail_m = 0;  ///< the extent of the smallest other shape

 private:
  /// A mesh of triangles without anything rare.  The scene's light has its emission.  It takes a
  /// fifth of the memory of a description.
  struct PlainMesh {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
  };
  using Kept = std::variant<PlainMesh, std::unique_ptr<const ShapeDescription>>;
  static bool is_plain(const ShapeDescription& shape);

  std::vector<Kept> kept_;
};

}  // namespace lucerna
