#include "server/files/ies_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace lucerna {

bool IesNumbers::is_blank(char c) const {
  // The last two are a blank that does not break, in UTF-8 and in Latin-1.
  constexpr std::string_view kBlanks = " \t;\f\v\xc2\xa0";
  return kBlanks.find(c) != std::string_view::npos || (c == ',' && comma_ == Comma::kSeparator);
}

std::string_view IesNumbers::word() const {
  const auto* const end =
      std::find_if(words_.begin(), words_.end(), [&](char c) { return is_blank(c); });
  return words_.substr(0, static_cast<std::size_t>(end - words_.begin()));
}

std::optional<double> IesNumbers::parse(std::string_view word) const {
  if (comma_ == Comma::kSeparator) return parse_number(word);
  // A comma at the end still separates: "0,5, 1,5".
  if (word.ends_with(',')) word.remove_suffix(1);
  std::string decimal(word);
  std::replace(decimal.begin(), decimal.end(), ',', '.');
  return parse_number(decimal);
}

void IesNumbers::note_comma(std::string_view word) {
  if (word.ends_with(',')) word.remove_suffix(1);
  if (word.find(',') == std::string_view::npos) return;
  const auto ambiguous = ambiguous_commas(word);
  if (!ambiguous) comma_decides_ = true;
  if (ambiguous && ambiguous_.ok())
    ambiguous_ =
        photometric_error(file_, line_, fmt::format("\"{}\" is {}", excerpt(word), *ambiguous));
}

std::optional<double> IesNumbers::next(std::string_view what) {
  if (!status.ok()) return std::nullopt;
  if (!skip()) {
    fail(fmt::format("the file ends before {}", what));
    return std::nullopt;
  }
  const std::string_view found = word();
  words_.remove_prefix(found.size());
  const auto number = parse(found);
  if (number && comma_ == Comma::kDecimal) note_comma(found);
  if (!number) fail(fmt::format("{} is \"{}\", allowed: a finite number", what, excerpt(found)));
  return number;
}

double IesNumbers::number(std::string_view what, double least, double most,
                          std::string_view allowed) {
  const auto n = next(what);
  if (n && !(*n >= least && *n <= most))
    fail(fmt::format("{} = {}, allowed: {}", what, *n, allowed));
  return n.value_or(0);
}

int IesNumbers::whole(std::string_view what, int least, int most, std::string_view allowed) {
  const double n = number(what, least, most, allowed);
  if (status.ok() && n != std::floor(n))
    fail(fmt::format("{} = {}, allowed: {}", what, n, allowed));
  return status.ok() ? static_cast<int>(n) : 0;
}

std::vector<double> IesNumbers::list(std::string_view what, std::size_t count, double least,
                                     std::string_view allowed) {
  std::vector<double> result;
  if (!status.ok()) return result;
  result.reserve(count);
  for (std::size_t i = 0; i < count && status.ok(); ++i)
    result.push_back(number(fmt::format("{} {}", what, i + 1), least, kAny, allowed));
  return result;
}

std::vector<double> IesNumbers::angles(std::string_view what, std::size_t count) {
  std::vector<double> result;
  if (!status.ok()) return result;
  result.reserve(count);
  for (std::size_t i = 0; i < count && status.ok(); ++i) {
    const double n =
        number(fmt::format("{} {}", what, i + 1), -720, 720, "from -720 to 720 degrees");
    if (status.ok() && i > 0 && !(n > result.back()))
      fail(fmt::format("{} {} = {} degrees, allowed: more than the previous angle, {}", what, i + 1,
                       n, result.back()));
    result.push_back(n);
  }
  return result;
}

void IesNumbers::check(int line, const absl::Status& checked) {
  if (status.ok() && !checked.ok())
    status = photometric_error(
        file_, line, std::string_view(checked.message().data(), checked.message().size()));
}

bool IesNumbers::room_for(std::uint64_t count) {
  const std::size_t left = words_.size() + 1 + rest_.size();
  if (status.ok() && count > (left + 1) / 2)
    fail(fmt::format("{} numbers announced, allowed: as many as fit in the remaining {} bytes",
                     count, left));
  return status.ok();
}

bool IesNumbers::skip() {
  for (;;) {
    const auto* const begin =
        std::find_if(words_.begin(), words_.end(), [&](char c) { return !is_blank(c); });
    words_.remove_prefix(static_cast<std::size_t>(begin - words_.begin()));
    if (!words_.empty()) return true;
    if (rest_.empty()) return false;
    words_ = take_line(rest_);
    ++line_;
  }
}

}  // namespace lucerna
