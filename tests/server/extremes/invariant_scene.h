// A scene with one light of each kind, and an instance.
#pragma once

#include "tests/server/extremes/every_light_scene.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {

/// The position of its middle [m].
inline const Vec3 kEveryLightMiddle{100, -50, 0};

/// With these settings the bits depend on nothing but the size.
inline SceneDescription invariant_scene() {
  SceneDescription scene = every_light_description();
  scene.objects = {{"ball", {{ball(2, [](const Vec3& p) { return p * 3.0; })}}}};
  scene.instances = {
      {0, Transform::translate({101.5, -49, 0.7}) * *Transform::rotate(0.5, {1, 2, 3}) *
              *Transform::scale({0.2, 0.1, 0.2})}};
  return scene;
}

}  // namespace lucerna::testing
