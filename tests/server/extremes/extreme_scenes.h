// Scene files with random lights and shapes of extreme sizes, places and levels.
#pragma once

#include <string>
#include <vector>

#include "tests/server/extremes/extreme_numbers.h"

namespace lucerna::testing {

/// A line of a scene file that makes one light or shape, and its kind.
struct SceneLine {
  std::string kind;
  std::string text;
};

/// All kinds of lights that `light_line` makes.
const std::vector<std::string>& light_kinds();

/// The scale of sizes and places.
struct SceneScale {
  /// One scale for all: places lie within 1, sizes are below it.
  static SceneScale random(ExtremeNumbers& numbers);

  bool wild = false;  ///< each number has a magnitude of its own
  double metres = 1;
  Vec3 offset_m{};
};

/// A light of this kind: a complete AttributeBegin ... AttributeEnd block.
SceneLine light_line(const std::string& kind, const SceneScale& scale, ExtremeNumbers& numbers);

/// A shape that emits no light.
SceneLine shape_line(const SceneScale& scale, ExtremeNumbers& numbers);

/// Film and camera, up to WorldBegin, each on its own line.
std::vector<std::string> head_lines(const SceneScale& scale, ExtremeNumbers& numbers);

}  // namespace lucerna::testing
