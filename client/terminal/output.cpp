#include "client/terminal/output.h"

#include <fmt/core.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lucerna::cli {
namespace {

/// Characters of UTF-8; each counts as one column.
std::size_t width(const std::string& text) {
  return std::count_if(text.begin(), text.end(),
                       [](unsigned char c) { return (c & 0xc0) != 0x80; });
}

/// A field of CSV.  Quotes are needed around these characters.
std::string quoted(const std::string& value) {
  if (value.find_first_of("\",\r\n") == std::string::npos) return value;
  std::string result = "\"";
  for (const char c : value) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& field : fields) {
    if (&field != fields.data()) line += ',';
    line += quoted(field);
  }
  return line + "\n";
}

/// Digits that read back as the same number.
template <class Number>
std::string full(Number value) {
  return fmt::format("{}", value);
}

template <class Number>
Cell make_triple(Number a, Number b, Number c) {
  return {triple(a, b, c), {full(a), full(b), full(c)}};
}

}  // namespace

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {
  for (Column& column : columns_) column.header = plain_line(column.header);
}

void Table::add(std::vector<Cell> row) {
  row.resize(columns_.size());
  for (Cell& cell : row) cell.make_plain();
  rows_.push_back(std::move(row));
}

std::string Table::to_string(bool colours) const {
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    widths.push_back(width(columns_[i].header));
    for (const auto& row : rows_) widths[i] = std::max(widths[i], width(row[i].text()));
  }
  std::string result;
  const auto add_line = [&](const auto& entry, const auto& colour) {
    std::string line;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::string& text = entry(i);
      const std::string space(widths[i] - width(text), ' ');
      const std::string shown = colours ? shell::paint(text, colour(i)) : text;
      line += columns_[i].text ? shown + space : space + shown;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    result += line + "\n";
  };
  add_line([&](std::size_t i) -> const std::string& { return columns_[i].header; },
           [](std::size_t) { return shell::Colour::kBold; });
  for (const auto& row : rows_) {
    add_line([&](std::size_t i) -> const std::string& { return row[i].text(); },
             [&](std::size_t i) {
               const shell::Colour own = row[i].colour();
               const bool is_status = columns_[i].header.empty();
               return own == shell::Colour::kPlain && is_status ? shell::Colour::kWarning : own;
             });
  }
  return result;
}

std::vector<std::string> Table::names_of(std::size_t column) const {
  std::size_t count = 1;
  for (const auto& row : rows_) count = std::max(count, row[column].values().size());
  const Column& c = columns_[column];
  if (!c.names.empty()) return c.names;
  if (c.header.empty()) return {"status"};
  // "what [unit]"
  const std::size_t bracket = std::min(c.header.find(" ["), c.header.size());
  std::string what = c.header.substr(0, bracket);
  const std::string unit = c.header.substr(bracket);
  if (what == "±") what = "error";
  if (count == 1) return {what + unit};
  const char* const* parts = nullptr;
  constexpr const char* kColour[] = {"R", "G", "B"};
  constexpr const char* kPlace[] = {" x", " y", " z"};
  if (what.ends_with("(RGB)")) what.resize(what.size() - 5);
  if (what == "RGB") what.clear();
  parts = what.size() + unit.size() < c.header.size() ? kColour : kPlace;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i)
    names.push_back(what + (i < 3 ? std::string(parts[i]) : fmt::format(" {}", i + 1)) + unit);
  return names;
}

std::string Table::to_csv() const {
  std::vector<std::string> header;
  std::vector<std::size_t> counts;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::vector<std::string> names = names_of(i);
    counts.push_back(names.size());
    header.insert(header.end(), names.begin(), names.end());
  }
  std::string result = csv_line(header);
  for (const auto& row : rows_) {
    std::vector<std::string> fields;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      std::vector<std::string> values = row[i].values();
      values.resize(counts[i]);
      fields.insert(fields.end(), values.begin(), values.end());
    }
    result += csv_line(fields);
  }
  return result;
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

Cell number_cell(double value) { return {number(value), {full(value)}}; }
Cell number_cell(float value) { return {number(value), {full(value)}}; }
Cell triple_cell(double a, double b, double c) { return make_triple(a, b, c); }
Cell triple_cell(float a, float b, float c) { return make_triple(a, b, c); }

Cell triple_cell_of(const google::protobuf::RepeatedField<float>& values, std::size_t i) {
  const auto at = static_cast<int>(3 * i);
  return at + 2 < values.size() ? make_triple(values[at], values[at + 1], values[at + 2]) : Cell();
}

std::string triple(double a, double b, double c) {
  return number(a) + " " + number(b) + " " + number(c);
}

std::string triple_of(const google::protobuf::RepeatedField<float>& values, std::size_t i) {
  const auto at = static_cast<int>(3 * i);
  return at + 2 < values.size() ? triple(values[at], values[at + 1], values[at + 2]) : "";
}

std::string direction(const v1::Vector3& v) {
  const double length = std::hypot(v.x(), v.y(), v.z());
  // + 0.0 turns the -0 of a small negative number into 0.
  const auto rounded = [&](double x) { return std::round(x / length * 1e4) / 1e4 + 0.0; };
  return triple(rounded(v.x()), rounded(v.y()), rounded(v.z()));
}

std::string to_json(const google::protobuf::Message& message, const std::string& more) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  std::string result;
  const auto status = google::protobuf::util::MessageToJsonString(message, &result, options);
  if (!status.ok()) throw std::runtime_error("no JSON of the answer: " + status.ToString());
  if (!more.empty()) result.insert(result.size() - 1, (result == "{}" ? "" : ",") + more);
  return result + "\n";
}

std::string item_status(const google::protobuf::RepeatedField<int>& statuses, std::size_t item) {
  if (item >= static_cast<std::size_t>(statuses.size())) return "";
  const int status = statuses[static_cast<int>(item)];
  if (status == v1::ITEM_STATUS_OK) return "";
  const std::string name = v1::ItemStatus_Name(status);
  constexpr std::string_view kPrefix = "ITEM_STATUS_";
  return name.starts_with(kPrefix) ? name.substr(kPrefix.size()) : fmt::format("status {}", status);
}

bool is_answered(int status) {
  return status == v1::ITEM_STATUS_OK || status == v1::ITEM_STATUS_INSIDE_SOLID ||
         status == v1::ITEM_STATUS_MAY_MISS_LIGHT;
}

bool has_answer(const google::protobuf::RepeatedField<int>& statuses, std::size_t item) {
  return item >= static_cast<std::size_t>(statuses.size()) ||
         is_answered(statuses[static_cast<int>(item)]);
}

bool any_failed(const google::protobuf::RepeatedField<int>& statuses) {
  return std::any_of(statuses.begin(), statuses.end(), [](int status) {
    switch (status) {
      case v1::ITEM_STATUS_OK:
      case v1::ITEM_STATUS_BEHIND:
      case v1::ITEM_STATUS_OUTSIDE_CONE:
      case v1::ITEM_STATUS_BLACK:
      case v1::ITEM_STATUS_INSIDE_SOLID:
      case v1::ITEM_STATUS_MAY_MISS_LIGHT:
        return false;
      default:
        return true;
    }
  });
}

std::string describe_inside(const google::protobuf::RepeatedField<int>& statuses) {
  const auto inside = std::count(statuses.begin(), statuses.end(), v1::ITEM_STATUS_INSIDE_SOLID);
  if (inside == 0) return {};
  return fmt::format("{} of {} points {} inside of solids or behind lamps; ", inside,
                     statuses.size(), inside == 1 ? "is" : "are");
}

std::string describe_missed(const v1::EstimateIrradianceResponse& response) {
  const auto points = std::count(response.status().begin(), response.status().end(),
                                 v1::ITEM_STATUS_MAY_MISS_LIGHT);
  return describe_missed(static_cast<std::uint64_t>(points),
                         static_cast<std::uint64_t>(response.status_size()),
                         {response.missed_surfaces().begin(), response.missed_surfaces().end()});
}

std::string describe_missed(std::uint64_t points, std::uint64_t all,
                            const std::set<std::string>& surfaces) {
  if (points == 0) return {};
  std::string way;
  for (const std::string& surface : surfaces) way += (way.empty() ? " by way of " : ", ") + surface;
  return fmt::format("{}{} may be missed at {} of {} points; ",
                     way.empty() ? "reflected light" : "light", way, points, all);
}

std::string describe(const v1::Cost& cost) {
  std::string result = fmt::format("{:.3g} s", cost.wall_time_s());
  const auto add = [&](std::uint64_t count, const char* one, const char* many) {
    if (count > 0) result += fmt::format(", {} {}", count, count == 1 ? one : many);
  };
  add(cost.samples(), "sample", "samples");
  add(cost.camera_rays() + cost.indirect_rays() + cost.shadow_rays(), "ray", "rays");
  add(cost.shadow_map_lookups(), "look-up in shadow maps", "look-ups in shadow maps");
  add(cost.through_thin_glass(), "ray through thin panes", "rays through thin panes");
  return result;
}

}  // namespace lucerna::cli
