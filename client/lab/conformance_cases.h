// The cases of a conformance pack: scenes with one light each.  There is at least one ordinary case
// for each kind of light and each shape, and cases at the extremes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lucerna/client/points.h"

namespace lucerna::conformance {

/// A file beside the scene file.
struct CaseFile {
  std::string name;
  std::string content;
};

struct Case {
  std::string name;  ///< of the case's folder: lower case and "_"
  std::string about;
  bool extreme = false;
  /// The scene file, scene.pbrt or scene.gltf, and the files that it names.
  CaseFile scene;
  std::vector<CaseFile> files = {};
  /// The receivers are about this point, world [m].
  client::Double3 center = {};
};

/// All cases, in the order of the pack.
std::vector<Case> cases();

/// A surface point where light is measured.
struct Receiver {
  client::Double3 point;   ///< world [m]
  client::Double3 normal;  ///< world, unit
};
/// The receivers of a case: above its floor, with normals in several directions.
std::vector<Receiver> receivers(const Case& scene);

}  // namespace lucerna::conformance
