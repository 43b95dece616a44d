// Completion of words on the command line.  Scripts for bash, zsh and fish ask the program, which
// knows its commands, options and values.  So the scripts never lack an option.
//
//   $ lucerna __complete power --method e
//   exact
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace lucerna::shell {

/// The first word of a command line that asks for completions.  No command has this name.
inline constexpr char kCompleteWord[] = "__complete";

struct Candidate {
  std::string word;         ///< what the word on the command line may become
  std::string description;  ///< one line; may be empty
};

struct Candidates {
  std::vector<Candidate> words;
  bool files = false;        ///< and any file
  bool directories = false;  ///< and any directory
};

/// Completes the last of `words`, which may be empty.  `words` are those after the name of the
/// program.  `scenes` returns the names of scenes that the server can load.  It is called only if
/// the word may be such a name.
Candidates complete(const CLI::App& app, const std::vector<std::string>& words,
                    const std::function<std::vector<std::string>()>& scenes);

/// What the scripts read: a line for each word, with its description after a tab, and the lines
/// ":files" and ":directories".
std::string to_lines(const Candidates& candidates);

}  // namespace lucerna::shell
