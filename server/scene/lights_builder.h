// Collects the lights of a scene.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/files/load_budget.h"
#include "server/scene/scene_frame.h"
#include "server/scene/scene_lights.h"

namespace lucerna {

class LightsBuilder {
 public:
  /// `loaded`: the lights that a revision begins with; null without.
  explicit LightsBuilder(const SceneFrame& frame, const SceneLights* loaded = nullptr);

  /// A light without a surface.  Errors: those of create_light, with its place.
  absl::StatusOr<SceneLight> free_light(std::uint64_t id, const LightDescription& light);
  /// The light of a surface.  `moving`: null if it does not move; its reach is set from the light.
  absl::StatusOr<SceneLight> area_light(std::uint64_t id, absl::StatusOr<LightPointer> light,
                                        const ShapeDescription::Emission& emission,
                                        std::unique_ptr<LightMotion> moving = nullptr);
  /// The motion of a light about `from`.
  std::unique_ptr<LightMotion> motion_about(const std::shared_ptr<const Motion>& motion,
                                            const Vec3& from) const;

  /// Notes the spectrum (null for RGB) and the name of the next light.
  void note(const std::shared_ptr<const Spectrum>& spectrum, std::string_view name);
  /// The data so far.
  LightsData& data() { return data_; }
  void part(std::string name, std::uint64_t bytes, std::string why) {
    data_.parts.push_back({std::move(name), bytes, 1e3 * watch_.seconds(), std::move(why)});
  }
  /// Reports the lights from this index on.  `bytes`: of all others.
  void report(std::size_t from, std::uint64_t bytes, std::string why);
  std::shared_ptr<const SceneLights> finish();

 private:
  absl::StatusOr<SceneLight> scene_light(std::uint64_t id, absl::StatusOr<LightPointer> light,
                                         const SourceLocation& where, std::uint32_t samples,
                                         std::unique_ptr<LightMotion> moving);
  /// The index of a file among the files of lights' source locations.
  std::uint32_t file_number(const std::string& file);
  void keep_spectra();
  void keep_names();
  void report_pictures(std::size_t from);

  LightsData data_;
  Stopwatch watch_;
  std::unordered_map<std::string, std::uint32_t> file_numbers_;
  std::vector<std::shared_ptr<const Spectrum>> spectra_;  // of each light, null for RGB
  std::vector<std::pair<std::uint32_t, std::string>> names_;
};

/// Counts the memory of the lights of `scene`, without their pictures, before they are built.
absl::Status count_lights(const SceneDescription& scene, LoadBudget& budget);

/// The lights of a scene, in the order of their ids.  Errors: those of the lights; CANCELLED.
absl::StatusOr<std::shared_ptr<const SceneLights>> build_lights(const SceneDescription& scene,
                                                                const ShapeExtents& extents,
                                                                const SceneFrame& frame,
                                                                const std::stop_token& stop);

}  // namespace lucerna
