#include "server/files/ies_unit.h"

#include <absl/strings/ascii.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace lucerna {
namespace {

/// Lower case; micro signs and words become the letters of units; no blanks about a slash.
std::string normalized(std::string_view line) {
  std::string text(line);
  absl::AsciiStrToLower(&text);
  // The two micro signs, the dot and the exponent -1 in UTF-8, then micro and dot in Latin-1.
  for (const auto& [word, unit] : std::vector<std::pair<std::string_view, std::string_view>>{
           {"\xc2\xb5", "u"},   {"\xce\xbc", "u"},
           {"\xc2\xb7", " "},   {"\xe2\x81\xbb\xc2\xb9", "-1"},
           {"\xb5", "u"},       {"\xb7", " "},
           {"*", " "},          {"^", ""},
           {" per ", "/"},      {"milli", "m"},
           {"micro", "u"},      {"watts", "w"},
           {"watt", "w"},       {"steradians", "sr"},
           {"steradian", "sr"}, {"/ster", "/sr"},
           {"/ ster", "/sr"},   {"moles", "mol"},
           {"ppf", "umol/s"},   {" /", "/"},
           {"/ ", "/"},         {" sr-1", "/sr"},
           {" s-1", "/s"}})
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += unit.size())
      text.replace(at, word.size(), unit);
  return text;
}

/// The unit of flux that a word states: "mW" for "mw/sr", and for "mw" if `of_flux`; otherwise
/// empty.
std::string flux_unit_of(std::string_view word, bool of_flux) {
  constexpr std::string_view kPerSr = "/sr";
  if (word.ends_with(kPerSr))
    word.remove_suffix(kPerSr.size());
  else if (!of_flux)
    return "";
  std::string prefix;
  if (!word.empty() && std::string_view("numk").find(word.front()) != std::string_view::npos &&
      !word.starts_with("mol")) {
    prefix = word.front();
    word.remove_prefix(1);
  }
  if (word == "w") return prefix + "W";
  return word == "mol/s" ? prefix + "mol/s" : "";
}

bool has_any(std::string_view text, std::initializer_list<std::string_view> parts) {
  return std::any_of(parts.begin(), parts.end(), [&](std::string_view part) {
    return text.find(part) != std::string_view::npos;
  });
}

/// Calls `each` with the words of a text, until it returns true.
template <typename Each>
void for_words(std::string_view text, Each&& each) {
  const auto separates = [](char c) {
    return !((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '/' || c == '.');
  };
  while (!text.empty()) {
    const auto size =
        static_cast<std::size_t>(std::find_if(text.begin(), text.end(), separates) - text.begin());
    std::string_view word = text.substr(0, size);
    while (word.ends_with('.')) word.remove_suffix(1);
    if (!word.empty() && each(word)) return;
    text.remove_prefix(std::min(size + 1, text.size()));
  }
}

/// Whether a keyword is about the unit of light: [_INTENSITYUNITS], [_FLUXUNIT], [UNITS].
bool is_about_unit(std::string_view keyword) {
  bool unit = false;
  for_words(keyword, [&](std::string_view word) {
    return unit = word.ends_with("unit") || word.ends_with("units");
  });
  return unit && (has_any(keyword, {"radiant", "flux", "intensity"}) ||
                  !has_any(keyword, {"power", "input", "electric", "length", "dimension",
                                     "distance", "size", "angle", "weight", "temp"}));
}

/// Whether the value of a keyword about a unit is one of light that the eye sees, one of length or
/// none.
bool is_of_no_concern(std::string_view value) {
  constexpr std::string_view kKnown[] = {
      "cd",      "candela", "candelas", "candlepower", "cp",         "lm",          "lumen",
      "lumens",  "lx",      "lux",      "fc",          "footcandle", "footcandles", "mm",
      "cm",      "m",       "in",       "inch",        "inches",     "ft",          "foot",
      "feet",    "metre",   "metres",   "meter",       "meters",     "metric",      "imperial",
      "english", "si",      "deg",      "degrees",     "none",       "n/a",         "na"};
  bool known = false, any = false;
  for_words(value, [&](std::string_view word) {
    any = true;
    return known = std::find(std::begin(kKnown), std::end(kKnown), word) != std::end(kKnown);
  });
  return known || !any;
}

/// A unit of flux, and what the file calls the unit of its intensities.
struct StatedUnit {
  std::string flux, intensity;
};

/// The unit that a line states; empty if it states none.  After a number the unit belongs to that
/// number: it counts if it is the radiant flux of the file, `flux` in this unit.
StatedUnit unit_in(std::string_view line, double flux) {
  const std::string text = normalized(line);
  const std::string_view rest = trimmed(text);
  const std::size_t end = rest.starts_with('[') ? std::min(rest.find(']'), rest.size()) : 0;
  const std::string_view key = rest.substr(0, end);
  const bool of_unit = is_about_unit(key);
  const bool of_flux = has_any(key, {"radiant", "photon", "umol/s"});
  double number = 0;
  bool after_number = false;
  std::string unit;
  for_words(rest.substr(end), [&](std::string_view word) {
    if (const auto n = parse_number(word)) {
      number = *n, after_number = true;
      return false;
    }
    unit = flux_unit_of(word, of_unit || of_flux);
    if (after_number && !(of_flux && std::fabs(flux - number) < 0.05 * number)) unit.clear();
    after_number = false;
    return !unit.empty();
  });
  if (!unit.empty()) return {unit, unit + "/sr"};
  if (!of_unit || is_of_no_concern(rest.substr(end))) return {};
  const std::size_t value = std::min(line.find(']'), line.size() - 1) + 1;
  return {"unknown", fmt::format("\"{}\"", excerpt(trimmed(line.substr(value))))};
}

}  // namespace

void note_unit(std::string_view header, PhotometricFile& file) {
  for (int line = 1; !header.empty(); ++line) {
    StatedUnit unit = unit_in(take_line(header), file.web->flux_lm());
    if (unit.flux.empty()) continue;
    file.unit = PhotometricFile::Note{
        line, fmt::format("intensities in {}, not in cd", unit.intensity),
        unit.flux == "unknown"
            ? "read as if in cd: lm and lx of this light are numbers in an unknown unit"
            : fmt::format("read as if in cd: of this light, lm stand for {0} and lx for {0}/m2",
                          unit.flux)};
    file.flux_unit = std::move(unit.flux);
    return;
  }
}

}  // namespace lucerna
