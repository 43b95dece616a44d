// The commands for those who look after a server.
#pragma once

namespace CLI {
class App;
}

namespace lucerna::cli {

class Session;

void add_lease_commands(CLI::App& app, Session& session);  // lease leases release
void add_info_command(CLI::App& app, Session& session);
void add_top_command(CLI::App& app, Session& session);
void add_doctor_command(CLI::App& app, Session& session);

}  // namespace lucerna::cli
