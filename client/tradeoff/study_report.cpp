#include "client/tradeoff/study_report.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "absl/strings/str_replace.h"

namespace lucerna::tradeoff {
namespace {

/// The URL of a local file.  Escapes bytes that have another meaning in a URL.
std::string file_url(const std::string& path) {
  std::string url = "file://";
  for (const char c : std::filesystem::absolute(path).string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = std::isalnum(byte) != 0 || std::strchr("/._-~", c) != nullptr;
    url += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return url;
}

/// Runs a program from PATH and drops its output.  Returns its exit status; nothing if it cannot be
/// started.
std::optional<int> run_quietly(std::vector<std::string> arguments) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int out : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, out, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  int status = 0;
  if (error != 0 || ::waitpid(child, &status, 0) != child) return std::nullopt;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

absl::StatusOr<std::string> report_page(std::string_view json) {
  auto data = nlohmann::ordered_json::parse(json, nullptr, false);
  if (!data.is_object() || data.value("lucerna_tradeoff", nlohmann::ordered_json()) != 1)
    return absl::InvalidArgumentError("is not a tradeoff.json of lucerna-tradeoff");
  data.erase("runs");  // the page does not show them
  // In a page, "</script>" and "<!--" have a meaning even inside the strings of a script.
  const std::string text = absl::StrReplaceAll(data.dump(), {{"<", "\\u003c"}});
  return absl::StrReplaceAll(std::string(kPage), {{"{{style}}", std::string(kStyle)},
                                                  {"{{licence}}", std::string(kLicence)},
                                                  {"{{library}}", std::string(kLibrary)},
                                                  {"{{data}}", text},
                                                  {"{{shared}}", std::string(kSharedScript)},
                                                  {"{{plots}}", std::string(kPlotsScript)},
                                                  {"{{page}}", std::string(kPageScript)}});
}

absl::Status draw_plot(const std::string& page, const std::string& picture) {
  const auto status =
      run_quietly({"chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                   "--force-device-scale-factor=1.5", "--window-size=1000,660",
                   "--screenshot=" + std::filesystem::absolute(picture).string(),
                   file_url(page) + "#only=errors"});
  if (!status) return absl::NotFoundError("no chromium in PATH");
  if (*status != 0 || !std::filesystem::exists(picture))
    return absl::UnknownError(
        fmt::format("chromium did not write {} (exit status {})", picture, *status));
  return absl::OkStatus();
}

}  // namespace lucerna::tradeoff
