// The kinds of lights that tests must cover.
#pragma once

#include <fmt/format.h>

#include <set>
#include <string>
#include <typeinfo>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"

namespace lucerna::testing {

/// An area light's kind is its shape, and what varies its radiance.
inline std::string kind_of(const Light& light) {
  const auto* area = dynamic_cast<const AreaLight*>(&light);
  if (area == nullptr) return typeid(light).name();
  const Shape& shape = area->shape();
  return fmt::format("area {}{}{}", typeid(shape).name(),
                     area->picture() != nullptr ? " picture" : "",
                     area->profile() != nullptr ? " profile" : "");
}

/// All lights, each shape as a light and with a picture, and each that can be flat with a profile.
inline std::set<std::string> all_kinds() {
  std::set<std::string> kinds;
  const auto add_free = [&]<typename... L>(LightList<L...>) {
    (kinds.insert(typeid(L).name()), ...);
  };
  add_free(FreeLights());
  const auto add_shape = [&]<typename S>() {
    const std::string kind = fmt::format("area {}", typeid(S).name());
    kinds.insert({kind, kind + " picture"});
    if (!QuadricShape<S> || FlatShape<S>) kinds.insert(kind + " profile");
  };
  ShapeTypes<TriangleMesh, PatchMesh>::for_each(add_shape);
  Quadrics::for_each(add_shape);
  return kinds;
}

}  // namespace lucerna::testing
