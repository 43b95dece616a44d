// The steps that build a scene from its description.  Used by scene.cpp and the files of the
// steps: scene_frame.cpp, lights_builder.cpp and geometry_builder.cpp.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/assets/load_budget.h"
#include "server/scene/scene.h"

namespace lucerna {

/// The origin of a scene or an object with these bounds: the centre rounded to a multiple of the
/// smallest power of two that is not below the extent.
Vec3 origin_for(const Bounds& bounds);

/// Adds the bounds of a shape to those of all, and to the extent of the smallest shape.
void add_shape(const Bounds& shape, Bounds& all, double& detail_m);

class Scene::Builder {
 public:
  /// Moves data out of `description` step by step.  `description` must outlive the builder.
  Builder(SceneDescription& description, std::stop_token stop, LoadBudget* budget = nullptr)
      : in_(description), stop_(std::move(stop)), budget_(budget), scene_(new Scene) {
    placed_->materials = std::make_shared<const SurfaceMaterials>();
    scene_->placed_ = placed_;
  }

  absl::StatusOr<std::shared_ptr<const Scene>> build(const std::string& isa);
  void note_moved(const MovedSurfaces& moved) { placed_->edits.moved = moved; }
  /// The scene of Scene::revise.  Requires an empty description.
  absl::StatusOr<std::shared_ptr<const Scene>> revise(std::shared_ptr<const Scene> loaded,
                                                      std::shared_ptr<const PlacedSurfaces> placed,
                                                      LightEdits edits);

 private:
  /// CANCELLED after a request to stop.  For every loop over the content of the scene.
  absl::Status check_stop() const {
    return stop_.stop_requested() ? absl::CancelledError("the build was cancelled")
                                  : absl::OkStatus();
  }
  absl::Status check_references() const;
  void report_halved_pictures();
  absl::Status report_portals();

  /// Computes bounds, origins and the scene's sphere.  Errors: shapes without bounds, motion out of
  /// the range of rays.
  absl::Status place();
  /// The part of place() that depends on lights without a surface.
  absl::Status place_lights();

  /// Counts the memory of the lights, without their pictures, before they are built.
  absl::Status count_lights() const;
  absl::Status build_lights();
  /// `moving`: null if the light does not move; its reach is set from the light.
  absl::StatusOr<SceneLight> scene_light(std::uint64_t id,
                                         absl::StatusOr<std::shared_ptr<const Light>> light,
                                         const SourceLocation& where, std::uint32_t samples,
                                         std::unique_ptr<LightMotion> moving);
  absl::StatusOr<SceneLight> free_light(std::uint64_t id, const LightDescription& light);
  /// Notes which lights rays meet.
  void note_visible_lights();
  /// The index of a file among the files of lights' source locations.
  std::uint32_t file_number(const std::string& file);
  /// Stores spectra separately from the lights, so that scenes with only RGB lights store nothing.
  void keep_spectra(const std::vector<std::shared_ptr<const Spectrum>>& given);
  /// Stores names separately from the lights, so that lights without a name store nothing.
  void keep_names(std::vector<std::pair<std::uint32_t, std::string>> named);
  void report_lights(const Stopwatch& watch);
  /// Pictures, webs and maps that the lights from this index on share.
  void report_shared_by_lights(std::size_t from, const Stopwatch& watch);
  /// A light of a scene without edits that has no surface, as its file gives it.
  static LightDescription describe(const Scene& loaded, std::uint32_t light);
  /// Errors: edits that remove the light of an emissive pane.
  static absl::Status check_panes(const Scene& loaded, const LightEdits& edits);
  /// A light that has a surface, with another level.
  static absl::StatusOr<SceneLight> revised_light(SceneLight light, const LightChange& change);
  absl::Status prepare_choice();

  absl::Status build_geometry(const std::string& isa);
  /// Leaves out media that absorb nothing, and interfaces between equal media.
  void simplify_media();
  absl::Status append(ShapeDescription& shape, const Vec3& origin, std::int32_t light,
                      GeometrySet& set, SurfaceTable& table);
  /// Frees the arrays of a shape that was appended.
  void drop(ShapeDescription& shape);
  void keep_movable(std::uint64_t geometry_bytes);
  void keep_materials();
  void keep_textures(GeometrySet& set, std::vector<GeometrySet>& objects);
  void report_motion(const std::vector<GeometryInstance>& instances);
  void report_geometry(const GeometrySet& set, const std::vector<GeometrySet>& objects,
                       const Stopwatch& watch);

  std::shared_ptr<const Motion> about_scene(const Motion& motion, const Vec3& from) const {
    return std::make_shared<const Motion>(motion.about(from, scene_->origin_));
  }
  /// The motion of a light about `from`.
  std::unique_ptr<LightMotion> light_motion(const std::shared_ptr<const Motion>& motion,
                                            const Vec3& from) const {
    return std::make_unique<LightMotion>(LightMotion{
        .motion = motion->about(from, scene_->origin_), .origin_m = from, .world = motion});
  }
  void part(std::string name, std::uint64_t bytes, const Stopwatch& watch, std::string why) {
    scene_->parts_.push_back({std::move(name), bytes, 1e3 * watch.seconds(), std::move(why)});
  }
  /// A part that depends on lights other than their pictures and webs.
  void light_part(std::string name, std::uint64_t bytes, const Stopwatch& watch, std::string why) {
    part(std::move(name), bytes, watch, std::move(why));
    scene_->parts_.back().is_of_lights = true;
  }

  SceneDescription& in_;
  std::stop_token stop_;
  LoadBudget* budget_;  ///< null: no limit
  std::shared_ptr<Scene> scene_;
  std::shared_ptr<PlacedSurfaces> placed_ = std::make_shared<PlacedSurfaces>();
  std::unordered_map<std::string, std::uint32_t> file_numbers_;
  std::vector<Vec3> object_origins_;
  double detail_m_ = Bounds::kInfinity;  ///< the extent of the smallest shape
  std::vector<Vec3> moving_origins_;     ///< of each moving shape
  std::vector<HalvedPicture> halved_;
  std::uint64_t read_by_embree_ = 0;  ///< bytes of geometry that Embree reads and also counts
};

}  // namespace lucerna
