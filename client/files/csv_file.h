// Reads lines of comma-separated numbers, in order or starting at any row.
#pragma once

#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/files/vector_file.h"

namespace lucerna::client {

/// `text` without spaces and tabs at its ends.
std::string_view trimmed(std::string_view text);
/// The fields between the commas, trimmed.
void split_fields(std::string_view line, std::vector<std::string_view>& fields);
/// A number, which may be NaN or infinite; nothing for other text.
std::optional<double> parse_number(std::string_view text);
/// Parses three or six numbers.  INVALID_ARGUMENT names the column.
absl::Status parse_fields(const std::vector<std::string_view>& fields, std::vector<double>& to);

/// Reads lines of x,y,z or of x,y,z,nx,ny,nz.  All lines have the same number of columns.  An
/// optional header begins with x,y,z (for normals nx,ny,nz).  Blank lines and lines that begin with
/// # are skipped.  INVALID_ARGUMENT begins with "name:line: ".
class CsvReader {
 public:
  /// The position of a row, and the state that depends on the rows before it.
  struct RowPosition {
    std::streamoff offset = 0;
    std::size_t line = 1;     // its number
    std::size_t columns = 0;  // 0: not known yet
    bool may_be_header = true;
  };

  CsvReader(std::istream& input, std::string name) : input_(input), name_(std::move(name)) {}

  /// The position of the next line; its offset is -1 at the end.
  RowPosition place();
  /// Continues at `place`.
  void seek(const RowPosition& place);
  /// The numbers of the next row; null after the last.
  absl::StatusOr<const std::vector<double>*> next();
  /// Skips the next row without parsing its numbers; false after the last.
  absl::StatusOr<bool> skip();
  std::size_t columns() const { return now_.columns; }

 private:
  absl::StatusOr<bool> next_fields();
  absl::Status at_line(const std::string& what) const;

  std::istream& input_;
  std::string name_;
  RowPosition now_;  // `line` is the number of the next line
  std::string text_;
  std::vector<std::string_view> fields_;  // views into text_
  std::vector<double> numbers_;
};

/// Opens a CSV file.  Finds the rows at once; read() finds errors in numbers.  Keeps 32 bytes per
/// 1024 rows in memory.
absl::StatusOr<std::unique_ptr<VectorFile>> open_csv(const std::string& path);

}  // namespace lucerna::client
