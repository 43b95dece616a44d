// A file of results of equal length, which may be written in any order.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/library/open_file.h"

namespace lucerna::client {

/// A header, then `rows` rows of `columns` little-endian floats.  Keeps no results in memory.  Not
/// thread-safe.  Only one process at a time may have it open.
class ResultFile {
 public:
  /// What open() does with a file of another header or length.
  enum class Other { kReplace, kKeep };

  /// Creates the file and allocates disk space for all of it.  A file with the same header and
  /// length stays unchanged; the caller must know which of its rows have results.
  ///
  /// UNKNOWN, with the file's name, if the disk fails or another process has it open.
  /// FAILED_PRECONDITION for Other::kKeep and a file of other contents.
  static absl::StatusOr<ResultFile> open(const std::string& path, const std::string& header,
                                         std::uint64_t rows, std::size_t columns,
                                         Other other = Other::kReplace);

  std::uint64_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  /// Writes whole rows, starting at row `first`.
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
