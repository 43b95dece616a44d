// A scene for queries: immutable, with only the data that queries need.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "lights/models/light.h"
#include "server/description/scene_contents.h"
#include "server/description/scene_description.h"
#include "server/rays/ray.h"
#include "server/runtime/shared_blocks.h"
#include "server/scene/camera.h"
#include "server/scene/light_names.h"
#include "server/scene/light_selector.h"
#include "server/scene/movable_surfaces.h"
#include "server/scene/scene_part.h"

namespace lucerna {

/// The motion of a light.
struct LightMotion {
  Motion motion;  ///< from its own coordinates at its first key frame to the scene's
  Vec3 origin_m;  ///< world position of the zero of its own coordinates
  /// Largest coordinate of the light's surface about its own zero [m].  Rays find the surface only
  /// to the rounding of floats of this size.  0 for lights without a surface.
  float reach_m = 0;
  /// The motion in the world, as the scene file gives it.
  std::shared_ptr<const Motion> world{};
  /// Set for lights with a direction and no place.  They use the rotations of `motion` but not the
  /// shifts, whose length depends on the distance from the centre of rotation.
  bool only_turns = false;

  Pose at(double time_s) const {
    Pose pose = motion.at(time_s);
    if (only_turns) pose.shift_m = {};
    return pose;
  }
};

/// One light of the scene.
struct SceneLight {
  std::uint64_t id;                    ///< stable, from 1, never reused
  std::shared_ptr<const Light> light;  ///< about the scene's origin; about its own if it moves
  std::shared_ptr<const LightMotion> moving;  ///< null if it does not move
  std::uint32_t samples = 1;  ///< points of each sample on it; the default of queries
  bool is_unseen = false;     ///< as in ShapeDescription::Emission
  // Place of the light in the scene files, as in SourceLocation; the file is an index into the
  // scene's files.
  std::uint32_t file = 0;
  int line = 0, column = 0;

  /// LightMotion::reach_m.
  float reach_m() const { return moving != nullptr ? moving->reach_m : 0; }
};

/// All const members may be called from any thread.
class Scene {
 public:
  /// Errors: parts of the description that cannot be built, with file:line:column; CANCELLED;
  /// refusals of `budget` (null: no limit).
  static absl::StatusOr<std::shared_ptr<const Scene>> build(SceneDescription description,
                                                            const std::string& isa = "",
                                                            std::stop_token stop = {},
                                                            LoadBudget* budget = nullptr);
  /// The same scene with surfaces of lights elsewhere, for revisions that move them.  It has the id
  /// of the scene without moves.
  static absl::StatusOr<std::shared_ptr<const Scene>> build_moved(SceneDescription description,
                                                                  const MovedSurfaces& moved,
                                                                  const std::string& isa = "",
                                                                  std::stop_token stop = {},
                                                                  LoadBudget* budget = nullptr);

  /// The surfaces of `loaded` with these edits.  They share the BVH of all others.  Null if the
  /// scene must be built with them: if they change the origin, the unit of rays or the number of
  /// triangles of a surface.  Also null if `loaded` was built with other moves.  Errors: edits that
  /// their light does not allow.
  static absl::StatusOr<std::shared_ptr<const PlacedSurfaces>> place(
      const Scene& loaded, const SurfaceEdits& edits, const std::stop_token& stop = {});

  /// A scene with the files of `loaded` and other lights.  It shares everything but its lights with
  /// `loaded`, which must come from build() or build_moved().  `placed`: the surfaces, which are
  /// loaded->placed(), or the result of place() if edits move or add surfaces.
  /// All queries have the same bits as in a scene whose files give these lights in this order.
  ///
  /// Errors: a change that its light does not allow; a level or a place out of range.
  static absl::StatusOr<std::shared_ptr<const Scene>> revise(
      std::shared_ptr<const Scene> loaded, std::shared_ptr<const PlacedSurfaces> placed,
      LightEdits edits, std::stop_token stop = {});
  /// The same with the surfaces of `loaded` or of place(), whichever the edits need.
  /// FAILED_PRECONDITION if they need build_moved().
  static absl::StatusOr<std::shared_ptr<const Scene>> revise(std::shared_ptr<const Scene> loaded,
                                                             LightEdits edits);

  /// scene_id() of all files read and of the level factors; for a revision, also of its edits.
  const std::string& id() const { return id_; }
  /// The scene without edits; null if this is one.
  const std::shared_ptr<const Scene>& loaded() const { return loaded_; }
  /// Empty for a scene without edits.
  const LightEdits& edits() const { return edits_; }
  /// What these edits change of the surfaces.
  SurfaceEdits surface_edits(const LightEdits& edits) const;
  /// Its surfaces, which revisions may share.
  const std::shared_ptr<const PlacedSurfaces>& placed() const { return placed_; }
  /// Whether it has surfaces that loaded() does not have.
  bool has_own_surfaces() const { return loaded_ == nullptr || placed_ != loaded_->placed_; }
  /// World position of the zero of scene coordinates [m].  It is a multiple of a power of two that
  /// is at least the scene's extent.  So scenes near zero keep their coordinates unchanged.
  const Vec3& origin() const { return origin_; }
  /// Contains geometry and local lights; radius 0 if there are none.
  const SceneSphere& sphere() const { return sphere_; }

  const SharedBlocks<SceneLight>& lights() const { return lights_; }
  SourceLocation source_of(const SceneLight& light) const {
    return {files_[light.file], light.line, light.column};
  }
  /// World position of the zero of the light's coordinates.
  const Vec3& origin_of(const SceneLight& light) const {
    return light.moving != nullptr ? light.moving->origin_m : origin_;
  }
  /// The spectrum of the light with this index; null for a light with RGB values.
  const Spectrum* spectrum(std::uint32_t light) const {
    const auto number = spectrum_number(light);
    return number ? spectra_[*number].get() : nullptr;
  }
  /// The number of its spectrum among those of the scene.  Equal spectra are stored once.
  std::optional<std::uint32_t> spectrum_number(std::uint32_t light) const {
    if (light_spectra_.empty() || light_spectra_[light] < 0) return std::nullopt;
    return static_cast<std::uint32_t>(light_spectra_[light]);
  }
  std::span<const std::shared_ptr<const Spectrum>> spectra() const { return spectra_; }
  /// The index of the light with this id.
  std::optional<std::uint32_t> find_light(std::uint64_t id) const;
  const LightNames& light_names() const { return light_names_; }
  /// Indices of the lights that rays meet when they leave the scene.
  std::span<const std::uint32_t> infinite_lights() const { return infinite_lights_; }
  /// The selector of all lights.  Requires two lights or more.  That of a revision is made at its
  /// first use.
  const LightSelector& light_selector() const {
    if (light_selector_) [[likely]]
      return *light_selector_;
    return revised_selector();
  }
  /// The selector of all lights except delta lights.  Made at its first use.
  const LightSelector& area_selector() const;
  /// Whether a light, a shape, an instance or the camera moves: pictures then depend on time.
  bool moves() const { return moves_; }
  /// Whether rays may find a light: one that is no delta light and is not unseen.
  bool has_visible_lights() const { return has_visible_lights_; }
  /// Whether there is nothing to hit.
  bool empty() const { return placed_->accelerator->empty(); }
  /// Whether nothing can take light on its way: no surface and no medium.
  bool is_clear() const { return empty() && !has_media(); }
  std::span<const Material> materials() const { return placed_->materials->all; }
  const Textures& textures() const { return base_->textures_; }
  /// The reflectance of a diffuse material without textures; null for all others.
  const Rgb* plain_diffuse(std::uint32_t material) const {
    const SurfaceMaterials& materials = *placed_->materials;
    return materials.plain[material] ? &materials.reflectances[material] : nullptr;
  }
  /// Where a surface was hit, as textures need it.
  struct ShadingPoint {
    TexturePoint texture;
    /// Scene [m]: how the point moves as u and v grow.  0 where (u, v) do not span the surface.
    Vec3 dpdu, dpdv;
  };
  ShadingPoint shading_point(const SurfaceHit& hit) const;
  const Camera& camera() const { return camera_; }
  const RenderHints& hints() const { return base_->hints_; }
  /// Applied to the levels that the scene file states.
  const LevelFactors& level_factors() const { return base_->level_factors_; }
  const SceneContents& contents() const { return base_->contents_; }
  const std::vector<Remark>& remarks() const { return base_->remarks_; }
  const std::vector<Asset>& assets() const { return base_->assets_; }
  /// The parts that are built: with the scene, and later for queries.
  std::vector<ScenePart> parts() const;
  /// Memory of all parts.  A revision counts the parts that it shares.
  std::uint64_t bytes() const;
  /// Memory without the parts that a revision shares with loaded().
  std::uint64_t own_bytes() const;
  /// Shapes in memory.  Those of an object count once, for any number of instances.
  std::uint64_t shape_count() const;
  /// Primitives in memory: triangles, patches, pieces of curves, spheres, disks, cylinders.
  std::uint64_t primitive_count() const;
  std::string isa() const;

  std::optional<SurfaceHit> closest_hit(const Ray& ray, Meets meets = Meets::kSurfaces) const;
  const Accelerator& accelerator() const { return *placed_->accelerator; }
  /// Shading data of the scene's own geometry.
  const SurfaceTable& surfaces() const { return placed_->surfaces; }
  /// The same for the geometry of an object, as Accelerator::object numbers it.
  const SurfaceTable& surfaces_of(std::uint32_t object) const {
    return base_->object_surfaces_[object];
  }
  /// Surface::light of a light without a surface.
  static constexpr std::int32_t kNoSurface = -2;
  /// Surface::light of the surfaces of a light; a number of no surface for a light without any.
  std::int32_t surface_number(const SceneLight& light) const;
  /// The index of the light of a surface; -1 if it does not emit.
  std::int32_t light_of(const Surface& surface) const {
    return light_numbers_.empty() || surface.light < 0
               ? surface.light
               : light_numbers_[static_cast<std::size_t>(surface.light)];
  }
  bool occluded(const Ray& ray, Meets meets = Meets::kSurfaces) const {
    return placed_->accelerator->occluded(ray, meets);
  }
  Obstacle obstacle(const Ray& ray, const LooseEnds& ends, Meets meets) const {
    return placed_->accelerator->obstacle(ray, ends, meets);
  }

  /// Whether it has smooth thin panes or sheets with a constant alpha, and whether it has media.
  bool has_panes() const { return base_->has_panes_; }
  bool has_media() const { return !base_->media_.empty(); }
  /// Whether all media absorb each channel alike.
  bool media_are_grey() const;
  /// Whether a smooth thin pane was hit.
  bool is_pane(const SurfaceHit& hit) const {
    return base_->has_panes_ && surface_of(hit).pane_eta.has_value();
  }
  /// The share of rays that meet the surface at a hit of a light.  Light models have the radiance
  /// times this share.
  double alpha(const SurfaceHit& hit) const {
    return base_->has_cut_lights_ ? alpha_of(surface_of(hit), hit) : 1;
  }
  /// The share of light that the panes and sheets along the ray pass straight on.
  double through_panes(const Ray& ray) const;
  /// The share of light along `direction` that one of them passes where it was hit.
  double through_pane(const SurfaceHit& hit, const Vec3f& direction) const;
  /// The share of light that the media along the ray leave, by channel.  Surfaces that bound
  /// media define the medium on each side.  If none is ahead, the nearest one behind decides.  If
  /// there is none at all, the ray is in the surrounding medium.
  Rgb through_media(const Ray& ray) const;

  /// The part of type `T` that other code keeps with this scene.  Made by `T(scene)` at its
  /// first use.
  template <std::derived_from<AttachedPart> T>
  const T& attached() const {
    return attached_.get<T>(*this);
  }

 private:
  Scene() = default;
  class Builder;
  /// A surface along a ray, at `t` in double.
  struct Crossing {
    SurfaceHit hit;
    double t = 0, error_t = 0;
    bool is_front = false;  ///< whether the ray meets the side of the normal
  };
  /// All surfaces along the ray in their order, each once.
  std::vector<Crossing> crossings(const Ray& ray, Meets meets) const;
  const LightSelector& revised_selector() const;
  /// The parts of a revision that it shares with loaded_, as they were built.
  std::vector<ScenePart> shared_parts() const;
  SurfaceHit surface_hit(const RawHit& raw, const Ray& ray) const;
  const Surface& surface_of(const SurfaceHit& hit) const;
  double alpha_of(const Surface& surface, const SurfaceHit& hit) const;

  std::string id_;
  std::shared_ptr<const Scene> loaded_;
  LightEdits edits_;
  // The scene that has everything but the lights and the surfaces: loaded_, or this one.
  const Scene* base_ = this;
  std::shared_ptr<const PlacedSurfaces> placed_;
  MovableSurfaces movable_;  // empty in revisions
  // For each Surface::light its index here, -1 if it was removed.  Empty if all are the same.
  std::vector<std::int32_t> light_numbers_;
  CameraDescription camera_description_;
  Film film_;
  Vec3 origin_;
  SceneSphere sphere_;
  SharedBlocks<SceneLight> lights_;
  std::vector<std::string> files_;  // the files of the lights' source locations
  std::vector<std::uint32_t> infinite_lights_;
  // Both are empty if no light has a spectrum.
  std::vector<std::shared_ptr<const Spectrum>> spectra_;
  std::vector<std::int32_t> light_spectra_;  // of each light, into spectra_; -1: RGB
  LightNames light_names_;
  Textures textures_;
  std::vector<Medium> media_;
  std::int32_t surrounding_medium_ = -1;
  bool has_panes_ = false;
  bool has_cut_lights_ = false;
  std::vector<SurfaceTable> object_surfaces_;  // of each object, then of each moving shape
  std::optional<LightSelector>
      light_selector_;  // empty with fewer than two lights, and in revisions
  LazyPart<LightSelector> revised_selector_{"light choice"};
  bool has_visible_lights_ = false;
  bool moves_ = false;
  bool others_move_ = false;  // anything but lights without a surface
  Camera camera_;
  RenderHints hints_;
  LevelFactors level_factors_;
  SceneContents contents_;
  std::vector<Remark> remarks_;
  std::vector<Asset> assets_;
  std::vector<ScenePart> parts_;  // built with the scene
  LazyPart<LightSelector> area_selector_{"area light choice"};
  AttachedParts attached_;  // last: its parts refer to the other members
};

/// The id of a scene from these files: SHA-256 over their names and digests, in order, as 64
/// hexadecimal digits.  `halved`: pictures that are not kept whole, which change answers.  Factors
/// of 1 do not change the id.
std::string scene_id(const std::vector<Asset>& assets,
                     const std::vector<HalvedPicture>& halved = {},
                     const LevelFactors& factors = {});

/// Chooses a light for a receiver (LightSelector).  The probability is not part of any density.
/// `u` in [0, 1).  Nothing if none of the lights that remain for `u` reaches the receiver.
/// Requires at least one light.
std::optional<LightChoice> choose_light(const Scene& scene, LightSelection how,
                                        const Receiver& receiver, double u);
/// The probability with which `choose_light` chooses this light.
double choice_probability(const Scene& scene, LightSelection how, const Receiver& receiver,
                          std::uint32_t light);
/// Chooses a light by flux, for a ray that leaves it.
LightChoice choose_emitter(const Scene& scene, double u);

}  // namespace lucerna
