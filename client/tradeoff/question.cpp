#include "client/tradeoff/question.h"

namespace lucerna::tradeoff {

v1::Accuracy reference_accuracy(std::size_t way) {
  v1::Accuracy accuracy;
  accuracy.set_sampler(v1::SAMPLER_INDEPENDENT);
  accuracy.set_combination(v1::COMBINATION_BALANCE_HEURISTIC);
  accuracy.set_area_sampling(v1::AREA_SAMPLING_LOW_DISTORTION);
  accuracy.set_closed_forms(v1::CLOSED_FORMS_OFF);
  accuracy.set_visibility(v1::VISIBILITY_RAYS);
  constexpr v1::LightSelection kWays[] = {v1::LIGHT_SELECTION_ALL, v1::LIGHT_SELECTION_POWER,
                                          v1::LIGHT_SELECTION_UNIFORM};
  accuracy.set_light_selection(kWays[way]);
  return accuracy;
}

std::vector<std::string> reference_ways_for(std::uint64_t lights) {
  const std::string common =
      "independent samples, points by area (low distortion), balance heuristic, no closed forms, "
      "exact rays";
  if (lights < 2) return {common};
  return {"every light, " + common, "one light by power, " + common,
          "one light by chance, " + common};
}

std::string join_flags(const Setting& setting, const Amount& amount) {
  std::string result = " " + amount.flags();
  for (const std::string& flag : setting.flags) result += " " + flag;
  return result;
}

v1::Accuracy accuracy_of(const Setting& setting, const Amount& amount, double floor) {
  v1::Accuracy accuracy = setting.accuracy;
  if (amount.target) {
    accuracy.mutable_target_error()->set_relative(amount.value);
    accuracy.mutable_target_error()->set_absolute_floor(floor);
  } else {
    accuracy.set_samples(static_cast<std::uint32_t>(amount.value));
  }
  return accuracy;
}

// Rec. 709.
double luminance(const float* rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

double rays_of(const v1::Cost& cost) {
  return static_cast<double>(cost.camera_rays() + cost.indirect_rays() + cost.shadow_rays());
}

}  // namespace lucerna::tradeoff
