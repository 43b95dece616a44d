// What the benchmarks that load scene files share.
#pragma once

#include <ctime>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/scene/scene.h"

namespace lucerna {

/// The processor time of this process [s].  Other programs do not count.
inline double processor_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <typename T>
T value_or_throw(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

/// Loads a .pbrt file.  Throws the server's message.
inline std::shared_ptr<const Scene> load_scene(const std::filesystem::path& file) {
  auto assets = value_or_throw(AssetReader::open(std::filesystem::absolute(file).parent_path()));
  return value_or_throw(
      Scene::build(value_or_throw(load_pbrt(assets, file.filename().string(), {}))));
}

}  // namespace lucerna
