// Loads random scenes of extreme lights into a server, from its root folder or by upload.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/server/extremes/extreme_numbers.h"
#include "tests/server/extremes/extreme_scenes.h"
#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {

struct WireScene {
  std::string id;
  /// The kind of each light by its place in the file: "scene.pbrt:7".
  std::map<std::string, std::string> kinds;
  bool has_panes = false;
  bool has_media = false, has_coloured_media = false;
  bool has_signed_filter = false;  ///< pixels may be below 0
};

class WireScenes {
 public:
  /// `root`: the server's root folder, into which files are written.
  WireScenes(Service& service, std::filesystem::path root);

  /// Loads the scene of this number: a dozen lights, of the next kinds in turn.  Lines that the
  /// server refuses are drawn again or left out.  Fails the test where the scene cannot be loaded.
  WireScene load(std::uint64_t number, ExtremeNumbers& numbers);
  /// The scene may already be unloaded.
  void release(const std::string& id);

  /// The text of the scene that was loaded last, to investigate a failure.
  const std::string& text() const { return text_; }
  /// How many lines were refused.
  std::uint64_t refused() const { return refused_; }
  /// How many scenes were loaded and files uploaded, by the names of the methods.
  const std::map<std::string, std::uint64_t>& items() const { return items_; }

 private:
  void write(const std::string& name, const std::string& bytes);
  grpc::Status load_text(const std::vector<SceneLine>& lines, bool upload, std::string* id);
  void upload(v1::SceneManifest* manifest);
  void put(const std::string& bytes, const std::string& digest);

  Service& service_;
  std::filesystem::path root_;
  std::map<std::string, std::string> files_;  // bytes by name
  std::string text_;
  std::uint64_t refused_ = 0;
  std::map<std::string, std::uint64_t> items_;
};

}  // namespace lucerna::testing
