#include "server/scene/scene_geometry.h"

#include <algorithm>

namespace lucerna {

bool SceneGeometry::moves() const {
  for (std::uint32_t i = 0; i < accelerator().instance_count(); ++i)
    if (accelerator().instance(i).motion != nullptr) return true;
  return false;
}

std::uint64_t SceneGeometry::shape_count() const {
  std::uint64_t sum = surfaces().surfaces.size();
  for (const SurfaceTable& o : data_.fixed->objects) sum += o.surfaces.size();
  return sum;
}

std::uint64_t SceneGeometry::primitive_count() const {
  std::uint64_t sum = accelerator().scene().primitives();
  for (std::uint32_t i = 0; i < data_.fixed->objects.size(); ++i)
    sum += accelerator().object(i).primitives();
  return sum;
}

std::vector<ScenePart> SceneGeometry::parts() const {
  std::vector<ScenePart> all = data_.parts;
  attached_.add_reports(all);
  return all;
}

}  // namespace lucerna
