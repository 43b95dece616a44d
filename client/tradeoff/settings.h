// What is swept: ways to make an answer, and how much of each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::tradeoff {

enum class Query { kIrradiance, kRender, kSample, kPower, kVisibility };

/// "irradiance" ... "visibility", as --query takes them.
const std::vector<std::string>& query_names();
std::string name(Query query);

/// One way to make an answer.
struct Setting {
  /// As the command line takes it: what is told is what was measured.
  std::vector<std::string> flags{};
  /// What these flags ask a server for.
  v1::Accuracy accuracy{};
  /// Whether its amounts are target errors and not numbers of samples.
  bool by_target = false;

  /// "automatic", or the flags without dashes before them.
  std::string name() const;
};

/// How much.
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

/// What decides which settings make sense.
struct SceneFacts {
  std::uint64_t lights = 0;
};

/// Automatic first; then one choice at a time beside it, and the pairs that methods are known to
/// work in.  Not for power, whose methods are not these.
std::vector<Setting> settings(Query query, const SceneFacts& facts);

/// A setting of these flags of lucerna irradiance; they must be such.
Setting make_setting(std::vector<std::string> flags, bool by_target = false);

/// Powers of four from 1, or target errors from 30%, falling by about three.
std::vector<Amount> amounts(const Setting& setting, std::uint32_t max_samples);

}  // namespace lucerna::tradeoff
