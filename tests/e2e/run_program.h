// Runs a program to its end and keeps all that it wrote.
#pragma once

#include <sys/types.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace lucerna {

struct Outcome {
  int status = -1;  ///< exit status; 128 + signal where a signal ended it
  std::string out;
  std::string err;
};

/// `arguments[0]` is the program.  `environment` is added to this process's own.  `meanwhile` is
/// called with the program's id once it runs.
Outcome run_program(std::vector<std::string> arguments, const std::string& input = {},
                    const std::map<std::string, std::string>& environment = {},
                    const std::function<void(pid_t)>& meanwhile = {});

/// What a command printed of an answer, without the last line: that tells the answer's cost, which
/// is not the same twice.
inline std::string without_cost(const std::string& out) {
  return out.substr(0, out.rfind('\n', out.size() - 2) + 1);
}

}  // namespace lucerna
