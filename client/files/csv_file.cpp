#include "client/files/csv_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

constexpr std::uint64_t kRowsPerMark = 1024;

bool is_header(const std::vector<std::string_view>& fields) {
  if (fields.size() != 3 && fields.size() != 6) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    std::string_view name = fields[i];
    if (name.starts_with('n') || name.starts_with('N')) name.remove_prefix(1);
    if (name.empty() || (name[0] | 0x20) != "xyz"[i]) return false;
  }
  return true;
}

class CsvFile final : public VectorFile {
 public:
  explicit CsvFile(const std::string& path)
      : path_(path), in_(path, std::ios::binary), reader_(in_, path) {}

  absl::Status open() {
    if (!in_) return absl::InvalidArgumentError(path_ + ": cannot be read");
    std::error_code error;
    if (!std::filesystem::is_regular_file(path_, error))
      return absl::InvalidArgumentError(path_ +
                                        ": is not a regular file, so it cannot be read twice");
    for (;;) {
      if (rows_ % kRowsPerMark == 0) marks_.push_back(reader_.place());
      LUCERNA_ASSIGN_OR_RETURN(const auto any, reader_.skip());
      if (!any) break;
      ++rows_;
    }
    columns_ = reader_.columns();
    next_ = rows_;
    // Parse the first row to check its number of columns, which all rows share.
    reader_.seek(marks_.front());
    next_ = rows_ > 0 ? 1 : 0;
    return reader_.next().status();
  }

  std::uint64_t rows() const override { return rows_; }
  std::size_t columns() const override { return columns_; }

  absl::Status read(std::uint64_t first, std::span<double> values) override {
    if (first != next_) {
      reader_.seek(marks_[first / kRowsPerMark]);
      for (next_ = first - first % kRowsPerMark; next_ < first; ++next_) {
        LUCERNA_RETURN_IF_ERROR(reader_.skip().status());
      }
    }
    for (auto to = values.begin(); to != values.end(); to += static_cast<long>(columns_)) {
      LUCERNA_ASSIGN_OR_RETURN(const auto row, reader_.next());
      if (row == nullptr || row->size() != columns_)
        return absl::InvalidArgumentError(path_ + ": became shorter while it was read");
      std::copy(row->begin(), row->end(), to);
      ++next_;
    }
    return absl::OkStatus();
  }

 private:
  std::string path_;
  std::ifstream in_;
  CsvReader reader_;
  std::vector<CsvReader::RowPosition> marks_;
  std::uint64_t rows_ = 0;
  std::uint64_t next_ = 0;  // the reader's next row
  std::size_t columns_ = 0;
};

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

void split_fields(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

absl::Status parse_fields(const std::vector<std::string_view>& fields, std::vector<double>& to) {
  if (fields.size() != 3 && fields.size() != 6) {
    return absl::InvalidArgumentError(fmt::format("{} column{}, must be 3 or 6: x,y,z[,nx,ny,nz]",
                                                  fields.size(), fields.size() == 1 ? "" : "s"));
  }
  to.clear();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto value = parse_number(fields[i]);
    if (!value) {
      return absl::InvalidArgumentError(
          fmt::format("column {}: \"{}\" is not a number", i + 1, fields[i]));
    }
    to.push_back(*value);
  }
  return absl::OkStatus();
}

CsvReader::RowPosition CsvReader::place() {
  RowPosition here = now_;
  here.offset = input_.tellg();
  return here;
}

void CsvReader::seek(const RowPosition& place) {
  input_.clear();
  input_.seekg(place.offset);
  now_ = place;
}

absl::Status CsvReader::at_line(const std::string& what) const {
  return absl::InvalidArgumentError(fmt::format("{}:{}: {}", name_, now_.line - 1, what));
}

absl::StatusOr<bool> CsvReader::next_fields() {
  while (std::getline(input_, text_)) {
    ++now_.line;
    std::string_view content = text_;
    if (now_.line == 2 && content.starts_with("\xef\xbb\xbf")) content.remove_prefix(3);
    content = trimmed(content);
    if (content.empty() || content.starts_with('#')) continue;
    split_fields(content, fields_);
    const bool header = now_.may_be_header && is_header(fields_);
    now_.may_be_header = false;
    if (now_.columns != 0 && fields_.size() != now_.columns)
      return at_line(
          fmt::format("{} columns, but {} in the lines before", fields_.size(), now_.columns));
    now_.columns = fields_.size();
    if (!header) return true;
  }
  if (input_.bad()) return at_line("cannot be read");
  return false;
}

absl::StatusOr<bool> CsvReader::skip() { return next_fields(); }

absl::StatusOr<const std::vector<double>*> CsvReader::next() {
  LUCERNA_ASSIGN_OR_RETURN(const auto any, next_fields());
  if (!any) return nullptr;
  if (absl::Status s = parse_fields(fields_, numbers_); !s.ok())
    return at_line(std::string(s.message()));
  return &numbers_;
}

absl::StatusOr<std::unique_ptr<VectorFile>> open_csv(const std::string& path) {
  auto file = std::make_unique<CsvFile>(path);
  LUCERNA_RETURN_IF_ERROR(file->open());
  return file;
}

}  // namespace lucerna::client
