// Checks of what is on the command line, with words a person can use.  CLI11's own ranges let NaN
// through and take -1 for a large unsigned number; its own sets of names tell their numbers too.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lucerna::cli {

/// The whole of `text` as a number that T holds and that is not infinite.
template <typename T>
std::optional<T> read_number(std::string_view text) {
  T value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

/// A finite number for which `allowed` holds; `what` says which those are.
template <typename Allowed>
CLI::Validator checked_number(const std::string& what, Allowed allowed) {
  return {[what, allowed](std::string& text) -> std::string {
            const auto value = read_number<double>(text);
            return value && allowed(*value) ? "" : text + " is not " + what;
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

/// A whole number from `least` to `most`, which is told as `limit` where there is one.  CLI11 by
/// itself takes the nearest that there is for one beyond.
inline CLI::Validator whole(std::uint64_t least,
                            std::uint64_t most = std::numeric_limits<std::uint32_t>::max(),
                            const std::string& limit = {}) {
  const std::string what = fmt::format("a whole number from {} to {}", least,
                                       limit.empty() ? std::to_string(most) : limit);
  return {[least, most, what](std::string& text) -> std::string {
            const auto value = read_number<std::uint64_t>(text);
            return value && *value >= least && *value <= most ? "" : text + " is not " + what;
          },
          "NUMBER"};
}

/// Seeds, ids and other 64-bit numbers.
inline CLI::Validator whole64(std::uint64_t least = 0) {
  return whole(least, std::numeric_limits<std::uint64_t>::max());
}

/// Numbers of samples, of which the server allows no more than its own limit.
inline CLI::Validator sample_count(std::uint64_t least = 1) {
  return whole(least, std::numeric_limits<std::uint32_t>::max(),
               "the server's limit (1048576, unless `lucerna info` tells another)");
}

/// A time as 60, 60s, 2m or 500ms, which becomes seconds.
inline CLI::Validator duration() {
  return {
      [](std::string& text) -> std::string {
        std::string_view number = text;
        double unit_s = 1;
        for (const auto& [name, seconds] : std::initializer_list<std::pair<const char*, double>>{
                 {"ms", 1e-3}, {"s", 1}, {"m", 60}}) {
          if (!number.ends_with(name)) continue;
          number.remove_suffix(std::string_view(name).size());
          unit_s = seconds;
          break;
        }
        const auto value = read_number<double>(number);
        const double time_s = value.value_or(0) * unit_s;
        if (!(time_s > 0) || !std::isfinite(time_s))
          return text + " is not a time above 0, as 60, 60s, 2m or 500ms";
        text = fmt::format("{}", time_s);
        return {};
      },
      "TIME"};
}

}  // namespace lucerna::cli
