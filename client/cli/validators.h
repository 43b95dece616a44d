// Checks of what is on the command line, with words a person can use.  CLI11's own ranges let NaN
// through and take -1 for a large unsigned number; its own sets of names tell their numbers too.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

namespace lucerna::cli {

/// A finite number for which `allowed` holds; `what` says which those are.
template <typename Allowed>
CLI::Validator checked_number(const std::string& what, Allowed allowed) {
  return {[what, allowed](std::string& text) -> std::string {
            double value = 0;
            const char* end = text.data() + text.size();
            const auto [stop, error] = std::from_chars(text.data(), end, value);
            if (error == std::errc() && stop == end && std::isfinite(value) && allowed(value))
              return {};
            return text + " is not " + what;
          },
          "NUMBER"};
}

/// One of these names.
inline CLI::Validator one_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return {[names, list](std::string& text) -> std::string {
            if (std::find(names.begin(), names.end(), text) != names.end()) return {};
            return text + " is not one of " + list;
          },
          "{" + list + "}"};
}

inline CLI::Validator positive() {
  return checked_number("a finite number above 0", [](double v) { return v > 0; });
}

inline CLI::Validator not_negative() {
  return checked_number("a finite number of at least 0", [](double v) { return v >= 0; });
}

/// A whole number from `least` to 2^32 - 1.
inline CLI::Validator whole(unsigned least) {
  return checked_number(
      "a whole number from " + std::to_string(least) + " to 4294967295",
      [least](double v) { return v >= least && v <= 4294967295.0 && v == std::floor(v); });
}

}  // namespace lucerna::cli
