// Analyses of invented runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/terminal/luminance.h"
#include "client/tradeoff/record.h"

namespace lucerna::tradeoff {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Adds five runs of one amount, spread by the share `scatter` about their middle.
void add_runs(SweepResult& to, std::size_t setting, const Amount& amount, double seconds,
              double error, double scatter = 0.01) {
  for (int i = -2; i <= 2; ++i) {
    Run run{.setting = setting, .amount = amount, .round = 1};
    run.seconds = seconds * (1 + scatter * i / 2);
    run.errors.relative_mse = error * error * (1 + scatter * i);
    run.errors.rmse = std::sqrt(run.errors.relative_mse);
    to.runs.push_back(run);
  }
}

void add_runs(SweepResult& to, std::size_t setting, double samples, double seconds, double error,
              double scatter = 0.01) {
  add_runs(to, setting, Amount{.target = false, .value = samples}, seconds, error, scatter);
}

std::vector<Setting> made_settings(std::size_t count) {
  std::vector<Setting> result(count);
  for (std::size_t i = 1; i < count; ++i) result[i].flags = {"--way", std::to_string(i)};
  return result;
}

Reference known() {
  Reference reference;
  reference.values = {1};
  reference.standard_error = {0};
  reference.exact = true;
  reference.way = "a formula";
  return reference;
}

TEST(TradeoffAnalysis, ComparesItemsOnlyOfSettingsWithSimilarTime) {
  SweepResult sweep;
  for (const double samples : {1, 4, 16}) add_runs(sweep, 0, samples, 1e-3 * samples, 0.1);
  add_runs(sweep, 1, 1, 1.5e-3, 0.1);
  add_runs(sweep, 2, 1, 3.1e-3, 0.1);
  add_runs(sweep, 3, 1, 0.7e-3, 0.1);
  add_runs(sweep, 3, 4, 2.8e-3, 0.1);
  const Analysis a = analyse(made_settings(4), sweep, known());
  EXPECT_DOUBLE_EQ(a.comparison_s, 1.5e-3);
  EXPECT_EQ(a.compared[0], 0U);
  EXPECT_EQ(a.compared[1], 0U);
  EXPECT_EQ(a.compared[2], std::nullopt) << "3.1 ms is more than twice 1.5 ms";
  EXPECT_EQ(a.compared[3], 1U) << "2.8 ms is within, 0.7 ms is not";
}

/// Automatic is measured down to 2% in 100 ms, which extrapolates to 400 ms for 1%.  The other
/// setting reaches 1% in `seconds`.
Recommendation one_percent(double seconds) {
  SweepResult sweep;
  add_runs(sweep, 0, 1, 0.025, 0.04, 0);
  add_runs(sweep, 0, 4, 0.1, 0.02, 0);
  add_runs(sweep, 1, 1, seconds / 4, 0.02, 0);
  add_runs(sweep, 1, 4, seconds, 0.01, 0);
  return analyse(made_settings(2), sweep, known()).levels[1];
}

TEST(TradeoffAnalysis, ExtrapolatedTimesCountTwice) {
  const Recommendation slow = one_percent(0.9), fast = one_percent(0.7);
  EXPECT_EQ(slow.setting, 0U);
  EXPECT_EQ(slow.best, 0U);
  EXPECT_EQ(slow.reached.how, Reached::How::kExtrapolated);
  EXPECT_NEAR(slow.reached.seconds, 0.4, 1e-9) << "reported without the factor";
  EXPECT_EQ(fast.setting, 1U);
  EXPECT_NEAR(fast.automatic_ratio.value(), 0.4 / 0.7, 1e-9);
  EXPECT_TRUE(fast.automatic_extrapolated);
}

TEST(TradeoffAnalysis, TargetErrorsAreExtrapolatedFromErrorsAlone) {
  // Half of the target error took hardly more time, by chance.
  SweepResult sweep;
  add_runs(sweep, 0, Amount{.target = true, .value = 0.2}, 1, 0.08, 0);
  add_runs(sweep, 0, Amount{.target = true, .value = 0.1}, 1 + 1e-9, 0.04, 0);
  std::vector<Setting> settings = made_settings(1);
  settings[0].by_target = true;
  const Recommendation r = analyse(settings, sweep, known()).levels[1];
  EXPECT_EQ(r.error, 0.01);
  EXPECT_EQ(r.reached.how, Reached::How::kExtrapolated);
  EXPECT_NEAR(r.reached.samples, 0.025, 1e-9);
  EXPECT_EQ(r.amount.flags(), "--error 2.5%");
}

/// A setting that takes nine tenths of automatic's time, with runs that scatter.
Recommendation ten_percent(double scatter) {
  SweepResult sweep;
  for (const double samples : {1, 4, 16}) {
    add_runs(sweep, 0, samples, 1e-3 * samples, 0.2 / std::sqrt(samples), scatter);
    add_runs(sweep, 1, samples, 0.9e-3 * samples, 0.2 / std::sqrt(samples), scatter);
  }
  return analyse(made_settings(2), sweep, known()).levels[0];
}

TEST(TradeoffAnalysis, AutomaticIsRecommendedIfTheBestIsNotSignificantlyFaster) {
  const Recommendation close = ten_percent(0.2), apart = ten_percent(0.001);
  EXPECT_EQ(close.setting, 0U);
  EXPECT_EQ(close.best, 1U);
  EXPECT_NEAR(close.best_reached.seconds, 3.6e-3, 1e-5);
  EXPECT_NEAR(close.automatic_ratio.value(), 1 / 0.9, 1e-3);
  EXPECT_EQ(apart.setting, 1U);
  EXPECT_EQ(apart.best, 1U);
}

TEST(TradeoffAnalysis, ExactSettingsAreRecognised) {
  SweepResult sweep;
  // Errors by rounding.
  for (const double samples : {1, 4, 16}) add_runs(sweep, 0, samples, 4e-4, 1e-8 * samples);
  for (const double samples : {1, 4, 16})
    add_runs(sweep, 1, samples, 1e-3 * samples, 0.2 / std::sqrt(samples));
  const Analysis a = analyse(made_settings(2), sweep, known());
  EXPECT_TRUE(a.curves[0].exact());
  EXPECT_EQ(a.curves[0].cells[1].error.mean, 0);
  EXPECT_FALSE(a.curves[1].exact());
  EXPECT_FALSE(a.curves[0].efficiency);
  EXPECT_TRUE(a.curves[1].efficiency);
  EXPECT_DOUBLE_EQ(a.comparison_s, 16e-3);
  EXPECT_EQ(a.compared[0], std::nullopt);
  for (const Recommendation& r : a.levels) {
    EXPECT_EQ(r.setting, 0U);
    EXPECT_TRUE(r.exact);
    EXPECT_EQ(r.amount.value, 4) << "a single sample does not show that the setting is exact";
  }
  // Samples with as small an error are not exact.
  add_runs(sweep, 1, 1e6, 1, 1e-7);
  EXPECT_FALSE(analyse(made_settings(2), sweep, known()).curves[1].exact());
  // If the reference has an error, a setting that agrees with it may be wrong too.
  Reference sampled = known();
  sampled.exact = false;
  sampled.relative_error = 1e-3;
  EXPECT_FALSE(analyse(made_settings(2), sweep, sampled).curves[0].exact());
}

// Squares of independent errors add.
TEST(TradeoffAnalysis, TheReferencesOwnErrorIsSubtracted) {
  Reference sampled = known();
  sampled.exact = false;
  sampled.relative_error = sampled.rmse = 0.03;
  SweepResult sweep;
  add_runs(sweep, 0, 1, 1e-3, 0.05, 0);
  add_runs(sweep, 0, 4, 4e-3, 0.03, 0);
  const Analysis a = analyse(made_settings(1), sweep, sampled);
  const std::vector<Cell>& cells = a.curves[0].cells;
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_NEAR(cells[0].error.mean, 0.04, 1e-12);
  EXPECT_NEAR(cells[0].rmse.mean, 0.04, 1e-12);
  EXPECT_LE(cells[1].error.mean, 0.03 / 2) << "the exact value is unknown";
  EXPECT_GT(cells[1].error.mean, 0);
  EXPECT_EQ(a.curves[0].efficient_at, 0U);
  EXPECT_FALSE(a.levels[0].below_reference);
  EXPECT_FALSE(a.levels[1].setting) << "a single known error gives no rate";
  EXPECT_TRUE(a.levels[1].below_reference);
  // An exact reference does not scatter, and its bound is no part of an error.
  sampled.exact = true;
  EXPECT_NEAR(analyse(made_settings(1), sweep, sampled).curves[0].cells[0].error.mean, 0.05, 1e-12);
}

TEST(TradeoffAnalysis, ErrorsBelowTheReferencesAreExtrapolated) {
  Reference sampled = known();
  sampled.exact = false;
  sampled.relative_error = sampled.rmse = 0.03;
  SweepResult sweep;
  const auto add = [&](double samples, double error) {
    add_runs(sweep, 0, samples, 1e-3 * samples, std::hypot(error, 0.03), 0);
  };
  add(1, 0.08);
  add(4, 0.04);
  add(16, 0.02);
  // Nothing measurable is left of this error.
  add(64, 0.0001);
  const Analysis a = analyse(made_settings(1), sweep, sampled);
  const Recommendation& one = a.levels[1];
  ASSERT_EQ(one.setting, 0U);
  EXPECT_EQ(one.reached.how, Reached::How::kExtrapolated);
  EXPECT_NEAR(one.reached.seconds, 64e-3, 1e-9);
  EXPECT_FALSE(one.below_reference);
}

TEST(TradeoffAnalysis, ApproximationsAreNotExtrapolated) {
  SweepResult sweep;
  std::vector<Setting> settings = {make_setting({}), make_setting({"--far-light", "5"}),
                                   make_setting({"--visibility", "shadow-maps"}),
                                   make_setting({"--visibility", "rays"}),
                                   make_setting({"--thin-glass", "blocks"})};
  for (std::size_t i = 0; i < settings.size(); ++i)
    for (const double samples : {1, 4, 16})
      add_runs(sweep, i, samples, 1e-3 * samples, 0.1 / std::sqrt(samples));
  const Analysis a = analyse(settings, sweep, known());
  for (const std::size_t i : {0, 1, 2, 3, 4}) {
    EXPECT_TRUE(a.curves[i].levels[0]) << "was measured";
    EXPECT_EQ(a.curves[i].levels[1].has_value(), i == 0 || i == 3) << i;
    EXPECT_EQ(a.curves[i].latest[1].has_value(), i == 0 || i == 3) << i;
  }
}

TEST(TradeoffAnalysis, ReportsWarningsOfTheReference) {
  SweepResult sweep;
  add_runs(sweep, 0, 1, 1e-3, 0.1);
  Reference reference = known();
  reference.warning = "mind the step";
  EXPECT_THAT(analyse(made_settings(1), sweep, reference).warnings,
              ::testing::ElementsAre("mind the step"));
}

/// A question without answers.  Its command is "ask" and the flags.
class Named : public Question {
 public:
  Named() : Question({}) {}
  Query query() const override { return Query::kIrradiance; }
  std::string quantity() const override { return "what there is"; }
  const Layout& layout() const override { return layout_; }
  std::vector<Setting> settings() const override { return {}; }
  std::vector<Amount> amounts_of(const Setting&) const override { return {}; }
  absl::StatusOr<Answer> answer(const Setting&, const Amount&, std::uint64_t) const override {
    return absl::InternalError("never called");
  }
  std::vector<ReferenceWay> reference_ways() const override { return {}; }
  absl::StatusOr<Answer> answer_reference(std::size_t, std::uint32_t,
                                          std::uint64_t) const override {
    return absl::InternalError("never called");
  }
  std::string command(const Setting& setting, const Amount& amount) const override {
    return "ask" + join_flags(setting, amount);
  }

 private:
  Layout layout_;
};

std::string words(const std::vector<Setting>& settings, const SweepResult& sweep) {
  const Named question;
  Record record;
  record.question = &question;
  record.settings = settings;
  record.reference = known();
  record.analysis = analyse(settings, sweep, record.reference);
  return to_text(record);
}

TEST(TradeoffWords, OfExactSettingsAreOneLine) {
  SweepResult sweep;
  add_runs(sweep, 0, 1, 4e-4, 0);
  add_runs(sweep, 1, 1, 1e-3, 0.2);
  const std::string text = words(made_settings(2), sweep);
  EXPECT_THAT(text, HasSubstr("Its own error: 0, except rounding."));
  EXPECT_THAT(text, HasSubstr("any error: automatic, 0.0004 s, exact\n  ask --samples 1\n"));
  EXPECT_THAT(text, Not(HasSubstr("1%")));
  // A faster setting is recommended for the errors that it reaches.
  add_runs(sweep, 1, 4, 2e-4, 0.05);
  const std::string more = words(made_settings(2), sweep);
  EXPECT_THAT(more, HasSubstr("10%: way 1, 0.0002 s"));
  EXPECT_THAT(more, HasSubstr("1%: automatic, 0.0004 s, exact\n  ask --samples 1\n"));
}

TEST(TradeoffWords, StateThatTheBestIsNotSignificantlyFaster) {
  SweepResult sweep;
  for (const double samples : {1, 4}) {
    add_runs(sweep, 0, samples, 1e-3 * samples, 0.1 / std::sqrt(samples), 0.2);
    add_runs(sweep, 1, samples, 0.9e-3 * samples, 0.1 / std::sqrt(samples), 0.2);
  }
  EXPECT_THAT(words(made_settings(2), sweep),
              HasSubstr("; not significantly slower than the fastest, way 1, 0.0009 s"));
}

TEST(TradeoffCommands, AreQuotedForAShell) {
  EXPECT_EQ(shell_word("room/scene-1.pbrt"), "room/scene-1.pbrt");
  EXPECT_EQ(shell_word("my room.pbrt"), "'my room.pbrt'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(command_line({.scene = "a b.pbrt"}, "power", " --method sampled"),
            "lucerna power 'a b.pbrt' --method sampled");
  EXPECT_EQ(command_line({.scene = "a.pbrt", .server = "far:50052"}, "power", ""),
            "lucerna power a.pbrt --server far:50052");
}

TEST(Luminance, IsThatOfTheServer) {
  // Rec. 709 primaries (0.64, 0.33), (0.30, 0.60), (0.15, 0.06) and the white (0.3127, 0.3290).
  // Cramer's rule for x, y and z of their sum gives the luminances of the primaries.
  const double red = 0.2126390058715104, green = 0.7151686787677559;
  const float colours[] = {1, 0, 0, 0, 1, 0, 1, 1, 1};
  EXPECT_DOUBLE_EQ(cli::luminance(colours), red);
  EXPECT_DOUBLE_EQ(cli::luminance(colours + 3), green);
  EXPECT_NEAR(cli::luminance(colours + 6), 1, 1e-15);
  const double blue = 1 - red - green;
  const auto sum = [&](double r, double g, double b) {
    return red * r / 0.33 + green * g / 0.60 + blue * b / 0.06;
  };
  EXPECT_NEAR(sum(0.64, 0.30, 0.15), 0.3127 / 0.3290, 1e-12);
  EXPECT_NEAR(sum(0.03, 0.10, 0.79), (1 - 0.3127 - 0.3290) / 0.3290, 1e-12);
}

}  // namespace
}  // namespace lucerna::tradeoff
