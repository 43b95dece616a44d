// The time that a grid of points takes to a target error, with all reflections.
//
//     irradiance_bench SCENE.pbrt X0 Y0 X1 Y1 Z [ERROR [REPEATS [REFERENCE_SEEDS]]]
//
// 25 x 13 points from (X0, Y0) to (X1, Y1) at the height Z face up.  Prints the seconds of the wall
// and of the processor, the samples and rays, and how wide the intervals are in multiples of ERROR
// (default 0.01).  With REFERENCE_SEEDS it also averages answers with that many other seeds, and
// prints the root mean square of the relative errors and the share of intervals that hold.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/common/defaults.h"
#include "proto/common/quantile.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/bench/bench_program.h"

namespace lucerna {
namespace {

constexpr int kColumns = 25, kRows = 13;

std::vector<IrradiancePoint> grid(const Scene& scene, const double (&corners)[5]) {
  std::vector<IrradiancePoint> points;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const double x = static_cast<double>(i) / (kColumns - 1),
                   y = static_cast<double>(j) / (kRows - 1);
      const Vec3 at(corners[0] + x * (corners[2] - corners[0]),
                    corners[1] + y * (corners[3] - corners[1]), corners[4]);
      points.push_back({at - scene.origin(), {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}});
    }
  return points;
}

void print_accuracy(const Scene& scene, const std::vector<IrradiancePoint>& points,
                    const IrradianceSettings& settings, const IrradianceResult& r, int seeds) {
  std::vector<double> truth(points.size());
  for (int s = 0; s < seeds; ++s) {
    IrradianceSettings other = settings;
    other.seed = static_cast<std::uint64_t>(s) + 1000;
    const IrradianceResult o = estimate_irradiance(scene, points, other, {});
    for (std::size_t i = 0; i < points.size(); ++i)
      truth[i] += luminance(o.points[i].irradiance_lx) / seeds;
  }
  double squares = 0, n = static_cast<double>(points.size());
  int held = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off = luminance(r.points[i].irradiance_lx) / truth[i] - 1;
    squares += off * off;
    held += r.points[i].illuminance_lx.lower <= truth[i] &&
            truth[i] <= r.points[i].illuminance_lx.upper;
  }
  fmt::print("root mean square error {:.3f} of the target, {:.1f}% of the intervals hold\n",
             std::sqrt(squares / n) / settings.target->relative, 100 * held / n);
}

int run(const std::filesystem::path& file, const double (&corners)[5], double error, int repeats,
        int seeds) {
  const auto scene = load_scene(file);
  const std::vector<IrradiancePoint> points = grid(*scene, corners);
  const IrradianceSettings settings{.block_count = kDefaultBlocks,
                                    .target = TargetError{.relative = error}};
  std::vector<double> wall, processor;
  IrradianceResult r;
  for (int i = 0; i < repeats; ++i) {
    const double begin = processor_s();
    const auto start = std::chrono::steady_clock::now();
    r = estimate_irradiance(*scene, points, settings, {});
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    processor.push_back(processor_s() - begin);
  }
  std::vector<double> widths;
  std::vector<std::uint64_t> counts;
  std::uint64_t answered = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ConfidenceInterval& c = r.points[i].illuminance_lx;
    widths.push_back((c.upper - c.lower) / 2 / luminance(r.points[i].irradiance_lx) / error);
    counts.push_back(r.costs[i].samples);
    answered += r.costs[i].samples;
  }
  const WorkCounts& w = r.work;
  const auto samples = static_cast<double>(w.samples);
  fmt::print("{:.3f} s, processor {:.3f} s (least {:.3f}, most {:.3f})\n", median(wall),
             median(processor), *std::ranges::min_element(processor),
             *std::ranges::max_element(processor));
  fmt::print("{:.2f} us and {:.2f} rays a sample ({:.2f} shadow); {} samples, pilots {}\n",
             1e6 * median(processor) / samples,
             static_cast<double>(w.indirect_rays + w.shadow_rays) / samples,
             static_cast<double>(w.shadow_rays) / samples, w.samples, w.samples - answered);
  fmt::print("samples of a point: least {}, median {}, most {}\n",
             *std::ranges::min_element(counts), median(counts), *std::ranges::max_element(counts));
  fmt::print("half-widths: median {:.2f}, most {:.2f} of the target; {} of {} points beyond it\n",
             median(widths), *std::ranges::max_element(widths),
             std::ranges::count_if(widths, [](double x) { return x > 1; }), points.size());
  if (seeds > 0) print_accuracy(*scene, points, settings, r, seeds);
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    if (argc < 7)
      throw std::runtime_error("SCENE.pbrt X0 Y0 X1 Y1 Z [ERROR [REPEATS [REFERENCE_SEEDS]]]");
    const auto number = [&](int i, const char* name, double least, double most, double otherwise) {
      return argc > i ? lucerna::number_of(name, argv[i], least, most) : otherwise;
    };
    double corners[5];
    for (int i = 0; i < 5; ++i) corners[i] = number(2 + i, "a coordinate", -1e9, 1e9, 0);
    return lucerna::run(argv[1], corners, number(7, "ERROR", 1e-4, 1, 0.01),
                        static_cast<int>(number(8, "REPEATS", 1, 1000, 3)),
                        static_cast<int>(number(9, "REFERENCE_SEEDS", 0, 1000, 0)));
  } catch (const std::exception& e) {
    fmt::print(stderr, "irradiance_bench: {}\n", e.what());
    return 1;
  }
}
