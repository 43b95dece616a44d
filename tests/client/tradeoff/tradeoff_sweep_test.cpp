// The choice of queries in a sweep, with an invented server whose answers advance the clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "client/tradeoff/analysis.h"
#include "client/tradeoff/sweep.h"

namespace lucerna::tradeoff {
namespace {

using ::testing::HasSubstr;

/// A setting with the error `error` / sqrt(samples), at `cost` seconds per sample and `call`
/// seconds per call.
struct Kind {
  double error, cost;
  std::uint64_t digest;
  absl::Status says = absl::OkStatus();
  /// From this many samples on, its bits differ from those of other settings.
  double own_from = 1e9;
  double call = 1e-3;
  double fewest = 0;  ///< the least number of samples that it answers
};

class TradeoffSweep : public ::testing::Test {
 protected:
  absl::StatusOr<SweepResult> run(const std::vector<Kind>& kinds, double seconds,
                                  std::uint32_t rounds = 0, std::uint32_t max_samples = 1 << 20) {
    settings_.clear();
    ladders_.clear();
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      settings_.push_back({.flags = i == 0 ? std::vector<std::string>{}
                                           : std::vector<std::string>{"--way", std::to_string(i)}});
      ladders_.push_back(amounts(settings_.back(), max_samples));
    }
    SweepOptions options{.seconds = seconds, .rounds = rounds, .seed = 1};
    options.clock = [this] { return now_; };
    options.answer = [&, this](std::size_t i, const Amount& amount, std::uint64_t seed,
                               std::uint32_t,
                               std::optional<double> longest_s) -> absl::StatusOr<tradeoff::Run> {
      if (!kinds[i].says.ok()) return kinds[i].says;
      if (amount.value < kinds[i].fewest) return absl::InvalidArgumentError("not so few");
      tradeoff::Run run{.seconds = kinds[i].call + kinds[i].cost * amount.value,
                        .samples = amount.value};
      if (longest_s && run.seconds > *longest_s) {
        now_ += *longest_s;
        return absl::DeadlineExceededError("no answer by then");
      }
      now_ += run.seconds;
      // Within 10%, depending on the seed.
      const double luck = 0.9 + 0.2 * static_cast<double>(seed % 1000) / 1000;
      run.errors.relative_mse = luck * kinds[i].error * kinds[i].error / amount.value;
      run.errors.rmse = std::sqrt(run.errors.relative_mse);
      run.digest = amount.value < kinds[i].own_from ? kinds[i].digest : 1000 + i;
      return run;
    };
    options.on_event = [this](const std::string& event) { events_ += event + "\n"; };
    return sweep(settings_, ladders_, options);
  }
  static std::map<std::pair<std::size_t, double>, int> counted(const SweepResult& result) {
    std::map<std::pair<std::size_t, double>, int> runs;
    for (const tradeoff::Run& run : result.runs)
      if (run.round > 0) ++runs[{run.setting, run.amount.value}];
    return runs;
  }

  double now_ = 100;
  std::vector<Setting> settings_;
  std::vector<std::vector<Amount>> ladders_;
  std::string events_;
};

TEST_F(TradeoffSweep, KeepsToItsTimeAndRepeatsEveryCell) {
  const auto result = run({{1, 1e-4, 1}, {1.2, 1e-4, 2}, {0.9, 2e-4, 3}}, 20);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(now_ - 100, 20.5);
  EXPECT_GT(now_ - 100, 15);
  for (const auto& [cell, runs] : counted(*result))
    EXPECT_GE(runs, static_cast<int>(kFewestRounds));
}

TEST_F(TradeoffSweep, SettingsShareTheSeedsOfARound) {
  const auto result = run({{1, 1e-4, 1}, {1.2, 1e-4, 2}, {0.9, 2e-4, 3}}, 20);
  ASSERT_TRUE(result.ok()) << result.status();
  std::map<std::pair<std::uint32_t, double>, std::uint64_t> seeds;
  for (const tradeoff::Run& run : result->runs) {
    if (run.round == 0) continue;
    EXPECT_EQ(seeds.emplace(std::pair(run.round, run.amount.value), run.seed).first->second,
              run.seed);
  }
  std::set<std::uint64_t> distinct;
  for (const auto& [cell, seed] : seeds)
    EXPECT_TRUE(distinct.insert(seed).second) << "the same seed again";
}

TEST_F(TradeoffSweep, RoundsMeasureEveryCellOnceInTheirOwnOrder) {
  const auto result = run({{1, 1e-4, 1}, {1.2, 1e-4, 2}}, 5);
  ASSERT_TRUE(result.ok()) << result.status();
  std::map<std::uint32_t, std::vector<std::pair<std::size_t, double>>> rounds;
  for (const tradeoff::Run& run : result->runs)
    if (run.round > 0) rounds[run.round].emplace_back(run.setting, run.amount.value);
  ASSERT_GE(rounds.size(), 2 * kFewestRounds);
  for (const auto& [round, cells] : rounds) {
    EXPECT_EQ(std::set(cells.begin(), cells.end()).size(), cells.size());
  }
  EXPECT_NE(rounds[1], rounds[2]);
  EXPECT_EQ(std::multiset(rounds[1].begin(), rounds[1].end()),
            std::multiset(rounds[2].begin(), rounds[2].end()));
}

TEST_F(TradeoffSweep, ReportsSettingsWithTheSameBitsAndThoseWithoutAnAnswer) {
  const auto result = run(
      {{1, 1e-4, 1}, {1, 1e-4, 1}, {1, 1e-4, 2, absl::UnimplementedError("not yet")}, {1, 1e-4, 4}},
      5);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSame);
  EXPECT_EQ(result->courses[1].same_as, 0);
  EXPECT_EQ(result->courses[2].fate, Course::Fate::kSkipped);
  EXPECT_THAT(result->courses[2].why, HasSubstr("not yet"));
  EXPECT_EQ(result->courses[3].fate, Course::Fate::kSwept);
  for (const auto& [cell, runs] : counted(*result)) EXPECT_TRUE(cell.first == 0 || cell.first == 3);
}

TEST_F(TradeoffSweep, EqualBitsOfFewSamplesDropNoSetting) {
  const auto result = run(
      {{1, 1e-4, 1}, {1, 1e-4, 1, absl::OkStatus(), 64}, {1, 1e-4, 1, absl::OkStatus(), 1024}}, 5);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSwept);
  EXPECT_EQ(result->courses[2].fate, Course::Fate::kSame);
  EXPECT_EQ(result->courses[2].same_as, 0);
  EXPECT_THAT(result->courses[2].why,
              HasSubstr("for 4 samples and, with another seed, for 64 sam"));
  // No query is sent twice.
  std::set<std::tuple<std::size_t, double, std::uint64_t>> queries;
  for (const tradeoff::Run& run : result->runs)
    EXPECT_TRUE(queries.emplace(run.setting, run.amount.value, run.seed).second);
}

TEST_F(TradeoffSweep, EqualBitsAreReportedForAffordableSampleCounts) {
  // A hundredth of the time is 50 ms.  64 samples take 0.26 s and 16 of them 65 ms.
  const auto result = run({{1, 4e-3, 1}, {1, 4e-3, 1, absl::OkStatus(), 16}}, 5);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSame);
  EXPECT_THAT(result->courses[1].why, HasSubstr("for 4 samples and, with another seed, for 4 sam"));
  const auto slow = run({{1, 2e-2, 1}, {1, 2e-2, 1}}, 5);
  ASSERT_TRUE(slow.ok()) << slow.status();
  EXPECT_THAT(slow->courses[1].why, HasSubstr("for 4 samples; a second look takes too long"));
}

TEST_F(TradeoffSweep, ALostConnectionEndsTheSweep) {
  const auto result = run({{1, 1e-4, 1}, {1, 1e-4, 2, absl::UnavailableError("gone")}}, 5);
  EXPECT_TRUE(absl::IsUnavailable(result.status())) << result.status();
}

TEST_F(TradeoffSweep, DropsSlowSettingsAndGivesTheOthersMoreTime) {
  // Thirty times the error takes nine hundred times the samples.
  const auto result =
      run({{1, 1e-4, 1}, {30, 1e-4, 2}, {30, 1e-4, 3}, {30, 1e-4, 4}, {1.3, 1e-4, 5}}, 20);
  ASSERT_TRUE(result.ok()) << result.status();
  for (const std::size_t i : {1, 2, 3}) {
    EXPECT_EQ(result->courses[i].fate, Course::Fate::kDropped);
    EXPECT_THAT(result->courses[i].why, HasSubstr("slower than automatic"));
  }
  EXPECT_EQ(result->courses[4].fate, Course::Fate::kSwept);
  std::map<std::size_t, double> largest;
  for (const auto& [cell, runs] : counted(*result))
    largest[cell.first] = std::max(largest[cell.first], cell.second);
  EXPECT_GT(largest[0], largest[1]);
}

TEST_F(TradeoffSweep, SimilarSettingsAreComparedAtTheSameAmounts) {
  // At any time budget, a cost that is a tenth higher per sample must not end an amount earlier.
  for (double seconds = 9; seconds < 40; seconds *= 1.05) {
    const auto result = run({{1, 1.1e-4, 1}, {1, 1e-4, 2}, {1, 1.05e-4, 3}}, seconds);
    ASSERT_TRUE(result.ok()) << result.status();
    std::map<std::size_t, double> largest;
    for (const auto& [cell, runs] : counted(*result))
      largest[cell.first] = std::max(largest[cell.first], cell.second);
    EXPECT_EQ(largest[0], largest[1]) << seconds << " s";
    EXPECT_EQ(largest[2], largest[1]) << seconds << " s";
    EXPECT_LT(now_ - 100, 1.1 * seconds);
    now_ = 100;
  }
}

TEST_F(TradeoffSweep, OneAmountIsEnoughToDropASetting) {
  // It takes half a second for what the first does in two milliseconds.  Four samples would take
  // too long.
  const auto result = run({{1, 1e-4, 1}, {1, 0.5, 2}, {0.02, 0.5, 3}}, 20);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kDropped);
  EXPECT_THAT(result->courses[1].why, HasSubstr("slower than automatic"));
  EXPECT_EQ(result->courses[2].fate, Course::Fate::kSwept)
      << "the first setting takes 0.25 s for an error of 2%";
}

TEST_F(TradeoffSweep, TooLittleTimeIsReportedWithTheNeededTime) {
  const auto result = run({{1, 0.5, 1}, {1, 0.5, 2}, {1, 0.5, 3}}, 2);
  EXPECT_TRUE(absl::IsDeadlineExceeded(result.status())) << result.status();
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("at least 3 rounds"));
}

TEST_F(TradeoffSweep, SlowAnswersAreNotWaitedFor) {
  const auto result = run({{1, 1e-4, 1}, {1, 50, 2}, {1, 0.4, 3}}, 40);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSkipped);
  EXPECT_THAT(result->courses[1].why, HasSubstr("no answer to 4 samples within 4.8 s"));
  EXPECT_NE(result->courses[2].fate, Course::Fate::kSkipped) << "one sample does not take too long";
  EXPECT_LT(now_ - 100, 41);
}

TEST_F(TradeoffSweep, ManySlowSettingsLeaveTimeForTheOthers) {
  std::vector<Kind> kinds = {{1, 1e-4, 1}};
  for (std::uint64_t i = 0; i < 9; ++i) kinds.push_back({1, 50, 2 + i});
  kinds.push_back({0.9, 1e-4, 20});
  const auto result = run(kinds, 40);
  ASSERT_TRUE(result.ok()) << result.status();
  for (std::size_t i = 1; i < 10; ++i) EXPECT_EQ(result->courses[i].fate, Course::Fate::kSkipped);
  EXPECT_EQ(result->courses[10].fate, Course::Fate::kSwept) << result->courses[10].why;
  EXPECT_LT(now_ - 100, 41);
}

TEST_F(TradeoffSweep, AnErrorAtTheLeastAmountIsNotReportedAsSlow) {
  std::vector<Kind> kinds = {{1, 1e-4, 1}, {1, 1e-4, 2}};
  kinds[1].fewest = 4;
  const auto result = run(kinds, 10);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSkipped);
  EXPECT_THAT(result->courses[1].why, HasSubstr("skipped: not so few"));
}

TEST_F(TradeoffSweep, ComparingAtTheSameAmountsKeepsToTheTime) {
  // One setting that is nearly twice as fast reaches amounts for which twenty others have no time.
  for (double seconds = 20; seconds < 80; seconds *= 1.1) {
    std::vector<Kind> kinds = {{1, 1e-4, 1}};
    for (std::uint64_t i = 0; i < 20; ++i) kinds.push_back({1, 1.9e-4, 2 + i});
    now_ = 100;
    const auto result = run(kinds, seconds);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_LT(now_ - 100, 1.05 * seconds);
  }
}

TEST_F(TradeoffSweep, SettingsThatAreSlowAtTheLeastAmountAreSkipped) {
  // Four samples are expected to take four times as long as one.  Here both take 2 s.
  const auto result = run({{1, 1e-4, 1}, {1, 0, 2, absl::OkStatus(), 1e9, 2}}, 40);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSkipped);
  EXPECT_THAT(result->courses[1].why, HasSubstr("2 s for 1 sample: too long for this budget"));
}

TEST_F(TradeoffSweep, CountedRoundsMeasureEveryAmountHoweverLongItTakes) {
  // The second setting is ten thousand times slower.  A sweep with a time budget would drop it.
  const auto result =
      run({{1, 1e-4, 1}, {30, 1, 2}, {1, 0, 3, absl::UnimplementedError("no")}}, 1e-9, 5, 64);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->courses[0].fate, Course::Fate::kSwept);
  EXPECT_EQ(result->courses[1].fate, Course::Fate::kSwept);
  EXPECT_EQ(result->courses[2].fate, Course::Fate::kSkipped);
  std::map<std::pair<std::size_t, double>, int> expected;
  for (const std::size_t setting : {0, 1})
    for (const double samples : {1, 4, 16, 64}) expected[{setting, samples}] = 5;
  EXPECT_EQ(counted(*result), expected);
}

/// A reference without error, with as many values as these tests need.
Reference good_reference() {
  Reference reference;
  reference.values = {1};
  reference.standard_error = {0};
  reference.exact = true;
  return reference;
}

TEST_F(TradeoffSweep, AnalysisRecommendsTheFastestAndReportsAutomaticsRatio) {
  // The second has a quarter of the squared error, so it takes a quarter of the samples.
  const auto result = run({{1, 1e-4, 1}, {0.5, 1e-4, 2}}, 40);
  ASSERT_TRUE(result.ok()) << result.status();
  const Analysis a = analyse(settings_, *result, good_reference());
  // 10%: 100 samples or 25, and a call of 1 ms.
  const Recommendation& ten = a.levels[0];
  ASSERT_TRUE(ten.setting);
  EXPECT_EQ(*ten.setting, 1);
  EXPECT_EQ(ten.reached.how, Reached::How::kBetween);
  EXPECT_NEAR(ten.reached.samples, 25, 4);
  EXPECT_EQ(ten.amount.value, 32);
  EXPECT_NEAR(ten.automatic_ratio.value(), (1e-3 + 100e-4) / (1e-3 + 25e-4), 0.4);
  EXPECT_EQ(a.levels[2].reached.how, Reached::How::kExtrapolated);
  ASSERT_TRUE(a.curves[1].efficiency);
  // 1 / (0.25 / N x (1 ms + N 0.1 ms)).
  EXPECT_NEAR(a.curves[1].efficiency->mean, 40000, 6000);
  EXPECT_LT(a.curves[1].efficiency->lower, a.curves[1].efficiency->mean);
  EXPECT_TRUE(a.warnings.empty());
}

TEST_F(TradeoffSweep, AnalysisWarnsWhereTheReferenceIsTheLimit) {
  const auto result = run({{1, 1e-4, 1}, {0.5, 1e-4, 2}}, 40);
  ASSERT_TRUE(result.ok()) << result.status();
  Reference poor = good_reference();
  poor.exact = false;
  poor.relative_error = 0.05;
  const Analysis a = analyse(settings_, *result, poor);
  ASSERT_EQ(a.warnings.size(), 1);
  EXPECT_THAT(a.warnings[0], HasSubstr("not 3 times below"));
  EXPECT_EQ(a.levels[0].reached.how, Reached::How::kBetween);
  EXPECT_EQ(a.levels[1].reached.how, Reached::How::kExtrapolated);
}

TEST(TradeoffAnalysis, AmountsAreRoundedToPracticalOnes) {
  EXPECT_EQ(practical(false, 3.2).value, 4);
  EXPECT_EQ(practical(false, 16).value, 16);
  EXPECT_EQ(practical(false, 16.5).value, 32);
  EXPECT_NEAR(practical(true, 0.0478).value, 0.047, 1e-12);
  EXPECT_NEAR(practical(true, 0.01).value, 0.01, 1e-12);
}

}  // namespace
}  // namespace lucerna::tradeoff
