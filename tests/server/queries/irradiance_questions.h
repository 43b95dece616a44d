// Queries of irradiance whose answers are known in closed form.
#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "tests/server/estimate/coverage_scenes.h"

namespace lucerna::testing {

/// A receiver, and its irradiance.
struct Question {
  std::string name;
  std::shared_ptr<const Scene> scene;
  Vec3 receiver;
  Vec3f normal{0, 0, 1};
  double truth;  // [lx]
  std::optional<std::uint32_t> bounces = 0;
};

inline Question lamp() {
  return {
      .name = "lamp", .scene = build(below_a_lamp(0)), .receiver = {}, .truth = lux_below_a_lamp()};
}

/// Half of a sky behind a wall: light ends at an edge.
inline Question half_a_sky() {
  SceneDescription d = description(0);
  d.shapes = {patch({0, -1e4, 0}, {0, 1e4, 0}, {0, -1e4, 1e4}, {0, 1e4, 1e4})};
  d.lights = {{UniformInfiniteLightParams{Rgb(3, 2, 1)}, {}}};
  // The part of the sky above and beside the wall has a share of 1e-5.
  return {.name = "half a sky",
          .scene = build(std::move(d)),
          .receiver = {0.1, 0, 0.1},
          .truth = luminance(Rgb(3, 2, 1)) * std::numbers::pi / 2};
}

inline Question partly_hidden(double end) {
  return {.name = "lamp to " + std::to_string(end) + " m",
          .scene = build(partly_hidden_lamp(end)),
          .receiver = {},
          .truth = lux_of_partly_hidden_lamp(end)};
}

inline Question furnace() {
  return {.name = "furnace",
          .scene = build(in_a_furnace()),
          .receiver = {0.1, 0.2, -0.3},
          .truth = kFurnaceRadiance * std::numbers::pi,
          .bounces = std::nullopt};
}

inline Question pinhole() {
  return {.name = "pinhole",
          .scene = build(below_a_pinhole(0)),
          .receiver = {},
          .truth = lux_below_a_pinhole()};
}

}  // namespace lucerna::testing
