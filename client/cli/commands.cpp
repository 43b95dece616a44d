#include "client/cli/commands.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "client/cli/admin_commands.h"
#include "client/cli/bench_command.h"
#include "client/lab/conformance_command.h"
#include "client/lab/verify_command.h"
#include "client/terminal/error.h"
#include "client/terminal/program.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_signals.h"

namespace lucerna::cli {

int run_lucerna(int argc, char** argv) {
  Session session(stop_on_signals(), first_signal());
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
  add_scene_commands(app, session);
  add_lease_commands(app, session);
  add_info_command(app, session);
  add_edit_command(app, session);
  add_light_commands(app, session);
  add_power_command(app, session);
  add_emission_commands(app, session);
  add_receiver_commands(app, session);
  add_render_command(app, session);
  add_top_command(app, session);
  add_doctor_command(app, session);
  add_bench_command(app, session);
  add_verify_command(app, session);
  add_conformance_command(app, session);
  add_tradeoff_command(app);
  try {
    start_tradeoff(app, argc, argv);
  } catch (const CommandError& error) {
    print_error(error.status(), false);
    return error.exit_status();
  }
  return run_program(app, session, argc, argv);
}

}  // namespace lucerna::cli
