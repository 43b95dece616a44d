#include "client/terminal/completion.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

namespace lucerna::shell {
namespace {

/// What a description says first: its text before the first semicolon or line.
std::string first_part(const std::string& text) {
  return text.substr(0, text.find_first_of(";\n"));
}

/// The names of a closed set, which its check prints as "{a, b}".  Empty for other values.
std::vector<std::string> closed_set(const std::string& type) {
  std::vector<std::string> names;
  const std::size_t begin = type.find('{');
  const std::size_t end = type.find('}', begin);
  if (end == std::string::npos) return names;
  std::string_view rest = std::string_view(type).substr(begin + 1, end - begin - 1);
  while (!rest.empty()) {
    const std::size_t length = std::min(rest.find(", "), rest.size());
    names.emplace_back(rest.substr(0, length));
    rest.remove_prefix(std::min(length + 2, rest.size()));
  }
  return names;
}

/// The state of the command line before the last word.
struct Before {
  const CLI::App* command = nullptr;   ///< none yet
  const CLI::Option* value = nullptr;  ///< the option whose value comes next
  std::size_t arguments = 0;           ///< of the command, without options
};

const CLI::Option* find_option(const CLI::App& app, const CLI::App* command,
                               const std::string& name) {
  const CLI::Option* option = command != nullptr ? command->get_option_no_throw(name) : nullptr;
  return option != nullptr ? option : app.get_option_no_throw(name);
}

bool has_value(const CLI::Option& option) { return option.get_items_expected_min() > 0; }

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == name) return command;
  }
  return nullptr;
}

Before read(const CLI::App& app, const std::vector<std::string>& words) {
  Before before;
  // A program without commands is a command itself.
  if (app.get_subcommands([](const CLI::App*) { return true; }).empty()) before.command = &app;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string& word = words[i];
    if (before.value != nullptr) {
      before.value = nullptr;
    } else if (word.size() > 1 && word.starts_with('-')) {
      const CLI::Option* option = find_option(app, before.command, word);
      if (option != nullptr && has_value(*option)) before.value = option;
    } else if (before.command == nullptr) {
      before.command = find_command(app, word);
    } else {
      ++before.arguments;
    }
  }
  return before;
}

const CLI::Option* argument(const CLI::App& command, std::size_t index) {
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional()) continue;
    if (index == 0) return option;
    --index;
  }
  return nullptr;
}

class Completion {
 public:
  explicit Completion(std::string prefix) : prefix_(std::move(prefix)) {}

  void add(const std::string& word, const std::string& description) {
    if (word.starts_with(prefix_)) result_.words.push_back({word, first_part(description)});
  }

  void add_options(const CLI::App& app) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames())
        add("--" + name, option->get_description());
      // One letter says little beside a long name.
      if (!option->get_lnames().empty()) continue;
      for (const std::string& name : option->get_snames())
        add("-" + name, option->get_description());
    }
  }

  /// Values of an option or of an argument.  `before` stands before them, as in --method=exact.
  void add_values(const CLI::Option& option, const std::string& before,
                  const std::function<std::vector<std::string>()>& scenes) {
    const std::string type = option.get_type_name();
    const auto names = closed_set(type);
    for (const std::string& name : names) add(before + name, "");
    if (!names.empty()) return;
    const bool is_scene = option.get_positional() && option.get_name() == "SCENE";
    const bool is_path = option.get_positional() && option.get_name() == "PATH";
    if (is_scene || is_path) {
      for (const std::string& name : scenes()) add(name, "");
    }
    result_.directories = type == "DIR";
    result_.files = is_path || type == "FILE" || type == "PATH" || type.starts_with("FILE ");
  }

  Candidates result() && { return std::move(result_); }

 private:
  std::string prefix_;
  Candidates result_;
};

}  // namespace

Candidates complete(const CLI::App& app, const std::vector<std::string>& words,
                    const std::function<std::vector<std::string>()>& scenes) {
  if (words.empty()) return {};
  const std::string& word = words.back();
  const Before before = read(app, words);
  Completion completion(word);
  const std::size_t equals = word.find('=');
  if (before.value != nullptr) {
    completion.add_values(*before.value, "", scenes);
  } else if (word.starts_with("--") && equals != std::string::npos) {
    const CLI::Option* option = find_option(app, before.command, word.substr(0, equals));
    if (option != nullptr) completion.add_values(*option, word.substr(0, equals + 1), scenes);
  } else if (word.starts_with('-')) {
    if (before.command != nullptr && before.command != &app)
      completion.add_options(*before.command);
    completion.add_options(app);
  } else if (before.command == nullptr) {
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
      // A command without a group is hidden from the help.
      if (!command->get_group().empty())
        completion.add(command->get_name(), command->get_description());
    }
  } else if (const CLI::Option* next = argument(*before.command, before.arguments)) {
    completion.add_values(*next, "", scenes);
  }
  return std::move(completion).result();
}

std::string to_lines(const Candidates& candidates) {
  std::string lines;
  for (const Candidate& candidate : candidates.words) {
    lines += candidate.word;
    if (!candidate.description.empty()) lines += "\t" + candidate.description;
    lines += "\n";
  }
  if (candidates.files) lines += ":files\n";
  if (candidates.directories) lines += ":directories\n";
  return lines;
}

}  // namespace lucerna::shell
