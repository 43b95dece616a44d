#include "client/cli/points.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <string_view>

#include "client/cli/session.h"

namespace lucerna::cli {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

bool is_header(const std::vector<std::string_view>& fields) {
  if (fields.size() != 3 && fields.size() != 6) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (fields[i].empty() || (fields[i][0] | 0x20) != "xyz"[i]) return false;
  }
  return true;
}

/// One line of numbers, or what is wrong with it.
absl::StatusOr<std::vector<double>> numbers(const std::vector<std::string_view>& fields) {
  if (fields.size() != 3 && fields.size() != 6) {
    return absl::InvalidArgumentError(fmt::format("{} column{}, must be 3 or 6: x,y,z[,nx,ny,nz]",
                                                  fields.size(), fields.size() == 1 ? "" : "s"));
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto value = number(fields[i]);
    if (!value) {
      return absl::InvalidArgumentError(
          fmt::format("column {}: \"{}\" is not a number", i + 1, fields[i]));
    }
    result.push_back(*value);
  }
  return result;
}

absl::Status at_line(const std::string& name, std::size_t line, const std::string& what) {
  return absl::InvalidArgumentError(fmt::format("{}:{}: {}", name, line, what));
}

}  // namespace

absl::StatusOr<Double3> parse_triple(const std::string& text, Triple kind) {
  const bool is_direction = kind == Triple::kDirection;
  const auto values = numbers(fields_of(text));
  // The contract's directions are floats.
  const double most =
      is_direction ? std::numeric_limits<float>::max() : std::numeric_limits<double>::max();
  const auto is_finite = [most](double v) { return std::fabs(v) <= most; };
  const auto is_zero = [](double v) { return static_cast<float>(v) == 0; };
  if (!values.ok() || values->size() != 3 ||
      !std::all_of(values->begin(), values->end(), is_finite) ||
      (is_direction && std::all_of(values->begin(), values->end(), is_zero))) {
    return absl::InvalidArgumentError(fmt::format("\"{}\", must be three finite {}, as 0,1.5,-2",
                                                  text,
                                                  is_direction ? "floats, not all 0" : "numbers"));
  }
  return Double3{(*values)[0], (*values)[1], (*values)[2]};
}

absl::StatusOr<std::vector<double>> parse_numbers(const std::string& text) {
  std::vector<double> result;
  for (const std::string_view field : fields_of(text)) {
    const auto value = number(field);
    if (!value) return absl::InvalidArgumentError(fmt::format("\"{}\" is not a number", field));
    result.push_back(*value);
  }
  return result;
}

absl::StatusOr<std::vector<double>> parse_sample_values(const std::string& text, std::size_t count,
                                                        bool chooses_light) {
  absl::StatusOr<std::vector<double>> values = parse_numbers(text);
  if (!values.ok() || values->size() != count + (chooses_light ? 1 : 0)) {
    const bool is_ray = count == 4;
    return absl::InvalidArgumentError(fmt::format(
        "\"{}\", must be {}", text,
        chooses_light ? (is_ray ? "five numbers u1,u2,u3,u4,u_light, or four with --light"
                                : "three numbers u1,u2,u_light, or two with --light")
                      : (is_ray ? "four numbers u1,u2,u3,u4" : "two numbers u1,u2")));
  }
  for (std::size_t i = 0; i < values->size(); ++i) {
    const double value = (*values)[i];
    // As NaN is none of these.
    const bool is_allowed = value >= 0 && (i < count ? value <= 1 : value < 1);
    if (!is_allowed) {
      return absl::InvalidArgumentError(fmt::format(
          "\"{}\": {} = {}, allowed: {}", text, i < count ? fmt::format("u{}", i + 1) : "u_light",
          value, i < count ? "[0, 1]" : "[0, 1)"));
    }
  }
  return values;
}

absl::StatusOr<PointSet> read_csv(std::istream& input, const std::string& name) {
  PointSet result;
  std::string text;
  std::size_t columns = 0;  // not known yet
  bool may_be_header = true;
  for (std::size_t line = 1; std::getline(input, text); ++line) {
    std::string_view content = text;
    if (line == 1 && content.starts_with("\xef\xbb\xbf")) content.remove_prefix(3);
    content = trimmed(content);
    if (content.empty() || content.starts_with('#')) continue;
    const auto fields = fields_of(content);
    const bool header = may_be_header && is_header(fields);
    may_be_header = false;
    if (columns != 0 && fields.size() != columns) {
      return at_line(name, line, fmt::format("{} columns, {} before", fields.size(), columns));
    }
    columns = fields.size();
    if (header) continue;
    const auto values = numbers(fields);
    if (!values.ok()) return at_line(name, line, std::string(values.status().message()));
    result.points.push_back({(*values)[0], (*values)[1], (*values)[2]});
    if (columns == 6) result.seconds.push_back({(*values)[3], (*values)[4], (*values)[5]});
  }
  if (input.bad()) return at_line(name, 1, "cannot be read");
  return result;
}

void PointOptions::add(CLI::App& command, const std::string& second) {
  command.add_option("--point", points_, "A point x,y,z [m]; may be given again")
      ->allow_extra_args(false);
  command.add_option("--points", file_,
                     "CSV file of points x,y,z [m], - for standard input; columns 4 to 6, where "
                     "there are, are " +
                         second);
}

PointSet PointOptions::read() const {
  PointSet result;
  if (!file_.empty()) {
    if (!points_.empty()) wrong_use("--point and --points: only one of them");
    std::ifstream file;
    if (file_ != "-") {
      file.open(file_);
      if (!file) wrong_use("--points " + file_ + ": cannot be opened");
    }
    auto points = read_csv(file_ == "-" ? std::cin : file, file_ == "-" ? "standard input" : file_);
    if (!points.ok()) wrong_use(std::string(points.status().message()));
    result = *std::move(points);
  }
  for (const std::string& text : points_) {
    const auto point = parse_triple(text, Triple::kPoint);
    if (!point.ok()) wrong_use("--point " + std::string(point.status().message()));
    result.points.push_back(*point);
  }
  if (result.points.empty()) wrong_use("no points: give --point x,y,z or --points FILE");
  return result;
}

void TripleOption::add(CLI::App& command, const std::string& flag, const std::string& what,
                       Triple kind) {
  flag_ = flag;
  kind_ = kind;
  command.add_option(flag, texts_, what + "; once for all points, or once for each")
      ->allow_extra_args(false);
}

std::vector<Double3> TripleOption::read(std::size_t count) const {
  std::vector<Double3> result;
  for (const std::string& text : texts_) {
    const auto triple = parse_triple(text, kind_);
    if (!triple.ok()) wrong_use(flag_ + " " + std::string(triple.status().message()));
    result.push_back(*triple);
  }
  if (result.size() == 1) result.resize(count, result[0]);
  if (result.size() != count) {
    wrong_use(fmt::format("{}: given {} times for {} points, must be once or once for each", flag_,
                          result.size(), count));
  }
  return result;
}

std::vector<Double3> read_directions(const TripleOption& option, const PointSet& set) {
  const auto result = option.given() ? option.read(set.points.size()) : set.seconds;
  if (result.empty()) wrong_use("no directions: give --direction, or six columns in --points");
  return result;
}

void fill(const std::vector<Double3>& vectors, google::protobuf::RepeatedField<float>* to) {
  to->Resize(static_cast<int>(3 * vectors.size()), 0);
  float* value = to->mutable_data();
  for (const Double3& vector : vectors) {
    for (const double coordinate : vector) *value++ = static_cast<float>(coordinate);
  }
}

}  // namespace lucerna::cli
