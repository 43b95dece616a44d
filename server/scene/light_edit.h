// Changes of lights after their scene was loaded.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "server/description/scene_description.h"

namespace lucerna {

/// How a light differs from the light as its file gives it.
struct LightChange {
  bool is_removed = false;
  bool is_off = false;
  double scale = 1;     ///< factor of the level: finite, at least 0
  Rgb tint{1};          ///< factors of its channels: finite, at least 0
  Vec3 shift_m{};       ///< world
  Vec3 turn_axis{};     ///< world, unit; zero without a turn
  double turn_rad = 0;  ///< about its own position, counter-clockwise seen against the axis

  bool has_level() const { return is_off || scale != 1 || !(tint == Rgb(1)); }
  bool has_place() const { return turn_rad != 0 || !(shift_m == Vec3()); }
  /// A tint removes the spectrum, since RGB does not determine one.
  bool keeps_spectrum() const { return tint.r == tint.g && tint.g == tint.b; }
  bool operator==(const LightChange&) const = default;
};

/// A shape that emits and does not move by itself.  Its material is diffuse, without textures.
struct AddedSurface {
  ShapeDescription shape;
  Rgb reflectance;
};

/// A light that the scene's file does not have.
struct AddedLight {
  LightDescription light;  ///< not used for a surface
  /// What makes the light different from others, for the scene's id.
  std::string content;
  std::shared_ptr<const AddedSurface> surface{};  ///< null for a light without one

  bool operator==(const AddedLight& other) const { return content == other.content; }
};

/// Memory of these, without their surfaces.
std::uint64_t bytes_of(const std::map<std::uint64_t, AddedLight>& added);

/// Changes of place, by the id of a light with a surface.
using MovedSurfaces = std::map<std::uint64_t, LightChange>;

/// All that edits change of a scene's surfaces.
struct SurfaceEdits {
  MovedSurfaces moved;
  std::map<std::uint64_t, AddedLight> added;  ///< lights with a surface, by id

  bool empty() const { return moved.empty() && added.empty(); }
  bool operator==(const SurfaceEdits&) const = default;
};

/// All changes of a scene's lights.  They do not tell in which order they were made.
struct LightEdits {
  std::map<std::uint64_t, LightChange> changes;  ///< by id; none that changes nothing
  /// By id.  The id of a light of the file: replaces it.
  std::map<std::uint64_t, AddedLight> added;

  bool empty() const { return changes.empty() && added.empty(); }
  /// The same for edits with the same result.
  std::string canonical() const;
  /// Memory of the lists, without the surfaces of added lights.
  std::uint64_t bytes() const;
};

/// Changes level and place of a light without a surface.  Errors: a light that moves, and a shift
/// of a light at infinity.
absl::Status apply(const LightChange& change, LightDescription& light);
/// The intensity, illuminance or radiance that `change` multiplies.
Rgb& level_of(LightParams& params);

/// The part of a change that says where the light is.
LightChange place_only(const LightChange& change);

/// Moves the shape of the light with this id, and its normals.  Errors: a light that moves by
/// itself.
absl::Status move_surface(std::uint64_t id, const LightChange& change, ShapeDescription& shape);

/// The same for lights of a scene.  Errors: also a light without a surface.
absl::Status move_surfaces(const MovedSurfaces& moved, SceneDescription& scene);

/// Chooses ids of added lights, in [2^32, 2^33).
class AddedLightIds {
 public:
  explicit AddedLightIds(const std::map<std::uint64_t, AddedLight>& taken);

  /// The first free id from the one that follows from the content; equal lights get the next ones.
  std::uint64_t take(const std::string& content);
  /// Ids of other lights have no effect.
  void free(std::uint64_t id);

 private:
  void add(std::uint64_t id);

  // The end of each run of taken ids, by its first.  Trying one id after another would take as many
  // steps as there are equal lights.
  std::map<std::uint64_t, std::uint64_t> runs_;
};

/// `level` with the change.
Rgb changed_level(const LightChange& change, const Rgb& level);

}  // namespace lucerna
