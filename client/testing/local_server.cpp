#include "client/testing/local_server.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <thread>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna::testing {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kListening[] = "listening on ";
constexpr auto kPause = std::chrono::milliseconds(2);

/// A file in memory.  Unlike a pipe, it never becomes full and blocks the writer.
class Capture {
 public:
  explicit Capture(const char* name) : file_(::memfd_create(name, MFD_CLOEXEC)) {}
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;
  ~Capture() {
    if (file_ >= 0) ::close(file_);
  }

  int file() const { return file_; }
  std::string text() const {
    std::string result;
    char buffer[4096];
    for (;;) {
      const ssize_t count =
          ::pread(file_, buffer, sizeof(buffer), static_cast<off_t>(result.size()));
      if (count <= 0) return result;
      result.append(buffer, static_cast<std::size_t>(count));
    }
  }

 private:
  int file_;
};

absl::StatusOr<std::string> find_program(const LocalServerOptions& options) {
  const char* variable = std::getenv("LUCERNAD");
  const bool from_environment = variable != nullptr && *variable != '\0';
  std::string program = from_environment ? variable : options.program;
  if (::access(program.c_str(), X_OK) == 0 && !std::filesystem::is_directory(program)) {
    return program;
  }
  return absl::NotFoundError("no program lucernad at \"" + program + "\" (from " +
                             (from_environment ? "the environment variable LUCERNAD"
                                               : "LocalServerOptions.program; the environment "
                                                 "variable LUCERNAD has priority") +
                             ")");
}

int exit_code(int wait_status) {
  return WIFSIGNALED(wait_status) ? 128 + WTERMSIG(wait_status) : WEXITSTATUS(wait_status);
}

}  // namespace

class LocalServer::Process {
 public:
  explicit Process(std::chrono::seconds patience) : patience_(patience) {}
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() { stop(); }

  absl::Status spawn(std::vector<std::string> arguments) {
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const pid_t parent = ::getpid();
    id_ = ::fork();
    if (id_ < 0) return failure(std::string("fork: ") + std::strerror(errno));
    if (id_ > 0) return absl::OkStatus();
    // Only async-signal-safe functions between fork and exec: other threads may hold locks.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);  // the parent died before prctl()
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::dup2(output_.file(), STDOUT_FILENO);
    ::dup2(errors_.file(), STDERR_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }

  /// Waits for the line with the port, then until the server serves.
  absl::Status wait_until_serving() {
    const Clock::time_point end = Clock::now() + patience_;
    while (target_.empty()) {
      if (ended()) return failure("it ended with exit status " + std::to_string(*exit_code_));
      if (Clock::now() > end) return failure("it does not print its address", true);
      const std::string text = output_.text();
      const std::size_t at = text.find(kListening);
      const std::size_t line_end = text.find('\n', at == std::string::npos ? 0 : at);
      if (at == std::string::npos || line_end == std::string::npos) {
        std::this_thread::sleep_for(kPause);
        continue;
      }
      const std::size_t begin = at + sizeof(kListening) - 1;
      target_ = text.substr(begin, line_end - begin);
    }
    LUCERNA_ASSIGN_OR_RETURN(auto client, client::Client::connect({.target = target_}));
    client_.emplace(std::move(client));
    for (;;) {
      const absl::Status health = client_->check_health(client::CallOptions::within(patience_));
      if (health.ok()) return absl::OkStatus();
      if (ended()) return failure("it ended with exit status " + std::to_string(*exit_code_));
      if (Clock::now() > end) return failure(std::string(health.message()), true);
      std::this_thread::sleep_for(kPause);
    }
  }

  int stop() {
    if (id_ <= 0) return -1;
    if (!ended()) ::kill(id_, SIGTERM);
    const Clock::time_point end = Clock::now() + patience_;
    while (!ended() && Clock::now() < end) std::this_thread::sleep_for(kPause);
    if (!ended()) {
      ::kill(id_, SIGKILL);
      int status = 0;
      while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
      }
      exit_code_ = exit_code(status);
    }
    return *exit_code_;
  }

  int id() const { return id_; }
  const std::string& target() const { return target_; }
  const client::Client& client() const { return *client_; }
  std::string log() const { return errors_.text(); }

 private:
  bool ended() {
    int status = 0;
    if (!exit_code_ && ::waitpid(id_, &status, WNOHANG) == id_) exit_code_ = exit_code(status);
    return exit_code_.has_value();
  }

  absl::Status failure(const std::string& what, bool too_late = false) const {
    const std::string log = errors_.text();
    const std::string message = "lucernad did not start: " + what +
                                "; its stderr: " + (log.empty() ? std::string("(empty)") : log);
    return too_late ? absl::DeadlineExceededError(message) : absl::UnavailableError(message);
  }

  std::chrono::seconds patience_;
  Capture output_{"lucernad stdout"};
  Capture errors_{"lucernad stderr"};
  pid_t id_ = -1;
  std::optional<int> exit_code_;
  std::string target_;
  std::optional<client::Client> client_;
};

LocalServer::LocalServer(std::unique_ptr<Process> process) : process_(std::move(process)) {}
LocalServer::LocalServer(LocalServer&&) noexcept = default;
LocalServer& LocalServer::operator=(LocalServer&&) noexcept = default;
LocalServer::~LocalServer() = default;

absl::StatusOr<LocalServer> LocalServer::start(const LocalServerOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(const auto program, find_program(options));
  std::vector<std::string> arguments = {program, "--listen",
                                        "127.0.0.1:" + std::to_string(options.port), "--scene-root",
                                        options.scene_root};
  if (options.threads > 0) {
    arguments.insert(arguments.end(), {"--threads", std::to_string(options.threads)});
  }
  for (const std::string& path : options.load) {
    arguments.insert(arguments.end(), {"--load", path});
  }
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  auto process = std::make_unique<Process>(options.patience);
  if (absl::Status status = process->spawn(std::move(arguments)); !status.ok()) return status;
  if (absl::Status status = process->wait_until_serving(); !status.ok()) return status;
  return LocalServer(std::move(process));
}

const std::string& LocalServer::target() const { return process_->target(); }
const client::Client& LocalServer::client() const { return process_->client(); }
int LocalServer::process_id() const { return process_->id(); }
std::string LocalServer::log() const { return process_->log(); }
int LocalServer::stop() { return process_->stop(); }

}  // namespace lucerna::testing
