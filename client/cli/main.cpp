// lucerna: queries lucernad from the command line.
#include <fmt/core.h>

#include <cstdio>
#include <exception>

#include "client/terminal/program.h"
#include "client/terminal/session.h"
#include "client/terminal/signals.h"

namespace {

int run(int argc, char** argv) {
  lucerna::cli::Session session(lucerna::cli::stop_on_signals(), lucerna::cli::first_signal());
  CLI::App app(
      "Queries a lighting server, lucernad.\n"
      "A SCENE is a path under the scene root of the server, the id of a loaded scene, or the "
      "first digits of an id.",
      "lucerna");
  app.set_version_flag("--version", "lucerna " LUCERNA_VERSION, "Print the version and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(
      "Example:\n  lucerna irradiance room.pbrt --point 0,0,0 --normal 0,0,1\n"
      "Exit status: 0 done; 1 the server refused, cannot be reached, or has no answer for some "
      "point; 2 wrong use; 130 or 143 "
      "interrupted (128 + the signal).");
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
  } catch (const lucerna::cli::CommandError& error) {
    fmt::print(stderr, "lucerna: {}\n", error.what());
    return error.exit_status();
  }
  return lucerna::cli::run_program(app, session, argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "lucerna: {}\n", error.what());
    return lucerna::cli::kServerRefused;
  }
}
