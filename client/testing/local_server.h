// Starts a private lucernad for integration tests and other programs, on a free port of the
// loopback interface.  local_server_test.h has a GoogleTest fixture.
//
//     auto server = lucerna::testing::LocalServer::start({.scene_root = "scenes"});
//     if (!server.ok()) return server.status();
//     server->client().load_scene(...);
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "lucerna/client/client.h"

// The CMake target lucerna::testing sets this to the program of the same installation.
#ifndef LUCERNA_LUCERNAD
#define LUCERNA_LUCERNAD ""
#endif

namespace lucerna::testing {

struct LocalServerOptions {
  /// Directory of the scene files; LoadScene's paths are relative to it.
  std::string scene_root = ".";
  /// Compute threads; 0 is the server's default.
  unsigned threads = 0;
  /// Scene files to load before the server accepts calls, relative to `scene_root`.
  std::vector<std::string> load = {};
  /// Port on 127.0.0.1; 0 is any free port.
  int port = 0;
  /// Further arguments of lucernad, one word each.
  std::vector<std::string> arguments = {};
  /// The program.  The environment variable LUCERNAD has priority.
  std::string program = LUCERNA_LUCERNAD;
  /// Time limit for the start, and for the end after SIGTERM.  After it, the server is killed.
  std::chrono::seconds patience{30};
};

/// A running lucernad, a child of this process.
///
/// Not thread-safe.  The child ends when the *thread* that started it ends (prctl(2),
/// PR_SET_PDEATHSIG).  So that thread must live as long as the server is needed.
class LocalServer {
 public:
  /// Returns when the server reports over grpc.health.v1 that it is serving.  NOT_FOUND if there is
  /// no program; UNAVAILABLE if the server ended, DEADLINE_EXCEEDED if it is not serving in time.
  /// The last two messages contain the server's stderr.
  static absl::StatusOr<LocalServer> start(const LocalServerOptions& options = {});
  LocalServer(LocalServer&&) noexcept;
  LocalServer& operator=(LocalServer&&) noexcept;
  /// Stops the server.
  ~LocalServer();

  /// "127.0.0.1:PORT".
  const std::string& target() const;
  /// Connected to the server; valid while the server runs.
  const client::Client& client() const;
  int process_id() const;
  /// The server's stderr so far.
  std::string log() const;

  /// Sends SIGTERM and waits; kills the server if it does not end within `patience`.  Returns the
  /// exit status, or 128 + signal if a signal ended the server.  Later calls return the same.
  int stop();

 private:
  class Process;
  explicit LocalServer(std::unique_ptr<Process> process);

  std::unique_ptr<Process> process_;
};

}  // namespace lucerna::testing
