// Describes the certainty of an answer in words: intervals, missed targets, budgets and
// approximations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/terminal/output.h"
#include "lucerna/v1/accuracy.pb.h"
#include "proto/common/defaults.h"

namespace lucerna::cli {

/// A fraction in (0, 1) in percent, with enough digits to differ from 0% and 100%: "95",
/// "99.9999999".
std::string percent(double share);

/// The text of the column ±: half the width of the interval, or both ends if the value is not in
/// the middle.  For the value 0 it is "< upper".  An interval without width is "exact", or "no
/// scatter" for an `approximate` answer.
std::string interval_text(double value, double lower, double upper, bool approximate);

/// The same as a cell with two values: `lower` and `upper`.
Cell interval_cell(double value, double lower, double upper, bool approximate);
Cell interval_cell(float value, float lower, float upper, bool approximate);
/// The column of these cells.
Table::Column interval_column(const std::string& unit = "lx");

/// Whether the request chose an approximation.  Intervals do not include its error.
bool is_approximate(const v1::Accuracy& accuracy);
/// "; approximated: area lights as points beyond 7.1 radii; ..." for the end of a footer.  Empty
/// without approximations.
std::string describe_approximations(const v1::Accuracy& accuracy, const v1::Cost& cost);

/// For an answer that took more time than its budget with the least number of samples, else empty.
/// Example: "over the budget of 3 s: each point takes at least 16 samples; --samples 1 would take
/// about 1.75 s; ".  `samples` is the largest number of samples of an item; `item` names an item
/// ("point").
std::string describe_overrun(const v1::Accuracy& accuracy, const v1::Cost& cost,
                             std::uint64_t samples, const std::string& item);

/// Counts the answers that miss the target error.
class TargetCheck {
 public:
  explicit TargetCheck(const v1::TargetError& target);

  /// Adds an item's answer.  `more_samples` is the next larger number of samples that the item
  /// could have taken.  Returns whether half the width of the interval is within the target.
  bool add(double value, double lower, double upper, std::uint64_t more_samples);

  std::uint64_t missed() const { return missed_; }
  /// "3 of 8 points missed the target; the worst interval is 1.5 times too wide; --max-samples
  /// reached; ".  Empty if none missed it.
  std::string describe(const std::string& items) const;

 private:
  double relative_, floor_;
  std::uint64_t max_samples_;
  std::uint64_t items_ = 0, missed_ = 0, capped_ = 0;
  double worst_ = 1;  // largest width / allowed width, of items with an allowed error above 0
};

/// The part of `upper_lx` that bounds light which no sample finds.
template <typename Answers>
double unsampled_bound(const Answers& answers, int i) {
  if constexpr (requires { answers.unsampled_bound_lx(i); })
    return i < answers.unsampled_bound_lx_size() ? answers.unsampled_bound_lx(i) : 0;
  else
    return 0;
}

/// Checks the receivers that have an answer.  `samples` has the number of samples of each receiver.
/// Sets `reached` to whether each receiver met the target; false for receivers without an answer.
template <typename Answers>
TargetCheck check_target(const Answers& answers,
                         const google::protobuf::RepeatedField<std::uint32_t>& samples,
                         const v1::TargetError& target, std::vector<bool>* reached = nullptr) {
  TargetCheck check(target);
  for (int i = 0; i < samples.size(); ++i) {
    const bool good = has_answer(answers.status(), i) &&
                      check.add(answers.illuminance_lx(i), answers.lower_lx(i),
                                double{answers.upper_lx(i)} - unsampled_bound(answers, i),
                                std::uint64_t{samples[i]} + kDefaultBlocks);
    if (reached != nullptr) reached->push_back(good);
  }
  return check;
}

/// A member of JSON for to_json(): `"name":[true,false]`.
std::string json_of(const char* name, const std::vector<bool>& values);
/// A member of JSON for to_json(): `"approximate":true`.
std::string json_of_approximate(const v1::Accuracy& accuracy);

}  // namespace lucerna::cli
