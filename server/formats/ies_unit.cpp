#include "server/formats/ies_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace lucerna {
namespace {

/// Lower case; micro signs and words become the letters of units; no blanks about a slash.
std::string normalized(std::string_view line) {
  std::string text(line);
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  // The two micro signs in UTF-8, then the one in Latin-1.
  for (const auto& [word, unit] :
       std::vector<std::pair<std::string_view, std::string_view>>{{"\xc2\xb5", "u"},
                                                                  {"\xce\xbc", "u"},
                                                                  {"\xb5", "u"},
                                                                  {" per ", "/"},
                                                                  {"milli", "m"},
                                                                  {"micro", "u"},
                                                                  {"watts", "w"},
                                                                  {"watt", "w"},
                                                                  {"steradians", "sr"},
                                                                  {"steradian", "sr"},
                                                                  {"moles", "mol"},
                                                                  {" /", "/"},
                                                                  {"/ ", "/"},
                                                                  {" sr-1", "/sr"},
                                                                  {" sr^-1", "/sr"},
                                                                  {"*sr^-1", "/sr"}})
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

/// Whether a keyword is about the unit of light: [_INTENSITYUNITS], [_FLUXUNIT], [UNITS].
bool is_about_unit(std::string_view keyword) {
  const auto has = [&](std::string_view word) {
    return keyword.find(word) != std::string_view::npos;
  };
  return has("unit") && !has("power") && !has("input") && !has("electric");
}

/// The unit that a line states, or empty.  After a number it belongs to that number.
std::string unit_in(std::string_view line) {
  const std::string text = normalized(line);
  std::string_view rest = trimmed(text);
  const bool of_flux = rest.starts_with('[') && is_about_unit(rest.substr(0, rest.find(']')));
  const auto separates = [](char c) {
    return !((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '/');
  };
  bool after_number = false;
  while (!rest.empty()) {
    const auto size =
        static_cast<std::size_t>(std::find_if(rest.begin(), rest.end(), separates) - rest.begin());
    const std::string_view word = rest.substr(0, size);
    if (std::string unit = flux_unit_of(word, of_flux); !unit.empty() && !after_number) return unit;
    if (!word.empty()) after_number = parse_number(word).has_value();
    rest.remove_prefix(std::min(size + 1, rest.size()));
  }
  return "";
}

}  // namespace

void note_unit(std::string_view header, PhotometricFile& file) {
  for (int line = 1; !header.empty(); ++line) {
    std::string unit = unit_in(take_line(header));
    if (unit.empty()) continue;
    file.unit = PhotometricFile::Note{
        line, fmt::format("intensities in {}/sr, not in cd", unit),
        fmt::format("read as if in cd: of this light, lm stand for {0} and lx for {0}/m2", unit)};
    file.flux_unit = std::move(unit);
    return;
  }
}

}  // namespace lucerna
