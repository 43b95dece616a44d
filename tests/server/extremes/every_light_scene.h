// A scene with one light of each kind.
#pragma once

#include <memory>
#include <stdexcept>

#include "server/assets/asset_reader.h"
#include "server/pbrt/load.h"
#include "server/scene/scene.h"
#include "tests/paths.h"

namespace lucerna::testing {

inline std::shared_ptr<const Scene> every_light() {
  absl::StatusOr<AssetReader> reader = AssetReader::open(test_data());
  if (!reader.ok()) throw std::runtime_error(reader.status().ToString());
  auto description = load_pbrt(*reader, "lights/every_light.pbrt", {});
  if (!description.ok()) throw std::runtime_error(description.status().ToString());
  auto scene = Scene::build(*std::move(description));
  if (!scene.ok()) throw std::runtime_error(scene.status().ToString());
  return *std::move(scene);
}

}  // namespace lucerna::testing
