// What the benchmarks of one scene file share.
#pragma once

#include <absl/strings/numbers.h>
#include <fmt/core.h>

#include <cstdint>
#include <ctime>
#include <exception>
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

/// The argument `name`, a number from `least` to `most`.  Throws for all other text.
inline double number_of(const char* name, const char* text, double least, double most) {
  double number = 0;
  if (!absl::SimpleAtod(text, &number) || !(number >= least && number <= most))
    throw std::runtime_error(
        fmt::format("{} = {}, allowed: a number from {} to {}", name, text, least, most));
  return number;
}

/// The program `name SCENE.pbrt [SAMPLES [REPEATS]]`.  Returns the exit status of `run`, or 1 after
/// an error, which it prints.
inline int run_on_scene(const char* name, int argc, char** argv, double most_samples, int repeats,
                        int (*run)(const std::filesystem::path& scene, std::uint32_t samples,
                                   int repeats)) {
  try {
    if (argc < 2) throw std::runtime_error("SCENE.pbrt [SAMPLES [REPEATS]]");
    const auto number = [&](int i, const char* what, double most, double otherwise) {
      return argc > i ? number_of(what, argv[i], 1, most) : otherwise;
    };
    return run(argv[1], static_cast<std::uint32_t>(number(2, "SAMPLES", most_samples, 16)),
               static_cast<int>(number(3, "REPEATS", 1000, repeats)));
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}: {}\n", name, e.what());
    return 1;
  }
}

}  // namespace lucerna
