// The command tradeoff: starts the program lucerna-tradeoff, which is in the folder of this
// program.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <vector>

#include "client/cli/commands.h"
#include "client/terminal/completion.h"
#include "client/terminal/session.h"

namespace lucerna::cli {
namespace {

constexpr std::string_view kCommand = "tradeoff";

/// The index of the first word from `begin` that is neither an option before the command nor its
/// value; `argc` if there is none.
int command_index(const CLI::App& app, int begin, int argc, char** argv) {
  for (int i = begin; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (!word.starts_with('-')) return i;
    const CLI::Option* option = app.get_option_no_throw(std::string(word));
    if (option != nullptr && option->get_items_expected_min() > 0) ++i;
  }
  return argc;
}

}  // namespace

void add_tradeoff_command(CLI::App& app) {
  app.add_subcommand(std::string(kCommand),
                     "Measures error against time of every sampling method; runs the program "
                     "lucerna-tradeoff");
}

void start_tradeoff(const CLI::App& app, int argc, char** argv) {
  // lucerna-tradeoff also completes its options.  A word that is not finished is no command yet.
  const bool completes = argc > 1 && std::string_view(argv[1]) == shell::kCompleteWord;
  const int index = command_index(app, completes ? 2 : 1, argc, argv);
  if (index == argc || argv[index] != kCommand || (completes && index + 1 == argc)) return;
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) wrong_use("cannot find the folder of this program: " + error.message());
  std::string program = (here.parent_path() / "lucerna-tradeoff").string();
  std::vector<char*> arguments = {program.data()};
  for (int i = 1; i < argc; ++i)
    if (i != index) arguments.push_back(argv[i]);
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  wrong_use(fmt::format(
      "cannot start {}: {}; build the target lucerna-tradeoff, or install it beside lucerna",
      program, std::strerror(errno)));
}

}  // namespace lucerna::cli
