#include "client/terminal/validators.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

namespace lucerna::cli {
namespace {

template <typename T>
std::optional<T> parse(std::string_view text) {
  T value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> read_number(std::string_view text) {
  const auto value = parse<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

CLI::Validator checked_number(const std::string& what, std::function<bool(double)> allowed) {
  return {[what, allowed = std::move(allowed)](std::string& text) -> std::string {
            const auto value = read_number(text);
            return value && allowed(*value) ? "" : text + " is not " + what;
          },
          "NUMBER"};
}

CLI::Validator finite_number() {
  return checked_number("a finite number", [](double) { return true; });
}

CLI::Validator one_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return {[names, list](std::string& text) -> std::string {
            if (std::find(names.begin(), names.end(), text) != names.end()) return {};
            return text + " is not one of " + list;
          },
          "{" + list + "}"};
}

CLI::Validator positive() {
  return checked_number("a finite number above 0", [](double v) { return v > 0; });
}

CLI::Validator not_negative() {
  return checked_number("a finite number of at least 0", [](double v) { return v >= 0; });
}

CLI::Validator whole(std::uint64_t least, std::uint64_t most, const std::string& limit) {
  const std::string what = fmt::format("a whole number from {} to {}", least,
                                       limit.empty() ? std::to_string(most) : limit);
  return {[least, most, what](std::string& text) -> std::string {
            const auto value = parse<std::uint64_t>(text);
            return value && *value >= least && *value <= most ? "" : text + " is not " + what;
          },
          "NUMBER"};
}

CLI::Validator whole64(std::uint64_t least) {
  return whole(least, std::numeric_limits<std::uint64_t>::max());
}

CLI::Validator sample_count(std::uint64_t least) {
  return whole(least, std::numeric_limits<std::uint32_t>::max(),
               "the server's limit (1048576, unless `lucerna info` shows another)");
}

CLI::Validator share() {
  return {[](std::string& text) -> std::string {
            const bool percent = text.ends_with('%');
            const std::string number = percent ? text.substr(0, text.size() - 1) : text;
            const auto value = read_number(number);
            if (!value || *value <= 0)
              return text + " is not a fraction above 0, such as 1% or 0.01";
            if (!percent && *value >= 1) {
              return fmt::format("{} is {:g}%; did you mean {}%?", text, 100 * *value, text);
            }
            if (percent) text = fmt::format("{}", *value / 100);
            return {};
          },
          "SHARE"};
}

std::optional<double> read_duration(std::string_view text) {
  if (const auto seconds = read_number(text)) return seconds;
  // ms comes before m, because it begins with m.
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"h", 3600}, {"ms", 1e-3}, {"m", 60}, {"s", 1}};
  double time_s = 0;
  double last_unit_s = std::numeric_limits<double>::infinity();
  while (!text.empty()) {
    const std::size_t length = std::min(text.find_first_of("hms"), text.size());
    const auto value = read_number(text.substr(0, length));
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

CLI::Validator duration() {
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
