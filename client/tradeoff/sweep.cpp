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

#include "client/tradeoff/statistics.h"

namespace lucerna::tradeoff {
namespace {

// The first heat's share of the time, and the most of the whole that a single question may take.
// (Target errors begin with pilots, and tell of questions that are larger anyway.)
constexpr double kFirstHeat = 0.4, kLongestQuestion = 0.03, kLongestTarget = 0.1;
// An amount's next takes up to four times as long, next target errors ten times.
constexpr double kGrowth = 4, kTargetGrowth = 10;
constexpr std::uint32_t kMostRounds = 40;
// Target errors take no less.
constexpr double kPilotSamples = 64;
// Few samples of few items may be the same by chance: settings that seem to be one are asked again
// with so many, or as many powers of four fewer as keep a question within this share of the time.
constexpr double kSecondLookSamples = 64, kSecondLook = 0.01;
// What all settings together may wait for answers that do not come, of which one takes at most half
// of what is left; and what each may wait anyway.
constexpr double kWaiting = 0.3, kLeastWaiting = 0.01;

bool says_no(const absl::Status& status) {
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
        begin_(options.clock()),
        shuffle_(mixed_seed(options.seed, 1)) {
    result_.courses.resize(settings.size());
    first_.resize(settings.size());
    rungs_.resize(settings.size());
  }

  absl::StatusOr<SweepResult> run() {
    if (const absl::Status s = tell_apart(); !s.ok()) return s;
    if (const absl::Status s = heat(begin_ + kFirstHeat * options_.seconds, "first"); !s.ok())
      return s;
    drop_far_behind();
    if (const absl::Status s = heat(begin_ + options_.seconds, "second"); !s.ok()) return s;
    if (round_ == 0) {
      return absl::DeadlineExceededError(
          fmt::format("what {} settings cost is all that could be found out in {:.2g} s",
                      settings_.size(), options_.seconds));
    }
    return std::move(result_);
  }

 private:
  bool races(std::size_t i) const { return result_.courses[i].fate == Course::Fate::kSwept; }
  void leave(std::size_t i, Course::Fate fate, const std::string& why) {
    result_.courses[i].fate = fate;
    result_.courses[i].why = why;
    options_.on_event(fmt::format("{}: {}", settings_[i].name(), why));
  }

  void leave_for(std::size_t i, const absl::Status& no) {
    leave(i, Course::Fate::kSkipped, fmt::format("skipped: {}", std::string(no.message())));
  }
  double longest_of(std::size_t i) const {
    return options_.seconds * (settings_[i].by_target ? kLongestTarget : kLongestQuestion);
  }

  absl::StatusOr<Run> ask(std::size_t i, const Amount& amount, std::uint64_t seed,
                          std::uint32_t round, std::optional<double> longest_s = std::nullopt) {
    auto run = options_.ask(i, amount, seed, round, longest_s);
    if (!run.ok()) return run.status();
    run->setting = i;
    run->amount = amount;
    run->seed = seed;
    run->round = round;
    result_.runs.push_back(*run);
    return run;
  }
  /// Of an amount in the present round, for every setting.
  std::uint64_t seed_of(const Amount& amount) const {
    const std::uint64_t round = mixed_seed(options_.seed, 2 + round_);
    return mixed_seed(round, std::bit_cast<std::uint64_t>(amount.value));
  }

  struct SecondLook {
    bool same = true;
    std::optional<Amount> of;  ///< not affordable where there is none
  };

  /// Whether answers of i are those of j to a question of another seed and, where affordable, of
  /// more samples.
  absl::StatusOr<SecondLook> look_again(std::size_t i, std::size_t j) {
    const Run &a = *first_[i], &b = *first_[j];
    const double most = std::min(kSecondLookSamples, ladders_[i].back().value);
    const double each = std::max(a.seconds, b.seconds) / a.amount.value;
    const double longest = kSecondLook * options_.seconds;
    Amount amount = a.amount;
    if (amount.value * each > longest) return SecondLook{};
    while (4 * amount.value <= most && 4 * amount.value * each <= longest) amount.value *= 4;
    const std::uint64_t seed = mixed_seed(mixed_seed(options_.seed, 0), 1);
    const auto digest = [&](std::size_t k) -> absl::StatusOr<std::uint64_t> {
      const auto known = second_.find({k, amount.value});
      if (known != second_.end()) return known->second;
      const auto run = ask(k, amount, seed, 0);
      if (!run.ok()) return run.status();
      return second_[{k, amount.value}] = run->digest;
    };
    const auto x = digest(i), y = digest(j);
    for (const auto& one : {x, y}) {
      if (!one.ok() && !says_no(one.status())) return one.status();
    }
    return SecondLook{.same = x.ok() && y.ok() && *x == *y, .of = amount};
  }

  /// Leaves where its answers are those of a setting before it.
  absl::Status leave_if_same(std::size_t i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (settings_[j].by_target || !first_[j] || first_[j]->digest != first_[i]->digest) continue;
      if (result_.courses[j].fate == Course::Fate::kSame) continue;  // as is what it is the same as
      const auto again = look_again(i, j);
      if (!again.ok()) return again.status();
      if (!again->same) continue;
      result_.courses[i].same_as = j;
      const std::string of =
          !again->of ? fmt::format("of {}; to look again takes too long for this budget",
                                   first_[i]->amount.text())
          : ladders_[i].size() == 1 ? "to both of two questions"
                                    : fmt::format("of {} and, with another seed, of {}",
                                                  first_[i]->amount.text(), again->of->text());
      leave(i, Course::Fate::kSame, fmt::format("same bits as {}, {}", settings_[j].name(), of));
      break;
    }
    return absl::OkStatus();
  }

  /// Every setting the same question, of the same seed: who says no, and who are the same.
  absl::Status tell_apart() {
    double round = 0, waited = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      const Amount telling = settings_[i].by_target || ladders_[i].size() == 1
                                 ? ladders_[i][0]
                                 : Amount{.target = false, .value = options_.telling_samples};
      const double longest = longest_of(i);
      if (settings_[i].by_target && i > 0) {
        const Run& automatic = result_.runs[0];
        const double pilot = automatic.seconds * kPilotSamples / automatic.amount.value;
        if (pilot > longest) {
          leave(i, Course::Fate::kSkipped,
                fmt::format("skipped, it begins with {} samples, which take about {:.2g} s, too "
                            "long for this budget",
                            kPilotSamples, pilot));
          continue;
        }
      }
      // What the least amount takes is all that must not take too long.  Automatic may: all others
      // are compared with it.
      const double least_share = settings_[i].by_target ? 1 : ladders_[i][0].value / telling.value;
      const double patience =
          std::max(kLeastWaiting * options_.seconds, (kWaiting * options_.seconds - waited) / 2);
      const auto limit =
          i > 0 ? std::optional(std::min(longest / least_share, patience)) : std::nullopt;
      const auto run = ask(i, telling, mixed_seed(options_.seed, 0), 0, limit);
      if (limit && absl::IsDeadlineExceeded(run.status())) {
        waited += *limit;
        leave(i, Course::Fate::kSkipped,
              fmt::format("skipped, no answer to {} within {:.2g} s: too long for this budget",
                          telling.text(), *limit));
        continue;
      }
      if (!run.ok()) {
        if (!says_no(run.status()) || i == 0) return run.status();
        leave_for(i, run.status());
        continue;
      }
      first_[i] = *run;
      if (!settings_[i].by_target) {
        if (const absl::Status s = leave_if_same(i); !s.ok()) return s;
        if (!races(i)) continue;
      }
      round += run->seconds * least_share;
      if (options_.clock() - begin_ + kFewestRounds * round > options_.seconds) {
        return absl::DeadlineExceededError(
            fmt::format("{} of {} settings alone take {:.2g} s a round, of {} rounds at least, and "
                        "{:.2g} s are left for them",
                        i + 1, settings_.size(), round, kFewestRounds, options_.seconds));
      }
    }
    return absl::OkStatus();
  }

  double growth(std::size_t i) const { return settings_[i].by_target ? kTargetGrowth : kGrowth; }

  /// Climbs each setting's ladder as far as a question may last, and the amounts that others come
  /// to where they last at most twice as long and there is time for all: what is compared is
  /// compared at the same amounts.  These runs do not count.
  absl::Status climb(double longest, double end) {
    std::size_t highest = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      if (const absl::Status s = climb(i, longest, ladders_[i].size()); !s.ok()) return s;
      if (!settings_[i].by_target) highest = std::max(highest, rungs_[i].size());
    }
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      if (settings_[i].by_target) continue;
      const std::size_t most = std::min(highest, ladders_[i].size());
      const double spare = end - options_.clock() - kFewestRounds * round_takes();
      const double longer = std::min(2 * longest, spare / (1 + kFewestRounds));
      if (const absl::Status s = climb(i, longer, most); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status climb(std::size_t i, double longest, std::size_t most) {
    std::vector<double>& seconds = rungs_[i];
    while (races(i) && seconds.size() < most) {
      if (!seconds.empty() && seconds.back() * growth(i) > longest) break;
      const Amount& amount = ladders_[i][seconds.size()];
      const auto run = ask(i, amount, seed_of(amount), 0);
      if (!run.ok()) {
        if (!says_no(run.status()) || (seconds.empty() && i == 0)) return run.status();
        if (seconds.empty()) leave_for(i, run.status());
        break;
      }
      // A question that asks for less may cost as much.
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

  /// Of all that races, as predicted.
  double round_takes() const {
    double sum = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i)
      if (races(i)) sum += std::accumulate(rungs_[i].begin(), rungs_[i].end(), 0.0);
    return sum;
  }

  absl::Status heat(double end, const char* which) {
    const double left = end - options_.clock();
    double share = 0;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      // A ladder costs its longest question and, below it, the sum of a geometric series; once to
      // climb and once a round; where time is left there are more rounds.
      if (races(i)) share += growth(i) / (growth(i) - 1);
    }
    if (const absl::Status s = climb(left / (share * (1 + kFewestRounds)), end); !s.ok()) return s;
    for (std::uint32_t n = 0; n < kMostRounds; ++n) {
      std::vector<std::pair<std::size_t, std::size_t>> cells;
      for (std::size_t i = 0; i < settings_.size(); ++i) {
        if (!races(i)) continue;
        for (std::size_t k = 0; k < rungs_[i].size(); ++k) cells.emplace_back(i, k);
      }
      const double now = options_.clock();
      if (n >= kFewestRounds && now + round_takes() > end) break;
      // The promised rounds are finished even where prediction was wrong, but not at any price.
      if (now > end + 0.25 * options_.seconds) break;
      ++round_;
      std::shuffle(cells.begin(), cells.end(), shuffle_);
      for (const auto& [i, k] : cells) {
        const Amount& amount = ladders_[i][k];
        const auto run = ask(i, amount, seed_of(amount), round_);
        if (!run.ok()) return run.status();
      }
    }
    options_.on_event(fmt::format("{} heat: {} rounds so far", which, round_));
    return absl::OkStatus();
  }

  /// With the mean errors, or those at the lower ends of their intervals.
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
      if (!races(i)) continue;
      // What is dropped has the benefit of the doubt.
      const std::vector<Measured> own = curve(i, true);
      if (own.empty()) continue;
      // At either of its two largest amounts, where it has two, it may be near.
      double behind = std::numeric_limits<double>::infinity();
      std::size_t winner = 0;
      for (const Measured& cell : std::span(own).last(std::min<std::size_t>(2, own.size()))) {
        double most = 0;
        for (std::size_t j = 0; j < settings_.size(); ++j) {
          if (j == i || !races(j) || cell.error <= 0) continue;
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
  const double begin_;
  std::mt19937_64 shuffle_;
  std::uint32_t round_ = 0;
  /// By which settings are told apart: of each the first run, and digests of those of more samples.
  std::vector<std::optional<Run>> first_;
  std::map<std::pair<std::size_t, double>, std::uint64_t> second_;
  /// Of each setting, what its amounts took when they were tried first.
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
