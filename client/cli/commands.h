// The commands of lucerna.
#pragma once

namespace CLI {
class App;
}

namespace lucerna::cli {

class Session;

/// The program lucerna.  Returns the exit status.
int run_lucerna(int argc, char** argv);

// One function for each group of commands.
void add_scene_commands(CLI::App& app, Session& session);  // load scenes scene lights ...
void add_edit_command(CLI::App& app, Session& session);
void add_light_commands(CLI::App& app, Session& session);  // sample pdf
void add_power_command(CLI::App& app, Session& session);
void add_emission_commands(CLI::App& app, Session& session);  // emit emit-pdf le
void add_receiver_commands(CLI::App& app, Session& session);  // visible irradiance
void add_render_command(CLI::App& app, Session& session);     // render
/// Adds tradeoff to the list of commands.
void add_tradeoff_command(CLI::App& app);
/// If the command is tradeoff, replaces this process by lucerna-tradeoff, with all other arguments.
/// Ends the program with a message if lucerna-tradeoff is not in the folder of this program.
void start_tradeoff(const CLI::App& app, int argc, char** argv);

}  // namespace lucerna::cli
