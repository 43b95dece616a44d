// The command conformance.
#pragma once

namespace CLI {
class App;
}

namespace lucerna::cli {

class Session;

void add_conformance_command(CLI::App& app, Session& session);

}  // namespace lucerna::cli
