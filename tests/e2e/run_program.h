// Runs a program to its end and keeps its output.
#pragma once

#include <sys/types.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace lucerna {

struct Outcome {
  int status = -1;  ///< exit status; 128 + signal if a signal ended it
  std::string out;
  std::string err;
};

/// `arguments[0]` is the program.  `environment` is added to that of this process.  `meanwhile` is
/// called with the process id when the program runs.
Outcome run_program(std::vector<std::string> arguments, const std::string& input = {},
                    const std::map<std::string, std::string>& environment = {},
                    const std::function<void(pid_t)>& meanwhile = {});

/// The printed answer without its last line, which holds the cost and differs from run to run.
inline std::string without_cost(const std::string& out) {
  return out.substr(0, out.rfind('\n', out.size() - 2) + 1);
}

}  // namespace lucerna
