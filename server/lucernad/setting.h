// One setting of lucernad.  The flag, the environment variable and the key of the configuration
// file all come from its name.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace lucerna::config {

/// One of these texts; without names, any text.
struct Text {
  std::string* to;
  std::vector<std::string> names{};
};
/// A list of texts.  The flag may be repeated.
struct Texts {
  std::vector<std::string>* to;
};
/// On or off.
struct Switch {
  bool* to;
};
/// A whole number in [least, most].
struct Whole {
  std::variant<std::uint64_t*, std::uint32_t*, int*> to;
  std::uint64_t least = 0, most = 0;
};
/// A number of bytes in [least, most], such as 8GiB.  Units are powers of 1024.
struct Bytes {
  std::uint64_t* to;
  // Sums of a few sizes then fit 64 bits.
  static constexpr std::uint64_t kMost = std::uint64_t{1} << 60;
  std::uint64_t least = 0, most = kMost;
};
/// A finite number in [least, most].
struct Real {
  double* to;
  double least = 0, most = 0;
};

struct Setting {
  std::string name;  ///< such as "memory-budget"
  std::string type;  ///< of its value, for the help
  std::string help;
  std::variant<Text, Texts, Switch, Whole, Bytes, Real> value;
  /// Whether SIGHUP changes it while the server runs.
  bool reloads = false;
};

/// "--memory-budget"
std::string flag_name(const Setting& setting);
/// "LUCERNAD_MEMORY_BUDGET"
std::string environment_name(const Setting& setting);

/// What the value may be, such as "0 to 1024".
std::string allowed(const Setting& setting);
/// Sets the value from its text.  Several texts are only for Texts; an environment variable
/// separates them by commas.  INVALID_ARGUMENT "TEXT, allowed: ..." leaves the value unchanged.
absl::Status set(const Setting& setting, const std::vector<std::string>& texts);
/// The present value, in the form that `set` accepts.
std::string text_of(const Setting& setting);

}  // namespace lucerna::config
