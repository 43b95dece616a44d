// The directives before WorldBegin: camera, film, and hints from integrator, sampler and filter.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The directives that a scene has once.
struct Settings {
  std::optional<ParameterSet> camera, film, integrator, sampler, filter;
  Transform camera_from_world;  ///< at the Camera directive, at the start of the exposure
  std::shared_ptr<const Motion> camera_motion{};  ///< in the world; null if it does not move
};

/// Fills camera, film and hints of `context.scene`, with the defaults of pbrt-v4.
void apply(LoadState& context, const Settings& settings);

}  // namespace lucerna::pbrt
