// What a job has done so far, on disk: a line that says which job, then one record a result.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace lucerna::client {

/// Not thread-safe, and for one process at a time.
class Journal {
 public:
  /// Opens or begins the journal of the job called `job` (one line), and calls `on_record` with
  /// each record that is there.  What was cut off while it was being written is forgotten.
  /// FAILED_PRECONDITION for another job's, UNKNOWN where the disk does not let.
  static absl::StatusOr<Journal> open(
      const std::string& path, const std::string& job,
      const std::function<absl::Status(const std::string&)>& on_record);

  absl::Status add(const std::string& record);

 private:
  explicit Journal(std::string path, std::ofstream out)
      : path_(std::move(path)), out_(std::move(out)) {}

  std::string path_;
  std::ofstream out_;
};

}  // namespace lucerna::client
