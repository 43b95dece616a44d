#include "client/testing/local_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::LocalServer;
using ::testing::MatchesRegex;

TEST(LocalServer, ServesOnAFreePortAndStops) {
  auto first = LocalServer::start();
  ASSERT_TRUE(first.ok()) << first.status();
  auto second = LocalServer::start();
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_THAT(first->target(), MatchesRegex("127\\.0\\.0\\.1:[0-9]+"));
  EXPECT_NE(first->target(), second->target());
  EXPECT_TRUE(first->client().get_server_info().ok());
  const int process = first->process_id();
  EXPECT_EQ(first->stop(), 0);
  EXPECT_EQ(first->stop(), 0);
  EXPECT_EQ(::kill(process, 0), -1);
  EXPECT_EQ(errno, ESRCH);
  EXPECT_TRUE(second->client().get_server_info().ok());
}

TEST(LocalServer, EndsWithItsObject) {
  int process = 0;
  {
    auto server = LocalServer::start();
    ASSERT_TRUE(server.ok()) << server.status();
    process = server->process_id();
    EXPECT_EQ(::kill(process, 0), 0);
  }
  EXPECT_EQ(::kill(process, 0), -1);
}

TEST(LocalServer, LoadsItsScenesBeforeItServes) {
  const auto server = LocalServer::start(
      {.scene_root = test_data("reference"), .load = {"point.pbrt", "spot.pbrt"}});
  ASSERT_TRUE(server.ok()) << server.status();
  const auto scenes = server->client().list_scenes({});
  ASSERT_TRUE(scenes.ok()) << scenes.status();
  EXPECT_EQ(scenes->scenes_size(), 2);
}

TEST(LocalServer, ReportsTheStderrOfAServerThatDoesNotStart) {
  const auto server = LocalServer::start({.scene_root = "/no/such/directory"});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("/no/such/directory"));
}

/// Sets the environment variable LUCERNAD, or removes it, until its end.
class Lucernad {
 public:
  explicit Lucernad(const char* value) {
    if (const char* before = std::getenv("LUCERNAD")) before_ = before;
    set(value);
  }
  ~Lucernad() { set(before_ ? before_->c_str() : nullptr); }
  Lucernad(const Lucernad&) = delete;
  Lucernad& operator=(const Lucernad&) = delete;

 private:
  static void set(const char* value) {
    value != nullptr ? ::setenv("LUCERNAD", value, 1) : ::unsetenv("LUCERNAD");
  }
  std::optional<std::string> before_;
};

TEST(LocalServer, ReportsThePathOfAMissingProgram) {
  const Lucernad none(nullptr);
  const auto server = LocalServer::start({.program = "/no/such/lucernad"});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("\"/no/such/lucernad\""));
}

TEST(LocalServer, EnvironmentVariableHasPriorityOverTheOption) {
  const Lucernad other("/no/such/program");
  const auto server = LocalServer::start({.program = "/no/such/lucernad"});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("environment variable LUCERNAD"));
}

/// A script of the test in the place of lucernad.
class Impostor : public ::testing::Test {
 protected:
  std::string script(const std::string& text) const {
    const std::string path = (directory_ / "program").string();
    std::ofstream(path) << "#!/bin/sh\n" << text << '\n';
    ::chmod(path.c_str(), 0755);
    return path;
  }
  /// A command of the shell that waits for ever.  It starts no other program: until a child of the
  /// shell runs its own, it has the shell's command line.
  std::string wait_for_ever() const {
    const std::string path = (directory_ / "silent").string();
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    return "read -r line < " + path;
  }
  /// The ids of all processes that run a script of this test.
  std::vector<std::string> processes() const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      // A process may end while its file is read.  The stream operator then stops without an
      // exception.
      std::ostringstream line;
      line << std::ifstream(entry.path() / "cmdline", std::ios::binary).rdbuf();
      if (line.str().find(directory_.string()) != std::string::npos)
        found.push_back(entry.path().filename());
    }
    return found;
  }

  const Lucernad none_{nullptr};  // it would have priority over the script
  const TempDirectory temp_;
  const std::filesystem::path& directory_ = temp_.path();
};

TEST_F(Impostor, ThatEndsAtOnceIsReported) {
  const auto server = LocalServer::start({.program = script("echo out of cheese >&2; exit 3")});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("exit status 3"));
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("out of cheese"));
}

TEST_F(Impostor, ThatNeverServesIsStopped) {
  const auto server =
      LocalServer::start({.program = script(wait_for_ever()), .patience = std::chrono::seconds(2)});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_THAT(processes(), ::testing::IsEmpty());
}

TEST_F(Impostor, ThatIgnoresSigtermIsKilled) {
  const auto server = LocalServer::start(
      {.program = script("trap '' TERM; " + wait_for_ever()), .patience = std::chrono::seconds(2)});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_THAT(processes(), ::testing::IsEmpty());
}

}  // namespace
}  // namespace lucerna
