// A line of docs/extremes.md: the result of a sweep over extreme inputs.  A test creates one, fills
// it, and ends with expect_within or expect_answers.  tests/extremes_page.py reads the lines from
// GoogleTest's report.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "lights/sampling/light_sample.h"

namespace lucerna::testing {

/// |value - truth| / |truth|.  Infinite if the value is NaN, or if only the truth is 0.
inline double relative_error(double value, double truth) {
  if (value == truth) return 0;
  const double error = std::fabs(value - truth) / std::fabs(truth);
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

class Sweep {
 public:
  /// `row` of the page; the `input`; the `swept` magnitudes; the `figure` that is compared.
  Sweep(int row, std::string input, std::string swept, std::string figure)
      : row_(row), input_(std::move(input)), swept_(std::move(swept)), figure_(std::move(figure)) {}

  /// Compares a served value with a reference; `at` names the position in the sweep for the
  /// message.
  void compare(double served, double truth, const std::string& at) {
    ++cases_;
    const double error = relative_error(served, truth);
    if (!(error > worst_)) return;
    worst_ = error;
    worst_at_ = at;
  }
  /// Compares the value of the textbook's formula in floats.
  void compare_textbook(double value, double truth) {
    if (std::isnan(value)) {
      textbook_answer("not a number");
    } else {
      textbook_ = std::max(textbook_, relative_error(value, truth));
    }
  }

  /// Records an answer in words: a typed reason or an error.
  void answer(const std::string& words) {
    ++cases_;
    answers_.insert(words);
  }
  void answer(NoLight reason) { answer(name_of(reason)); }
  void textbook_answer(const std::string& words) { textbook_answers_.insert(words); }

  /// Expects the worst relative error to be at most `allowed`.
  void expect_within(double allowed) {
    EXPECT_GT(cases_, 0);
    EXPECT_LE(worst_, allowed) << figure_ << " at " << worst_at_;
    ::testing::Test::RecordProperty("worst", number(worst_));
    ::testing::Test::RecordProperty("allowed", number(allowed));
    record();
  }
  /// Expects all answers to be `expected`.
  void expect_answers(const std::string& expected) {
    EXPECT_EQ(answers_, std::set<std::string>{expected}) << figure_;
    record();
  }
  void expect_answers(NoLight expected) { expect_answers(name_of(expected)); }

  /// Expects that none of `of` cases is wrong; `left_out` of them had no right answer.
  void expect_none(std::int64_t wrong, std::int64_t of, std::int64_t left_out) {
    EXPECT_EQ(wrong, 0) << figure_;
    EXPECT_GT(of, left_out);
    cases_ = static_cast<int>(of);
    answers_ = {(wrong == 0 ? "none of " : count(wrong) + " of ") + count(of) + ", " +
                (left_out > 0 ? count(left_out) : "none") + " left out"};
    record();
  }
  void textbook_count(std::int64_t wrong) {
    textbook_answers_ = {wrong > 0 ? count(wrong) : "none"};
  }

  static std::string name_of(NoLight reason) {
    switch (reason) {
      case NoLight::kNone:
        return "light";
      case NoLight::kBehind:
        return "BEHIND";
      case NoLight::kOutsideCone:
        return "OUTSIDE_CONE";
      case NoLight::kDegenerate:
        return "DEGENERATE";
      case NoLight::kBlack:
        return "BLACK";
      case NoLight::kOutOfRange:
        return "OUT_OF_RANGE";
    }
    return "";
  }

 private:
  static std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
  }
  /// One digit, since the last digits of a count depend on the processor's libm.
  static std::string count(std::int64_t n) {
    char text[32];
    std::snprintf(text, sizeof text, "%.0e", static_cast<double>(n));
    return text;
  }
  static std::string joined(const std::set<std::string>& words) {
    std::string all;
    for (const std::string& w : words) all += (all.empty() ? "" : ", ") + w;
    return all;
  }
  void record() const {
    using ::testing::Test;
    const auto* result = ::testing::UnitTest::GetInstance()->current_test_info()->result();
    for (int i = 0; i < result->test_property_count(); ++i)
      EXPECT_STRNE(result->GetTestProperty(i).key(), "row") << "a line of the page is a test";
    Test::RecordProperty("row", row_);
    Test::RecordProperty("input", input_);
    Test::RecordProperty("swept", swept_);
    Test::RecordProperty("figure", figure_);
    Test::RecordProperty("cases", cases_);
    if (!answers_.empty()) Test::RecordProperty("answers", joined(answers_));
    if (textbook_ >= 0) Test::RecordProperty("textbook", number(textbook_));
    if (!textbook_answers_.empty())
      Test::RecordProperty("textbook_answers", joined(textbook_answers_));
  }

  int row_;
  std::string input_, swept_, figure_;
  int cases_ = 0;
  double worst_ = 0;
  std::string worst_at_ = "all";
  double textbook_ = -1;
  std::set<std::string> answers_, textbook_answers_;
};

}  // namespace lucerna::testing
