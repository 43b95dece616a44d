// The options --blender and --lumens-per-watt: the light levels of glTF files from Blender.
#pragma once

#include <optional>
#include <string>

#include "lucerna/v1/scene.pb.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

class BlenderOption {
 public:
  void add(CLI::App& app);
  /// LoadSceneRequest.blender; nothing without --blender.
  std::optional<v1::BlenderLevels> levels() const;

 private:
  std::string mode_;
  std::optional<double> lumens_per_watt_;
};

}  // namespace lucerna::cli
