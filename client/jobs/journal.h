// What a job has done so far, on disk: a line that says which job, then one record a result.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/jobs/open_file.h"

namespace lucerna::client {

/// Not thread-safe, and one job at a time has it.
class Journal {
 public:
  /// Opens or begins the journal of the job called `job` (one line), and calls `on_record` with
  /// each record that is there.  What was cut off while it was being written is forgotten.
  /// FAILED_PRECONDITION for another job's, UNKNOWN where the disk does not let or a job that runs
  /// has it.  Where the file system has no locks, two jobs may have written a record each of the
  /// same piece.
  static absl::StatusOr<Journal> open(
      const std::string& path, const std::string& job,
      const std::function<absl::Status(const std::string&)>& on_record);

  /// Whether there is a journal, of whatever job, with more than its first line.
  static bool tells(const std::string& path);

  absl::Status add(const std::string& record);

 private:
  explicit Journal(OpenFile file) : file_(std::move(file)) {}

  OpenFile file_;
};

}  // namespace lucerna::client
