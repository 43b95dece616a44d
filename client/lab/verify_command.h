// The command `lucerna verify`.
#pragma once

namespace CLI {
class App;
}

namespace lucerna::cli {

class Session;

/// Adds verify.
void add_verify_command(CLI::App& app, Session& session);

}  // namespace lucerna::cli
