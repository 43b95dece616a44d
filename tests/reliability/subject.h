// The server that is measured, its scenes, and the requests that it gets.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lucerna/client/testing/local_server.h"
#include "tests/reliability/traffic.h"
#include "tests/temp_directory.h"

namespace lucerna::reliability {

/// The value, or ends the program with the error.
template <typename T>
T value_of(absl::StatusOr<T> result, const std::string& what) {
  if (!result.ok()) throw std::runtime_error(what + ": " + result.status().ToString());
  return *std::move(result);
}

/// Scene files in a temporary folder: a wavy floor of 2 `edge`^2 triangles with 20 point lights, a
/// disk and a picture of 64 x 64 pixels.
class SceneFiles {
 public:
  explicit SceneFiles(std::uint32_t edge = 100);
  std::string folder() const { return directory_.path().string(); }
  /// Writes a scene whose lights depend on `number`, and returns its name.  Scenes with different
  /// numbers have different ids.
  std::string write(std::uint64_t number) const;

 private:
  TempDirectory directory_;
};

/// A running server with one scene.
class Subject {
 public:
  /// `arguments` of lucernad.  Loads scene 0 of `files`.
  explicit Subject(const SceneFiles& files, std::vector<std::string> arguments = {});

  const std::string& target() const { return server_.target(); }
  const client::Client& client() const { return server_.client(); }
  testing::LocalServer& server() { return server_; }
  const std::string& scene() const { return scene_; }
  /// Loads a file of the scene root, and returns the scene's id.
  std::string load(const std::string& path) const;

  /// Processor time of all threads so far, to the moment of the call.
  double cpu_s() const;
  /// Processor time so far of the allocator's own threads, which return memory about a second after
  /// it was freed.
  double allocator_cpu_s() const;
  double resident_bytes() const;
  double most_resident_bytes() const;  ///< so far

  /// A query of one receiver that is computed at once.
  Message one_item() const;
  /// SampleLi of 1000 points.
  Message thousand_samples() const;
  /// Irradiance at `receivers` points with `samples` each.
  Message irradiance(int receivers, std::uint32_t samples) const;
  Message tile(std::uint32_t edge, std::uint32_t samples) const;

 private:
  testing::LocalServer server_;
  std::string scene_;
  // Their files in /proc, and their time before they were found.
  mutable std::map<std::string, double> allocator_threads_;
  mutable std::chrono::steady_clock::time_point listed_;
};

/// `count` points above the floor of the scene.
v1::Points points_above(int count);

}  // namespace lucerna::reliability
