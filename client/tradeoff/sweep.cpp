#include "client/tradeoff/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <utility>

#include "client/tradeoff/study_statistics.h"
#include "proto/common/status_macros.h"

namespace lucerna::tradeoff {
namespace {

// Shares of the time: for the first heat, and the most for a single question.  A target error gets
// more, because it starts with pilot samples.
constexpr double kFirstHeat = 0.4, kLongestQuestion = 0.03, kLongestTarget = 0.1;
// The next number of samples takes up to four times as long, the next target error up to ten times.
constexpr double kGrowth = 4, kTargetGrowth = 10;
constexpr std::uint32_t kMostRounds = 40;
// The least number of samples of a target error.
constexpr double kPilotSamples = 64;
// Few samples of few items may be equal by chance.  Settings with equal answers are measured again
// with kSecondLookSamples.  If these take more than this share of the time, with a smaller power of
// four.
constexpr double kSecondLookSamples = 64, kSecondLook = 0.01;
// Shares of the time for answers that take too long.  All of them together get kWaiting, and each
// gets at most half of what is left of it.  Every answer gets at least kLeastWaiting.
constexpr double kWaiting = 0.3, kLeastWaiting = 0.01;
// The time of a sweep with a number of rounds.
constexpr double kForever = std::numeric_limits<double>::infinity();

bool refuses(const absl::Status& status) {
  return absl::IsUnimplemented(status) || absl::IsInvalidArgument(status) ||
         absl::IsFailedPrecondition(status) || absl::IsResourceExhausted(status) ||
         absl::IsOutOfRange(status);
}

class Sweep {
 public:
  Sweep(const std::vector<Setting>& settings, const std::vector<std::vector<Amount>>& ladders,
        const SweepOptions& options)
      : settings_(settings),
        ladders_(ladders),
        options_(options),
        seconds_(options.rounds > 0 ? kForever : options.seconds),
        begin_(options.clock()),
        shuffle_(mixed_seed(options.seed, 1)) {
    result_.courses.resize(settings.size());
    first_.resize(settings.size());
    rungs_.resize(settings.size());
  }

  absl::StatusOr<SweepResult> run() {
    LUCERNA_RETURN_IF_ERROR(compare_first_answers());
    if (options_.rounds > 0) {
      LUCERNA_RETURN_IF_ERROR(heat(kForever, options_.rounds, "only"));
      return std::move(result_);
    }
    LUCERNA_RETURN_IF_ERROR(heat(begin_ + kFirstHeat * seconds_, kMostRounds, "first"));
    drop_far_behind();
    LUCERNA_RETURN_IF_ERROR(heat(begin_ + seconds_, kMostRounds, "second"));
    if (round_ == 0) {
      return absl::DeadlineExceededError(
          fmt::format("{:.2g} s are only enough to find out the cost of {} settings", seconds_,
                      settings_.size()));
    }
    return std::move(result_);
  }

 private:
  bool stays(std::size_t i) const { return result_.courses[i].fate == Course::Fate::kSwept; }
  void leave(std::size_t i, Course::Fate fate, const std::string& why) {
    result_.courses[i].fate = fate;
    result_.courses[i].why = why;
    options_.on_event(fmt::format("{}: {}", settings_[i].name(), why));
  }

  void leave_for(std::size_t i, const absl::Status& no) {
    leave(i, Course::Fate::kSkipped, fmt::format("skipped: {}", std::string(no.message())));
  }
  double longest_of(std::size_t i) const {
    return seconds_ * (settings_[i].by_target ? kLongestTarget : kLongestQuestion);
  }

  absl::StatusOr<Run> run_question(std::size_t i, const Amount& amount, std::uint64_t seed,
                                   std::uint32_t round,
                                   std::optional<double> longest_s = std::nullopt) {
    LUCERNA_ASSIGN_OR_RETURN(Run run, options_.answer(i, amount, seed, round, longest_s));
    run.setting = i;
    run.amount = amount;
    run.seed = seed;
    run.round = round;
    result_.runs.push_back(run);
    return run;
  }
  /// The seed of an amount in the current round, the same for every setting.
  std::uint64_t seed_of(const Amount& amount) const {
    const std::uint64_t round = mixed_seed(options_.seed, 2 + round_);
    return mixed_seed(round, std::bit_cast<std::uint64_t>(amount.value));
  }

  struct SecondLook {
    bool same = true;
    std::optional<Amount> of;  ///< empty if the second look takes too long
  };

  /// Whether i and j have equal answers with another seed and, if the time allows, with more
  /// samples.
  absl::StatusOr<SecondLook> look_again(std::size_t i, std::size_t j) {
    const Run &a = *first_[i], &b = *first_[j];
    const double most = std::min(kSecondLookSamples, ladders_[i].back().value);
    const double each = std::max(a.seconds, b.seconds) / a.amount.value;
    const double longest = kSecondLook * seconds_;
    Amount amount = a.amount;
    if (amount.value * each > longest) return SecondLook{};
    while (4 * amount.value <= most && 4 * amount.value * each <= longest) amount.value *= 4;
    const std::uint64_t seed = mixed_seed(mixed_seed(options_.seed, 0), 1);
    const auto digest = [&](std::size_t k) -> absl::StatusOr<std::uint64_t> {
      const auto known = second_.find({k, amount.value});
      if (known != second_.end()) return known->second;
      LUCERNA_ASSIGN_OR_RETURN(const Run run, run_question(k, amount, seed, 0));
      return second_[{k, amount.value}] = run.digest;
    };
    const auto x = digest(i), y = digest(j);
    for (const auto& one : {x, y}) {
      if (!one.ok() && !refuses(one.status())) return one.status();
    }
    return SecondLook{.same = x.ok() && y.ok() && *x == *y, .of = amount};
  }

  /// Removes setting i if its answers equal those of an earlier setting.
  absl::Status leave_if_same(std::size_t i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (settings_[j].by_target || !first_[j] || first_[j]->digest != first_[i]->digest) continue;
      if (result_.courses[j].fate == Course::Fate::kSame)
        continue;  // i is compared with the setting that j equals
      LUCERNA_ASSIGN_OR_RETURN(const SecondLook again, look_again(i, j));
      if (!again.same) continue;
      result_.courses[i].same_as = j;
      const std::string scope =
          !again.of ? fmt::format("for {}; a second look takes too long for this budget",
                                  first_[i]->amount.text())
          : ladders_[i].size() == 1 ? "in both of two answers"
                                    : fmt::format("for {} and, with another seed, for {}",
                                                  first_[i]->amount.text(), again.of->text());
      leave(i, Course::Fate::kSame, fmt::format("same bits as {}, {}", settings_[j].name(), scope));
      break;
    }
    return absl::OkStatus();
  }

  /// Measures the same question with the same seed for every setting.  Removes settings that the
  /// server refuses, that take too long, or that equal another setting.
  absl::Status compare_first_answers() {
    double round = 0, waited = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      const Amount first = settings_[i].by_target || ladders_[i].size() == 1
                               ? ladders_[i][0]
                               : Amount{.target = false, .value = options_.first_samples};
      const double longest = longest_of(i);
      if (settings_[i].by_target && i > 0) {
        const Run& automatic = result_.runs[0];
        const double pilot = automatic.seconds * kPilotSamples / automatic.amount.value;
        if (pilot > longest) {
          leave(i, Course::Fate::kSkipped,
                fmt::format("skipped, it starts with {} samples, which take about {:.2g} s: too "
                            "long for this budget",
                            kPilotSamples, pilot));
          continue;
        }
      }
      // The limit is for the least amount.  Automatic has no limit, because all other settings are
      // compared with it.
      const double least_share = settings_[i].by_target ? 1 : ladders_[i][0].value / first.value;
      const double patience =
          std::max(kLeastWaiting * seconds_, (kWaiting * seconds_ - waited) / 2);
      const auto limit = i > 0 && std::isfinite(seconds_)
                             ? std::optional(std::min(longest / least_share, patience))
                             : std::nullopt;
      const auto run = run_question(i, first, mixed_seed(options_.seed, 0), 0, limit);
      if (limit && absl::IsDeadlineExceeded(run.status())) {
        waited += *limit;
        leave(i, Course::Fate::kSkipped,
              fmt::format("skipped, no answer to {} within {:.2g} s: too long for this budget",
                          first.text(), *limit));
        continue;
      }
      if (!run.ok()) {
        if (!refuses(run.status()) || i == 0) return run.status();
        leave_for(i, run.status());
        continue;
      }
      first_[i] = *run;
      if (!settings_[i].by_target) {
        LUCERNA_RETURN_IF_ERROR(leave_if_same(i));
        if (!stays(i)) continue;
      }
      round += run->seconds * least_share;
      if (options_.clock() - begin_ + kFewestRounds * round > seconds_) {
        return absl::DeadlineExceededError(
            fmt::format("the first {} of {} settings take {:.2g} s for each round and need at "
                        "least {} rounds, but only {:.2g} s are left",
                        i + 1, settings_.size(), round, kFewestRounds, seconds_));
      }
    }
    return absl::OkStatus();
  }

  double growth(std::size_t i) const { return settings_[i].by_target ? kTargetGrowth : kGrowth; }

  /// Raises each setting's amount as long as a question takes at most `longest` seconds.  Then
  /// raises it to the amounts that other settings reached, if these take at most twice as long and
  /// there is time.  So settings are compared at the same amounts.  These runs do not count.
  absl::Status climb(double longest, double end) {
    std::size_t highest = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      LUCERNA_RETURN_IF_ERROR(climb(i, longest, ladders_[i].size()));
      if (!settings_[i].by_target) highest = std::max(highest, rungs_[i].size());
    }
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      if (settings_[i].by_target) continue;
      const std::size_t most = std::min(highest, ladders_[i].size());
      const double spare = end - options_.clock() - kFewestRounds * round_takes();
      const double longer = std::min(2 * longest, spare / (1 + kFewestRounds));
      LUCERNA_RETURN_IF_ERROR(climb(i, longer, most));
    }
    return absl::OkStatus();
  }

  absl::Status climb(std::size_t i, double longest, std::size_t most) {
    std::vector<double>& seconds = rungs_[i];
    while (stays(i) && seconds.size() < most) {
      if (!seconds.empty() && seconds.back() * growth(i) > longest) break;
      const Amount& amount = ladders_[i][seconds.size()];
      const auto run = run_question(i, amount, seed_of(amount), 0);
      if (!run.ok()) {
        if (!refuses(run.status()) || (seconds.empty() && i == 0)) return run.status();
        if (seconds.empty()) leave_for(i, run.status());
        break;
      }
      // The least amount may take as long as the first question, which was larger.
      if (seconds.empty() && i > 0 && run->seconds > longest_of(i)) {
        leave(i, Course::Fate::kSkipped,
              fmt::format("skipped, {:.2g} s for {}: too long for this budget", run->seconds,
                          amount.text()));
        break;
      }
      seconds.push_back(run->seconds);
    }
    return absl::OkStatus();
  }

  /// The predicted seconds of one round.
  double round_takes() const {
    double sum = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i)
      if (stays(i)) sum += std::accumulate(rungs_[i].begin(), rungs_[i].end(), 0.0);
    return sum;
  }

  /// Rounds until `end` on the clock, at most `most_rounds`.
  absl::Status heat(double end, std::uint32_t most_rounds, const char* which) {
    const double left = end - options_.clock();
    double share = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      // The times of a ladder's amounts are a geometric series that ends at the longest question.
      // Climbing takes this time once, and so does each round.
      if (stays(i)) share += growth(i) / (growth(i) - 1);
    }
    LUCERNA_RETURN_IF_ERROR(climb(left / (share * (1 + kFewestRounds)), end));
    for (std::uint32_t n = 0; n < most_rounds; ++n) {
      std::vector<std::pair<std::size_t, std::size_t>> cells;
      for (std::size_t i = 0; i < settings_.size(); ++i) {
        if (!stays(i)) continue;
        for (std::size_t k = 0; k < rungs_[i].size(); ++k) cells.emplace_back(i, k);
      }
      const double now = options_.clock();
      if (n >= kFewestRounds && now + round_takes() > end) break;
      // The least number of rounds may exceed the end by at most a quarter of the time.
      if (now > end + 0.25 * seconds_) break;
      ++round_;
      std::shuffle(cells.begin(), cells.end(), shuffle_);
      for (const auto& [i, k] : cells) {
        const Amount& amount = ladders_[i][k];
        LUCERNA_RETURN_IF_ERROR(run_question(i, amount, seed_of(amount), round_).status());
      }
    }
    options_.on_event(fmt::format("{} heat: {} rounds so far", which, round_));
    return absl::OkStatus();
  }

  /// Time and error of each amount: the mean error or, with `favourable`, the lower end of its
  /// interval.
  std::vector<Measured> curve(std::size_t i, bool favourable) const {
    std::vector<Measured> result;
    for (std::size_t k = 0; k < rungs_[i].size(); ++k) {
      std::vector<double> seconds, squares;
      for (const Run& run : result_.runs) {
        if (run.setting != i || run.round == 0 || !(run.amount == ladders_[i][k])) continue;
        seconds.push_back(run.seconds);
        squares.push_back(run.errors.relative_mse);
      }
      if (seconds.empty()) continue;
      const Interval interval = root_mean_interval(squares);
      const double error = favourable ? interval.lower : interval.mean;
      result.push_back(
          {.seconds = quartiles(seconds).median, .error = error, .samples = ladders_[i][k].value});
    }
    return result;
  }

  void drop_far_behind() {
    std::vector<std::vector<Measured>> curves;
    for (std::size_t i = 0; i < settings_.size(); ++i) curves.push_back(curve(i, false));
    for (std::size_t i = 1; i < settings_.size(); ++i) {
      if (!stays(i)) continue;
      // Drop a setting only if even its lowest likely error is behind.
      const std::vector<Measured> own = curve(i, true);
      if (own.empty()) continue;
      // One of its two largest amounts may be close to the best, so the better of the two decides.
      double behind = std::numeric_limits<double>::infinity();
      std::size_t winner = 0;
      for (const Measured& cell : std::span(own).last(std::min<std::size_t>(2, own.size()))) {
        double most = 0;
        for (std::size_t j = 0; j < settings_.size(); ++j) {
          if (j == i || !stays(j) || cell.error <= 0) continue;
          const auto other = time_to_error(curves[j], cell.error, false);
          if (!other || cell.seconds / other->seconds <= most) continue;
          most = cell.seconds / other->seconds;
          winner = j;
        }
        behind = std::min(behind, most);
      }
      if (behind > kFarBehind) {
        leave(i, Course::Fate::kDropped,
              fmt::format("dropped after {} rounds: {:.0f} times slower than {}", round_, behind,
                          settings_[winner].name()));
      }
    }
  }

  const std::vector<Setting>& settings_;
  const std::vector<std::vector<Amount>>& ladders_;
  const SweepOptions& options_;
  const double seconds_;
  const double begin_;
  std::mt19937_64 shuffle_;
  std::uint32_t round_ = 0;
  /// The first run of each setting, and the digests of second looks by setting and amount.
  std::vector<std::optional<Run>> first_;
  std::map<std::pair<std::size_t, double>, std::uint64_t> second_;
  /// The seconds of each setting's amounts when they were measured first.
  std::vector<std::vector<double>> rungs_;
  SweepResult result_;
};

}  // namespace

absl::StatusOr<SweepResult> sweep(const std::vector<Setting>& settings,
                                  const std::vector<std::vector<Amount>>& ladders,
                                  const SweepOptions& options) {
  return Sweep(settings, ladders, options).run();
}

}  // namespace lucerna::tradeoff
