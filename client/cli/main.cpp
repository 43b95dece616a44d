// lucerna: asks a lucernad from the command line.
#include <fmt/core.h>

#include <cstdio>
#include <exception>

#include "client/terminal/session.h"
#include "client/terminal/signals.h"

namespace {

int run(int argc, char** argv) {
  lucerna::cli::Session session(lucerna::cli::stop_on_signals(), lucerna::cli::first_signal());
  CLI::App app(
      "Asks a lucernad about light.\n"
      "A SCENE is a path under the server's scene root, or the id (or its first digits) of one "
      "that "
      "is loaded.",
      "lucerna");
  app.set_version_flag("--version", "lucerna " LUCERNA_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(
      "Example:\n  lucerna irradiance room.pbrt --point 0,0,0 --normal 0,0,1\n"
      "Exit status: 0; 1 the server said no; 2 wrong use; 130 or 143 interrupted (128 + the "
      "signal).");
  session.add_options(app);
  lucerna::cli::add_scene_commands(app, session);
  lucerna::cli::add_light_commands(app, session);
  lucerna::cli::add_power_command(app, session);
  lucerna::cli::add_emission_commands(app, session);
  lucerna::cli::add_receiver_commands(app, session);
  lucerna::cli::add_render_command(app, session);
  lucerna::cli::add_tradeoff_command(app);
  try {
    lucerna::cli::start_tradeoff(app, argc, argv);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // CLI11 would only say that a subcommand is required.
    if (error.get_exit_code() != 0 && app.get_subcommands().empty() && !app.remaining().empty()) {
      fmt::print(stderr, "lucerna: no subcommand {}; see lucerna --help\n", app.remaining()[0]);
      return lucerna::cli::kWrongUse;
    }
    return app.exit(error) == 0 ? lucerna::cli::kDone : lucerna::cli::kWrongUse;
  } catch (const lucerna::cli::CommandError& error) {
    fmt::print(stderr, "lucerna: {}\n", error.what());
    return error.status();
  }
  if (std::fflush(stdout) != 0) return lucerna::cli::kWrongUse;
  return session.exit_status();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "lucerna: {}\n", error.what());
    return lucerna::cli::kServerSaidNo;
  }
}
