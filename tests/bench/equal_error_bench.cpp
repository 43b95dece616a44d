// Time to equal error, compared with pbrt-v4, on the scenes of tests/data/reference.
//
//     equal_error_bench [blocks] [SCENE ...]
//
// Pictures have one sequence for each pixel, as those of `lucerna render`.  With the first word
// `blocks` they have independent blocks, as those that come with standard errors.
//
// The error is the mean squared error of 64 samples a pixel against the reference picture, less the
// variance of that picture.  Error times seconds does not depend on the number of samples.  The
// ratio is pbrt-v4's product over ours: "3.0" means a third of the time to the same error.
//
// pbrt4_times.tsv has pbrt-v4's figures and the speed of its machine, in shadow rays a second of
// one thread through a sheet of 180 000 triangles.  The same sheet here scales its seconds.  It is
// measured again before each scene, because shared machines change their speed.  Seconds are those
// of the processor, divided by the two threads that pbrt-v4 had.
#include <embree3/rtcore.h>
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/common/quantile.h"
#include "server/estimate/render.h"
#include "server/runtime/denormals.h"
#include "tests/bench/bench_program.h"
#include "tests/paths.h"
#include "tests/server/estimate/compare.h"

namespace lucerna {
namespace {

using testing::Picture;
using testing::read_picture;

const std::string kReference = test_data("reference/");
constexpr std::uint32_t kBlocks = 8, kSamplesPerBlock = 8;  // 64 samples a pixel
constexpr std::uint32_t kRepeats = 3;                       // with different seeds
constexpr int kThreads = 2;                                 // of pbrt-v4's figures

/// Rays from just above a bumpy sheet to a plane above it.
class Sheet {
 public:
  Sheet() : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    constexpr unsigned kSide = 300;
    const RTCGeometry sheet = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(sheet, RTC_BUFFER_TYPE_VERTEX, 0,
                                                          RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                          std::size_t{kSide + 1} * (kSide + 1)));
    auto* t = static_cast<unsigned*>(rtcSetNewGeometryBuffer(sheet, RTC_BUFFER_TYPE_INDEX, 0,
                                                             RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
                                                             std::size_t{2} * kSide * kSide));
    for (unsigned i = 0; i <= kSide; ++i)
      for (unsigned j = 0; j <= kSide; ++j) {
        const float x = 10.F * static_cast<float>(i) / kSide - 5;
        const float y = 10.F * static_cast<float>(j) / kSide - 5;
        for (const float c : {x, y, height(x, y)}) *v++ = c;
      }
    for (unsigned i = 0; i < kSide; ++i)
      for (unsigned j = 0; j < kSide; ++j) {
        const unsigned a = i * (kSide + 1) + j, c = a + kSide + 1;
        for (const unsigned corner : {a, c, a + 1, a + 1, c, c + 1}) *t++ = corner;
      }
    rtcCommitGeometry(sheet);
    rtcAttachGeometry(scene_, sheet);
    rtcReleaseGeometry(sheet);
    rtcCommitScene(scene_);
    std::uint64_t state = 1;
    const auto u = [&] {
      state = state * 6364136223846793005U + 1442695040888963407U;
      return static_cast<float>(state >> 40U) * 0x1p-24F * 10 - 5;
    };
    for (int i = 0; i < 1 << 19; ++i) {
      const float x = u(), y = u(), z = height(x, y) + 1e-3F;
      const float dx = u() - x, dy = u() - y;
      rays_.push_back({x, y, z, 1e-4F, dx, dy, 3 - z, 0, 1 - 1e-4F, ~0U, 0, 0});
    }
  }
  ~Sheet() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Sheet(const Sheet&) = delete;
  Sheet& operator=(const Sheet&) = delete;

  /// Million rays a second of one thread.
  double mray_per_s() const {
    const DenormalsAreZero denormals;
    std::vector<double> rates;
    for (int repeat = 0; repeat < 5; ++repeat) {
      std::vector<RTCRay> rays = rays_;
      const double begin = processor_s();
      for (RTCRay& ray : rays) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene_, &context, &ray);
      }
      rates.push_back(static_cast<double>(rays.size()) / (processor_s() - begin) / 1e6);
    }
    return median(rates);
  }

 private:
  static float height(float x, float y) {
    return std::sin(3 * x) * std::cos(4 * y) + 0.1F * std::sin(40 * x + 3) * std::sin(37 * y);
  }

  RTCDevice device_;
  RTCScene scene_;
  std::vector<RTCRay> rays_;
};

struct Theirs {
  std::string scene;
  double seconds = 0, error = 0, mray_per_s = 0;
};

std::vector<Theirs> read_times() {
  std::ifstream file(kReference + "pbrt4_times.tsv");
  std::string header;
  std::getline(file, header);
  std::vector<Theirs> out;
  for (Theirs t; file >> t.scene >> t.seconds >> t.error >> t.mray_per_s;) out.push_back(t);
  if (out.empty()) throw std::runtime_error("pbrt4_times.tsv: no rows");
  return out;
}

/// Whether the scene shows a kind of light, and not a surface, a camera or a shape.
bool about_lights(const std::string& scene) {
  constexpr std::array kCameras{"orthographic", "lens", "spherical", "gaussian", "mitchell"};
  return !scene.starts_with("m_") && std::ranges::find(kCameras, scene) == kCameras.end();
}

struct Ours {
  double seconds = 0, error = 0;
};

Ours render(const std::string& name, bool in_blocks) {
  const auto scene = load_scene(kReference + name + ".pbrt");
  const Picture reference = read_picture(kReference + "pictures/" + name + ".exr");
  const Picture noise = read_picture(kReference + "pictures/" + name + ".stderr.exr");
  const auto count = static_cast<double>(reference.values.size());
  double variance = 0;
  for (const double s : noise.values) variance += s * s / count;
  TileSettings settings{
      .rect = {0, 0, scene->camera().width(), scene->camera().height()},
      .samples_per_block = kSamplesPerBlock,
      .block_count = kBlocks,
      .bounces = static_cast<std::uint32_t>(scene->report().hints.max_depth.value_or(1) - 1),
      .one_sequence = !in_blocks};
  std::vector<double> seconds;
  double error = 0;
  for (std::uint32_t repeat = 0; repeat < kRepeats; ++repeat) {
    settings.seed = repeat + 1;
    const double begin = processor_s();
    const TileResult tile = render_tile(*scene, settings, {});
    seconds.push_back((processor_s() - begin) / kThreads);
    for (std::size_t i = 0; i < tile.channels.size(); ++i) {
      const double difference = tile.channels[i].sum / kBlocks - reference.values[i];
      error += difference * difference / count / kRepeats;
    }
  }
  return {median(seconds), error - variance};
}

int run(std::vector<std::string> names) {
  const bool in_blocks = !names.empty() && names[0] == "blocks";
  if (in_blocks) names.erase(names.begin());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Sheet sheet;
  std::vector<double> lights, surfaces;
  fmt::print("{:20} {:>10} {:>12} {:>8}\n", "scene", "seconds", "error", "ratio");
  for (const Theirs& theirs : read_times()) {
    if (!names.empty() && std::ranges::find(names, theirs.scene) == names.end()) continue;
    // `colour` has other right answers in RGB.
    if (theirs.scene == "colour") continue;
    const double speed = sheet.mray_per_s();
    const Ours ours = render(theirs.scene, in_blocks);
    if (!(ours.error > 0)) {
      fmt::print("{:20} {:10.3f} {:>12} {:>8}\n", theirs.scene, ours.seconds, "below", "-");
      continue;
    }
    const double ratio =
        theirs.error * theirs.seconds * (theirs.mray_per_s / speed) / (ours.error * ours.seconds);
    (about_lights(theirs.scene) ? lights : surfaces).push_back(ratio);
    fmt::print("{:20} {:10.3f} {:12.4g} {:8.2f}\n", theirs.scene, ours.seconds, ours.error, ratio);
  }
  for (const auto& [what, ratios] :
       {std::pair{"lights", lights}, std::pair{"surfaces, cameras and shapes", surfaces}}) {
    if (ratios.empty()) continue;
    const double logs = std::accumulate(ratios.begin(), ratios.end(), 0.0,
                                        [](double sum, double r) { return sum + std::log(r); });
    fmt::print("{}: median {:.2f}, geometric mean {:.2f}, least {:.2f} of {} scenes\n", what,
               median(ratios), std::exp(logs / static_cast<double>(ratios.size())),
               *std::ranges::min_element(ratios), ratios.size());
  }
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    return lucerna::run({argv + 1, argv + argc});
  } catch (const std::exception& e) {
    fmt::print(stderr, "equal_error_bench: {}\n", e.what());
    return 1;
  }
}
