// The settings of a sweep: ways to make an answer, and the amounts of each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::tradeoff {

enum class Query { kIrradiance, kRender, kSample, kPower, kVisibility };

/// "irradiance" ... "visibility", the names that --query accepts.
const std::vector<std::string>& query_names();
std::string name(Query query);

/// One way to make an answer.
struct Setting {
  /// The flags on the command line, so that the report prints the measured setting.
  std::vector<std::string> flags{};
  /// The request that these flags make.
  v1::Accuracy accuracy{};
  /// The amounts are target errors and not numbers of samples.
  bool by_target = false;

  /// "automatic", or the flags without dashes before them.
  std::string name() const;
};

/// The amount of work of one question.
struct Amount {
  bool target = false;
  /// Samples of each item, or a relative error.
  double value = 1;

  /// "64 samples", "error 1%".
  std::string text() const;
  /// "--samples 64", "--error 1%".
  std::string flags() const;
  bool operator==(const Amount&) const = default;
};

/// Facts that decide which settings make sense.
struct SceneFacts {
  std::uint64_t lights = 0;
};

/// Automatic first.  Then one method that differs from automatic at a time, and the pairs of
/// methods that affect each other.  Empty but for automatic for power, which has its own methods.
std::vector<Setting> settings(Query query, const SceneFacts& facts);

/// The setting of these flags, which `lucerna irradiance` must accept.
Setting make_setting(std::vector<std::string> flags, bool by_target = false);

/// Powers of four from 1 to `max_samples`, or target errors from 30% that fall by about three.
std::vector<Amount> amounts(const Setting& setting, std::uint32_t max_samples);

}  // namespace lucerna::tradeoff
