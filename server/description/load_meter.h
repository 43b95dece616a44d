// Counts what a loader puts into a description, and checks it against the limits of the load.
#pragma once

#include <absl/status/status.h>

#include <cstdint>

#include "server/description/scene_description.h"
#include "server/files/load_budget.h"
#include "server/files/load_limits.h"

namespace lucerna {

/// Not thread-safe: use one for each load.  The description and the budget must outlive it.
class LoadMeter {
 public:
  LoadMeter(SceneDescription& scene, const LoadLimits& limits) : scene_(scene), limits_(limits) {}

  LoadBudget* budget() const { return limits_.budget; }
  const LoadLimits& limits() const { return limits_; }

  /// Counts a shape that the loader is about to add.  RESOURCE_EXHAUSTED above the limit of
  /// primitives or of the budget.
  absl::Status add(const ShapeDescription& shape);
  /// Counts bytes that the description keeps until the scene is built.
  absl::Status hold(std::uint64_t bytes);
  /// Counts bytes that the scene keeps, such as the pictures of lights.
  absl::Status keep(std::uint64_t bytes);
  /// Counts the lists other than those of shapes, and the textures, as they are now.
  absl::Status count_lists();

 private:
  SceneDescription& scene_;
  LoadLimits limits_;
  std::uint64_t primitives_ = 0;
  std::uint64_t lists_ = 0, textures_ = 0;  ///< as last counted
};

/// Memory of the arrays of a shape.
std::uint64_t array_bytes(const ShapeDescription& shape);
/// Memory of a shape in a list, with its arrays and its emission.
std::uint64_t listed_bytes(const ShapeDescription& shape);

}  // namespace lucerna
