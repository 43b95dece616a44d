// What all subcommands share: the options before them, the connection, how an error ends the
// program.
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "lucerna/client/client.h"
#include "lucerna/client/query_servers.h"

namespace lucerna::cli {

/// Exit statuses of the program.
enum ExitStatus : int {
  kDone = 0,
  kServerSaidNo = 1,  ///< or it cannot be reached, or an item has no answer
  kWrongUse = 2,      ///< flags, numbers or files that cannot be taken
  kSignal = 128,      ///< and the number of the signal that interrupted it, as shells tell it
};

/// Ends the program with a message.
class CommandError : public std::runtime_error {
 public:
  CommandError(ExitStatus status, const std::string& message)
      : std::runtime_error(message), status_(status) {}
  ExitStatus status() const { return status_; }

 private:
  ExitStatus status_;
};

[[noreturn]] void wrong_use(const std::string& message);

/// Common options, and the server that they name; or the servers, for questions about a scene,
/// which any of them can answer.
class Session {
 public:
  /// `signal` is which one it was by the time that `stop` is requested, and outlives the session.
  Session(std::stop_token stop, const std::atomic<int>& signal)
      : stop_(std::move(stop)), signal_(signal) {}

  /// --server, --allow-mixed, --timeout and --json, which may stand before or after the subcommand.
  void add_options(CLI::App& app);

  bool json() const { return json_; }
  const std::string& server() const { return server_; }
  /// Whether servers of different numeric fingerprints may share work.
  bool allow_mixed() const { return allow_mixed_; }
  /// Connects at the first use.  Where --server names several, ends the program unless scene_id()
  /// was asked before: what is not about a scene is about one server.
  const client::Client& client();
  /// Ends the program where --server names several: `what` is for one.
  void need_one_server(const std::string& what) const;
  /// The deadline is the same for all calls of one run.
  const client::CallOptions& call_options();

  /// The answer, or the end of the program with what the server said.
  template <class Response>
  Response ask(absl::StatusOr<Response> response) {
    if (!response.ok()) fail(response.status());
    return *std::move(response);
  }
  /// The same for a question about the scene of scene_id(), a function of the client; where
  /// several servers are asked it is asked again of one that lost the scene.
  template <class Ask>
  auto ask_about_scene(const Ask& question) {
    return servers_ ? ask(servers_->query(question)) : ask(question(client()));
  }
  [[noreturn]] void fail(const absl::Status& status) const;
  /// Where it is not one server that says it: `exit` with the message as it is.
  [[noreturn]] void fail_here(const absl::Status& status, ExitStatus exit) const;

  /// The id that `scene` stands for: an id; a prefix, of four digits or more, of one that is
  /// loaded; or a path, which is loaded where it is not yet, on each of the servers, with what is
  /// not modelled told on stderr.
  std::string scene_id(const std::string& scene);

  /// What the program ends with where nothing fails.
  void set_exit_status(ExitStatus status) { exit_status_ = status; }
  ExitStatus exit_status() const { return exit_status_; }

 private:
  bool several() const;
  /// Readies all servers for `scene`.
  void connect_to_all(const std::string& scene);
  void fail_if_ended(const absl::Status& status) const;

  std::string server_ = "127.0.0.1:50051";
  std::optional<double> timeout_s_;
  bool json_ = false;
  std::stop_token stop_;
  const std::atomic<int>& signal_;
  bool allow_mixed_ = false;
  std::optional<client::Client> client_;
  std::optional<client::QueryServers> servers_;
  std::optional<client::CallOptions> call_options_;
  ExitStatus exit_status_ = kDone;
};

/// The scene file of `load`; every scene there is.
v1::LoadSceneResponse load_scene(Session& session, const std::string& path, double lease_s = 0);
v1::ListScenesResponse list_scenes(Session& session);
/// Every light of a scene, from all pages.
v1::ListLightsResponse list_lights(Session& session, const std::string& scene_id);
/// "file:line:column: what; instead"
std::string describe(const v1::Remark& remark);

// One function a family of subcommands.
void add_scene_commands(CLI::App& app, Session& session);  // load scenes scene lights ...
void add_light_commands(CLI::App& app, Session& session);  // sample pdf
void add_power_command(CLI::App& app, Session& session);
void add_emission_commands(CLI::App& app, Session& session);  // emit emit-pdf le
void add_receiver_commands(CLI::App& app, Session& session);  // visible irradiance
void add_render_command(CLI::App& app, Session& session);     // render
/// Lists tradeoff among the commands.
void add_tradeoff_command(CLI::App& app);
/// Replaces this process by lucerna-tradeoff, with all other arguments, if the command is tradeoff.
/// Ends the program with a message if lucerna-tradeoff is not beside this program.
void start_tradeoff(const CLI::App& app, int argc, char** argv);

}  // namespace lucerna::cli
