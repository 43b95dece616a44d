// The common part of all commands: options, the connection to the server, and errors that end the
// program.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>

#include "client/terminal/error.h"
#include "client/terminal/load_options.h"
#include "client/terminal/output.h"
#include "client/terminal/remarks.h"
#include "client/terminal/server_address.h"
#include "lucerna/client/client.h"
#include "lucerna/client/query_servers.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

/// The options of all commands, and the connection to the server of --server.  For queries about a
/// scene, --server may name several servers, any of which can answer.
class Session {
 public:
  /// A request to stop ends every call.  `signal` is the number of the signal that caused it, and
  /// must outlive the session.
  Session(std::stop_token stop, const std::atomic<int>& signal)
      : stop_(std::move(stop)), signal_(signal) {}

  /// Adds --server, --allow-mixed, --timeout, --output, --json, --strict and the options of
  /// BlenderOption, EditOption and SecurityOptions.  They may come before or after the command.
  void add_options(CLI::App& app);

  /// The form of the answer.  With CSV, the program prints one table and nothing else.
  bool json() const { return json_ || output_ == "json"; }
  bool csv() const { return !json() && output_ == "csv"; }
  /// Declares that the command prints a table, so that it may be CSV.
  void prints_table(const CLI::App& command) { table_commands_.insert(&command); }
  /// Prints the table, and then the notes for people.  As CSV, only the table.
  void show(const Table& table, const std::string& notes = {}) const;
  /// The address or the list of --server; each host has a port.
  const std::string& server() const { return server_; }
  /// Of the scene files that this command loads.
  std::optional<v1::BlenderLevels> blender() const { return blender_.levels(); }
  /// TLS and token of all servers.
  client::Security security() const { return security_.security(); }
  /// Of the scene files that this command loads.  Ends the program for wrong options.
  EditOption::Edits edits() const;
  const EditOption& edit_option() const { return edit_; }
  /// Whether servers of different numeric fingerprints may share work.
  bool allow_mixed() const { return allow_mixed_; }
  /// Connects at the first use.  If --server names several servers, scene_id() must be called
  /// first.  Otherwise this ends the program, since the command is for one server.
  const client::Client& client();
  /// Ends the program if --server names several servers.  `what` is the reason in the error
  /// message.
  void need_one_server(const std::string& what) const;
  /// All calls of one run share the deadline.
  const client::CallOptions& call_options();

  /// Returns the response.  An error ends the program with the server's message.
  template <class Response>
  Response value_or_fail(absl::StatusOr<Response> response) {
    if (!response.ok()) fail(response.status());
    return *std::move(response);
  }
  /// The same for `call`, a function of the client that sends a query about the scene of
  /// scene_id().  With several servers, loads the scene again on a server that lost it, and repeats
  /// the call.
  template <class Call>
  auto query_scene(const Call& call) {
    return servers_ ? value_or_fail(servers_->query(call)) : value_or_fail(call(client()));
  }
  /// Ends the program with an error that a server reported.
  [[noreturn]] void fail(const absl::Status& status) const;
  /// Ends the program with an error of this machine, whose message stays unchanged.
  [[noreturn]] void fail_here(const absl::Status& status, ExitStatus exit) const;

  /// The id of `scene`.  `scene` is an id, the first digits (4 or more) of the id of a loaded
  /// scene, or a path.  Loads a path on each server that has not loaded it, and prints the new
  /// remarks to stderr.
  std::string scene_id(const std::string& scene);
  /// The same without the edits of the options.
  std::string unedited_scene_id(const std::string& scene);
  /// The same for a query about light.  Also keeps the scene's remarks for print_remarks().
  std::string query_scene_id(const std::string& scene);

  using Remarks = google::protobuf::RepeatedPtrField<v1::Remark>;
  /// Keeps the remarks for print_remarks().  With --strict, any remark is FAILED_PRECONDITION, with
  /// the name `scene` in the message.  Thread-safe.
  absl::Status note_remarks(const std::string& scene, const Remarks& remarks);
  /// Prints the last line of an answer, which counts the remarks.  Prints nothing for a scene
  /// without remarks, and as CSV.
  void print_remarks() const;

  /// Whether the scene that the session queried last has remarks.  False as CSV, for which they are
  /// not read.
  bool has_remarks() const {
    const std::lock_guard lock(remarks_mutex_);
    return !remarks_line_.empty();
  }

  /// Sets the exit status of a run without errors.
  void set_exit_status(ExitStatus status) { exit_status_ = status; }
  ExitStatus exit_status() const { return exit_status_; }

 private:
  bool several() const;
  /// Loads `scene` on all servers.
  void connect_to_all(const std::string& scene);
  void fail_if_ended(const absl::Status& status) const;

  std::string server_ = "127.0.0.1:50051";
  std::optional<double> timeout_s_;
  bool json_ = false;
  std::string output_ = "table";
  std::set<const CLI::App*> table_commands_;
  bool strict_ = false;
  BlenderOption blender_;
  SecurityOptions security_;
  EditOption edit_;
  bool edits_at_load_ = true;
  std::stop_token stop_;
  const std::atomic<int>& signal_;
  bool allow_mixed_ = false;
  std::optional<client::Client> client_;
  std::optional<client::QueryServers> servers_;
  std::optional<client::CallOptions> call_options_;
  ExitStatus exit_status_ = kDone;
  std::optional<Remarks> loaded_remarks_;  // of the last scene that scene_id() loaded
  mutable std::mutex remarks_mutex_;
  std::string remarks_line_;  // guarded by remarks_mutex_; empty without remarks
};

/// Loads a scene file.  `lease_s`: see LoadSceneRequest.
v1::LoadSceneResponse load_scene(Session& session, const std::string& path, double lease_s = 0);
/// The request to load the file `path`, with the session's Blender levels and edits.
v1::LoadSceneRequest load_request(const Session& session, const std::string& path, double lease_s);
/// All loaded scenes, from all pages.
v1::ListScenesResponse list_scenes(Session& session);
/// All scene files that the server can load, from all pages.
v1::ListAvailableScenesResponse list_available_scenes(Session& session);
/// All lights of a scene, from all pages.
v1::ListLightsResponse list_lights(Session& session, const std::string& scene_id);

/// Units of the illuminances of a scene.
struct IlluminanceUnits {
  /// Of a sum over lights: "lx", another one such as "mW/m2", or "mixed".
  std::string sum = "lx";
  /// Of the light of each light; empty if all are in lx.
  std::map<std::uint64_t, std::string> lights;
};
/// Of the scene that the session queried last.  It lists the lights unless the scene has no
/// remarks: a light in another unit than lm has one.
IlluminanceUnits illuminance_units(Session& session, const std::string& scene_id);

/// Help of the argument SCENE.
inline constexpr char kSceneHelp[] =
    "A path under the scene root, the name of an uploaded scene, an id, or the first digits of an "
    "id";

}  // namespace lucerna::cli
