// Measures what a scene with one point light pays for features of other scenes: bytes, and
// nanoseconds per sample.  The references are loops written by hand for that light, with the same
// flags.  There are two of each: bare, for valid receivers only; and complete, with the status of
// each item for any input and the error and cost of each point.  Medians of paired runs on one
// thread.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "proto/common/quantile.h"
#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/runtime/denormals.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

constexpr std::size_t kReceivers = 1 << 16;
constexpr int kRuns = 41;
constexpr Vec3 kLamp{0.5, -0.25, 3};
constexpr double kCandela = 100;

/// The parameters of the light.
struct Lamp {
  Vec3 position;
  Rgb intensity;
};

struct Arrays {
  std::vector<float> value = std::vector<float>(3 * kReceivers);
  std::vector<float> wi = value, offsets = value, normals = value;
  std::vector<float> distance = std::vector<float>(kReceivers), pdf = distance;
  std::vector<std::uint8_t> delta = std::vector<std::uint8_t>(kReceivers / 8), visible = delta;
  std::vector<std::uint64_t> ids = std::vector<std::uint64_t>(kReceivers);
  std::vector<double> probability = std::vector<double>(kReceivers);
  std::vector<int> status = std::vector<int>(kReceivers);
  SampleLiAnswer answer() {
    return {value.data(),   wi.data(),          distance.data(), offsets.data(),
            normals.data(), pdf.data(),         delta.data(),    visible.data(),
            ids.data(),     probability.data(), status.data()};
  }
};

/// SampleLi for one point light without checks: the same numbers up to rounding.
void sample_bare(const Lamp& lamp, const std::vector<float>& receivers, Arrays& a) {
  for (std::size_t i = 0; i < kReceivers; ++i) {
    const Vec3 to = lamp.position - Vec3(triple(receivers, i));
    const double squared = dot(to, to), distance = std::sqrt(squared), inverse = 1 / squared;
    store(a.wi.data(), i, Vec3f(to * (1 / distance)));
    store(a.value.data(), i,
          Vec3f(Vec3(lamp.intensity.r, lamp.intensity.g, lamp.intensity.b) * inverse));
    store(a.offsets.data(), i, Vec3f(lamp.position));
    a.distance[i] = static_cast<float>(distance);
    a.pdf[i] = 1;
    a.delta[i / 8] |= static_cast<std::uint8_t>(1u << (i % 8));
    a.status[i] = static_cast<int>(ItemResult::kOk);
  }
}

bool is_float(const Vec3& v) { return is_finite(Vec3f(v)); }

/// The same with everything that SampleLi guarantees for any input.
void sample_whole(const Lamp& lamp, const PointArray& receivers, const Vec3& scene_origin,
                  const std::vector<float>& u, Arrays& a) {
  const Vec3 shift = receivers.origin_m - scene_origin;
  const bool is_black = lamp.intensity.is_black();
  for (std::size_t i = 0; i < kReceivers; ++i) {
    const auto put = [&](ItemResult result) { a.status[i] = static_cast<int>(result); };
    a.pdf[i] = 1;
    const Vec3f offset = triple(receivers.offsets_m, i);
    if (!is_finite(offset) || !std::isfinite(u[2 * i]) || !std::isfinite(u[2 * i + 1])) {
      put(ItemResult::kInvalidInput);
      continue;
    }
    const Vec3 position = shift + Vec3(offset);
    if (!is_float(position)) {
      put(ItemResult::kOutOfRange);
      continue;
    }
    a.delta[i / 8] |= static_cast<std::uint8_t>(1u << (i % 8));
    const Vec3 to = lamp.position - position;
    if (to == Vec3{}) {
      put(ItemResult::kDegenerate);
      continue;
    }
    const double squared = dot(to, to);
    const double distance = is_safe_square(squared) ? std::sqrt(squared) : length(to);
    store(a.wi.data(), i, Vec3f(to / distance));
    const Vec3f point(lamp.position - shift);
    const auto reported_distance = static_cast<float>(distance);
    const bool has_place = std::isfinite(reported_distance) && is_finite(point);
    if (std::isfinite(reported_distance)) a.distance[i] = reported_distance;
    if (has_place) store(a.offsets.data(), i, point);
    const Rgb lux =
        is_safe_square(squared) ? lamp.intensity / squared : lamp.intensity / distance / distance;
    const Vec3f value(Vec3(lux.r, lux.g, lux.b));
    if (is_black) {
      put(ItemResult::kBlack);
    } else if (!is_finite(value) || !has_place) {
      put(ItemResult::kOutOfRange);
    } else {
      store(a.value.data(), i, value);
      put(ItemResult::kOk);
    }
  }
}

/// EstimateIrradiance for one point light, with a shadow ray if there is a scene.
void irradiance_bare(const Lamp& lamp, const std::vector<IrradiancePoint>& points,
                     const Scene* scene, std::vector<Rgb>& answer) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const IrradiancePoint& p = points[i];
    const Vec3 to = lamp.position - p.position;
    const double squared = dot(to, to), distance = std::sqrt(squared);
    const double cosine = dot(Vec3(p.normal), to) / distance;
    answer[i] = {};
    if (!(cosine > 0)) continue;
    if (scene != nullptr) {
      const Vec3f start = offset_origin(Vec3f(p.position), p.position_error, Vec3(p.normal), to);
      if (scene->geometry().occluded({start, Vec3f(lamp.position) - start, 0, 1})) continue;
    }
    answer[i] = lamp.intensity * (cosine / squared);
  }
}

/// The same with everything that EstimateIrradiance reports for each point.
IrradianceResult irradiance_whole(const Lamp& lamp, const std::vector<IrradiancePoint>& points,
                                  const Scene* scene) {
  IrradianceResult answer;
  answer.points.resize(points.size());
  answer.costs.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const IrradiancePoint& p = points[i];
    IrradianceEstimate& e = answer.points[i];
    e.exact = true;
    const Vec3 to = lamp.position - p.position;
    const double squared = dot(to, to);
    if (!(squared > 0)) continue;
    const double distance = is_safe_square(squared) ? std::sqrt(squared) : length(to);
    const double cosine = dot(Vec3(p.normal), to / distance);
    if (!(cosine > 0)) continue;
    if (scene != nullptr) {
      ++answer.work.shadow_rays;
      answer.costs[i].rays = 1;
      const Vec3f start = offset_origin(Vec3f(p.position), p.position_error, Vec3(p.normal), to);
      if (scene->geometry().occluded({start, Vec3f(lamp.position) - start, 0, 1})) continue;
    }
    const Rgb lux =
        is_safe_square(squared) ? lamp.intensity / squared : lamp.intensity / distance / distance;
    if (!is_finite(lux)) continue;
    e.irradiance_lx = lux * cosine;
    const double illuminance = luminance(e.irradiance_lx);
    e.illuminance_lx = {illuminance, illuminance};
  }
  return answer;
}

double nanoseconds(const std::function<void()>& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start)
             .count() /
         kReceivers;
}

void compare(const char* what, const std::function<void()>& bare,
             const std::function<void()>& whole, const std::function<void()>& by_scene) {
  std::vector<double> of_bare, of_whole, of_scene, ratio;
  for (int i = 0; i < kRuns; ++i) {
    of_bare.push_back(nanoseconds(bare));
    of_whole.push_back(nanoseconds(whole));
    of_scene.push_back(nanoseconds(by_scene));
    ratio.push_back(of_scene.back() / of_whole.back());
  }
  fmt::print("| {} | {:.1f} | {:.1f} | {:.1f} | {:.2f} |\n", what, median(of_bare),
             median(of_whole), median(of_scene), median(ratio));
}

void run() {
  const DenormalsAreZero denormals;
  SceneDescription d = testing::description();
  d.lights = {testing::point_light(kLamp, kCandela)};
  const auto bare = testing::build(d);
  d.shapes = {testing::floor(10)};
  const auto with_floor = testing::build(d);
  const auto lamp_in = [](const Scene& scene) {
    return Lamp{kLamp - scene.origin(), Rgb(kCandela)};
  };

  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(-9, 9);
  std::vector<float> receivers;
  std::vector<IrradiancePoint> points, floor_points;
  for (std::size_t i = 0; i < kReceivers; ++i) {
    const Vec3f p{u(random), u(random), 0};
    receivers.insert(receivers.end(), {p.x, p.y, p.z});
    const float e = 0x1p-19f;
    points.push_back({Vec3(p) - bare->origin(), {e, e, e}, {0, 0, 1}});
    floor_points.push_back({Vec3(p) - with_floor->origin(), {e, e, e}, {0, 0, 1}});
  }

  fmt::print("bytes: the light {}, the scene {}", sizeof(Lamp), bare->bytes());
  for (const ScenePart& part : bare->parts()) fmt::print("; {} {}", part.name, part.bytes);
  fmt::print("; one entry of its table of lights {}\n\n", sizeof(SceneLight));
  fmt::print("| ns a sample | by hand, bare | by hand, whole | by the scene | over whole |\n");
  fmt::print("|---|---|---|---|---|\n");

  Arrays by_hand, by_scene;
  const std::vector<float> numbers(2 * kReceivers, 0.5f);
  SampleLiQuery query;
  query.receivers = {bare->origin(), receivers};
  query.light = 0;
  query.u = numbers;
  const Lamp of_bare = lamp_in(*bare), of_floor = lamp_in(*with_floor);
  compare(
      "SampleLi", [&] { sample_bare(of_bare, receivers, by_hand); },
      [&] { sample_whole(of_bare, query.receivers, bare->origin(), numbers, by_hand); },
      [&] { sample_li(*bare, query, by_scene.answer(), {}); });
  std::vector<Rgb> answer(kReceivers);
  IrradianceResult whole, estimate;
  IrradianceSettings settings{.block_count = 16, .bounces = 0};
  compare(
      "irradiance, nothing to hit", [&] { irradiance_bare(of_bare, points, nullptr, answer); },
      [&] { whole = irradiance_whole(of_bare, points, nullptr); },
      [&] { estimate = estimate_irradiance(*bare, points, settings, {}); });
  compare(
      "irradiance over a floor, with a shadow ray",
      [&] { irradiance_bare(of_floor, floor_points, with_floor.get(), answer); },
      [&] { whole = irradiance_whole(of_floor, floor_points, with_floor.get()); },
      [&] { estimate = estimate_irradiance(*with_floor, floor_points, settings, {}); });
  double off = 0, lux_off = 0;
  for (std::size_t i = 0; i < by_hand.value.size(); ++i)
    off = std::max(off, std::fabs(1.0 - by_hand.value[i] / by_scene.value[i]));
  for (std::size_t i = 0; i < whole.points.size(); ++i)
    lux_off = std::max(lux_off, std::fabs(1 - whole.points[i].irradiance_lx.g /
                                                  estimate.points[i].irradiance_lx.g));
  fmt::print("\nvalues differ by {:.1e} of them at most, irradiances by {:.1e}\n", off, lux_off);
}

}  // namespace
}  // namespace lucerna

int main() {
  tbb::task_arena arena(1);
  arena.execute([] { lucerna::run(); });
}
