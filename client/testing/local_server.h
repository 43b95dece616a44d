// A lucernad of one's own for integration tests: on a free port of the loopback interface, gone
// when the test is.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "lucerna/client/client.h"

// Set by the CMake target lucerna::testing: the program of the same build or installation.
#ifndef LUCERNA_LUCERNAD
#define LUCERNA_LUCERNAD ""
#endif

namespace lucerna::testing {

struct LocalServerOptions {
  /// Directory that LoadScene's paths are relative to.
  std::string scene_root = ".";
  /// Compute threads; 0: the server's default.
  unsigned threads = 0;
  /// Scene files to load before it serves, relative to `scene_root`.
  std::vector<std::string> load = {};
  /// The port of 127.0.0.1 to listen at; 0: a free one.
  int port = 0;
  /// More of lucernad's options, each a word of its own.
  std::vector<std::string> arguments = {};
  /// The program.  The environment variable LUCERNAD goes before it.
  std::string program = LUCERNA_LUCERNAD;
  /// How long it may take until it serves, and to end after SIGTERM before it is killed.
  std::chrono::seconds patience{30};
};

/// A running lucernad, a child of this process.
///
/// Not thread-safe.  The child ends with the *thread* that started it, however that ends, so start
/// it in one that lives as long as it is needed (prctl(2), PR_SET_PDEATHSIG).
class LocalServer {
 public:
  /// Comes back when the server says over grpc.health.v1 that it serves.  NOT_FOUND where there is
  /// no program; UNAVAILABLE or DEADLINE_EXCEEDED, with what the server wrote to stderr, where it
  /// ended or does not serve in time.
  static absl::StatusOr<LocalServer> start(const LocalServerOptions& options = {});
  LocalServer(LocalServer&&) noexcept;
  LocalServer& operator=(LocalServer&&) noexcept;
  /// Stops it.
  ~LocalServer();

  /// "127.0.0.1:PORT".
  const std::string& target() const;
  /// Connected to it; valid for as long as it runs.
  const client::Client& client() const;
  int process_id() const;
  /// What it has written to stderr so far.
  std::string log() const;

  /// Asks it to end (SIGTERM) and waits; kills it where it does not within `patience`.
  /// Its exit status; 128 + signal where a signal ended it.  Again: the same answer.
  int stop();

 private:
  class Process;
  explicit LocalServer(std::unique_ptr<Process> process);

  std::unique_ptr<Process> process_;
};

/// A GoogleTest fixture: each test has a server of its own.
///
///     class MyTest : public lucerna::testing::LocalServerTest {
///       LocalServerOptions options() const override { return {.scene_root = "scenes"}; }
///     };
class LocalServerTest : public ::testing::Test {
 protected:
  virtual LocalServerOptions options() const { return {}; }

  /// Fails the test where the server does not start.
  void SetUp() override;
  void TearDown() override { server_.reset(); }

  LocalServer& server() { return *server_; }
  const client::Client& client() const { return server_->client(); }

 private:
  std::optional<LocalServer> server_;
};

}  // namespace lucerna::testing
