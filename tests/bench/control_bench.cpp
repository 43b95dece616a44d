// Measures a closed form as a control variate for a partly hidden light, on scenes of scenes/. It
// prints the squared error of 64 samples of one light at one receiver, relative to the irradiance
// without obstacles.  [Heitz18]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "lights/sampling/sobol.h"
#include "server/estimate/paths/path.h"
#include "server/estimate/queries/receiver_irradiance.h"
#include "server/runtime/denormals.h"
#include "tests/bench/shipped_scene.h"

namespace lucerna {
namespace {

/// Illuminance by four methods: samples of a light; samples of it and of directions from the
/// surface; the closed form minus the hidden part; the closed form times the visible share.
enum Estimator { kLights, kBoth, kLess, kTimes, kEstimators };
constexpr std::array kNames = {"lights alone", "lights and directions", "closed form less hidden",
                               "closed form times visible"};
using Estimates = std::array<double, kEstimators>;

/// A light at a receiver.
class Pair {
 public:
  Pair(const Scene& scene, const SurfaceHit& hit, std::uint32_t light)
      : scene_(scene), hit_(hit), light_(light), receiver_(hit.position) {
    receiver_.normal = hit.ns;
    const Light& l = *scene_.lights()[light_].light;
    if (l.has_surface() && !l.hides_itself())
      unshadowed_lx_ = luminance(l.irradiance(receiver_).value_or(Rgb()));
  }

  /// 0 if there is no closed form.
  double unshadowed_lx() const { return unshadowed_lx_; }

  Estimates estimate(AreaSampling way, std::uint64_t seed, std::uint32_t samples) const {
    const SobolSequence sequence(seed, 0, 0);
    Receiver receiver = receiver_;
    receiver.area_sampling = way;
    double all = 0, visible = 0, weighed = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
      const Vec2f u = sequence.pair(i, 0);
      const auto s = scene_.lights()[light_].light->sample_li(receiver, {double{u.x}, double{u.y}});
      const double cosine = dot(receiver.normal, s.wi);
      if (s.reason == NoLight::kNone && cosine > 0) {
        const double lx = luminance(s.value) * cosine / s.pdf.per_sr;
        all += lx;
        if (!scene_.geometry().occluded(shadow_ray(hit_, s, scene_.lights()[light_].reach_m()))) {
          visible += lx;
          weighed += lx * weight(s.pdf.per_sr, cosine);
        }
      }
      weighed += found(receiver, sequence.pair(i, 1));
    }
    const double n = samples;
    return {visible / n, weighed / n, unshadowed_lx_ - (all - visible) / n,
            all > 0 ? unshadowed_lx_ * visible / all : 0};
  }

 private:
  /// Weight of the power heuristic against cosine-distributed directions.
  static double weight(double light_pdf, double cosine) {
    const double ratio = cosine * std::numbers::inv_pi / light_pdf;
    return 1 / (1 + ratio * ratio);
  }
  /// Contribution of a cosine-distributed direction that hits the light.
  double found(const Receiver& receiver, const Vec2f& u) const {
    const Vec3f wi = PathTracer::cosine_direction(Vec3f(hit_.ns), Vec3f(hit_.ns), u);
    const auto hit = scene_.closest_hit(spawn_ray(hit_, wi));
    if (!hit || hit->light != static_cast<std::int32_t>(light_)) return 0;
    const Light& l = *scene_.lights()[light_].light;
    const double light_pdf = l.pdf_li(receiver, hit->on_light()).per_sr;
    return std::numbers::pi * luminance(l.le(hit->on_light(), Vec3(-wi))) *
           (1 - weight(light_pdf, dot(hit_.ns, Vec3(wi))));
  }

  const Scene& scene_;
  const SurfaceHit& hit_;
  std::uint32_t light_;
  Receiver receiver_;
  double unshadowed_lx_ = 0;
};

void measure(const std::string& name) {
  constexpr std::uint32_t kSamples = 64, kConverged = 1 << 16;
  constexpr int kRepeats = 16, kMostPairs = 150;
  constexpr std::array kWays = {AreaSampling::kAutomatic, AreaSampling::kCosineSolidAngle};
  const DenormalsAreZero denormals;
  const auto scene = load_shipped(name);
  std::array<Estimates, kWays.size()> squares{};
  int pairs = 0;
  for (const IrradiancePoint& point : shipped_points(*scene, name)) {
    SurfaceHit hit;
    hit.position = point.position;
    hit.position_error = point.position_error;
    hit.ns = point.normal;
    hit.ng = Vec3(point.normal);
    for (std::uint32_t l = 0; l < scene->lights().size() && pairs < kMostPairs; ++l) {
      const Pair pair(*scene, hit, l);
      const double all = pair.unshadowed_lx();
      if (!(all > 0)) continue;
      // A few samples decide whether it is partly hidden.  The closed form minus the hidden part
      // then converges to the truth.
      const double share = pair.estimate(AreaSampling::kAutomatic, 1, kSamples)[kTimes] / all;
      if (!(share > 0.02 && share < 0.98)) continue;
      ++pairs;
      const double truth = pair.estimate(AreaSampling::kAutomatic, 2, kConverged)[kLess];
      for (std::size_t w = 0; w < kWays.size(); ++w)
        for (int r = 0; r < kRepeats; ++r) {
          const Estimates e =
              pair.estimate(kWays[w], 100 + static_cast<std::uint64_t>(r), kSamples);
          for (int k = 0; k < kEstimators; ++k)
            squares[w][k] += (e[k] - truth) * (e[k] - truth) / (all * all) / kRepeats;
        }
    }
  }
  for (int k = 0; k < kEstimators; ++k)
    fmt::print("| {} | {} | {:.3g} | {:.3g} |\n", fmt::format("{}, {} pairs", name, pairs),
               kNames[k], squares[0][k] / pairs, squares[1][k] / pairs);
}

}  // namespace
}  // namespace lucerna

int main() {
  fmt::print(
      "| scene | estimator | points by the default | by projected solid angle "
      "|\n|---|---|---|---|\n");
  for (const char* name : {"cornell", "street"}) lucerna::measure(name);
}
