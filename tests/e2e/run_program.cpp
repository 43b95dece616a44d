#include "tests/e2e/run_program.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

namespace lucerna {
namespace {

/// A file in memory with `content`, to be read from its beginning.
int memory_file(const std::string& content) {
  const int file = ::memfd_create("run_program", MFD_CLOEXEC);
  if (file < 0 ||
      ::write(file, content.data(), content.size()) != static_cast<ssize_t>(content.size())) {
    std::abort();
  }
  ::lseek(file, 0, SEEK_SET);
  return file;
}

std::string take(int file) {
  std::string text(static_cast<std::size_t>(::lseek(file, 0, SEEK_END)), '\0');
  if (::pread(file, text.data(), text.size(), 0) < 0) text.clear();
  ::close(file);
  return text;
}

}  // namespace

Outcome run_program(std::vector<std::string> arguments, const std::string& input,
                    const std::map<std::string, std::string>& environment,
                    const std::function<void(pid_t)>& meanwhile) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string text = *variable;
    if (!environment.contains(text.substr(0, text.find('=')))) variables.push_back(text);
  }
  for (const auto& [name, value] : environment) variables.push_back(name + "=" + value);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::vector<char*> envp;
  for (std::string& variable : variables) envp.push_back(variable.data());
  envp.push_back(nullptr);

  const int in = memory_file(input);
  const int out = memory_file("");
  const int err = memory_file("");
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(in, STDIN_FILENO);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(err, STDERR_FILENO);
    ::execve(argv[0], argv.data(), envp.data());
    ::_exit(127);
  }
  if (child > 0 && meanwhile) meanwhile(child);
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child) std::abort();
  ::close(in);
  Outcome outcome;
  outcome.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  outcome.out = take(out);
  outcome.err = take(err);
  return outcome;
}

}  // namespace lucerna
