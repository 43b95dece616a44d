// Tables of numbers with named columns, in CSV and NPY files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace lucerna::client {

/// A table in memory.  An empty field of a CSV file is NaN.
class NumberTable {
 public:
  /// What the file does not have to state.
  struct Expected {
    /// The order of the columns of a file without names.  Such a file may leave out the last ones.
    std::vector<std::string> default_names;
    /// A column whose fields may also be words, such as the names of lights; "" for none.
    std::string word_column;
    /// The number that stands for a word.  INVALID_ARGUMENT or NOT_FOUND states what is allowed.
    std::function<absl::StatusOr<double>(std::string_view)> number_of_word;
  };

  /// Reads a .csv or .npy file.
  /// - CSV: a line of names is optional.  Blank lines and lines that begin with # are skipped.
  /// - NPY: a two-dimensional array without names, or a one-dimensional structured array.
  /// INVALID_ARGUMENT begins with "file:line:column: " for CSV, and with "file: " for NPY.
  static absl::StatusOr<NumberTable> read(const std::string& path, const Expected& expected);

  const std::string& path() const { return path_; }
  std::size_t rows() const { return rows_; }
  const std::vector<std::string>& names() const { return names_; }
  /// The number of the column with this name; -1 if there is none.
  int column(std::string_view name) const;
  double at(std::size_t row, std::size_t column) const {
    return values_[row * names_.size() + column];
  }
  /// "file:line:column" in a CSV file, "file: row 3, column pdf" in an NPY file.  Rows count
  /// from 1.
  std::string place(std::size_t row, std::size_t column) const;
  /// The same for a whole row.
  std::string place(std::size_t row) const;

 private:
  absl::Status read_csv(const Expected& expected);
  absl::Status read_npy(const Expected& expected);
  absl::Status set_names(std::vector<std::string> names, const std::string& place);
  absl::Status set_default_names(std::size_t columns, const Expected& expected,
                                 const std::string& place);

  std::string path_;
  std::vector<std::string> names_;
  std::size_t rows_ = 0;
  std::vector<double> values_;
  std::vector<std::uint32_t> lines_;    // of each row; empty for NPY
  std::vector<std::uint32_t> letters_;  // of each field, from 1; empty for NPY
};

}  // namespace lucerna::client
