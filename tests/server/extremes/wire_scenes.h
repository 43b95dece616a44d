// Loads random scenes of extreme lights into a server, from its root or by upload.
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
  /// The kinds of its lights by where the file makes them: "scene.pbrt:7".
  std::map<std::string, std::string> kinds;
};

class WireScenes {
 public:
  /// `root`: the server's, into which files are written.
  WireScenes(Service& service, std::filesystem::path root);

  /// The scene of that number: a dozen kinds of lights, the next in turn.  Lines that the server
  /// refuses are drawn again or left out.  Fails the test where it is not loaded in the end.
  WireScene load(std::uint64_t number, ExtremeNumbers& numbers);
  /// The scene may be gone already.
  void release(const std::string& id);

  /// Of the scene that was loaded last, for who looks at a failure.
  const std::string& text() const { return text_; }
  /// How many lines were refused.
  std::uint64_t refused() const { return refused_; }
  /// How many scenes were asked to be loaded, and files uploaded, by the names of the methods.
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
