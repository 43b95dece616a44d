// Errors, settings and references, for an invented question.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "client/tradeoff/reference.h"

namespace lucerna::tradeoff {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(TradeoffErrors, FollowTheirDefinition) {
  // Mean 10, so the dark level is 0.1.
  const std::vector<double> reference = {20, 10, 0};
  const double dark = dark_level(reference);
  EXPECT_DOUBLE_EQ(dark, 0.1);
  const Errors e = measure(std::vector<double>{22, 9, 0.1}, reference, dark);
  EXPECT_DOUBLE_EQ(e.rmse, std::sqrt((4 + 1 + 0.01) / 3));
  EXPECT_DOUBLE_EQ(e.relative_mse, (4 / 400.01 + 1 / 100.01 + 1) / 3);
}

TEST(TradeoffErrors, ItemsWithoutAReferenceDoNotCount) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> reference = {nan, 10};
  EXPECT_DOUBLE_EQ(dark_level(reference), 0.1);
  EXPECT_DOUBLE_EQ(measure(std::vector<double>{5, 11}, reference, 0.1).rmse, 1);
  EXPECT_DOUBLE_EQ(measure(std::vector<double>{5, nan}, reference, 0.1).rmse, 10);
  EXPECT_EQ(dark_level(std::vector<double>{0, nan}), 1);
}

TEST(TradeoffErrors, ReplicatesHaveTheMeanAndItsStandardError) {
  Replicates r(2);
  for (const double x : {1.0, 2.0, 3.0, 6.0}) r.add(std::vector<double>{x, 1e9 + x});
  EXPECT_THAT(r.mean(), ElementsAre(3, 1e9 + 3));
  // Deviations -2, -1, 0, 3: 14 / (4 x 3).
  EXPECT_NEAR(r.standard_error()[0], std::sqrt(14.0 / 12), 1e-12);
  EXPECT_NEAR(r.standard_error()[1], std::sqrt(14.0 / 12), 1e-6);
}

TEST(TradeoffSettings, FollowTheirFlags) {
  const Setting s = make_setting({"--light-selection", "bvh", "--samples-per-light", "4"});
  EXPECT_EQ(s.name(), "light-selection bvh + samples-per-light 4");
  EXPECT_EQ(s.accuracy.light_selection(), v1::LIGHT_SELECTION_BVH);
  EXPECT_EQ(s.accuracy.samples_per_light(), 4);
  EXPECT_EQ(make_setting({}).name(), "automatic");
  EXPECT_EQ((Amount{.target = true, .value = 0.03}).flags(), "--error 3%");
  EXPECT_EQ((Amount{.target = false, .value = 1}).text(), "1 sample");
}

TEST(TradeoffSettings, HaveEveryChoiceAndNoneTwice) {
  for (const Query query :
       {Query::kIrradiance, Query::kRender, Query::kSample, Query::kVisibility}) {
    std::set<std::string> names;
    for (const Setting& s : settings(query, {.lights = 9}))
      EXPECT_TRUE(names.insert(s.name()).second) << s.name();
    EXPECT_TRUE(names.contains("automatic"));
    EXPECT_TRUE(names.contains("light-selection bvh"));
    EXPECT_TRUE(names.contains("sampler independent"));
    EXPECT_TRUE(names.contains("visibility shadow-maps"));
    EXPECT_TRUE(names.contains("thin-glass blocks"));
    // With one light there is no selection.
    for (const Setting& s : settings(query, {.lights = 1}))
      EXPECT_THAT(s.name(), ::testing::Not(HasSubstr("light-selection"))) << name(query);
  }
}

TEST(TradeoffSettings, AmountsArePowersOfFour) {
  std::vector<double> values;
  for (const Amount& a : amounts(make_setting({}), 300)) values.push_back(a.value);
  EXPECT_THAT(values, ElementsAre(1, 4, 16, 64, 256));
}

/// A question with two ways to answer: normal errors of `spread` per sample about 5 and 10, at
/// `cost` seconds per sample.
class MadeUp : public Question {
 public:
  struct Way {
    double spread, cost;
  };
  MadeUp(std::vector<Way> ways, double* now) : Question({}), ways_(std::move(ways)), now_(now) {}

  Query query() const override { return Query::kIrradiance; }
  std::string quantity() const override { return "what there is"; }
  const Layout& layout() const override { return layout_; }
  std::vector<Setting> settings() const override { return {}; }
  std::vector<Amount> amounts_of(const Setting&) const override { return {}; }
  absl::StatusOr<Answer> answer(const Setting&, const Amount&, std::uint64_t) const override {
    return absl::InternalError("never called");
  }
  std::vector<ReferenceWay> reference_ways() const override {
    return {{"first"}, {.words = "second", .checked = checked}};
  }
  absl::StatusOr<Answer> answer_reference(std::size_t way, std::uint32_t samples,
                                          std::uint64_t seed) const override {
    EXPECT_TRUE(seeds_.insert(seed).second) << "the same seed again";
    std::mt19937_64 bits(seed);
    std::normal_distribution<double> normal(0, ways_[way].spread / std::sqrt(samples));
    const double off = way == 1 ? bias : 0;
    Answer answer{.values = {5 + normal(bits), 10 + off + normal(bits)},
                  .seconds = ways_[way].cost * samples};
    *now_ += answer.seconds;
    return answer;
  }
  std::string command(const Setting&, const Amount&) const override { return {}; }
  absl::StatusOr<std::optional<std::vector<double>>> closed_form(std::uint64_t) const override {
    return closed;
  }

  std::optional<std::vector<double>> closed;
  /// Properties of the second way.
  bool checked = false;
  double bias = 0;

 private:
  std::vector<Way> ways_;
  double* now_;
  Layout layout_;
  mutable std::set<std::uint64_t> seeds_;
};

TEST(TradeoffReference, UsesTheBetterWayWithinItsTimeAndStatesItsError) {
  double now = 7;
  const MadeUp question({{3, 1e-3}, {0.3, 1e-3}}, &now);
  const auto r = make_reference(question, 10, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_EQ(r->way, "second");
  EXPECT_LE(now, 17);
  EXPECT_GT(now, 15);
  EXPECT_GE(r->replicates, 10U);
  // The tolerance is a third of the standard error.  The scatter of dozens of replicates is more
  // accurate than that.
  const double samples = double(r->replicates) * r->samples_each;
  EXPECT_NEAR(r->rmse, 0.3 / std::sqrt(samples), 0.1 / std::sqrt(samples));
  // Five standard errors.
  EXPECT_NEAR(r->values[0], 5, 1.5 / std::sqrt(samples));
  EXPECT_NEAR(r->values[1], 10, 1.5 / std::sqrt(samples));
  EXPECT_FALSE(r->exact);
}

TEST(TradeoffReference, IsTheClosedFormIfSamplesAgree) {
  double now = 0;
  MadeUp question({{3, 1e-3}, {0.3, 1e-3}}, &now);
  question.closed = {5, 10};
  const auto r = make_reference(question, 10, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_TRUE(r->exact);
  EXPECT_THAT(r->values, ElementsAre(5, 10));
  EXPECT_THAT(r->standard_error, ElementsAre(0, 0));
  EXPECT_EQ(r->relative_error, 0);
  EXPECT_EQ(r->rmse, 0);
  EXPECT_EQ(r->warning, "");
  EXPECT_THAT(r->way, HasSubstr("closed forms"));
  EXPECT_THAT(r->way, HasSubstr("(second)"));
}

TEST(TradeoffReference, RejectsAClosedFormThatSamplesContradict) {
  double now = 0;
  MadeUp question({{3, 1e-3}, {0.3, 1e-3}}, &now);
  // This is 30 standard errors of 0.3 / sqrt(about 8000 samples) = 0.0033.
  question.closed = {5, 10.1};
  const auto r = make_reference(question, 10, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_FALSE(r->exact);
  EXPECT_EQ(r->way, "second");
  EXPECT_GT(r->relative_error, 0);
  EXPECT_THAT(r->warning, HasSubstr("item 2 is 10.1, and "));
}

TEST(TradeoffReference, AWayThatNeedsACheckIsComparedWithAnother) {
  double now = 0;
  MadeUp question({{3, 1e-3}, {0.3, 1e-3}}, &now);
  question.checked = true;
  const auto r = make_reference(question, 10, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_THAT(r->way, ::testing::StartsWith("second; "));
  EXPECT_THAT(r->way, HasSubstr("by another (first) differ from it by"));
  EXPECT_EQ(r->warning, "");
  EXPECT_LE(now, 10);
  // At most 3 s of the 10 s went to the first way.
  EXPECT_LT(r->rmse, 0.3 / std::sqrt(5000));
}

TEST(TradeoffReference, AWayThatDiffersFromItsCheckIsRejected) {
  double now = 0;
  MadeUp question({{3, 1e-3}, {0.3, 1e-3}}, &now);
  question.checked = true;
  // The bias is 5% in the mean of the two values.  The first way's standard error is 3 / sqrt(about
  // 2500 samples) = 0.06 for each value, about 0.7% of the mean.
  question.bias = 1;
  const auto r = make_reference(question, 10, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_EQ(r->way, "first");
  EXPECT_THAT(r->warning, HasSubstr("(second) was rejected"));
  EXPECT_NEAR(r->values[1], 10, 0.3);
  EXPECT_GE(r->replicates, kFewestReplicates);
  // Without a check it is accepted.
  question.checked = false;
  const auto unchecked = make_reference(question, 10, 2, [&] { return now; });
  ASSERT_TRUE(unchecked.ok()) << unchecked.status();
  EXPECT_EQ(unchecked->way, "second");
}

TEST(TradeoffReference, WithoutTimeForBothTheWayWithoutACheckIsUsed) {
  double now = 0;
  MadeUp question({{3, 1}, {0.3, 1}}, &now);
  question.checked = true;
  const auto r = make_reference(question, 9, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_EQ(r->way, "first");
  EXPECT_LE(now, 9);
  const auto longer = make_reference(question, 40, 2, [&] { return now; });
  ASSERT_TRUE(longer.ok()) << longer.status();
  EXPECT_THAT(longer->way, ::testing::StartsWith("second; "));
}

TEST(TradeoffReference, TheCheckTakesNoTimeThatTheBestWayNeeds) {
  double now = 0;
  MadeUp question({{3, 0.05}, {0.01, 1.4}}, &now);
  question.checked = true;
  const auto r = make_reference(question, 10, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_THAT(r->way, ::testing::StartsWith("second; "));
  EXPECT_LE(now, 10);
}

TEST(TradeoffReference, ARejectedWayAndARejectedClosedFormAreBothReported) {
  for (const bool right : {false, true}) {
    double now = 0;
    MadeUp question({{3, 1e-3}, {0.3, 1e-3}}, &now);
    question.checked = true;
    question.bias = 1;
    question.closed = {5, right ? 10.0 : 12.0};
    const auto r = make_reference(question, 10, 1, [&] { return now; });
    ASSERT_TRUE(r.ok()) << r.status();
    EXPECT_EQ(r->exact, right);
    EXPECT_THAT(r->warning, HasSubstr("(second) was rejected"));
    EXPECT_EQ(r->warning.find("item 2 is 12, and ") != std::string::npos, !right);
  }
}

TEST(TradeoffReference, WaysWithoutScatterMustAgreeToRounding) {
  double now = 0;
  MadeUp question({{1e-9, 1e-3}, {0, 1e-3}}, &now);
  question.checked = true;
  for (const double bias : {1e-6, 1e-3}) {
    question.bias = bias;
    const auto r = make_reference(question, 10, mixed_seed(7, static_cast<std::uint64_t>(1 / bias)),
                                  [&] { return now; });
    ASSERT_TRUE(r.ok()) << r.status();
    EXPECT_EQ(r->warning.empty(), bias < 1e-5) << r->warning;
  }
}

TEST(TradeoffReference, CountedAnswersDoNotDependOnTheirTime) {
  std::vector<std::vector<double>> values;
  for (const double cost : {1e-6, 1e3}) {
    double now = 0;
    const MadeUp question({{3, cost}, {0.3, cost}}, &now);
    const auto r = make_counted_reference(question, 7, 64, 1, [&] { return now; });
    ASSERT_TRUE(r.ok()) << r.status();
    EXPECT_EQ(r->replicates, 7U);
    EXPECT_EQ(r->samples_each, 64U);
    EXPECT_EQ(r->way, "first");
    EXPECT_NEAR(r->seconds, 7 * 64 * cost, 1e-9 * r->seconds);
    values.push_back(r->values);
  }
  EXPECT_EQ(values[0], values[1]);
}

TEST(TradeoffReference, ManyLightsAreAlsoChosenByTheTree) {
  for (const std::uint64_t lights : {1, 2, 20, 21, 3000}) {
    const std::vector<ReferenceWay> ways = reference_ways_for(lights);
    bool tree = false;
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const bool by_tree =
          reference_accuracy(i, lights).light_selection() == v1::LIGHT_SELECTION_BVH;
      EXPECT_EQ(ways[i].checked, by_tree);
      EXPECT_EQ(ways[i].words.find("light BVH") != std::string::npos, by_tree);
      tree = tree || by_tree;
    }
    EXPECT_EQ(tree, lights > 20);
  }
}

TEST(TradeoffReference, StopsWhenItIsAccurateEnough) {
  double now = 0;
  const MadeUp question({{1e-5, 1e-3}, {1e-5, 1e-3}}, &now);
  const auto r = make_reference(question, 100, 1, [&] { return now; });
  ASSERT_TRUE(r.ok()) << r.status();
  EXPECT_EQ(r->replicates, kFewestReplicates);
  EXPECT_LT(r->relative_error, kGoodReference);
}

TEST(TradeoffReference, TooLittleTimeIsReportedWithItsBudget) {
  for (const double seconds : {0.01, 3.0}) {
    double now = 0;
    const MadeUp question({{1, 1}, {1, 1}}, &now);
    const auto r = make_reference(question, seconds, 1, [&] { return now; });
    EXPECT_TRUE(absl::IsDeadlineExceeded(r.status())) << r.status();
    EXPECT_THAT(std::string(r.status().message()),
                HasSubstr(fmt::format("gets only {} s", seconds)));
  }
}

}  // namespace
}  // namespace lucerna::tradeoff
