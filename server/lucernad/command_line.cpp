#include "server/lucernad/command_line.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>

namespace lucerna::config {

CommandLine parse_command_line(int argc, const char* const* argv, const std::string& version) {
  CommandLine line;
  line.given.environment = environment();
  CLI::App app("Lucerna's server: answers queries about the light in scenes, over gRPC.");
  app.set_version_flag("--version", "lucernad " + version);
  app.footer(
      "Each option may also be an environment variable, such as LUCERNAD_THREADS for --threads,\n"
      "or a line of the configuration file, such as threads = 4.  An option overrides the\n"
      "variable, and the variable overrides the file.\n\n"
      "Example:\n  lucernad --scene-root scenes --load room.pbrt");
  app.add_option("--config", line.given.file, "Configuration file in TOML (LUCERNAD_CONFIG)")
      ->type_name("FILE");
  app.add_flag("--check-config", line.check,
               "Print each setting, its value and where it comes from, and exit");
  Options defaults;
  const std::vector<Setting> all = settings(defaults);
  // Texts for all options, because CLI11 takes a second to compile for each type.  `configure`
  // parses them as it parses the environment and the file.
  std::map<std::string, std::vector<std::string>> texts;
  std::map<std::string, bool> switches;
  for (const Setting& setting : all) {
    const std::string flag = flag_name(setting);
    if (std::holds_alternative<Switch>(setting.value)) {
      app.add_flag(flag, switches[setting.name], setting.help);
      continue;
    }
    CLI::Option* option = app.add_option(flag, texts[setting.name], setting.help)
                              ->type_name(setting.type)
                              ->expected(1)
                              ->default_str(text_of(setting));
    if (std::holds_alternative<Texts>(setting.value)) {
      option->take_all();
    } else {
      option->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    }
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {
      line.exit_status = app.exit(e);  // --help, --version
    } else {
      fmt::print(stderr, "lucernad: {}\nlucernad --help lists the options\n", e.what());
      line.exit_status = 2;
    }
    return line;
  }
  for (const Setting& setting : all) {
    if (app.count(flag_name(setting)) == 0) continue;
    line.given.flags[setting.name] =
        std::holds_alternative<Switch>(setting.value)
            ? std::vector<std::string>{switches[setting.name] ? "true" : "false"}
            : texts[setting.name];
  }
  return line;
}

}  // namespace lucerna::config
