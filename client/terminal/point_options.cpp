#include "client/terminal/point_options.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <string_view>

#include "client/files/csv_file.h"
#include "client/files/open_vectors.h"
#include "client/terminal/session.h"
#include "proto/common/status_macros.h"

namespace lucerna::cli {
namespace {

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  client::split_fields(line, fields);
  return fields;
}

}  // namespace

absl::StatusOr<Double3> parse_triple(const std::string& text, Triple kind) {
  const bool is_direction = kind == Triple::kDirection;
  std::vector<double> values;
  const absl::Status parsed = client::parse_fields(fields_of(text), values);
  // Directions are floats in requests.
  const double most =
      is_direction ? std::numeric_limits<float>::max() : std::numeric_limits<double>::max();
  const auto is_finite = [most](double v) { return std::fabs(v) <= most; };
  const auto is_zero = [](double v) { return static_cast<float>(v) == 0; };
  if (!parsed.ok() || values.size() != 3 || !std::all_of(values.begin(), values.end(), is_finite) ||
      (is_direction && std::all_of(values.begin(), values.end(), is_zero))) {
    return absl::InvalidArgumentError(
        fmt::format("\"{}\", must be three finite {}, such as 0,1.5,-2", text,
                    is_direction ? "floats, not all 0" : "numbers"));
  }
  return Double3{values[0], values[1], values[2]};
}

absl::StatusOr<std::vector<double>> parse_numbers(const std::string& text) {
  std::vector<double> result;
  for (const std::string_view field : fields_of(text)) {
    const auto value = client::parse_number(field);
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
    // False for NaN.
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
  client::CsvReader reader(input, name);
  for (;;) {
    LUCERNA_ASSIGN_OR_RETURN(const auto next, reader.next());
    if (next == nullptr) return result;
    const std::vector<double>& row = *next;
    result.points.push_back({row[0], row[1], row[2]});
    if (row.size() == 6) result.seconds.push_back({row[3], row[4], row[5]});
  }
}

void PointOptions::add(CLI::App& command, const std::string& second) {
  command.add_option("--point", points_, "Point x,y,z [m]; may be repeated")
      ->allow_extra_args(false);
  command
      .add_option(
          "--points", file_,
          "CSV file of points x,y,z [m], or - for standard input; columns 4 to 6 are " + second)
      ->type_name("FILE");
}

const std::string& PointOptions::file() const {
  if (!file_.empty() && !points_.empty()) wrong_use("--point and --points: only one of them");
  return file_;
}

PointSet PointOptions::read() const {
  PointSet result;
  if (!file().empty()) {
    const auto format = client::vector_format(file_);
    if (format.ok() && *format != client::VectorFormat::kCsv) {
      wrong_use(fmt::format(
          "--points {}: a table accepts only CSV; for other files use irradiance -o", file_));
    }
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

}  // namespace lucerna::cli
