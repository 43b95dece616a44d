// Errors that end the program, and how they are printed.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "proto/common/status_error.h"

namespace lucerna::cli {

/// Exit statuses of the program.
enum ExitStatus : int {
  kDone = 0,
  kServerRefused = 1,  ///< the server refused or cannot be reached, or an item has no answer
  kWrongUse = 2,       ///< wrong options, numbers or files
  kSignal = 128,       ///< plus the number of the signal that interrupted the program
};

/// Ends the program with a message.
class CommandError : public StatusError {
 public:
  /// The status code depends on `exit`: INVALID_ARGUMENT for kWrongUse, CANCELLED after a signal,
  /// else UNKNOWN.
  CommandError(ExitStatus exit, const std::string& message);
  /// Keeps the code and the details of `status`, and replaces its message by `message`.
  CommandError(ExitStatus exit, const absl::Status& status, const std::string& message);

  ExitStatus exit_status() const { return exit_; }

 private:
  ExitStatus exit_;
};

/// Throws a CommandError with exit status 2.
[[noreturn]] void wrong_use(const std::string& message);

/// One line of JSON, {"error": {"code": "NOT_FOUND", "message": ..., "details": [...]}}, with a new
/// line.  The details are those of the server's google.rpc.Status, in the JSON of protocol buffers.
/// A detail of an unknown type has only its "@type".
std::string to_json(const absl::Status& error);

/// Prints the error to stderr: as to_json(), or as "lucerna: MESSAGE".
void print_error(const absl::Status& error, bool json);

}  // namespace lucerna::cli
