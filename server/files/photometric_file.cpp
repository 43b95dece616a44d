#include "server/files/photometric_file.h"

#include <absl/strings/ascii.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace lucerna {

std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  const bool pair = text.substr(end, 2) == "\r\n";
  text.remove_prefix(std::min(end + (pair ? 2 : 1), text.size()));
  return line;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string upper_case(std::string_view text) {
  std::string upper(text);
  absl::AsciiStrToUpper(&upper);
  return upper;
}

std::optional<double> parse_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::string> ambiguous_commas(std::string_view number) {
  const std::size_t comma = number.find(',');
  const std::size_t digits = number.find_first_of("123456789");
  const bool thousands = comma != std::string_view::npos && digits < comma && comma - digits <= 3 &&
                         number.size() == comma + 4 &&
                         number.find_first_not_of("0123456789", comma + 1) == number.npos;
  if (!thousands) return std::nullopt;
  std::string all(number), decimal(number);
  all.erase(comma, 1), decimal[comma] = '.';
  return fmt::format("{} or {}, and no other number decides it, allowed: numbers without commas",
                     parse_number(all).value_or(0), parse_number(decimal).value_or(0));
}

std::optional<PhotometricFile::Note> opening_note(int line, std::initializer_list<double> sizes_m) {
  std::string sizes;
  for (const double size : sizes_m)
    if (size != 0) sizes += fmt::format("{}{:.4g}", sizes.empty() ? "" : " x ", std::fabs(size));
  if (sizes.empty()) return std::nullopt;
  return PhotometricFile::Note{line, fmt::format("a luminous opening of {} m", sizes),
                               "a point; right from about 5 times that size on"};
}

void note_gap(int line, std::optional<AngleGap> gap, PhotometricFile& file) {
  if (gap) file.notes.push_back({line, std::move(gap->what), std::move(gap->instead)});
}

void NoiseBelowZero::add(double value, std::size_t number, int line) {
  if (value >= 0) return;
  ++count_;
  if (value < least_) least_ = value, number_ = number, line_ = line;
}

absl::Status NoiseBelowZero::clear(std::vector<double>& values, std::string_view name,
                                   const std::function<std::string(std::size_t)>& what,
                                   PhotometricFile& file) const {
  if (count_ == 0) return absl::OkStatus();
  const double largest = *std::max_element(values.begin(), values.end());
  if (least_ < -0.03 * largest)
    return photometric_error(name, line_,
                             fmt::format("{} = {}, allowed: finite, not negative, and noise down "
                                         "to -3% of the largest",
                                         what(number_), least_));
  for (double& value : values) value = std::max(value, 0.0);
  file.notes.push_back({line_,
                        fmt::format("{} negative {}, down to {}", count_,
                                    count_ == 1 ? "intensity" : "intensities", least_),
                        "0"});
  return absl::OkStatus();
}

std::string excerpt(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result;
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return text.size() > kLongest ? result + "..." : result;
}

absl::Status photometric_error(std::string_view file, int line, std::string_view what) {
  return absl::InvalidArgumentError(fmt::format("{}:{}: {}", file, line, what));
}

}  // namespace lucerna
