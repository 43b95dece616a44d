// How an error ends the program, and how it is printed.
#pragma once

#include <stdexcept>
#include <string>

#include "absl/status/status.h"

namespace lucerna::cli {

/// Exit statuses of the program.
enum ExitStatus : int {
  kDone = 0,
  kServerSaidNo = 1,  ///< the server refused or cannot be reached, or an item has no answer
  kWrongUse = 2,      ///< wrong options, numbers or files
  kSignal = 128,      ///< plus the number of the signal that interrupted the program
};

/// Ends the program with a message.
class CommandError : public std::runtime_error {
 public:
  /// The code of the status follows from `exit`: INVALID_ARGUMENT, CANCELLED or UNKNOWN.
  CommandError(ExitStatus exit, const std::string& message);
  /// The code and the details of `status`; `message` stands in the place of its own.
  CommandError(ExitStatus exit, const absl::Status& status, const std::string& message);

  ExitStatus exit_status() const { return exit_; }
  const absl::Status& status() const { return status_; }

 private:
  ExitStatus exit_;
  absl::Status status_;
};

/// Throws a CommandError with exit status 2.
[[noreturn]] void wrong_use(const std::string& message);

/// One line of JSON, {"error": {"code": "NOT_FOUND", "message": ..., "details": [...]}}, with a new
/// line.  The details are those of the server's google.rpc.Status, in the JSON of protocol buffers;
/// a detail of an unknown type has its "@type" alone.
std::string to_json(const absl::Status& error);

/// Prints the error to stderr: as to_json(), or as "lucerna: MESSAGE".
void print_error(const absl::Status& error, bool json);

}  // namespace lucerna::cli
