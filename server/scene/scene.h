// A scene for queries: immutable, with only the data that queries need.
#pragma once

#include <absl/status/statusor.h>

#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/description/scene_description.h"
#include "server/files/load_budget.h"
#include "server/scene/camera.h"
#include "server/scene/light_edit.h"
#include "server/scene/scene_geometry.h"
#include "server/scene/scene_lights.h"
#include "server/scene/scene_part.h"
#include "server/scene/scene_report.h"

namespace lucerna {

/// A scene is its geometry, its lights, its camera and its report.  A revision has its own lights.
/// It shares the report, and the geometry unless edits move or add surfaces.  All const members may
/// be called from any thread.
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
  /// A scene with the files of `loaded` and other lights.  `loaded` must come from build() or
  /// build_moved().  `geometry`: that of `loaded`, or the result of moved_geometry() if edits move
  /// or add surfaces.  All queries have the same bits as in a scene whose files give these lights
  /// in this order.
  ///
  /// Errors: a change that its light does not allow; a level or a place out of range.
  static absl::StatusOr<std::shared_ptr<const Scene>> revise(
      std::shared_ptr<const Scene> loaded, std::shared_ptr<const SceneGeometry> geometry,
      LightEdits edits, std::stop_token stop = {});
  /// The same with the geometry of `loaded` or of moved_geometry(), whichever the edits need.
  /// FAILED_PRECONDITION if they need build_moved().
  static absl::StatusOr<std::shared_ptr<const Scene>> revise(std::shared_ptr<const Scene> loaded,
                                                             LightEdits edits);

  /// scene_id() of all files read and of the level factors; for a revision, also of its edits.
  const std::string& id() const { return id_; }
  /// The scene without edits; null if this is one.
  const std::shared_ptr<const Scene>& loaded() const { return loaded_; }
  const Scene& without_edits() const { return loaded_ != nullptr ? *loaded_ : *this; }
  /// Empty for a scene without edits.
  const LightEdits& edits() const { return edits_; }

  const SceneGeometry& geometry() const { return *geometry_; }
  const std::shared_ptr<const SceneGeometry>& shared_geometry() const { return geometry_; }
  /// Whether it has surfaces that loaded() does not have.
  bool has_own_geometry() const { return loaded_ == nullptr || geometry_ != loaded_->geometry_; }
  const SceneLights& lights() const { return *lights_; }
  const Camera& camera() const { return camera_; }
  const SceneReport& report() const { return *report_; }
  /// World position of the zero of scene coordinates [m].  It is a multiple of a power of two that
  /// is at least the scene's extent.  So scenes near zero keep their coordinates unchanged.
  const Vec3& origin() const { return lights_->frame().origin; }
  /// Contains geometry and local lights; radius 0 if there are none.
  const SceneSphere& sphere() const { return lights_->frame().sphere; }
  /// Whether a light, a shape, an instance or the camera moves: pictures then depend on time.
  bool moves() const { return moves_; }

  /// SurfaceHit::light is an index into lights(), or -1.
  std::optional<SurfaceHit> closest_hit(const Ray& ray,
                                        RayFilter filter = RayFilter::kSurfaces) const {
    std::optional<SurfaceHit> hit = geometry_->closest_hit(ray, filter);
    if (hit) hit->light = lights_->of_surface(hit->light);
    return hit;
  }
  /// Surface::light of a light without a surface.
  static constexpr std::int32_t kNoSurface = -2;
  /// Surface::light of the surfaces of a light; a number of no surface for a light without any.
  std::int32_t surface_number(const SceneLight& light) const;

  /// The parts that are built: with the scene, and later for queries.
  std::vector<ScenePart> parts() const;
  /// Memory of all parts.  A revision counts the parts that it shares.
  std::uint64_t bytes() const { return bytes_of(parts()); }
  /// Memory without the parts that a revision shares with loaded().
  std::uint64_t own_bytes() const;
  /// The part of type `T` that other code keeps with this scene.  Made by `T(scene)` at its
  /// first use.
  template <std::derived_from<AttachedPart> T>
  const T& attached() const {
    return attached_.get<T>(*this);
  }

 private:
  Scene() = default;

  std::string id_;
  std::shared_ptr<const Scene> loaded_;
  LightEdits edits_;
  std::shared_ptr<const SceneGeometry> geometry_;
  std::shared_ptr<const SceneLights> lights_;
  std::shared_ptr<const SceneReport> report_;
  Camera camera_;
  bool moves_ = false;
  AttachedParts attached_;  // last: its parts refer to the other members
};

}  // namespace lucerna
