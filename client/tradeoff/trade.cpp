#include "client/tradeoff/trade.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna::tradeoff {
namespace {

// Without a time budget, the reference is the mean of kCountedAnswers answers.  Each has
// kCountedSamples times the samples of the largest amount.  The reference's error is then an eighth
// of the error at that amount.
constexpr std::size_t kCountedAnswers = 16;
constexpr std::uint32_t kCountedSamples = 4;
// Smaller target errors take a number of samples that is not known in advance.
constexpr double kLeastCountedTarget = 0.1;

// FNV-1a.
std::uint64_t digest(const std::vector<double>& values) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const double v : values) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    for (int i = 0; i < 8; ++i) hash = (hash ^ (bits >> (8 * i) & 0xff)) * 0x100000001b3;
  }
  return hash;
}

/// Sums of the items' errors over the runs of one cell.
struct Sums {
  std::size_t runs = 0;
  std::vector<float> relative;  // squared
  std::vector<float> last;
};

/// Adds one error for each item.  A pixel is one item of three values.
void add(const std::vector<double>& values, const Reference& reference, bool pictures, Sums& to) {
  const std::size_t channels = pictures ? 3 : 1;
  to.relative.resize(values.size() / channels);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(reference.values[i])) continue;
    to.relative[i / channels] += static_cast<float>(
        relative_square(values[i], reference.values[i], reference.dark) / double(channels));
  }
  if (pictures) to.last.assign(values.begin(), values.end());
  ++to.runs;
}

absl::StatusOr<Reference> reference_of(const Question& question, const TradeOptions& options) {
  if (options.rounds == 0)
    return make_reference(question, options.budget_s / 2, options.seed, options.clock);
  return make_counted_reference(question, kCountedAnswers, kCountedSamples * options.max_samples,
                                options.seed, options.clock);
}

std::vector<Amount> ladder_of(const Question& question, const Setting& setting,
                              const TradeOptions& options) {
  std::vector<Amount> amounts = question.amounts_of(setting);
  if (options.rounds > 0) {
    std::erase_if(amounts, [&](const Amount& amount) {
      return amount.target ? amount.value < kLeastCountedTarget
                           : amount.value > options.max_samples;
    });
  }
  return amounts;
}

}  // namespace

absl::StatusOr<Record> measure_trade(Question& question, const TradeOptions& options) {
  const double begin = options.clock();
  const client::CallOptions call = question.call();
  const auto too_short = [&](const absl::Status& status) -> absl::Status {
    if (!absl::IsDeadlineExceeded(status)) return status;
    // The caller's deadline.  A server also refuses work that cannot be done before it.
    if (client::CallOptions::Clock::now() >= call.deadline ||
        status.GetPayload(client::kStatusPayloadUrl))
      return status;
    return absl::DeadlineExceededError(fmt::format(
        "--budget {:g}s is too short: {}", options.budget_s, std::string(status.message())));
  };
  Record record;
  record.question = &question;
  record.settings = question.settings();
  auto reference = reference_of(question, options);
  if (!reference.ok()) return too_short(reference.status());
  record.reference = *std::move(reference);
  question.set_dark_level(record.reference.dark);
  options.on_event(fmt::format("reference: own error {:.2g}%, {} answers of {} samples, {:.1f} s",
                               100 * record.reference.relative_error, record.reference.replicates,
                               record.reference.samples_each, record.reference.seconds));

  std::vector<std::vector<Amount>> ladders;
  ladders.reserve(record.settings.size());
  for (const Setting& setting : record.settings)
    ladders.push_back(ladder_of(question, setting, options));
  const bool pictures = !question.layout().tiles.empty();
  std::map<std::pair<std::size_t, double>, Sums> sums;
  SweepOptions sweep_options{.seconds = options.budget_s - (options.clock() - begin),
                             .rounds = options.rounds,
                             .seed = options.seed,
                             .clock = options.clock};
  sweep_options.on_event = options.on_event;
  // A picture has many values, so one sample shows which settings are the same.
  if (pictures) sweep_options.first_samples = 1;
  sweep_options.answer = [&](std::size_t setting, const Amount& amount, std::uint64_t seed,
                             std::uint32_t round,
                             std::optional<double> longest_s) -> absl::StatusOr<Run> {
    question.set_call(longest_s ? call.at_most(std::chrono::duration<double>(*longest_s)) : call);
    LUCERNA_ASSIGN_OR_RETURN(const Answer answer,
                             question.answer(record.settings[setting], amount, seed));
    Run run{.seconds = answer.seconds, .samples = answer.samples, .rays = answer.rays};
    run.errors = question.errors(answer.values, record.reference.values, record.reference.dark);
    run.digest = digest(answer.values);
    if (round > 0) add(answer.values, record.reference, pictures, sums[{setting, amount.value}]);
    return run;
  };
  auto swept = sweep(record.settings, ladders, sweep_options);
  if (!swept.ok()) return too_short(swept.status());
  record.sweep = *std::move(swept);
  record.analysis = analyse(record.settings, record.sweep, record.reference);

  record.items.resize(record.settings.size());
  for (std::size_t i = 0; i < record.settings.size(); ++i) {
    const auto cell = record.analysis.compared[i];
    if (!cell) continue;
    Sums& s = sums[{i, record.analysis.curves[i].cells[*cell].amount.value}];
    for (float& square : s.relative) square = std::sqrt(square / static_cast<float>(s.runs));
    record.items[i] = {.relative = std::move(s.relative), .values = std::move(s.last)};
  }
  record.circumstances.spent_s = options.clock() - begin;
  return record;
}

}  // namespace lucerna::tradeoff
