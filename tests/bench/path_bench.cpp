// Rays a second of paths, and where the rays go.
//
//     path_bench SCENE.pbrt [SAMPLES [REPEATS]]
//
// Renders the picture by one thread and prints millions of rays for each second of the processor,
// the rays of a sample, and a hash of the picture.  Seconds of the processor do not count other
// programs.  Two builds with the same hash gave all pixels the same bits.
// tests/bench/embree_cornell.py makes the scene that Embree's `pathtracer --benchmark` renders.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "lights/sampling/sobol.h"
#include "server/estimate/render.h"
#include "tests/bench/bench_program.h"

namespace lucerna {
namespace {

int run(const std::filesystem::path& file, std::uint32_t samples, int repeats) {
  const auto scene = load_scene(file);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TileSettings settings{
      .rect = {0, 0, scene->camera().width(), scene->camera().height()},
      .samples_per_block = samples,
      .bounces = static_cast<std::uint32_t>(scene->report().hints.max_depth.value_or(1) - 1)};
  std::vector<double> rates;
  WorkCounts work;
  std::uint64_t hash = 0;
  for (int i = 0; i < repeats; ++i) {
    const double begin = processor_s();
    const TileResult tile = render_tile(*scene, settings, {});
    work = tile.work;
    const auto rays = static_cast<double>(work.camera_rays + work.indirect_rays + work.shadow_rays);
    rates.push_back(rays / (processor_s() - begin) / 1e6);
    hash = 0;
    for (const BlockStatistics& channel : tile.channels)
      hash = mix_bits(hash + std::bit_cast<std::uint64_t>(channel.sum));
  }
  std::ranges::sort(rates);
  const auto per_sample = [&](std::uint64_t n) {
    return static_cast<double>(n) / static_cast<double>(work.samples);
  };
  fmt::print("{:.3f} Mray/s (least {:.3f}, most {:.3f})\n", rates[rates.size() / 2], rates.front(),
             rates.back());
  fmt::print("rays of a sample: {:.3f} = 1 camera + {:.3f} indirect + {:.3f} shadow\n",
             per_sample(work.camera_rays + work.indirect_rays + work.shadow_rays),
             per_sample(work.indirect_rays), per_sample(work.shadow_rays));
  fmt::print("picture {:016x}\n", hash);
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    if (argc < 2) throw std::runtime_error("SCENE.pbrt [SAMPLES [REPEATS]]");
    return lucerna::run(argv[1], argc > 2 ? static_cast<std::uint32_t>(std::stoul(argv[2])) : 16,
                        argc > 3 ? std::stoi(argv[3]) : 3);
  } catch (const std::exception& e) {
    fmt::print(stderr, "path_bench: {}\n", e.what());
    return 1;
  }
}
