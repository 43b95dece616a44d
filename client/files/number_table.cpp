#include "client/files/number_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "client/files/csv_file.h"
#include "client/files/npy_header.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

/// Whether the text can be the name of a column: it begins with a letter.
bool is_name(std::string_view text) {
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
         !parse_number(text);
}

/// One field of a structured array.
struct Field {
  std::string name, type;
};

/// The fields of a list such as [('x', '<f8'), ('pdf', '<f4')].  Empty for any other text.
std::vector<Field> fields_of(std::string_view list) {
  std::vector<Field> fields;
  std::vector<std::string> words;
  bool inside = false;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const char c = list[i];
    if (c == '(') {
      if (inside) return {};
      inside = true;
      words.clear();
    } else if (c == ')') {
      if (words.size() != 2) return {};
      fields.push_back({words[0], words[1]});
      inside = false;
    } else if (c == '\'' || c == '"') {
      const std::size_t end = list.find(c, i + 1);
      if (end == std::string_view::npos) return {};
      words.emplace_back(list.substr(i + 1, end - i - 1));
      i = end;
    } else if (inside && std::isdigit(static_cast<unsigned char>(c)) != 0) {
      return {};  // a field of several numbers
    }
  }
  return fields;
}

constexpr std::string_view kTypes = "<f4, <f8, <i4, <i8, <u4, <u8, |i1, |u1 or |b1";

/// Bytes of a number of this type; 0 for a type that is not allowed.
std::size_t bytes_of(std::string_view type) {
  if (type == "|i1" || type == "|u1" || type == "|b1") return 1;
  if (type == "<f4" || type == "<i4" || type == "<u4") return 4;
  if (type == "<f8" || type == "<i8" || type == "<u8") return 8;
  return 0;
}

template <class T>
double number_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

double number_at(const char* bytes, std::string_view type) {
  if (type == "<f4") return number_at<float>(bytes);
  if (type == "<f8") return number_at<double>(bytes);
  if (type == "<i4") return number_at<std::int32_t>(bytes);
  if (type == "<u4") return number_at<std::uint32_t>(bytes);
  if (type == "<i8") return number_at<std::int64_t>(bytes);
  if (type == "<u8") return number_at<std::uint64_t>(bytes);
  if (type == "|i1") return number_at<std::int8_t>(bytes);
  return number_at<std::uint8_t>(bytes);
}

}  // namespace

absl::StatusOr<NumberTable> NumberTable::read(const std::string& path, const Expected& expected) {
  NumberTable table;
  table.path_ = path;
  std::string type = std::filesystem::path(path).extension().string();
  std::ranges::transform(type, type.begin(), [](unsigned char c) { return std::tolower(c); });
  if (type == ".csv") {
    LUCERNA_RETURN_IF_ERROR(table.read_csv(expected));
  } else if (type == ".npy") {
    LUCERNA_RETURN_IF_ERROR(table.read_npy(expected));
  } else {
    return absl::InvalidArgumentError(path + ": unknown file type, must be .csv or .npy");
  }
  if (table.rows_ == 0) return absl::InvalidArgumentError(path + ": has no rows");
  return table;
}

int NumberTable::column(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  return found == names_.end() ? -1 : static_cast<int>(found - names_.begin());
}

std::string NumberTable::place(std::size_t row, std::size_t column) const {
  if (lines_.empty()) return fmt::format("{}: row {}, column {}", path_, row + 1, names_[column]);
  return fmt::format("{}:{}:{}", path_, lines_[row], letters_[row * names_.size() + column]);
}

std::string NumberTable::place(std::size_t row) const {
  if (lines_.empty()) return fmt::format("{}: row {}", path_, row + 1);
  return fmt::format("{}:{}", path_, lines_[row]);
}

absl::Status NumberTable::set_names(std::vector<std::string> names, const std::string& place) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(names.begin(), names.begin() + static_cast<long>(i), names[i]) !=
        names.begin() + static_cast<long>(i))
      return absl::InvalidArgumentError(
          fmt::format("{}: column \"{}\" is there twice, allowed: once", place, names[i]));
  }
  names_ = std::move(names);
  return absl::OkStatus();
}

absl::Status NumberTable::set_default_names(std::size_t columns, const Expected& expected,
                                            const std::string& place) {
  const std::vector<std::string>& all = expected.default_names;
  if (columns > all.size()) {
    return absl::InvalidArgumentError(
        fmt::format("{}: {} columns without names, allowed: at most {}, in this order: {}", place,
                    columns, all.size(), fmt::join(all, ",")));
  }
  return set_names({all.begin(), all.begin() + static_cast<long>(columns)}, place);
}

absl::Status NumberTable::read_csv(const Expected& expected) {
  std::ifstream in(path_, std::ios::binary);
  if (!in || std::filesystem::is_directory(path_))
    return absl::InvalidArgumentError(path_ + ": cannot be read");
  std::string line;
  std::vector<std::string_view> fields;
  for (std::uint32_t number = 1; std::getline(in, line); ++number) {
    std::string_view content = line;
    if (number == 1 && content.starts_with("\xef\xbb\xbf")) content.remove_prefix(3);
    content = trimmed(content);
    if (content.empty() || content.starts_with('#')) continue;
    split_fields(content, fields);
    const std::string line_place = fmt::format("{}:{}", path_, number);
    if (names_.empty()) {
      if (std::ranges::all_of(fields, is_name)) {
        LUCERNA_RETURN_IF_ERROR(set_names({fields.begin(), fields.end()}, line_place));
        continue;
      }
      LUCERNA_RETURN_IF_ERROR(set_default_names(fields.size(), expected, line_place));
    }
    if (fields.size() != names_.size()) {
      return absl::InvalidArgumentError(fmt::format("{}: {} columns, allowed: {}, as before",
                                                    line_place, fields.size(), names_.size()));
    }
    std::string_view rest = content;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const char* at = fields[i].empty() ? rest.data() : fields[i].data();
      letters_.push_back(static_cast<std::uint32_t>(at - line.data() + 1));
      rest.remove_prefix(std::min(rest.find(','), rest.size() - 1) + 1);
      if (fields[i].empty()) {
        values_.push_back(std::numeric_limits<double>::quiet_NaN());
        continue;
      }
      const auto value = parse_number(fields[i]);
      if (value && !std::isnan(*value)) {
        values_.push_back(*value);
        continue;
      }
      const auto here =
          fmt::format("{}:{}: {} = \"{}\"", line_place, letters_.back(), names_[i], fields[i]);
      if (expected.word_column.empty() || names_[i] != expected.word_column)
        return absl::InvalidArgumentError(here + " is not a number");
      const absl::StatusOr<double> word = expected.number_of_word(fields[i]);
      if (!word.ok())
        return absl::InvalidArgumentError(
            fmt::format("{}: {}", here, std::string(word.status().message())));
      values_.push_back(*word);
    }
    lines_.push_back(number);
    ++rows_;
  }
  if (in.bad()) return absl::InvalidArgumentError(path_ + ": cannot be read");
  return absl::OkStatus();
}

absl::Status NumberTable::read_npy(const Expected& expected) {
  std::ifstream in(path_, std::ios::binary);
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(path_, error);
  if (!in || error) return absl::InvalidArgumentError(path_ + ": cannot be read");
  LUCERNA_ASSIGN_OR_RETURN(const NpyHeader header, read_npy_header(in, path_));
  const auto bad = [&](const std::string& what) {
    return absl::InvalidArgumentError(path_ + ": " + what);
  };
  std::vector<std::string> types;
  const bool structured = header.descr.starts_with('[');
  if (structured) {
    if (header.shape.size() != 1)
      return bad(fmt::format("shape = ({}), allowed for an array with names: (n,)",
                             fmt::join(header.shape, ", ")));
    const std::vector<Field> fields = fields_of(header.descr);
    if (fields.empty()) return bad("descr = " + header.descr + ", allowed: one number per name");
    std::vector<std::string> names;
    for (const Field& f : fields) {
      names.push_back(f.name);
      types.push_back(f.type);
    }
    LUCERNA_RETURN_IF_ERROR(set_names(std::move(names), path_));
  } else {
    if (header.fortran_order)
      return bad("fortran_order = True, allowed: False (numpy.ascontiguousarray makes it so)");
    if (header.shape.size() != 2 || header.shape[1] == 0)
      return bad(fmt::format("shape = ({}), allowed: (n, columns)", fmt::join(header.shape, ", ")));
    LUCERNA_RETURN_IF_ERROR(set_default_names(header.shape[1], expected, path_));
    types.assign(header.shape[1], header.descr);
  }
  std::size_t row_bytes = 0;
  for (const std::string& type : types) {
    if (bytes_of(type) == 0) return bad(fmt::format("descr = {}, allowed: {}", type, kTypes));
    row_bytes += bytes_of(type);
  }
  const std::uint64_t held = bytes - static_cast<std::uint64_t>(in.tellg());
  if (header.shape[0] > held / row_bytes || header.shape[0] * row_bytes != held)
    return bad(fmt::format("holds {} bytes of numbers, its shape has {} rows of {}", held,
                           header.shape[0], row_bytes));
  std::vector<char> data(held);
  in.read(data.data(), static_cast<std::streamsize>(held));
  if (!in) return bad("became shorter while it was read");
  rows_ = header.shape[0];
  const char* at = data.data();
  for (std::size_t row = 0; row < rows_; ++row) {
    for (const std::string& type : types) {
      values_.push_back(number_at(at, type));
      at += bytes_of(type);
    }
  }
  return absl::OkStatus();
}

}  // namespace lucerna::client
