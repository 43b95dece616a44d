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

Table::Column WavelengthOption::column(const std::string& unit) const {
  const std::string end = unit.empty() ? " nm" : fmt::format(" nm [{}]", unit);
  Table::Column column{.header = "at", .text = true, .names = {}};
  for (const double nm : nm_) {
    column.header += " " + number(nm);
    column.names.push_back(fmt::format("at {}{}", nm, end));
  }
  column.header += end;
  return column;
}

}  // namespace lucerna::cli
