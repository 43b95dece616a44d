// Results of one length each, written to a file in any order as they arrive.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/jobs/open_file.h"

namespace lucerna::client {

/// A header, then `rows` rows of `columns` little-endian floats.  Nothing of it is held in memory.
/// Not thread-safe, and one process at a time has it.
class ResultFile {
 public:
  /// What becomes of a file of another header or length.
  enum class Other { kReplace, kKeep };

  /// Makes the file, with room on the disk for all of it.  A file of the same header and length
  /// stays as it is: what it holds must be known from elsewhere.
  /// UNKNOWN, naming the file, where the disk does not let or another process has it;
  /// FAILED_PRECONDITION where it holds something else that is to be kept.
  static absl::StatusOr<ResultFile> open(const std::string& path, const std::string& header,
                                         std::uint64_t rows, std::size_t columns,
                                         Other other = Other::kReplace);

  std::uint64_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  /// `values`: whole rows, from row `first` on.
  absl::Status write(std::uint64_t first, std::span<const float> values);
  absl::Status read(std::uint64_t first, std::span<float> values) const;

 private:
  ResultFile(OpenFile file, std::uint64_t begin, std::uint64_t rows, std::size_t columns)
      : file_(std::move(file)), begin_(begin), rows_(rows), columns_(columns) {}

  OpenFile file_;
  std::uint64_t begin_ = 0;  // where the rows begin
  std::uint64_t rows_ = 0;
  std::size_t columns_ = 0;
};

}  // namespace lucerna::client
