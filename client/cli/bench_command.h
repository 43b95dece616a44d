// The command `lucerna bench`.
#pragma once

namespace CLI {
class App;
}

namespace lucerna::cli {

class Session;

/// Adds bench.
void add_bench_command(CLI::App& app, Session& session);

}  // namespace lucerna::cli
