// The surfaces of a scene at their places.  Edits can move and add those of lights.
#pragma once

#include <absl/status/statusor.h>

#include <concepts>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "lights/models/light.h"
#include "server/materials/material.h"
#include "server/rays/accelerator.h"
#include "server/rays/surface_table.h"
#include "server/scene/light_edit.h"
#include "server/scene/scene_part.h"

namespace lucerna {

class Scene;
struct SceneLight;

/// The materials of surfaces.
struct SurfaceMaterials {
  std::vector<Material> all;  ///< empty if all are plain
  // By material: whether it is diffuse without textures, and then its reflectance.
  std::vector<bool> plain;
  std::vector<Rgb> reflectances;
};

/// The surfaces of a scene, for rays.  Immutable once built.  It refers to the textures of the
/// scene from whose files it was made.
struct PlacedSurfaces {
  SurfaceEdits edits;  ///< how they differ from those of the file
  Bounds world_m;      ///< of all shapes over their motion, world [m]
  std::shared_ptr<const Accelerator> accelerator;
  SurfaceTable surfaces;  ///< of the scene's own geometry
  std::shared_ptr<const SurfaceMaterials> materials;
  /// A light whose surface was moved or added.
  struct EditedLight {
    std::shared_ptr<const Light> light;  ///< with the level of the file
    std::int32_t number;                 ///< Surface::light
  };
  /// By id.  Empty if the whole scene was built with them at their places.
  std::map<std::uint64_t, EditedLight> lights;
  std::vector<ScenePart> parts;  ///< what it does not share; empty if a scene has it as its own

  /// The part of type `T` that other code keeps with these surfaces.  Made by `T(*this)` at its
  /// first use.
  template <std::derived_from<AttachedPart> T>
  const T& attached() const {
    return attached_parts.get<T>(*this);
  }
  /// `parts`, then what is attached and built.
  std::vector<ScenePart> reports() const;
  /// Memory of these.
  std::uint64_t bytes() const;

  AttachedParts attached_parts;  ///< last: they refer to the other members
};

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
  ShapeDescription shape(std::size_t i, const Scene& loaded, const SceneLight& light) const;
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
