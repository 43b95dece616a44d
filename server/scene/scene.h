// A scene as queries see it: immutable, compiled from a SceneDescription to the least that answers.
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
#include "lights/models/posed_light.h"
#include "server/description/scene_description.h"
#include "server/rays/accelerator.h"
#include "server/rays/ray.h"
#include "server/rays/surface_table.h"
#include "server/scene/camera.h"
#include "server/scene/light_selector.h"
#include "server/scene/scene_part.h"

namespace lucerna {

/// How a light moves.
struct LightMotion {
  Motion motion;          ///< from its own coordinates at its first key frame to the scene's
  Vec3<double> origin_m;  ///< world position of its own coordinates' zero
  /// Of a surface: its largest coordinate about its own zero, where it is found by rays no better
  /// than floats tell them apart there [m].  Else 0.
  float reach_m = 0;
  /// It has a direction and no place: of `motion` it takes the turns, not the shifts, which are as
  /// long as the scene is far from where it turns.
  bool only_turns = false;

  Pose at(double time_s) const {
    Pose pose = motion.at(time_s);
    if (only_turns) pose.shift_m = {};
    return pose;
  }
};

/// One light as the scene holds it.
struct SceneLight {
  std::uint64_t id;                           ///< stable, from 1, never reused
  Light<double> light;                        ///< about the scene's origin; where it moves, its own
  std::unique_ptr<const LightMotion> moving;  ///< null: it rests
  std::uint32_t samples = 1;  ///< points that each sample takes on it, where the query does not say
  // Where the scene asks for it, as SourceLocation says; the file as one of Scene's.
  std::uint32_t file = 0;
  int line = 0, column = 0;

  /// LightMotion's.
  float reach_m() const { return moving != nullptr ? moving->reach_m : 0; }
};

/// Calls `f` with the light as it is at `time_s`, about the scene's origin: the model itself or,
/// where it moves, its Posed form.
template <typename F>
auto visit_light(const SceneLight& light, double time_s, F&& f) {
  return visit(
      [&](const auto& model) {
        if (light.moving == nullptr) [[likely]]
          return f(model);
        using Model = std::decay_t<decltype(model)>;
        return f(Posed<double, Model>(model, light.moving->at(time_s)));
      },
      light.light);
}

/// All const members may be called from any thread.
class Scene {
 public:
  /// Errors: what of the description cannot be built, by file:line:column; CANCELLED.
  static absl::StatusOr<std::shared_ptr<const Scene>> build(SceneDescription description,
                                                            const std::string& isa = "",
                                                            std::stop_token stop = {});

  /// scene_id() of all files read.
  const std::string& id() const { return id_; }
  /// World position of scene coordinates' zero [m].  A multiple of a power of two not less than the
  /// scene's extent, so that scenes near their own zero keep the coordinates they were written
  /// with.
  const Vec3<double>& origin() const { return origin_; }
  /// Around geometry and local lights; radius 0 where there are none.
  const SceneSphere& sphere() const { return sphere_; }

  std::span<const SceneLight> lights() const { return lights_; }
  SourceLocation source_of(const SceneLight& light) const {
    return {files_[light.file], light.line, light.column};
  }
  /// World position of the zero of the coordinates that the light is in.
  const Vec3<double>& origin_of(const SceneLight& light) const {
    return light.moving != nullptr ? light.moving->origin_m : origin_;
  }
  /// The spectrum that the light of this index was given; null where it was given RGB.
  const Spectrum* spectrum(std::uint32_t light) const {
    const auto number = spectrum_number(light);
    return number ? spectra_[*number].get() : nullptr;
  }
  /// Its number among all spectra of the scene, each of which is there once.
  std::optional<std::uint32_t> spectrum_number(std::uint32_t light) const {
    if (light_spectra_.empty() || light_spectra_[light] < 0) return std::nullopt;
    return static_cast<std::uint32_t>(light_spectra_[light]);
  }
  std::span<const std::shared_ptr<const Spectrum>> spectra() const { return spectra_; }
  /// Index of a light id.
  std::optional<std::uint32_t> find_light(std::uint64_t id) const;
  /// Indices of lights that rays leaving the scene meet.
  std::span<const std::uint32_t> infinite_lights() const { return infinite_lights_; }
  /// Requires two lights or more.
  const LightSelector& light_selector() const { return *light_selector_; }
  /// The same of all lights but delta lights.  Made when it is first asked for.
  const LightSelector& area_selector() const;
  /// True where a light, shape, instance or the camera moves: pictures then depend on time.
  bool moves() const { return moves_; }
  /// True where some light is not a delta light: rays may find it.
  bool has_visible_lights() const { return has_visible_lights_; }
  /// True where there is nothing to hit.
  bool empty() const { return accelerator_->empty(); }
  std::span<const DiffuseMaterial> materials() const { return materials_; }
  const Camera& camera() const { return camera_; }
  const RenderHints& hints() const { return hints_; }
  const std::vector<Remark>& remarks() const { return remarks_; }
  const std::vector<Asset>& assets() const { return assets_; }
  /// What was built so far: with the scene, and since then because somebody asked for it.
  std::vector<ScenePart> parts() const;
  /// Memory of all of them.
  std::uint64_t bytes() const;
  std::uint64_t shape_count() const;  ///< shapes, each instance counting its object's once
  std::uint64_t primitive_count()
      const;  ///< triangles, patches, spheres, disks and cylinders held in memory
  std::string isa() const;

  std::optional<SurfaceHit> closest_hit(const Ray& ray) const;
  const Accelerator& accelerator() const { return *accelerator_; }
  /// Of the scene's own geometry.
  const SurfaceTable& surfaces() const { return surfaces_; }
  bool occluded(const Ray& ray) const { return accelerator_->occluded(ray); }
  void occluded(std::span<const Ray> rays, std::span<std::uint8_t> bits) const {
    accelerator_->occluded(rays, bits);
  }

  /// The part of type `T` that other code keeps with this scene; made by `T(scene)` at its first
  /// use.
  template <std::derived_from<AttachedPart> T>
  const T& attached() const {
    return attached_.get<T>(*this);
  }

 private:
  Scene() = default;
  class Builder;

  std::string id_;
  Vec3<double> origin_;
  SceneSphere sphere_;
  std::vector<SceneLight> lights_;
  std::vector<std::string> files_;  // that lights are asked for in
  std::vector<std::uint32_t> infinite_lights_;
  // Both empty where no light was given a spectrum.
  std::vector<std::shared_ptr<const Spectrum>> spectra_;
  std::vector<std::int32_t> light_spectra_;  // of each light, into spectra_; -1: RGB
  std::vector<DiffuseMaterial> materials_;
  std::unique_ptr<Accelerator> accelerator_;
  SurfaceTable surfaces_;                        // of the scene's own geometry
  std::vector<SurfaceTable> object_surfaces_;    // of each object's, then of each moving shape
  std::optional<LightSelector> light_selector_;  // none where there are fewer than two lights
  bool has_visible_lights_ = false;
  bool moves_ = false;
  Camera camera_;
  RenderHints hints_;
  std::vector<Remark> remarks_;
  std::vector<Asset> assets_;
  std::vector<ScenePart> parts_;  // what was built with the scene
  LazyPart<LightSelector> area_selector_{"area light choice"};
  AttachedParts attached_;  // last: its parts refer to the others
};

/// The id of a scene that was read from these files: SHA-256 over their names and digests, in
/// order, 64 hexadecimal digits.
std::string scene_id(const std::vector<Asset>& assets);

/// A light for a receiver (LightSelector); the probability is not part of any density.  `u` in
/// [0, 1).  Nothing where no light that `u` is left with reaches the receiver.  Requires at least
/// one light.
std::optional<LightChoice> choose_light(const Scene& scene, LightSelection how,
                                        const Receiver<double>& receiver, double u);
/// One for a ray that leaves a light, by flux.
LightChoice choose_emitter(const Scene& scene, double u);

}  // namespace lucerna
