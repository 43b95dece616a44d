#include "server/lucernad/setting.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_replace.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace lucerna::config {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

constexpr std::string_view kUnits = "KMGTPE";

/// The whole text as a number.
template <typename Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// "8", "8B", "8K", "8KB" or "8KiB", in any case, with spaces before the unit.
std::optional<std::uint64_t> bytes(std::string_view text) {
  std::size_t digits = 0;
  while (digits < text.size() && absl::ascii_isdigit(text[digits])) ++digits;
  const auto number = number_of<std::uint64_t>(text.substr(0, digits));
  if (!number) return std::nullopt;
  std::string unit = absl::AsciiStrToUpper(std::string(text.substr(digits)));
  std::erase(unit, ' ');
  if (unit.empty() || unit == "B") return number;
  const std::size_t power = kUnits.find(unit[0]);
  const std::string_view rest = std::string_view(unit).substr(1);
  if (power == std::string_view::npos || (!rest.empty() && rest != "B" && rest != "IB")) {
    return std::nullopt;
  }
  const std::uint64_t factor = std::uint64_t{1} << (10 * (power + 1));
  if (*number > UINT64_MAX / factor) return std::nullopt;
  return *number * factor;
}

/// The number with the largest unit that divides it.
std::string describe_bytes(std::uint64_t number) {
  std::size_t power = 0;
  while (number != 0 && number % 1024 == 0 && power < kUnits.size()) {
    number /= 1024;
    ++power;
  }
  return power == 0 ? fmt::format("{}", number) : fmt::format("{}{}iB", number, kUnits[power - 1]);
}

std::uint64_t present(const Whole& value) {
  return std::visit([](const auto* to) { return static_cast<std::uint64_t>(*to); }, value.to);
}

template <typename Range, typename Number>
bool is_within(const Range& range, const std::optional<Number>& number) {
  return number && *number >= range.least && *number <= range.most;
}

bool assign(const Whole& value, const std::string& text) {
  const auto number = number_of<std::uint64_t>(text);
  if (!is_within(value, number)) return false;
  std::visit([&](auto* to) { *to = static_cast<std::decay_t<decltype(*to)>>(*number); }, value.to);
  return true;
}

bool assign(const Bytes& value, const std::string& text) {
  const std::optional<std::uint64_t> number = bytes(text);
  if (is_within(value, number)) *value.to = *number;
  return is_within(value, number);
}

bool assign(const Real& value, const std::string& text) {
  const auto number = number_of<double>(text);
  if (is_within(value, number)) *value.to = *number;
  return is_within(value, number);
}

bool assign(const Switch& value, const std::string& text) {
  if (text != "true" && text != "false") return false;
  *value.to = text == "true";
  return true;
}

bool assign(const Text& value, const std::string& text) {
  if (!value.names.empty() && std::ranges::count(value.names, text) == 0) return false;
  *value.to = text;
  return true;
}

}  // namespace

std::string flag_name(const Setting& setting) { return "--" + setting.name; }

std::string environment_name(const Setting& setting) {
  return "LUCERNAD_" + absl::AsciiStrToUpper(absl::StrReplaceAll(setting.name, {{"-", "_"}}));
}

std::string allowed(const Setting& setting) {
  return std::visit(
      Overloaded{[](const Text& v) {
                   return v.names.empty() ? "a text" : fmt::format("{}", fmt::join(v.names, ", "));
                 },
                 [](const Texts&) { return std::string("a list of texts"); },
                 [](const Switch&) { return std::string("true or false"); },
                 [](const Whole& v) { return fmt::format("{} to {}", v.least, v.most); },
                 [](const Bytes& v) {
                   if (v.most == Bytes::kMost) {
                     return fmt::format("at least {} bytes, such as 8GiB", describe_bytes(v.least));
                   }
                   return fmt::format("{} to {} bytes, such as 64MiB", describe_bytes(v.least),
                                      v.most);
                 },
                 [](const Real& v) { return fmt::format("{} to {}", v.least, v.most); }},
      setting.value);
}

absl::Status set(const Setting& setting, const std::vector<std::string>& texts) {
  if (const auto* list = std::get_if<Texts>(&setting.value)) {
    *list->to = texts;
    return absl::OkStatus();
  }
  const bool good =
      texts.size() == 1 &&
      std::visit(Overloaded{[](const Texts&) { return false; },
                            [&](const auto& value) { return assign(value, texts.front()); }},
                 setting.value);
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{}, allowed: {}", fmt::join(texts, ", "), allowed(setting)));
}

std::string text_of(const Setting& setting) {
  return std::visit(
      Overloaded{[](const Text& v) { return *v.to; },
                 [](const Texts& v) { return fmt::format("{}", fmt::join(*v.to, ",")); },
                 [](const Switch& v) { return std::string(*v.to ? "true" : "false"); },
                 [](const Whole& v) { return fmt::format("{}", present(v)); },
                 [](const Bytes& v) { return describe_bytes(*v.to); },
                 [](const Real& v) { return fmt::format("{}", *v.to); }},
      setting.value);
}

}  // namespace lucerna::config
