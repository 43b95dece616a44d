// What stands before WorldBegin: camera, film, and the hints of integrator, sampler and filter.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// One of the directives that a scene has once.
struct Setting {
  std::string type;
  ParameterSet params;
  Place place;
};

struct Settings {
  std::optional<Setting> camera, film, integrator, sampler, filter;
  Transform camera_from_world;                    ///< in force at Camera, at its start
  std::shared_ptr<const Motion> camera_motion{};  ///< world to world; null where it rests
};

/// Fills camera, film and hints of `context.scene`; defaults are pbrt-v4's.
void apply(Context& context, const Settings& settings);

}  // namespace lucerna::pbrt
