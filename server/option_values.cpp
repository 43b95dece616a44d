#include "server/option_values.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace lucerna {
namespace {

/// The number at the beginning of `text`, which is then removed.  Nothing without one, or if it
/// exceeds 64 bits.
std::optional<std::uint64_t> take_whole(std::string_view& text) {
  std::uint64_t number = 0;
  const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (code != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  return number;
}

/// The factor of a unit such as "GiB"; nothing for unknown ones.
std::optional<std::uint64_t> factor_of(std::string_view unit) {
  std::string lower;
  for (const char c : unit)
    if (c != ' ') lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (lower.empty() || lower == "b") return 1;
  constexpr std::string_view kUnits = "kmgtp";
  const std::size_t power = kUnits.find(lower[0]);
  const std::string_view rest = std::string_view(lower).substr(1);
  if (power == std::string_view::npos || !(rest.empty() || rest == "b" || rest == "ib"))
    return std::nullopt;
  return std::uint64_t{1} << (10 * (power + 1));
}

bool contains(const Range<std::uint64_t>& range, std::uint64_t number) {
  return number >= range.least && number <= range.most;
}

}  // namespace

std::string check_whole(const std::string& text, const Range<std::uint64_t>& range) {
  std::string_view rest = text;
  const auto number = take_whole(rest);
  if (number && rest.empty() && contains(range, *number)) return {};
  return fmt::format("found {}, allowed: a whole number from {} to {}", text, range.least,
                     range.most);
}

std::string check_real(const std::string& text, const Range<double>& range) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, number);
  // A number that is not finite is in no range.
  if (code == std::errc{} && rest == end && number >= range.least && number <= range.most)
    return {};
  return fmt::format("found {}, allowed: a number from {} to {}", text, range.least, range.most);
}

std::string to_bytes(std::string& text, const Range<std::uint64_t>& range) {
  std::string_view rest = text;
  const auto number = take_whole(rest);
  const auto factor = factor_of(rest);
  std::uint64_t bytes = 0;
  if (number && factor && !__builtin_mul_overflow(*number, *factor, &bytes) &&
      contains(range, bytes)) {
    text = std::to_string(bytes);
    return {};
  }
  return fmt::format("found {}, allowed: {} to {} bytes, such as 512MiB or 8GiB", text, range.least,
                     range.most);
}

}  // namespace lucerna
