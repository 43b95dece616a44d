// The same scene in other units: every length of a description is multiplied by a factor.  Levels
// of lights change so that all radiances and illuminances stay the same.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <variant>

#include "server/description/scene_description.h"

namespace lucerna::testing {

inline Transform scaled_places(const Transform& t, double s) {
  const auto times = [](double f) { return *Transform::scale({f, f, f}); };
  return times(s) * t * times(1 / s);
}

/// Requires a scene without motion.
inline SceneDescription scaled_scene(SceneDescription d, double s) {
  const auto scale_shape = [&](ShapeDescription& shape) {
    std::visit(
        [&](auto& geometry) {
          if constexpr (requires { geometry.positions; })
            for (Vec3& p : geometry.positions) p = p * s;
          else if constexpr (requires { geometry.points; }) {
            for (Vec3& p : geometry.points) p = p * s;
            geometry.start_width_m *= s, geometry.end_width_m *= s;
          } else
            geometry.world_from_object = *Transform::scale({s, s, s}) * geometry.world_from_object;
        },
        shape.geometry);
    // The radiance of a panel is the intensity of its file over its area.
    if (shape.emission && shape.emission->panel)
      shape.emission->radiance_cd_m2 = shape.emission->radiance_cd_m2 * (s * s);
  };
  for (ShapeDescription& shape : d.shapes) scale_shape(shape);
  for (ObjectDefinition& object : d.objects)
    for (ShapeDescription& shape : object.shapes) scale_shape(shape);
  for (InstanceDescription& i : d.instances)
    i.world_from_object = scaled_places(i.world_from_object, s);
  for (LightDescription& light : d.lights)
    std::visit(
        [&](auto& p) {
          if constexpr (requires { p.position_m; }) p.position_m = p.position_m * s;
          if constexpr (requires { p.intensity_cd; }) p.intensity_cd = p.intensity_cd * (s * s);
          if constexpr (requires { p.intensity; }) p.intensity = p.intensity * (s * s);
          if constexpr (requires { p.width_m; }) p.width_m *= s, p.height_m *= s;
          if constexpr (requires { p.corners_m; })
            for (Vec3& c : p.corners_m) c = c * s;
        },
        light.params);
  d.camera.world_from_camera = scaled_places(d.camera.world_from_camera, s);
  return d;
}

}  // namespace lucerna::testing
