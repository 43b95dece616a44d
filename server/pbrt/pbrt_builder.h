// The graphics state, and the effect of each directive on it and on the scene.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/pbrt/pbrt_area_lights.h"
#include "server/pbrt/pbrt_camera.h"
#include "server/pbrt/pbrt_lights.h"
#include "server/pbrt/pbrt_materials.h"
#include "server/pbrt/pbrt_media.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

using Parameters = std::vector<std::shared_ptr<Parameter>>;

/// The transforms at the start and at the end of the exposure.  Copies share them.
class MovingTransform {
 public:
  MovingTransform() : start_(std::make_shared<const Transform>()), end_(start_) {}

  const Transform& start() const { return *start_; }
  const Transform& end() const { return *end_; }
  bool moves() const { return start_ != end_; }
  bool is_same_object_as(const MovingTransform& other) const {
    return start_ == other.start_ && end_ == other.end_;
  }

  /// Replaces those that `at_start` and `at_end` choose by `changed(transform)`.
  template <typename F>
  void change(bool at_start, bool at_end, F&& changed) {
    const auto apply = [&](const Transform& t) {
      return std::make_shared<const Transform>(changed(t));
    };
    const bool both = at_start && at_end && !moves();
    const auto start = at_start ? apply(*start_) : start_;
    const auto end = both ? start : at_end ? apply(*end_) : end_;
    start_ = start;
    end_ = *start == *end ? start : end;
  }

 private:
  std::shared_ptr<const Transform> start_, end_;  // one object if it does not move
};

/// The state that AttributeBegin saves.
struct GraphicsState {
  MovingTransform world_from_object;
  bool start_active = true, end_active = true;
  bool reverse_orientation = false;
  const RgbPrimaries* colour_space = nullptr;
  std::uint32_t material = Materials::kDefault;
  MediumSides media;
  std::shared_ptr<const ParameterSet> area_light;
  Parameters shape_attributes, light_attributes, material_attributes, texture_attributes,
      medium_attributes;
};

/// Receives the directives of a scene in the order of the file.
class Builder {
 public:
  explicit Builder(LoadState& context) : context_(context) {}

  // Transforms.
  void set_transform(const Transform& transform);
  void concatenate(const Transform& transform);
  void coordinate_system(const std::string& name);
  void coord_sys_transform(const std::string& name, const FilePosition& place);
  void active_transform(bool start, bool end);

  /// The primaries of rgb parameters from here on; null: Rec. 709.
  void set_colour_space(const RgbPrimaries* space) { state_.colour_space = space; }
  const RgbPrimaries* colour_space() const { return state_.colour_space; }

  // Before WorldBegin.
  /// `directive` is Camera, Film, Integrator, Sampler, PixelFilter or Accelerator.
  void setting(const std::string& directive, const std::string& type, Parameters params,
               const FilePosition& place);
  void world_begin(const FilePosition& place);
  void transform_times(double start_s, double end_s, const FilePosition& place);

  // The world.
  void attribute_begin(const FilePosition& place);
  void attribute_end(const FilePosition& place);
  void attribute(const std::string& target, Parameters params, const FilePosition& place);
  void reverse_orientation(const FilePosition& place);
  void material(const std::string& type, Parameters params, const FilePosition& place);
  void make_named_material(const std::string& name, Parameters params, const FilePosition& place);
  void named_material(const std::string& name, const FilePosition& place);
  void make_named_medium(const std::string& name, Parameters params, const FilePosition& place);
  void medium_interface(const std::string& inside, const std::string& outside,
                        const FilePosition& place);
  void texture(const std::string& name, const std::string& kind, const std::string& type,
               Parameters params, const FilePosition& place);
  void shape(const std::string& type, Parameters params, const FilePosition& place);
  void light_source(const std::string& type, Parameters params, const FilePosition& place);
  void area_light_source(const std::string& type, Parameters params, const FilePosition& place);
  void object_begin(const std::string& name, const FilePosition& place);
  void object_end(const FilePosition& place);
  void object_instance(const std::string& name, const FilePosition& place);

  /// An imported file begins or ends.  It must close every block that it opens, and it has its own
  /// state.
  void import_begin(const FilePosition& place);
  void import_end();

  /// Ends the scene: checks that everything opened is closed, and resolves names.
  void finish(const FilePosition& end);

 private:
  struct Opened {
    std::string_view opener;  ///< AttributeBegin, ObjectBegin or Import
    FilePosition place;
    GraphicsState saved;
  };
  struct Use {
    std::size_t instance;  ///< index into `scene.instances`
    std::string name;
    FilePosition place;
  };
  /// Saves the state.  Fails if too many blocks are open.
  void open(std::string_view opener, const FilePosition& place);
  /// Counts the memory of materials that were added since `before`.
  void count_materials(std::size_t before, std::size_t parameters);
  void require_world(const char* directive, const FilePosition& place) const;
  void require_before_world(const std::string& directive, const FilePosition& place) const;
  void close(std::string_view opener, const char* directive, const FilePosition& place);
  /// The current transform at the start of the exposure.  Adds a remark if it moves.
  const Transform& still_transform(const char* directive, const FilePosition& place);
  /// The motion of the current transform; null if it does not move.  Fails on a motion that is not
  /// rigid, and on a transform beyond the range.
  std::shared_ptr<const Motion> motion(const char* directive, const FilePosition& place) {
    return motion(directive, state_.world_from_object, place);
  }
  std::shared_ptr<const Motion> motion(const char* directive, const MovingTransform& moving,
                                       const FilePosition& place);
  void resolve_materials(ShapeList& shapes);

  LoadState& context_;
  GraphicsState state_;
  std::deque<Opened> opened_;
  std::map<std::string, MovingTransform> coordinate_systems_;
  double start_s_ = 0, end_s_ = 1;  ///< TransformTimes
  MovingTransform last_moving_;     ///< of `last_motion_`
  std::shared_ptr<const Motion> last_motion_;
  Settings settings_;
  Materials materials_;
  Media media_;
  std::optional<std::size_t> open_object_;
  std::map<std::string, std::uint32_t> objects_;
  LongList<Use> undefined_objects_;  ///< names used before their definition, for finish()
  bool in_world_ = false;
};

}  // namespace lucerna::pbrt
