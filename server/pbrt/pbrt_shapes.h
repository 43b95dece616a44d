// Converts Shape directives to geometry in world space (in an object definition: in object space).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// A Shape directive and its graphics state.
struct ShapeDirective {
  ParameterSet& params;  ///< long lists move out of it
  Transform world_from_object;
  bool reverse_orientation = false;
  bool needs_uv = false;  ///< meshes then have the (u, v) of their corners

  const std::string& type() const { return params.type(); }
  const FilePosition& place() const { return params.place(); }
};

/// The positions in world space.  Fails on one that is not finite.
std::vector<Vec3> world_positions(const ShapeDirective& shape, std::vector<Vec3> positions);

/// The geometry of a Shape directive.  Nothing, and a remark, for shapes that are not modelled.
/// Fails on unknown shapes and on invalid parameters.
std::optional<Geometry> make_geometry(LoadState& context, const ShapeDirective& shape);

}  // namespace lucerna::pbrt
