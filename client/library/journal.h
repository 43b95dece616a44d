// The journal of a job on disk: a line that identifies the job, then one record per result.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/library/open_file.h"

namespace lucerna::client {

/// Not thread-safe.  One job at a time may have it open.
class Journal {
 public:
  /// Opens or creates the journal of the job called `job` (one line).  Calls `on_record` with each
  /// existing record.  Drops an incomplete record at the end.
  ///
  /// FAILED_PRECONDITION for the journal of another job; UNKNOWN if the disk fails or a running job
  /// has the journal open.  On file systems without locks, two jobs may each have written a record
  /// of one piece.
  static absl::StatusOr<Journal> open(
      const std::string& path, const std::string& job,
      const std::function<absl::Status(const std::string&)>& on_record);

  /// Whether the file is a journal, of any job, with at least one record.
  static bool has_records(const std::string& path);

  absl::Status add(const std::string& record);

 private:
  explicit Journal(OpenFile file) : file_(std::move(file)) {}

  OpenFile file_;
};

}  // namespace lucerna::client
