// Scenes whose light is known in closed form, for counting how many intervals hold it.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "tests/lights/closed_forms.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {

/// Illuminance at the origin, facing up, of a square above it.
inline double of_patch(double radiance, double half_side, double z) {
  const double h = half_side;
  return radiance *
         polygon_irradiance({{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}}, {}, {0, 0, 1});
}

/// A lamp of 2 m x 2 m, 2 m above a floor.
inline SceneDescription below_a_lamp(double reflectance) {
  SceneDescription d = description(reflectance);
  d.shapes = {floor(9), emissive(patch({-1, -1, 2}, {-1, 1, 2}, {1, -1, 2}, {1, 1, 2}), 5)};
  return d;
}
inline double lux_below_a_lamp() { return of_patch(5, 1, 2); }

/// A lamp of 1 m x 1 m, 2 m above the origin.  A plate halfway hides it, except for the part left
/// of `end` [m].
inline SceneDescription partly_hidden_lamp(double end) {
  SceneDescription d = description(0);
  d.shapes = {floor(9),
              emissive(patch({-0.5, -0.5, 2}, {-0.5, 0.5, 2}, {0.5, -0.5, 2}, {0.5, 0.5, 2}), 20),
              patch({end / 2, -3, 1}, {3, -3, 1}, {end / 2, 3, 1}, {3, 3, 1})};
  return d;
}
inline double lux_of_partly_hidden_lamp(double end) {
  return 20 * polygon_irradiance({{-0.5, -0.5, 2}, {end, -0.5, 2}, {end, 0.5, 2}, {-0.5, 0.5, 2}},
                                 {}, {0, 0, 1});
}

/// A closed room whose surfaces all emit 2 cd/m2 and reflect half: 4 cd/m2 everywhere.
inline SceneDescription in_a_furnace() {
  SceneDescription d = description(0.5);
  d.shapes = {emissive(shape(room()), 2, true)};
  return d;
}
inline constexpr double kFurnaceRadiance = 4;

/// A lamp of 2 m x 2 m at 4 m, behind a lid at 2 m with a hole in its middle.  From the floor a
/// thousandth of the lamp is visible.
inline SceneDescription below_a_pinhole(double reflectance) {
  const double hole = std::sqrt(1e-3) / 2, far = 30;
  SceneDescription d = description(reflectance);
  d.shapes = {floor(9),
              emissive(patch({-1, -1, 4}, {-1, 1, 4}, {1, -1, 4}, {1, 1, 4}), 1000),
              patch({-far, -far, 2}, {far, -far, 2}, {-far, -hole, 2}, {far, -hole, 2}),
              patch({-far, hole, 2}, {far, hole, 2}, {-far, far, 2}, {far, far, 2}),
              patch({-far, -hole, 2}, {-hole, -hole, 2}, {-far, hole, 2}, {-hole, hole, 2}),
              patch({hole, -hole, 2}, {far, -hole, 2}, {hole, hole, 2}, {far, hole, 2})};
  return d;
}
inline double lux_below_a_pinhole() { return of_patch(1000, std::sqrt(1e-3), 4); }

/// A lamp behind a closed lid.
inline SceneDescription below_a_lid(double reflectance) {
  SceneDescription d = description(reflectance);
  d.shapes = {floor(9), floor(9, 2),
              emissive(patch({-1, -1, 4}, {-1, 1, 4}, {1, -1, 4}, {1, 1, 4}), 7)};
  return d;
}

}  // namespace lucerna::testing
