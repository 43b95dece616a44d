#include "server/estimate/light_strategy.h"

#include <cmath>

#include "server/estimate/direct_light.h"
#include "server/scene/light_distribution.h"

namespace lucerna {

void AllLights::sample(const DirectLight& direct, const LightVertex& v, const PathSample& s) const {
  const auto lights = static_cast<std::uint32_t>(direct.scene().lights().size());
  for (std::uint32_t l = 0; l < lights; ++l)
    if (!v.exact.has(l))
      direct.sample_light(v, {l, 1}, s, PathSample::kFirstVisited + v.depth * lights + l);
}

std::optional<LightChoice> OneLight::choose(const Scene& scene, const Receiver& receiver,
                                            double u) const {
  return (areas_only_ ? scene.lights().area_selector() : scene.lights().selector())
      .choose(how_, receiver, u);
}

double OneLight::probability(const Scene& scene, const Receiver& receiver,
                             std::uint32_t light) const {
  return (areas_only_ ? scene.lights().area_selector() : scene.lights().selector())
      .probability(how_, receiver, light);
}

void OneLight::sample(const DirectLight& direct, const LightVertex& v, const PathSample& s) const {
  const auto choice = choose(direct.scene(), direct.receiver(v.hit, v.wo, v.scattering),
                             choosing_value(s.at(v.depth, PathSample::kLight)));
  if (choice && !v.exact.has(choice->light))
    direct.sample_light(v, *choice, s, PathSample::dimension(v.depth, PathSample::kLightPoint));
}

void ResampledLights::sample(const DirectLight& direct, const LightVertex& v,
                             const PathSample& s) const {
  const std::uint32_t times = direct.methods().samples_per_light.value_or(1);
  for (std::uint32_t k = 0; k < times; ++k) sample_one_of(direct, v, s.part(k, times), 1.0 / times);
}

void ResampledLights::sample_one_of(const DirectLight& direct, const LightVertex& v,
                                    const PathSample& s, double share) const {
  // One pass over the candidates.  Each replaces the kept candidate with the probability of its
  // share in the sum so far.  [Chao82]
  double u = s.at(v.depth, PathSample::kSurvival).y;
  double sum = 0;
  std::uint32_t light = 0;
  DirectLight::Candidate kept{};
  const Receiver from = direct.receiver(v.hit, v.wo, v.scattering);
  for (std::uint32_t j = 0; j < candidates_; ++j) {
    const PathSample part = s.part(j, candidates_);
    const auto choice =
        choose(direct.scene(), from, choosing_value(part.at(v.depth, PathSample::kLight)));
    if (!choice || v.exact.has(choice->light)) continue;
    const DirectLight::Candidate c = direct.candidate(
        v, *choice, 1, part, PathSample::dimension(v.depth, PathSample::kLightPoint));
    if (!c.found.is_black()) v.add(choice->light, {{}, c.found * share});
    const double importance = c.value.max_component();
    if (!(importance > 0)) continue;
    sum += importance;
    const double kept_share = importance / sum;
    if (u < kept_share) {
      u /= kept_share;
      kept = c;
      light = choice->light;
    } else {
      u = (u - kept_share) / (1 - kept_share);
    }
  }
  share /= candidates_;
  if (!(sum > 0 && std::isfinite(sum))) return;
  kept.value = kept.value * (share * (sum / kept.value.max_component()));
  v.add(light, direct.shadowed(v.hit, light, kept, v.work));
}

void DeltasAndOneLight::sample(const DirectLight& direct, const LightVertex& v,
                               const PathSample& s) const {
  const auto& lights = direct.scene().lights();
  for (std::uint32_t l = 0; l < lights.size() && direct.has_deltas(); ++l)
    if (is_delta(lights[l]) && !v.exact.has(l)) direct.sample_light(v, {l, 1}, s, 0);
  other_.sample(direct, v, s);
}

}  // namespace lucerna
