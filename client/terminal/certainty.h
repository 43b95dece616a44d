// How certain an answer is, in words: intervals, targets that were missed, approximations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/terminal/output.h"
#include "lucerna/v1/accuracy.pb.h"
#include "proto/common/defaults.h"

namespace lucerna::cli {

/// A share in (0, 1) in percent, with as many digits as tell it from 0% and 100%: "95",
/// "99.9999999".
std::string percent(double share);

/// What stands under ±: half the width of the interval; both its ends where the value is not in its
/// middle; "< upper" where the value is 0.  Of no width: "exact", or "no scatter" of an answer that
/// is `approximate`.
std::string interval_text(double value, double lower, double upper, bool approximate);

/// Whether approximations were asked for that no interval knows of.
bool is_approximate(const v1::Accuracy& accuracy);
/// "; approximated: area lights as points beyond 7.1 radii; ..." for the end of a footer.  Empty
/// where nothing is.
std::string describe_approximations(const v1::Accuracy& accuracy, const v1::Cost& cost);

/// Which answers to a target error are as certain as was asked for.
class TargetCheck {
 public:
  explicit TargetCheck(const v1::TargetError& target);

  /// An item's answer.  `more_samples`: how many it would have taken had it taken more.  Whether
  /// half the width of the interval is no more than was asked for.
  bool add(double value, double lower, double upper, std::uint64_t more_samples);

  /// How many are not.
  std::uint64_t missed() const { return missed_; }
  /// "3 of 8 points are less certain than asked for (1.5 times at worst), --max-samples reached; ".
  /// Empty where none is.
  std::string describe(const std::string& items) const;

 private:
  double relative_, floor_;
  std::uint64_t max_samples_;
  std::uint64_t items_ = 0, missed_ = 0, capped_ = 0;
  double worst_ = 1;  // of those that were allowed any error
};

/// Of the receivers that have an answer.  `samples` of each; `reached`: whether each is as certain
/// as was asked for, false of those that have none.
template <typename Answers>
TargetCheck check_target(const Answers& answers,
                         const google::protobuf::RepeatedField<std::uint32_t>& samples,
                         const v1::TargetError& target, std::vector<bool>* reached = nullptr) {
  TargetCheck check(target);
  for (int i = 0; i < samples.size(); ++i) {
    const bool good = item_status(answers.status(), i).empty() &&
                      check.add(answers.illuminance_lx(i), answers.lower_lx(i), answers.upper_lx(i),
                                std::uint64_t{samples[i]} + kReplicates);
    if (reached != nullptr) reached->push_back(good);
  }
  return check;
}

/// `"name":[true,false]`, for to_json().
std::string json_of(const char* name, const std::vector<bool>& values);
/// `"approximate":true`.
std::string json_of_approximate(const v1::Accuracy& accuracy);

}  // namespace lucerna::cli
