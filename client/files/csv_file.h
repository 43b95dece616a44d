// Lines of numbers with commas between them, one after the other and from any row on.
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

/// Without spaces and tabs before and after it.
std::string_view trimmed(std::string_view text);
/// What stands between the commas, trimmed.
void split_fields(std::string_view line, std::vector<std::string_view>& fields);
/// A number, NaN and infinities too; nothing for all else.
std::optional<double> parse_number(std::string_view text);
/// Three or six numbers.  INVALID_ARGUMENT that names the column.
absl::Status parse_fields(const std::vector<std::string_view>& fields, std::vector<double>& to);

/// Lines of x,y,z or of x,y,z,nx,ny,nz, all alike, after an optional header that begins with x,y,z
/// (of normals nx,ny,nz).  Blank lines and lines that begin with # are nothing.  INVALID_ARGUMENT
/// that begins with "name:line: ".
class CsvReader {
 public:
  /// Where a row begins, and what has to be known of those before it.
  struct Place {
    std::streamoff offset = 0;
    std::size_t line = 1;     // its number
    std::size_t columns = 0;  // not known yet
    bool may_be_header = true;
  };

  CsvReader(std::istream& input, std::string name) : input_(input), name_(std::move(name)) {}

  /// Where the next line begins; -1 as offset at the end.
  Place place();
  /// Goes on from there.
  void seek(const Place& place);
  /// The numbers of the next row, nothing after the last.
  absl::StatusOr<const std::vector<double>*> next();
  /// Over the next row, whose numbers are not looked at; false after the last.
  absl::StatusOr<bool> skip();
  std::size_t columns() const { return now_.columns; }

 private:
  absl::StatusOr<bool> next_fields();
  absl::Status at_line(const std::string& what) const;

  std::istream& input_;
  std::string name_;
  Place now_;  // `line`: the number of the next one
  std::string text_;
  std::vector<std::string_view> fields_;  // of text_
  std::vector<double> numbers_;
};

/// Such a file.  Finds where its rows are at once, and what is wrong with its numbers when they are
/// read.  Holds 32 bytes for each 1024 rows.
absl::StatusOr<std::unique_ptr<VectorFile>> open_csv(const std::string& path);

}  // namespace lucerna::client
