// Options of the scene files that a command loads: edits of lights (--set, --remove, --add), and
// the light levels of glTF files from Blender (--blender, --lumens-per-watt).
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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

class EditOption {
 public:
  using Edits = google::protobuf::RepeatedPtrField<v1::LightEdit>;
  /// The ids of the lights of a name; an error if there are none.
  using Named = std::function<absl::StatusOr<std::vector<std::uint64_t>>(const std::string& name)>;

  void add(CLI::App& app);
  bool given() const { return !sets_.empty() || !removed_.empty() || !added_.empty(); }
  /// The edits in the order set, remove, add.  `named`: null if only ids are allowed.  Errors:
  /// INVALID_ARGUMENT with the option and what is allowed; those of `named`.
  absl::StatusOr<Edits> edits(const Named& named = nullptr) const;

 private:
  std::vector<std::string> sets_, removed_, added_;
};

}  // namespace lucerna::cli
