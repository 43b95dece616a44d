#include "server/queries/li_estimates.h"

#include <algorithm>
#include <atomic>

#include "server/estimate/pilots.h"
#include "server/queries/irradiance_estimate.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

// The stop token is polled every tenth of a millisecond.
constexpr std::size_t kSamplesAtOnce = 512;

/// The estimate from a receiver's blocks of equally many samples.
IrradianceEstimate estimate(const LiSampler& sampler, std::size_t receiver,
                            std::span<const LiShare> shares, std::size_t samples_per_block,
                            const IntervalRule& rule) {
  Estimate e{.may_be_hidden = sampler.tests_visibility()};
  const std::size_t blocks = shares.size() / samples_per_block;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    e.add(shares[i].lx);
    if ((i + 1) % samples_per_block == 0)
      e.end_block(static_cast<std::uint32_t>(samples_per_block));
  }
  return e.result({}, static_cast<double>(blocks), rule,
                  [&](bool missed) { return missed ? MostIrradiance{} : sampler.most(receiver); });
}

/// Finds the number of samples that receivers need.
class Pilots {
 public:
  Pilots(const LiSampler& sampler, const TargetError& target, std::uint32_t blocks,
         const std::stop_token& stop)
      : sampler_(sampler), target_(target), blocks_(blocks), stop_(stop) {}

  /// The number of samples in each block of an answer.
  std::uint32_t needed(std::size_t receiver, WorkCounts& work) {
    if (sampler_.receiver_result(receiver) != ItemResult::kOk) return 0;
    return needed_samples_per_block(
        target_, blocks_, [&](const Blocks& these) -> std::optional<PilotEstimate> {
          const std::vector<LiShare> shares = pilot(receiver, these, work);
          if (stopped_) return std::nullopt;
          const IrradianceEstimate e =
              estimate(sampler_, receiver, shares, these.samples,
                       IntervalRule(target_.confidence, blocks_, shares.size()));
          return PilotEstimate{luminance(e.irradiance_lx), e.illuminance_lx};
        });
  }
  bool stopped() const { return stopped_; }

 private:
  std::vector<LiShare> pilot(std::size_t receiver, const Blocks& these, WorkCounts& work) {
    const std::size_t n = these.count * these.samples;
    std::vector<LiShare> shares(n);
    std::vector<LiPlace> places;
    places.reserve(std::min(n, kSamplesAtOnce));
    for (std::size_t i = 0; i < n; ++i) {
      places.push_back({receiver, these.first + i / these.samples,
                        static_cast<std::uint32_t>(i % these.samples)});
      if (places.size() < kSamplesAtOnce && i + 1 < n) continue;
      if (stop_.stop_requested()) {
        stopped_ = true;
        return shares;
      }
      work +=
          sampler_.take(places, std::span(shares).subspan(i + 1 - places.size(), places.size()));
      work.samples += places.size();
      places.clear();
    }
    return shares;
  }

  const LiSampler& sampler_;
  const TargetError& target_;
  const std::uint32_t blocks_;
  const std::stop_token& stop_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

std::optional<std::vector<std::uint32_t>> samples_needed(
    const LiSampler& sampler, std::size_t receivers, const TargetError& target,
    std::uint32_t blocks, const std::stop_token& stop, WorkCounts& work) {
  std::vector<std::uint32_t> needed(receivers);
  if (sampler.needs_one_sample()) return needed;
  Pilots pilots(sampler, target, blocks, stop);
  work +=
      parallel_work(receivers, 1, stop, [&](std::size_t begin, std::size_t end, WorkCounts& spent) {
        for (std::size_t r = begin; r < end && !pilots.stopped(); ++r)
          needed[r] = pilots.needed(r, spent);
      });
  if (pilots.stopped() || stop.stop_requested()) return std::nullopt;
  return needed;
}

std::vector<std::uint32_t> equally_many(const LiSampler& sampler, std::size_t receivers,
                                        std::uint32_t samples_per_block) {
  std::vector<std::uint32_t> each(receivers);
  if (sampler.needs_one_sample()) return each;
  for (std::size_t r = 0; r < receivers; ++r)
    if (sampler.receiver_result(r) == ItemResult::kOk) each[r] = samples_per_block;
  return each;
}

namespace {

/// kInvalidInput or kOutOfRange if one of the samples is, else kOk.
ItemResult result_of(std::span<const int> status) {
  ItemResult of_all = ItemResult::kOk;
  for (const int s : status) {
    const auto result = static_cast<ItemResult>(s);
    if (result == ItemResult::kInvalidInput || result == ItemResult::kOutOfRange) of_all = result;
  }
  return of_all;
}

/// Statistics over blocks of one receiver's samples at one wavelength.  `values`: of the first
/// sample at that wavelength; `stride` values lie between samples.
BlockStatistics spectral_blocks(std::span<const LiShare> shares, std::size_t blocks,
                                const float* values, std::size_t stride) {
  const std::size_t each = shares.size() / blocks;
  BlockStream<1> at(0);
  for (std::size_t b = 0; b < blocks; ++b) {
    CompensatedSum sum;
    for (std::size_t i = b * each; i < (b + 1) * each; ++i)
      sum.add(shares[i].weight * values[i * stride]);
    at.add({sum.value() / static_cast<double>(each)});
  }
  return at.total()[0];
}

}  // namespace

LiEstimates estimates_of(const LiSampler& sampler, const LiLayout& layout, std::size_t receivers,
                         std::uint32_t blocks, double confidence, std::span<const LiShare> shares,
                         std::span<const int> status, std::span<const float> spectral_value,
                         std::size_t wavelengths) {
  const DenormalsAreZero denormals;
  LiEstimates all;
  all.points.resize(receivers);
  all.results.assign(receivers, ItemResult::kOk);
  all.spectral.resize(receivers * wavelengths);
  all.spectral_error.resize(receivers * wavelengths);
  // Kept between receivers: Student's quantile takes longer than some tens of samples.
  std::optional<IntervalRule> rule;
  std::size_t rule_samples = 0;
  for (std::size_t r = 0; r < receivers; ++r) {
    const std::size_t begin = layout.begin(r), n = layout.begin(r + 1) - begin;
    all.results[r] = result_of(status.subspan(begin, n));
    if (all.results[r] != ItemResult::kOk) continue;
    const std::span<const LiShare> own = shares.subspan(begin, n);
    const bool exact = n < blocks;
    if (exact) {
      set_exact(own[0].lx.value, all.points[r]);
    } else {
      if (rule_samples != n) rule.emplace(confidence, blocks, n);
      rule_samples = n;
      all.points[r] = estimate(sampler, r, own, n / blocks, *rule);
    }
    const std::size_t drawn = exact ? 1 : blocks;
    const auto count = static_cast<double>(drawn);
    for (std::size_t k = 0; k < wavelengths; ++k) {
      const BlockStatistics total =
          spectral_blocks(own, drawn, spectral_value.data() + begin * wavelengths + k, wavelengths);
      all.spectral[r * wavelengths + k] = total.sum / count;
      if (!exact) all.spectral_error[r * wavelengths + k] = standard_error(total, count);
    }
  }
  return all;
}

}  // namespace lucerna
