#include "client/tradeoff/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "client/tradeoff/study_statistics.h"
#include "proto/common/confidence.h"
#include "proto/common/status_macros.h"

namespace lucerna::tradeoff {
namespace {

// Shares of the reference's time: for the search for the best estimator, and for one answer.  A
// small share of one answer allows dozens of answers.
constexpr double kPilotShare = 0.25, kAnswerShare = 0.03;
// The share for the answers that check the best estimator.  kMostChecks answers are enough to
// estimate their scatter.
constexpr double kCheckShare = 0.25;
constexpr std::size_t kMostChecks = 16;
constexpr std::uint32_t kMostSamples = 1 << 16;

/// Keeps the seeds of the reference different from the seeds of the sweep.
constexpr std::uint64_t kReferenceSeeds = 0x5eed0f7e;

void finish(const Replicates& replicates, Reference& r) {
  r.values = replicates.mean();
  r.standard_error = replicates.standard_error();
  r.replicates = replicates.count();
  r.dark = dark_level(r.values);
  std::vector<double> off = r.values;
  for (std::size_t i = 0; i < off.size(); ++i) off[i] += r.standard_error[i];
  const Errors own = measure(off, r.values, r.dark);
  r.relative_error = std::sqrt(own.relative_mse);
  r.rmse = own.rmse;
}

/// Replaces the sampled values by the closed forms `values`, or adds a warning.
void take_closed_form(const std::vector<double>& values, Reference& r) {
  const auto items =
      std::count_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  // Bonferroni correction: any of the items may be outside its interval.
  const double allowed =
      student_quantile(static_cast<double>(r.replicates) - 1,
                       kRefusal / (2 * static_cast<double>(std::max<std::ptrdiff_t>(items, 1))));
  double farthest = 0;  // in multiples of the allowed difference
  std::size_t where = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]) != std::isnan(r.values[i])) {
      farthest = std::numeric_limits<double>::infinity();
      where = i;
    }
    if (std::isnan(values[i]) || std::isnan(r.values[i])) continue;
    // Rounding of sums in single precision does not scatter, so it is added to the bound.
    const double bound =
        allowed * r.standard_error[i] + 10 * kRounding * std::max(std::fabs(r.values[i]), r.dark);
    const double off = std::fabs(values[i] - r.values[i]) / bound;
    if (off <= farthest) continue;
    farthest = off;
    where = i;
  }
  if (farthest > 1) {
    if (!r.warning.empty()) r.warning += "  ";
    r.warning += fmt::format(
        "Automatic reports exact values, but they differ from the sampled reference by more than "
        "its errors allow: item {} is {:.6g}, and {:.6g} +- {:.2g} (standard error) in the "
        "reference. The sampled reference was kept.",
        where + 1, values[where], r.values[where], r.standard_error[where]);
    return;
  }
  r.way = fmt::format(
      "closed forms: automatic reports an exact value of every item; all lie within the errors, "
      "{:.2g}% together, of {} answers of {} samples by another estimator ({})",
      100 * r.relative_error, r.replicates, r.samples_each, r.way);
  r.values = values;
  r.standard_error.assign(values.size(), 0);
  r.dark = dark_level(values);
  r.relative_error = r.rmse = 0;
  r.exact = true;
}

/// Answers of an estimator that does not need a check.
struct Check {
  std::vector<std::vector<double>> answers{};
  std::string way{};
  std::uint32_t samples_each = 0;
};

/// Keeps the reference if its mean agrees with the mean of `check`.  Otherwise replaces it by the
/// check.
void compare(const Check& check, Reference& r) {
  // Divide by the values of the reference.  It is the better of the two, and no value is then
  // divided by itself.
  double items = 0, own = 0;
  bool same_items = true;
  std::vector<double> differences(check.answers.size());
  for (std::size_t i = 0; i < r.values.size(); ++i) {
    for (const std::vector<double>& answer : check.answers)
      same_items = same_items && std::isnan(answer[i]) == std::isnan(r.values[i]);
    if (std::isnan(r.values[i])) continue;
    const double level = std::hypot(r.values[i], r.dark);
    ++items;
    own += r.standard_error[i] / level;  // as if all errors were fully correlated
    for (std::size_t k = 0; k < differences.size(); ++k)
      differences[k] += (check.answers[k][i] - r.values[i]) / level;
  }
  if (items == 0 && same_items) return;
  const auto n = static_cast<double>(differences.size());
  const double mean = std::accumulate(differences.begin(), differences.end(), 0.0) / n / items;
  double squares = 0;
  for (const double d : differences) squares += (d / items - mean) * (d / items - mean);
  const double error = std::hypot(std::sqrt(squares / (n * (n - 1))), own / items);
  // Rounding of sums in single precision does not scatter, so it is added to the bound.
  const double allowed = student_quantile(n - 1, kRefusal / 2) * error + 10 * kRounding;
  const std::string difference =
      same_items ? fmt::format(
                       "differ from it by {:.2g} +- {:.2g}% (standard error) in the mean of "
                       "all items",
                       100 * mean, 100 * error)
                 : "are of other items";
  const std::string finding =
      fmt::format("{} answers of {} samples by another ({}) {}", check.answers.size(),
                  check.samples_each, check.way, difference);
  if (same_items && std::fabs(mean) <= allowed) {
    r.way += "; " + finding;
    return;
  }
  r.warning = fmt::format("A reference ({}) was rejected and replaced: {}.", r.way, finding);
  Replicates replicates(check.answers[0].size());
  for (const std::vector<double>& answer : check.answers) replicates.add(answer);
  finish(replicates, r);
  r.way = check.way;
  r.samples_each = check.samples_each;
}

struct Pilot {
  std::size_t way = 0;
  double cost = 0;  ///< squared error times seconds of one answer
  std::uint32_t samples = 1;
  double seconds = 0;  ///< wall time of one answer
};

/// Doubles the samples until one answer takes `seconds`, then takes two answers.
absl::StatusOr<Pilot> try_way(const Question& question, std::size_t way, double seconds,
                              std::uint64_t seed) {
  Pilot pilot{.way = way};
  std::uint64_t number = 0;
  for (;;) {
    LUCERNA_ASSIGN_OR_RETURN(
        const Answer a, question.answer_reference(way, pilot.samples, mixed_seed(seed, number++)));
    pilot.seconds = a.seconds;
    if (2 * a.seconds < seconds && pilot.samples < kMostSamples) {
      // Increase at most eightfold at once, because short answers predict long ones badly.
      const double factor = std::min(8.0, seconds / std::max(a.seconds, 1e-6));
      const int doublings = std::max(1, static_cast<int>(std::log2(factor)));
      pilot.samples = std::min(kMostSamples, pilot.samples << doublings);
      continue;
    }
    LUCERNA_ASSIGN_OR_RETURN(
        const Answer b, question.answer_reference(way, pilot.samples, mixed_seed(seed, number++)));
    Replicates both(a.values.size());
    both.add(a.values);
    both.add(b.values);
    Reference r;
    finish(both, r);
    pilot.seconds = (a.seconds + b.seconds) / 2;
    pilot.cost = r.relative_error * r.relative_error * pilot.seconds;
    return pilot;
  }
}

struct Ways {
  Pilot best;
  Pilot unchecked;  ///< the best estimator that does not need a check
};

absl::StatusOr<Ways> try_ways(const Question& question, const std::vector<ReferenceWay>& ways,
                              double seconds, std::uint64_t seed, const Clock& clock) {
  const double begin = clock();
  std::optional<Pilot> best, unchecked;
  absl::Status refused;
  for (std::size_t way = 0; way < ways.size(); ++way) {
    // Try no further estimator after the pilots' share of the time.
    if (unchecked && clock() - begin > kPilotShare * seconds) break;
    const auto pilot = try_way(question, way, kAnswerShare * seconds, mixed_seed(seed, way));
    if (!pilot.ok()) {
      if (!ways[way].checked) refused = pilot.status();
      continue;  // another estimator may work
    }
    if (!best || pilot->cost < best->cost) best = *pilot;
    if (!ways[way].checked && (!unchecked || pilot->cost < unchecked->cost)) unchecked = *pilot;
  }
  if (!unchecked) return refused;
  return Ways{.best = *best, .unchecked = *unchecked};
}

absl::StatusOr<Check> make_check(const Question& question, const Pilot& way, double seconds,
                                 std::uint64_t seed, const Clock& clock) {
  Check check{.way = question.reference_ways()[way.way].words, .samples_each = way.samples};
  const double end = clock() + seconds;
  while (check.answers.size() < kFewestReplicates ||
         (check.answers.size() < kMostChecks && clock() + way.seconds < end)) {
    LUCERNA_ASSIGN_OR_RETURN(
        Answer answer,
        question.answer_reference(way.way, way.samples, mixed_seed(seed, check.answers.size())));
    check.answers.push_back(std::move(answer.values));
  }
  return check;
}

/// The reference that the server reports with a bound.
absl::StatusOr<Reference> exact_reference(const Question& question, const Clock& clock) {
  const double begin = clock();
  LUCERNA_ASSIGN_OR_RETURN(const Answer answer, question.answer_reference(0, 1, 0));
  Replicates one(answer.values.size());
  one.add(answer.values);
  Reference result;
  finish(one, result);
  result.exact = true;
  result.way = question.reference_ways()[0].words;
  result.standard_error = question.reference_bounds();
  std::vector<double> off = result.values;
  for (std::size_t i = 0; i < off.size(); ++i) off[i] += result.standard_error[i];
  const Errors own = measure(off, result.values, result.dark);
  result.relative_error = std::sqrt(own.relative_mse);
  result.rmse = own.rmse;
  result.seconds = clock() - begin;
  return result;
}

/// Whether the mean of the answers so far is good enough.  `last_s` is the time of the last answer
/// [s].
using Enough = std::function<bool(const Reference& so_far, double last_s)>;

/// The mean of at least kFewestReplicates answers with different seeds.
absl::StatusOr<Reference> mean_answer(const Question& question, const Pilot& way,
                                      std::uint64_t seed, const Enough& enough) {
  Reference result;
  std::unique_ptr<Replicates> replicates;
  for (std::uint64_t i = 0;; ++i) {
    LUCERNA_ASSIGN_OR_RETURN(const Answer answer,
                             question.answer_reference(way.way, way.samples, mixed_seed(seed, i)));
    if (!replicates) replicates = std::make_unique<Replicates>(answer.values.size());
    replicates->add(answer.values);
    if (replicates->count() < kFewestReplicates) continue;
    finish(*replicates, result);
    if (enough(result, answer.seconds) || result.relative_error < kGoodReference) break;
  }
  result.way = question.reference_ways()[way.way].words;
  result.samples_each = way.samples;
  return result;
}

absl::Status try_closed_form(const Question& question, std::uint64_t seed, Reference& r) {
  LUCERNA_ASSIGN_OR_RETURN(const auto values, question.closed_form(seed));
  if (values) take_closed_form(*values, r);
  return absl::OkStatus();
}

}  // namespace

std::uint64_t mixed_seed(std::uint64_t seed, std::uint64_t number) {
  std::uint64_t z = seed + (number + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

absl::StatusOr<Reference> make_reference(const Question& question, double seconds,
                                         std::uint64_t seed, const Clock& clock) {
  if (question.reference_is_exact()) return exact_reference(question, clock);
  const double begin = clock();
  const std::vector<ReferenceWay> ways = question.reference_ways();
  seed = mixed_seed(seed, kReferenceSeeds);
  LUCERNA_ASSIGN_OR_RETURN(const Ways tried, try_ways(question, ways, seconds, seed, clock));
  const double spent = clock() - begin;
  const bool both =
      spent + kFewestReplicates * (tried.best.seconds + tried.unchecked.seconds) < seconds;
  const Pilot& best = both ? tried.best : tried.unchecked;
  const double needed = spent + kFewestReplicates * best.seconds;
  if (needed > seconds) {
    return absl::DeadlineExceededError(fmt::format(
        "the reference needs at least {:.3g} s, but gets only {:.3g} s", needed, seconds));
  }
  std::optional<Check> check;
  if (ways[best.way].checked) {
    const double spare = seconds - spent - kFewestReplicates * best.seconds;
    LUCERNA_ASSIGN_OR_RETURN(
        check, make_check(question, tried.unchecked, std::min(kCheckShare * seconds, spare),
                          mixed_seed(seed, ways.size() + 2), clock));
  }
  const auto enough = [&](const Reference&, double last_s) {
    return clock() - begin + last_s > seconds;
  };
  LUCERNA_ASSIGN_OR_RETURN(Reference result,
                           mean_answer(question, best, mixed_seed(seed, ways.size()), enough));
  result.seconds = clock() - begin;
  if (check) compare(*check, result);
  LUCERNA_RETURN_IF_ERROR(try_closed_form(question, mixed_seed(seed, ways.size() + 1), result));
  return result;
}

absl::StatusOr<Reference> make_counted_reference(const Question& question, std::size_t answers,
                                                 std::uint32_t samples, std::uint64_t seed,
                                                 const Clock& clock) {
  if (question.reference_is_exact()) return exact_reference(question, clock);
  const double begin = clock();
  const std::vector<ReferenceWay> ways = question.reference_ways();
  const auto way =
      std::find_if(ways.begin(), ways.end(), [](const ReferenceWay& w) { return !w.checked; });
  const Pilot pilot{.way = static_cast<std::size_t>(way - ways.begin()),
                    .samples = std::min(samples, kMostSamples)};
  seed = mixed_seed(seed, kReferenceSeeds);
  const auto enough = [&](const Reference& so_far, double) { return so_far.replicates >= answers; };
  LUCERNA_ASSIGN_OR_RETURN(Reference result,
                           mean_answer(question, pilot, mixed_seed(seed, ways.size()), enough));
  result.seconds = clock() - begin;
  LUCERNA_RETURN_IF_ERROR(try_closed_form(question, mixed_seed(seed, ways.size() + 1), result));
  return result;
}

}  // namespace lucerna::tradeoff
