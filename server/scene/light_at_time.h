// A light of a scene at one moment.
#pragma once

#include <optional>
#include <typeinfo>

#include "lights/models/moved_light.h"
#include "lights/models/point_light.h"
#include "server/scene/scene.h"

namespace lucerna {

/// A light of a scene at one moment, about the scene's origin: the light itself or, if it moves, a
/// MovedLight.  Refers to the light, which must outlive it.  May be called from any thread.
class LightAtTime {
 public:
  LightAtTime(const SceneLight& light, double time_s)
      : light_(light.light.get()), is_unseen_(light.is_unseen) {
    if (light.moving != nullptr) [[unlikely]]
      light_ = &moved_.emplace(*light_, light.moving->at(time_s));
  }
  LightAtTime(const LightAtTime&) = delete;
  LightAtTime& operator=(const LightAtTime&) = delete;

  bool is_unseen() const { return is_unseen_; }
  const Light& operator*() const { return *light_; }
  const Light* operator->() const { return light_; }

 private:
  const Light* light_;
  bool is_unseen_;
  std::optional<MovedLight> moved_{};
};

/// Whether the light is a delta light.
inline bool is_delta(const SceneLight& light) { return light.light->is_delta(); }

/// The light as a point light at rest; null if it is of another kind or moves.
inline const PointLight* resting_point_light(const SceneLight& light) {
  const bool is_one = light.moving == nullptr && typeid(*light.light) == typeid(PointLight);
  return is_one ? static_cast<const PointLight*>(light.light.get()) : nullptr;
}

}  // namespace lucerna
