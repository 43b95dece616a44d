// SampleLi with many lights: the time of a sample, and the error after equal time compared with
// uniform choice.
//
//     many_lights_bench [ROUNDS]
//
// A floor under a field of point lights, one for each square metre, 1 to 4 m high and of 1 to 100
// cd.  Receivers are on the floor, without shadow rays, so the sum over all lights is the exact
// answer.  The error of one sample is its root mean square error, relative to the exact illuminance
// and averaged over the receivers.  After equal time, the error of a method is proportional to that
// times the square root of its time.
#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/queries/queries.h"
#include "server/runtime/parallel.h"
#include "server/scene/scene.h"
#include "tests/server/queries/li_samples.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kReceivers = 64;
constexpr std::uint32_t kSamples = 512;

struct Lamp {
  Vec3 at;
  double intensity_cd;
};

std::vector<Lamp> lamps(std::uint32_t count) {
  std::mt19937_64 random(count);
  std::uniform_real_distribution<double> u(0, 1);
  const double side = std::sqrt(count);
  std::vector<Lamp> all(count);
  for (Lamp& lamp : all)
    lamp = {{side * (u(random) - 0.5), side * (u(random) - 0.5), 1 + 3 * u(random)},
            std::pow(10, 2 * u(random))};
  return all;
}

std::shared_ptr<const Scene> scene_of(const std::vector<Lamp>& lamps) {
  SceneDescription d;
  d.materials = {diffuse_material(Rgb(0.5))};
  const double side = std::sqrt(static_cast<double>(lamps.size()));
  ShapeDescription floor;
  floor.geometry = PatchMeshData{
      {{-side, -side, 0}, {side, -side, 0}, {-side, side, 0}, {side, side, 0}}, {}, {0, 1, 2, 3}};
  d.shapes = {std::move(floor)};
  for (const Lamp& lamp : lamps)
    d.lights.push_back({PointLightParams{lamp.at, Rgb(lamp.intensity_cd)}, {}});
  auto scene = Scene::build(std::move(d));
  if (!scene.ok()) throw std::runtime_error(scene.status().ToString());
  return *scene;
}

class Study {
 public:
  explicit Study(std::uint32_t count) : lamps_(lamps(count)), scene_(scene_of(lamps_)) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<float> u(-0.4F, 0.4F);
    const auto side = std::sqrt(static_cast<float>(count));
    for (std::uint32_t i = 0; i < kReceivers; ++i) {
      const float x = side * u(random), y = side * u(random);
      offsets_m_.insert(offsets_m_.end(), {x, y, 0});
      normals_.insert(normals_.end(), {0, 0, 1});
      exact_lx_.push_back(exact({x, y, 0}));
    }
  }

  struct Result {
    double sample_ns = 0;
    double error = 0;  ///< of one sample
  };
  /// `rounds` calls with different seeds.
  Result measure(LightSelection selection, int rounds) const {
    constexpr std::size_t kN = std::size_t{kReceivers} * kSamples;
    testing::LiSamples arrays(kN);
    SampleLiQuery query{.receivers = {{}, offsets_m_}, .samples = kSamples, .normals = normals_};
    query.methods.light_selection = selection;
    // Independent, so that the error of one sample has a meaning.
    query.methods.sampler = Sampler::kIndependent;
    const SampleLiAnswer answer = arrays.answer();
    std::vector<double> times_ns;
    std::vector<double> squares(kReceivers);
    for (int round = 0; round < rounds; ++round) {
      query.seed = SeedRange{.seed = static_cast<std::uint64_t>(round)};
      std::ranges::fill(arrays.delta, 0);
      // Processor time, which other programs change little.  The arena has one thread.
      const std::int64_t begin_ns = thread_cpu_ns();
      (void)sample_li(*scene_, query, answer, {});
      times_ns.push_back(static_cast<double>(thread_cpu_ns() - begin_ns) / kN);
      for (std::size_t i = 0; i < kN; ++i) {
        const std::size_t r = i / kSamples;
        const double lx = arrays.status[i] > 1
                              ? 0
                              : arrays.value[3 * i] * std::max(0.0F, arrays.wi[3 * i + 2]) /
                                    arrays.selection_probability[i];
        const double difference = lx / exact_lx_[r] - 1;
        squares[r] += difference * difference;
      }
    }
    double sum = 0;
    for (const double s : squares) sum += std::sqrt(s / (static_cast<double>(rounds) * kSamples));
    std::ranges::sort(times_ns);
    return {.sample_ns = times_ns[times_ns.size() / 2], .error = sum / kReceivers};
  }

 private:
  double exact(const Vec3& at) const {
    double sum = 0;
    for (const Lamp& lamp : lamps_) {
      const Vec3 to = lamp.at - at;
      const double square = dot(to, to);
      sum += lamp.intensity_cd * to.z / (square * std::sqrt(square));
    }
    return sum;
  }

  std::vector<Lamp> lamps_;
  std::shared_ptr<const Scene> scene_;
  std::vector<float> offsets_m_, normals_;
  std::vector<double> exact_lx_;
};

int run(int rounds) {
  fmt::print("{:>8} {:>14} {:>16} {:>10} {:>12} {:>14}\n", "lights", "sample [ns]", "uniform [ns]",
             "error", "uniform", "at equal time");
  for (const std::uint32_t count : {1'000U, 10'000U, 100'000U, 1'000'000U}) {
    const Study study(count);
    const Study::Result tree = study.measure(LightSelection::kAutomatic, rounds);
    const Study::Result uniform = study.measure(LightSelection::kUniform, rounds);
    fmt::print("{:>8} {:>14.0f} {:>16.0f} {:>10.2f} {:>12.2f} {:>14.4f}\n", count, tree.sample_ns,
               uniform.sample_ns, tree.error, uniform.error,
               tree.error / uniform.error * std::sqrt(tree.sample_ns / uniform.sample_ns));
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    const int rounds = argc > 1 ? std::stoi(argv[1]) : 20;
    return tbb::task_arena(1).execute([=] { return lucerna::run(rounds); });
  } catch (const std::exception& e) {
    fmt::print(stderr, "many_lights_bench: {}\n", e.what());
    return 1;
  }
}
