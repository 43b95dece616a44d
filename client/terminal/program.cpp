#include "client/terminal/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <vector>

#include "client/terminal/completion.h"
#include "client/terminal/print.h"
#include "client/terminal/suggestion.h"

namespace lucerna::cli {
namespace {

bool is_option(const std::string& word) { return word.size() > 1 && word.starts_with('-'); }

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::string unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  const std::string nearest = nearest_word(word, names);
  return fmt::format("no command {}{}", word,
                     nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest));
}

std::string unknown_words(const CLI::App& app, const CLI::App& command,
                          const std::vector<std::string>& words) {
  std::vector<std::string> known = options_of(command);
  const std::vector<std::string> common = options_of(app);
  known.insert(known.end(), common.begin(), common.end());
  std::string text = fmt::format("unexpected: {}", fmt::join(words, " "));
  const auto option = std::find_if(words.begin(), words.end(), is_option);
  if (option == words.end()) return text;
  const std::string nearest = nearest_word(option->substr(0, option->find('=')), known);
  return nearest.empty() ? text : fmt::format("{}; did you mean {}?", text, nearest);
}

/// The scenes that the server of `words` can load, for completion.  None if it does not answer at
/// once.
std::vector<std::string> scene_names(const std::vector<std::string>& words) {
  // Without a time-out, a server that hangs would block the shell.
  std::vector<std::string> reversed = {"1", "--timeout"};
  reversed.insert(reversed.begin(), words.rbegin() + 1, words.rend());
  const std::atomic<int> no_signal = 0;
  Session session({}, no_signal);
  CLI::App options;
  session.add_options(options);
  options.allow_extras();
  try {
    options.parse(std::move(reversed));
    const v1::ListAvailableScenesResponse scenes = list_available_scenes(session);
    return {scenes.paths().begin(), scenes.paths().end()};
  } catch (const std::exception&) {
    return {};
  }
}

/// Moves `--output table|json|csv` before the command.  Some commands have an option --output of
/// their own, whose value is the name of a file with an ending.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc), first;
  const auto is_form = [](std::string_view word) {
    return word == "table" || word == "json" || word == "csv";
  };
  for (auto word = words.begin(); word != words.end() && *word != "--";) {
    constexpr std::string_view kOutput = "--output";
    const auto next = word + 1;
    if (*word == kOutput && next != words.end() && is_form(*next)) {
      first.insert(first.end(), {*word, *next});
      word = words.erase(word, next + 1);
    } else if (word->starts_with("--output=") && is_form(word->substr(kOutput.size() + 1))) {
      first.push_back(*word);
      word = words.erase(word);
    } else {
      ++word;
    }
  }
  first.insert(first.end(), words.begin(), words.end());
  return first;
}

}  // namespace

std::string describe(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> words = app.remaining(true);
  const std::vector<CLI::App*> commands = app.get_subcommands();
  const CLI::App& command = commands.empty() ? app : *commands.front();
  std::string name = app.get_name();
  if (&command != &app) name += " " + command.get_name();
  // A missing argument is often a misspelt one, so name the unknown words first.
  const bool may_be_misspelt = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
                               dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  std::string text = error.what();
  if (words.empty() && commands.empty() && may_be_misspelt) text = "a command is required";
  if (!words.empty() && may_be_misspelt) {
    text = commands.empty() && !is_option(words[0]) ? unknown_command(app, words[0])
                                                    : unknown_words(app, command, words);
  }
  return fmt::format("{} {} --help", text.ends_with('?') ? text + " See" : text + "; see", name);
}

int run_program(CLI::App& app, Session& session, int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == shell::kCompleteWord) {
    const std::vector<std::string> words(argv + 2, argv + argc);
    const auto scenes = [&words] { return scene_names(words); };
    shell::print_text(stdout, "{}", shell::to_lines(shell::complete(app, words, scenes)));
    return kDone;
  }
  std::vector<std::string> words = words_of(argc, argv);
  // --json may come after the word that cannot be parsed.
  const bool json = std::find(words.begin(), words.end(), "--json") != words.end();
  const auto has_json = [&] { return session.json() || json; };
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // as CLI11 takes them
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error);  // prints the help or the version
      return kDone;
    }
    print_error(absl::InvalidArgumentError(describe(app, error)), has_json());
    return kWrongUse;
  } catch (const CommandError& error) {
    print_error(error.status(), session.json());
    return error.exit_status();
  } catch (const std::exception& error) {
    print_error(absl::InternalError(error.what()), session.json());
    return kServerRefused;
  }
  if (std::fflush(stdout) != 0) {
    print_error(absl::UnknownError("cannot write to standard output"), session.json());
    return kWrongUse;
  }
  return session.exit_status();
}

CLI::App* add_command(CLI::App& app, const char* name, const char* what, const char* argument,
                      const char* argument_what, const char* example,
                      std::function<void(const std::string&)> run) {
  CLI::App* command = app.add_subcommand(name, what);
  command->footer(fmt::format("Example:\n  {}", example));
  const auto value = std::make_shared<std::string>();
  if (argument != nullptr) command->add_option(argument, *value, argument_what)->required();
  command->callback([value, run = std::move(run)] { run(*value); });
  return command;
}

}  // namespace lucerna::cli
