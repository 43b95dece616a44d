#include "client/terminal/wavelengths.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "client/terminal/validators.h"

namespace lucerna::cli {

void WavelengthOption::add(CLI::App& command) {
  command
      .add_option(
          "--wavelength", nm_,
          "Also print the value at this wavelength [nm]; may be repeated, or a list with commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(checked_number("a wavelength from 100 to 1000000 nm",
                             [](double nm) { return nm >= 100 && nm <= 1e6; }));
}

std::string WavelengthOption::header(const std::string& unit) const {
  std::string text = "at";
  for (const double nm : nm_) text += " " + number(nm);
  return text + (unit.empty() ? " nm" : fmt::format(" nm [{}]", unit));
}

}  // namespace lucerna::cli
