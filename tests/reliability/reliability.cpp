// Measures what docs/reliability.md promises.
//
//     reliability [--brief] [--minutes N] ROW...
//
// Exits with 1 if a figure that does not depend on the machine is over its limit.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <map>

#include "tests/reliability/reliability_report.h"
#include "tests/reliability/stopping.h"

int main(int argc, char** argv) {
  namespace r = lucerna::reliability;
  using Row = void (*)(const r::Settings&, r::Report&);
  const std::vector<std::pair<std::string, Row>> rows = {
      {"attacks", r::attacks},   {"overload", r::overload},       {"priority", r::priority},
      {"stopping", r::stopping}, {"connections", r::connections}, {"churn", r::churn},
      {"drain", r::drain},       {"monitoring", r::monitoring},   {"soak", r::soak}};
  r::Settings settings;
  std::vector<std::string> names, all;
  for (const auto& [name, row] : rows) all.push_back(name);
  CLI::App app("Measures the rows of docs/reliability.md.");
  app.add_flag("--brief", settings.brief, "the short form, without times");
  app.add_option("--minutes", settings.soak_minutes, "how long the row soak takes")
      ->check(CLI::Range(0.1, 10000.0))
      ->capture_default_str();
  app.add_option("ROW", names, "which rows, all by default")->check(CLI::IsMember(all));
  // A client of the row `stopping`, which that row kills.
  std::vector<std::string> endless;
  app.add_option("--endless", endless)->expected(3)->group("");
  CLI11_PARSE(app, argc, argv);
  try {
    if (!endless.empty()) return r::run_endless(endless[0], endless[1], endless[2]);
    bool hold = true;
    for (const auto& [name, row] : rows) {
      if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
      fmt::print("{}\n", name);
      r::Report report(settings.brief);
      row(settings, report);
      hold = hold && report.holds();
    }
    return hold ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "reliability: {}\n", error.what());
    return 2;
  }
}
