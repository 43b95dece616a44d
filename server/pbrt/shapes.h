// Shapes as geometry in world space (within an object definition: in the object's space).
#pragma once

#include <optional>
#include <string>

#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// A Shape directive and the state that it was met in.
struct ShapeDirective {
  std::string type;
  const ParameterSet& params;
  Place place;
  Transform world_from_object;
  bool reverse_orientation = false;
  bool needs_uv = false;  ///< meshes then say the (u, v) of their corners
};

using Geometry = decltype(ShapeDescription::geometry);

/// Nothing, and a remark, for shapes that are not modelled.  Fails on unknown ones and on wrong
/// parameters.
std::optional<Geometry> make_geometry(Context& context, const ShapeDirective& shape);

}  // namespace lucerna::pbrt
