// Checks of the words on the command line, with messages for people.  CLI11's own ranges accept
// NaN, and read -1 as a large unsigned number.  Messages of its own sets of names also show the
// numbers of the names.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lucerna::cli {

/// The number in `text`.  Nothing if `text` is not a finite number in the range of T.
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

/// A finite number for which `allowed` is true.  `what` describes these numbers in the error
/// message.
template <typename Allowed>
CLI::Validator checked_number(const std::string& what, Allowed allowed) {
  return {[what, allowed](std::string& text) -> std::string {
            const auto value = read_number<double>(text);
            return value && allowed(*value) ? "" : text + " is not " + what;
          },
          "NUMBER"};
}

/// One of `names`.
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

/// A whole number from `least` to `most`.  If `limit` is not empty, the message shows it instead of
/// `most`.  CLI11's own check silently replaces a number that is too large by the largest allowed
/// one.
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

/// Numbers of samples.  The server has its own limit.
inline CLI::Validator sample_count(std::uint64_t least = 1) {
  return whole(least, std::numeric_limits<std::uint32_t>::max(),
               "the server's limit (1048576, unless `lucerna info` shows another)");
}

/// Seconds of a time such as 60, 60s, 2m, 500ms, 1h or 1h30m.  The text is a number of seconds, or
/// numbers with the units h, m, s and ms in this order, each at most once.  Nothing for any other
/// text.
inline std::optional<double> read_duration(std::string_view text) {
  if (const auto seconds = read_number<double>(text)) return seconds;
  // ms comes before m, because it begins with m.
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"h", 3600}, {"ms", 1e-3}, {"m", 60}, {"s", 1}};
  double time_s = 0;
  double last_unit_s = std::numeric_limits<double>::infinity();
  while (!text.empty()) {
    const std::size_t length = std::min(text.find_first_of("hms"), text.size());
    const auto value = read_number<double>(text.substr(0, length));
    text.remove_prefix(length);
    const auto unit = std::find_if(std::begin(kUnits), std::end(kUnits),
                                   [&](const auto& u) { return text.starts_with(u.first); });
    if (!value || *value < 0 || unit == std::end(kUnits) || unit->second >= last_unit_s) {
      return std::nullopt;
    }
    text.remove_prefix(unit->first.size());
    last_unit_s = unit->second;
    time_s += *value * unit->second;
  }
  return time_s;
}

/// A time above 0 in the form of read_duration().  The text becomes the number of seconds.
inline CLI::Validator duration() {
  return {[](std::string& text) -> std::string {
            const double time_s = read_duration(text).value_or(0);
            if (!(time_s > 0) || !std::isfinite(time_s))
              return text + " is not a time above 0, such as 60, 60s, 2m, 1h30m or 500ms";
            text = fmt::format("{}", time_s);
            return {};
          },
          "TIME"};
}

}  // namespace lucerna::cli
