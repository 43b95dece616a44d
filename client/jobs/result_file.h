// Results of equal length, written to a file in any order as they arrive.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/jobs/open_file.h"

namespace lucerna::client {

/// A header, then `rows` rows of `columns` little-endian floats.  Nothing is held in memory.  Not
/// thread-safe.  One process at a time may have it open.
class ResultFile {
 public:
  /// What happens to a file with another header or length.
  enum class Other { kReplace, kKeep };

  /// Creates the file and allocates disk space for all of it.  A file with the same header and
  /// length stays unchanged; the caller must know which rows it holds.
  ///
  /// UNKNOWN, with the file's name, if the disk fails or another process has it open;
  /// FAILED_PRECONDITION if it holds something else that is to be kept.
  static absl::StatusOr<ResultFile> open(const std::string& path, const std::string& header,
                                         std::uint64_t rows, std::size_t columns,
                                         Other other = Other::kReplace);

  std::uint64_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  /// Writes whole rows, from row `first` on.
  absl::Status write(std::uint64_t first, std::span<const float> values);
  absl::Status read(std::uint64_t first, std::span<float> values) const;

 private:
  ResultFile(OpenFile file, std::uint64_t begin, std::uint64_t rows, std::size_t columns)
      : file_(std::move(file)), begin_(begin), rows_(rows), columns_(columns) {}

  OpenFile file_;
  std::uint64_t begin_ = 0;  // offset of the first row
  std::uint64_t rows_ = 0;
  std::size_t columns_ = 0;
};

}  // namespace lucerna::client
