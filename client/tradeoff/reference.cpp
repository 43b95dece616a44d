#include "client/tradeoff/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace lucerna::tradeoff {
namespace {

// Of the time for the reference: what is spent to find the best way, and what one answer of it
// takes, so that there are dozens of them.
constexpr double kPilotShare = 0.25, kAnswerShare = 0.03;
// And what is spent on answers that the best way is checked by, where it is to be; no more of them
// than tell how they scatter.
constexpr double kCheckShare = 0.25;
constexpr std::size_t kMostChecks = 16;
constexpr std::uint32_t kMostSamples = 1 << 16;

/// What sets the reference's seeds apart from those of the sweep.
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

/// Takes `values` in the place of what was sampled, or says why not.
void take_closed_form(const std::vector<double>& values, Reference& r) {
  const auto items =
      std::count_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  // Bonferroni: any of them may be the one that is out.
  const double allowed =
      quantile(boost::math::students_t(static_cast<double>(r.replicates) - 1),
               1 - kRefusal / (2 * static_cast<double>(std::max<std::ptrdiff_t>(items, 1))));
  double farthest = 0;  // of what is allowed
  std::size_t where = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]) != std::isnan(r.values[i])) {
      farthest = std::numeric_limits<double>::infinity();
      where = i;
    }
    if (std::isnan(values[i]) || std::isnan(r.values[i])) continue;
    // Sums of floats may be off where nothing scatters.
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
        "Automatic's answers say that they are exact, and differ from the reference by more than "
        "its errors allow: item {} is {:.6g}, and {:.6g} +- {:.2g} (standard error) in the "
        "reference, which was kept.",
        where + 1, values[where], r.values[where], r.standard_error[where]);
    return;
  }
  r.way = fmt::format(
      "closed forms: automatic's answers say of every item that they are exact; all lie within the "
      "errors, {:.2g}% together, of {} answers of {} samples by another estimator ({})",
      100 * r.relative_error, r.replicates, r.samples_each, r.way);
  r.values = values;
  r.standard_error.assign(values.size(), 0);
  r.dark = dark_level(values);
  r.relative_error = r.rmse = 0;
  r.exact = true;
}

/// Answers of a way that needs no check.
struct Check {
  std::vector<std::vector<double>> answers{};
  std::string way{};
  std::uint32_t samples_each = 0;
};

/// Keeps what was sampled where `check` agrees with it in the mean, or takes the check in its
/// place.
void compare(const Check& check, Reference& r) {
  // By the better of the two, so that no value is divided by itself.
  double items = 0, own = 0;
  bool same_items = true;
  std::vector<double> differences(check.answers.size());
  for (std::size_t i = 0; i < r.values.size(); ++i) {
    for (const std::vector<double>& answer : check.answers)
      same_items = same_items && std::isnan(answer[i]) == std::isnan(r.values[i]);
    if (std::isnan(r.values[i])) continue;
    const double level = std::hypot(r.values[i], r.dark);
    ++items;
    own += r.standard_error[i] / level;  // as if all errors were one
    for (std::size_t k = 0; k < differences.size(); ++k)
      differences[k] += (check.answers[k][i] - r.values[i]) / level;
  }
  if (items == 0 && same_items) return;
  const auto n = static_cast<double>(differences.size());
  const double mean = std::accumulate(differences.begin(), differences.end(), 0.0) / n / items;
  double squares = 0;
  for (const double d : differences) squares += (d / items - mean) * (d / items - mean);
  const double error = std::hypot(std::sqrt(squares / (n * (n - 1))), own / items);
  // Sums of floats may be off where nothing scatters.
  const double allowed =
      quantile(boost::math::students_t(n - 1), 1 - kRefusal / 2) * error + 10 * kRounding;
  const std::string difference =
      same_items ? fmt::format(
                       "differ from it by {:.2g} +- {:.2g}% (standard error) in the mean of "
                       "all items",
                       100 * mean, 100 * error)
                 : "are of other items";
  const std::string told =
      fmt::format("{} answers of {} samples by another ({}) {}", check.answers.size(),
                  check.samples_each, check.way, difference);
  if (same_items && std::fabs(mean) <= allowed) {
    r.way += "; " + told;
    return;
  }
  r.warning = fmt::format("A reference ({}) was not believed: {}, and were taken in its place.",
                          r.way, told);
  Replicates replicates(check.answers[0].size());
  for (const std::vector<double>& answer : check.answers) replicates.add(answer);
  finish(replicates, r);
  r.way = check.way;
  r.samples_each = check.samples_each;
}

struct Pilot {
  std::size_t way = 0;
  double merit = 0;  ///< squared error times time of one answer, the less the better
  std::uint32_t samples = 1;
  double seconds = 0;  ///< of an answer
};

/// Doubles the samples until one answer takes `seconds`, then judges by two.
absl::StatusOr<Pilot> try_way(const Question& question, std::size_t way, double seconds,
                              std::uint64_t seed) {
  Pilot pilot{.way = way};
  std::uint64_t number = 0;
  for (;;) {
    const auto a = question.ask_reference(way, pilot.samples, mixed_seed(seed, number++));
    if (!a.ok()) return a.status();
    pilot.seconds = a->seconds;
    if (2 * a->seconds < seconds && pilot.samples < kMostSamples) {
      // At most eightfold at once: short answers say little about long ones.
      const double factor = std::min(8.0, seconds / std::max(a->seconds, 1e-6));
      const int doublings = std::max(1, static_cast<int>(std::log2(factor)));
      pilot.samples = std::min(kMostSamples, pilot.samples << doublings);
      continue;
    }
    const auto b = question.ask_reference(way, pilot.samples, mixed_seed(seed, number++));
    if (!b.ok()) return b.status();
    Replicates both(a->values.size());
    both.add(a->values);
    both.add(b->values);
    Reference r;
    finish(both, r);
    pilot.seconds = (a->seconds + b->seconds) / 2;
    pilot.merit = r.relative_error * r.relative_error * pilot.seconds;
    return pilot;
  }
}

struct Ways {
  Pilot best;
  Pilot unchecked;  ///< of those that need no check, the best
};

absl::StatusOr<Ways> try_ways(const Question& question, const std::vector<ReferenceWay>& ways,
                              double seconds, std::uint64_t seed, const Clock& clock) {
  const double begin = clock();
  std::optional<Pilot> best, unchecked;
  absl::Status refused;
  for (std::size_t way = 0; way < ways.size(); ++way) {
    // A way after the first is not begun when time is short.
    if (unchecked && clock() - begin > kPilotShare * seconds) break;
    const auto pilot = try_way(question, way, kAnswerShare * seconds, mixed_seed(seed, way));
    if (!pilot.ok()) {
      if (!ways[way].checked) refused = pilot.status();
      continue;  // others may do
    }
    if (!best || pilot->merit < best->merit) best = *pilot;
    if (!ways[way].checked && (!unchecked || pilot->merit < unchecked->merit)) unchecked = *pilot;
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
    const auto answer =
        question.ask_reference(way.way, way.samples, mixed_seed(seed, check.answers.size()));
    if (!answer.ok()) return answer.status();
    check.answers.push_back(answer->values);
  }
  return check;
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
  const double begin = clock();
  const std::vector<ReferenceWay> ways = question.reference_ways();
  Reference result;
  if (question.reference_is_exact()) {
    const auto answer = question.ask_reference(0, 1, 0);
    if (!answer.ok()) return answer.status();
    Replicates one(answer->values.size());
    one.add(answer->values);
    finish(one, result);
    result.exact = true;
    result.way = ways[0].words;
    result.standard_error = question.reference_bounds();
    std::vector<double> off = result.values;
    for (std::size_t i = 0; i < off.size(); ++i) off[i] += result.standard_error[i];
    const Errors own = measure(off, result.values, result.dark);
    result.relative_error = std::sqrt(own.relative_mse);
    result.rmse = own.rmse;
    result.seconds = clock() - begin;
    return result;
  }
  seed = mixed_seed(seed, kReferenceSeeds);
  const auto ways_tried = try_ways(question, ways, seconds, seed, clock);
  if (!ways_tried.ok()) return ways_tried.status();
  const Pilot& other = ways_tried->unchecked;
  const double tried = clock() - begin;
  const bool both =
      tried + kFewestReplicates * (ways_tried->best.seconds + other.seconds) < seconds;
  const Pilot& best = both ? ways_tried->best : other;
  const double needed = tried + kFewestReplicates * best.seconds;
  if (needed > seconds) {
    return absl::DeadlineExceededError(
        fmt::format("the reference takes {:.3g} s at least, and gets {:.3g} s", needed, seconds));
  }
  std::optional<Check> check;
  if (ways[best.way].checked) {
    const double spare = seconds - tried - kFewestReplicates * best.seconds;
    auto made = make_check(question, other, std::min(kCheckShare * seconds, spare),
                           mixed_seed(seed, ways.size() + 2), clock);
    if (!made.ok()) return made.status();
    check = *std::move(made);
  }
  std::unique_ptr<Replicates> replicates;
  for (std::uint64_t i = 0;; ++i) {
    const auto answer = question.ask_reference(best.way, best.samples,
                                               mixed_seed(mixed_seed(seed, ways.size()), i));
    if (!answer.ok()) return answer.status();
    if (!replicates) replicates = std::make_unique<Replicates>(answer->values.size());
    replicates->add(answer->values);
    result.seconds = clock() - begin;
    if (replicates->count() < kFewestReplicates) continue;
    finish(*replicates, result);
    if (result.seconds + answer->seconds > seconds || result.relative_error < kGoodReference) break;
  }
  result.way = ways[best.way].words;
  result.samples_each = best.samples;
  if (check) compare(*check, result);
  const auto closed = question.closed_form(mixed_seed(seed, ways.size() + 1));
  if (!closed.ok()) return closed.status();
  if (*closed) take_closed_form(**closed, result);
  return result;
}

}  // namespace lucerna::tradeoff
