// The settings of a sweep, which are ways to make an answer, and the amounts of each setting.
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
  /// The flags of the command line, which the report prints.
  std::vector<std::string> flags{};
  /// The part of the request that these flags set.
  v1::Accuracy accuracy{};
  /// Whether the amounts are target errors instead of numbers of samples.
  bool by_target = false;

  /// "automatic", or the flags without dashes before them.
  std::string name() const;
};

/// The amount of work of one question.
struct Amount {
  bool target = false;
  /// Samples of each item, or a relative error.
  double value = 1;

  /// In words: "64 samples", "error 1%".
  std::string text() const;
  /// As options: "--samples 64", "--error 1%".
  std::string flags() const;
  bool operator==(const Amount&) const = default;
};

/// Facts that decide which settings make sense.
struct SceneFacts {
  std::uint64_t lights = 0;
};

/// All settings of a query.  Automatic comes first.  Each further setting changes one method, or a
/// pair of methods that affect each other.  For power, which has its own methods, only automatic.
std::vector<Setting> settings(Query query, const SceneFacts& facts);

/// The setting of these flags.  `lucerna irradiance` must accept them.
Setting make_setting(std::vector<std::string> flags, bool by_target = false);

/// Powers of four from 1 to `max_samples`, or target errors that start at 30% and fall by a factor
/// of about three.
std::vector<Amount> amounts(const Setting& setting, std::uint32_t max_samples);

}  // namespace lucerna::tradeoff
