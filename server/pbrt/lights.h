// Lights with the levels that pbrt-v4 gives them: spectra at luminance 1 before `scale`, and the
// whole multiplied up where `power` or `illuminance` is given.
#pragma once

#include <optional>
#include <string>

#include "server/pbrt/params.h"
#include "server/pbrt/shapes.h"

namespace lucerna::pbrt {

/// A LightSource.  Nothing, and a remark, for lights that are not modelled.
std::optional<LightDescription> make_light(Context& context, const std::string& type,
                                           const ParameterSet& params, const Place& place,
                                           const Transform& world_from_light);

/// What AreaLightSource says, kept until a shape comes.
struct AreaLightDirective {
  std::string type;
  ParameterSet params;
  Place place;
};

/// Whether it asks for the (u, v) of shapes: for an image or a profile.
bool needs_uv(const AreaLightDirective& light);

/// The emission of `geometry` under `light`; nothing, and a remark, where it is not modelled.
/// `power` is that of the whole mesh.  `mirrored`: its transform swaps handedness.  Fails on levels
/// that are no levels and on shapes that cannot emit.
std::optional<ShapeDescription::Emission> make_emission(Context& context,
                                                        const AreaLightDirective& light,
                                                        const Geometry& geometry,
                                                        const Place& shape_place, bool mirrored);

}  // namespace lucerna::pbrt
