#include "server/rpc/messages/requested_accuracy.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<TargetError> check_target(const CallContext& context, const v1::TargetError& error) {
  const auto bad = [](const char* field, const auto& value, const std::string& allowed) {
    return bad_field(fmt::format("accuracy.target_error.{}", field), value, "{}", allowed);
  };
  TargetError target;
  target.relative = error.relative();
  if (!(target.relative > 0) || !std::isfinite(target.relative))
    return bad("relative", target.relative, "finite and more than 0");
  target.absolute_floor = error.absolute_floor();
  if (!(target.absolute_floor >= 0) || !std::isfinite(target.absolute_floor))
    return bad("absolute_floor", target.absolute_floor, "finite and not negative");
  if (error.has_confidence()) {
    target.confidence = error.confidence();
    if (!(target.confidence > 0 && target.confidence < 1))
      return bad("confidence", target.confidence, "more than 0 and less than 1");
  }
  const std::uint32_t most = context.limits.max_samples;
  target.max_samples = std::min<std::uint64_t>(target.max_samples, most);
  if (error.has_max_samples()) {
    if (error.max_samples() < kLeastTargetSamples || error.max_samples() > most)
      return bad("max_samples", error.max_samples(),
                 fmt::format("[{}, {}]", kLeastTargetSamples, most));
    target.max_samples = error.max_samples();
  }
  return target;
}

/// `samples`, or `fallback` if unset.
absl::StatusOr<std::uint32_t> check_samples(const CallContext& context,
                                            const v1::Accuracy& accuracy, std::uint32_t fallback) {
  if (!accuracy.has_samples()) return fallback;
  if (accuracy.samples() == 0 || accuracy.samples() > context.limits.max_samples) {
    return bad_field("accuracy.samples", accuracy.samples(), "[1, {}]", context.limits.max_samples);
  }
  return accuracy.samples();
}

/// `ways`: the server's enumerator for each number of the message's enum, from 0.
template <typename Way, std::size_t n>
absl::Status take(int number, std::string_view field, std::string_view type,
                  const std::array<Way, n>& ways, Way& to) {
  if (number < 0 || number >= static_cast<int>(n)) {
    return bad_field(fmt::format("accuracy.{}", field), number, "[0, {}], the numbers of {}", n - 1,
                     type);
  }
  to = ways[static_cast<std::size_t>(number)];
  return absl::OkStatus();
}

constexpr std::array kAreaSampling = {AreaSampling::kAutomatic,  AreaSampling::kSquareRoot,
                                      AreaSampling::kKraemer,    AreaSampling::kParallelogram,
                                      AreaSampling::kRejection,  AreaSampling::kLowDistortion,
                                      AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle};
static_assert(kAreaSampling.size() == v1::AreaSampling_ARRAYSIZE);

constexpr std::array kLightSelection = {LightSelection::kAutomatic, LightSelection::kAll,
                                        LightSelection::kUniform, LightSelection::kPower,
                                        LightSelection::kBvh};
static_assert(kLightSelection.size() == v1::LightSelection_ARRAYSIZE);

constexpr std::array kSampler = {Sampler::kSobol, Sampler::kSobol, Sampler::kIndependent};
static_assert(kSampler.size() == v1::Sampler_ARRAYSIZE);

constexpr std::array kCombination = {Combination::kPowerHeuristic, Combination::kPowerHeuristic,
                                     Combination::kBalanceHeuristic, Combination::kLights,
                                     Combination::kSurfaces};
static_assert(kCombination.size() == v1::Combination_ARRAYSIZE);

constexpr std::array kClosedForms = {ClosedForms::kAutomatic, ClosedForms::kOff,
                                     ClosedForms::kEmptyShafts};
static_assert(kClosedForms.size() == v1::ClosedForms_ARRAYSIZE);

constexpr std::array kVisibility = {VisibilityMethod::kRays, VisibilityMethod::kRays,
                                    VisibilityMethod::kShadowMaps};
static_assert(kVisibility.size() == v1::Visibility_ARRAYSIZE);

constexpr std::array kThinGlass = {ThinGlass::kPasses, ThinGlass::kPasses, ThinGlass::kBlocks};
static_assert(kThinGlass.size() == v1::ThinGlass_ARRAYSIZE);

}  // namespace

std::uint32_t blocks_of(std::uint32_t samples) {
  if (samples <= kDefaultBlocks) return samples;
  for (std::uint32_t n = kDefaultBlocks; n <= samples / n; ++n)
    if (samples % n == 0) return n;
  for (std::uint32_t each = kDefaultBlocks; each > 1; --each)
    if (samples % each == 0 && samples / each >= kDefaultBlocks) return samples / each;
  return samples;
}

absl::StatusOr<StopRule> check_stop_rule(const CallContext& context, const v1::Accuracy& accuracy,
                                         std::uint32_t fallback) {
  StopRule rule;
  if (accuracy.has_target_error()) {
    LUCERNA_ASSIGN_OR_RETURN(rule.target, check_target(context, accuracy.target_error()));
  } else if (accuracy.has_time_budget_s()) {
    const double budget = accuracy.time_budget_s();
    if (!(budget > 0) || !std::isfinite(budget))
      return bad_field("accuracy.time_budget_s", budget, "finite and more than 0 s");
    rule.time_budget_s = budget;
  } else {
    LUCERNA_ASSIGN_OR_RETURN(rule.samples, check_samples(context, accuracy, fallback));
  }
  return rule;
}

absl::StatusOr<Methods> check_methods(const v1::Accuracy& accuracy) {
  Methods m;
  LUCERNA_RETURN_IF_ERROR(take(accuracy.area_sampling(), "area_sampling", "AreaSampling",
                               kAreaSampling, m.area_sampling));
  LUCERNA_RETURN_IF_ERROR(take(accuracy.light_selection(), "light_selection", "LightSelection",
                               kLightSelection, m.light_selection));
  LUCERNA_RETURN_IF_ERROR(take(accuracy.sampler(), "sampler", "Sampler", kSampler, m.sampler));
  LUCERNA_RETURN_IF_ERROR(
      take(accuracy.combination(), "combination", "Combination", kCombination, m.combination));
  LUCERNA_RETURN_IF_ERROR(
      take(accuracy.closed_forms(), "closed_forms", "ClosedForms", kClosedForms, m.closed_forms));
  LUCERNA_RETURN_IF_ERROR(
      take(accuracy.visibility(), "visibility", "Visibility", kVisibility, m.visibility));
  LUCERNA_RETURN_IF_ERROR(
      take(accuracy.thin_glass(), "thin_glass", "ThinGlass", kThinGlass, m.thin_glass));
  if (accuracy.has_samples_per_light()) {
    if (accuracy.samples_per_light() < 1 || accuracy.samples_per_light() > kMostSamplesPerLight) {
      return bad_field("accuracy.samples_per_light", accuracy.samples_per_light(), "[1, {}]",
                       kMostSamplesPerLight);
    }
    m.samples_per_light = accuracy.samples_per_light();
  }
  if (accuracy.has_far_light_radii()) {
    if (!(accuracy.far_light_radii() > 0) || !std::isfinite(accuracy.far_light_radii())) {
      return bad_field("accuracy.far_light_radii", accuracy.far_light_radii(),
                       "finite and more than 0");
    }
    m.far_light_radii = accuracy.far_light_radii();
  }
  return m;
}

}  // namespace lucerna::rpc
