// What the benchmarks of one scene file share.
#pragma once

#include <absl/strings/numbers.h>
#include <fmt/core.h>

#include <ctime>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "server/assets/asset_reader.h"
#include "server/pbrt/load.h"
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

/// The argument `name`, a number from `least` to `most`.  Throws for all other text.
inline double number_of(const char* name, const char* text, double least, double most) {
  double number = 0;
  if (!absl::SimpleAtod(text, &number) || !(number >= least && number <= most))
    throw std::runtime_error(
        fmt::format("{} = {}, allowed: a number from {} to {}", name, text, least, most));
  return number;
}

}  // namespace lucerna
