// The scenes of scenes/ and their points.
#pragma once

#include <algorithm>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/queries/receiver_irradiance.h"
#include "server/scene/scene.h"
#include "tests/paths.h"

namespace lucerna {

inline std::shared_ptr<const Scene> load_shipped(const std::string& name) {
  auto assets = AssetReader::open(source_path("scenes"));
  return *Scene::build(*load_pbrt(*assets, name + "/scene.pbrt", {}));
}

/// Its points.csv: x, y, z, nx, ny, nz per line.
inline std::vector<IrradiancePoint> shipped_points(const Scene& scene, const std::string& name) {
  std::ifstream file(source_path("scenes/") + name + "/points.csv");
  std::vector<IrradiancePoint> out;
  for (std::string line; std::getline(file, line);) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream in(line);
    Vec3 p, n{0, 0, 1};
    if (!(in >> p.x >> p.y >> p.z)) continue;  // the header
    in >> n.x >> n.y >> n.z;
    const Vec3 at = p - scene.origin();
    const auto error = static_cast<float>(max_abs(at) * 0x1p-21);
    out.push_back({at, {error, error, error}, normalized(n)});
  }
  return out;
}

}  // namespace lucerna
