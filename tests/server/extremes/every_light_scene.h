// A scene with one light of each kind.
#pragma once

#include <memory>
#include <utility>

#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/scene/scene.h"
#include "tests/paths.h"
#include "tests/value_of.h"

namespace lucerna::testing {

inline SceneDescription every_light_description() {
  auto assets = value_of(AssetReader::open(test_data()));
  return value_of(load_pbrt(assets, "lights/every_light.pbrt"));
}

inline std::shared_ptr<const Scene> every_light() {
  return value_of(Scene::build(every_light_description()));
}

}  // namespace lucerna::testing
