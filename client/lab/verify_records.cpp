#include "client/lab/verify_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "client/terminal/error.h"
#include "client/terminal/luminance.h"

namespace lucerna::verify {
namespace {

using cli::wrong_use;
using client::NumberTable;

struct Columns {
  const char* name;
  std::vector<std::string> all, required;
};

const Columns& columns_of(Kind kind) {
  static const Columns kAll[] = {
      {"samples",
       {"x",  "y",  "z",  "light", "wx", "wy", "wz", "pdf", "value", "distance", "selection", "nx",
        "ny", "nz", "gx", "gy",    "gz", "lx", "ly", "lz",  "r",     "g",        "b"},
       {"x", "y", "z", "wx", "wy", "wz"}},
      {"densities",
       {"x", "y", "z", "light", "wx", "wy", "wz", "pdf", "drawn", "nx", "ny", "nz", "gx", "gy",
        "gz", "lx", "ly", "lz", "selection"},
       {"x", "y", "z", "wx", "wy", "wz", "pdf"}},
      {"emission",
       {"x", "y", "z", "light", "wx", "wy", "wz", "pdf_position", "pdf_direction", "value", "nx",
        "ny", "nz", "selection", "r", "g", "b"},
       {"x", "y", "z", "wx", "wy", "wz"}},
      {"power", {"light", "power", "stderr", "r", "g", "b"}, {"light"}},
      {"irradiance",
       {"x", "y", "z", "nx", "ny", "nz", "illuminance", "light", "stderr", "gx", "gy", "gz", "r",
        "g", "b"},
       {"x", "y", "z", "nx", "ny", "nz"}},
      {"visibility",
       {"x", "y", "z", "tx", "ty", "tz", "visible"},
       {"x", "y", "z", "tx", "ty", "tz", "visible"}},
  };
  return kAll[static_cast<std::size_t>(kind)];
}

/// The column with the luminance of the value.
const char* value_column(Kind kind) {
  if (kind == Kind::kPower) return "power";
  if (kind == Kind::kIrradiance) return "illuminance";
  return "value";
}

/// Reads the columns of one table, and checks their numbers.
class Reader {
 public:
  explicit Reader(const NumberTable& table) : table_(table) {}

  bool has(const char* column) const { return table_.column(column) >= 0; }

  /// Numbers for which `allowed` is true.  An empty field is NaN unless the column is required.
  template <class Allowed>
  std::vector<double> numbers(const char* column, const char* what, Allowed&& allowed,
                              bool required = false) const {
    const int at = table_.column(column);
    if (at < 0) return {};
    std::vector<double> values(table_.rows());
    for (std::size_t row = 0; row < values.size(); ++row) {
      values[row] = table_.at(row, static_cast<std::size_t>(at));
      const bool empty = std::isnan(values[row]);
      if (empty ? required : !allowed(values[row])) fail(row, column, what);
    }
    return values;
  }

  /// Three columns such as wx, wy, wz.  Unit vectors if `unit` is set; then they must not be zero.
  std::vector<Double3> triples(const std::array<const char*, 3>& names, bool unit) const {
    const auto given = std::ranges::count_if(names, [&](const char* n) { return has(n); });
    if (given == 0) return {};
    std::vector<Double3> result(table_.rows());
    for (std::size_t i = 0; i < 3; ++i) {
      if (!has(names[i]))
        wrong_use(fmt::format("{}: column \"{}\" is missing; {}, {} and {} come together",
                              table_.path(), names[i], names[0], names[1], names[2]));
      const std::vector<double> one = numbers(
          names[i], "a finite number", [](double v) { return std::isfinite(v); }, true);
      for (std::size_t row = 0; row < one.size(); ++row) result[row][i] = one[row];
    }
    if (!unit) return result;
    for (std::size_t row = 0; row < result.size(); ++row) {
      Double3& v = result[row];
      const double length = std::hypot(v[0], v[1], v[2]);
      if (!(length > 0 && std::isfinite(length)))
        wrong_use(fmt::format("{}: {},{},{} = 0,0,0, allowed: a direction of any length but 0",
                              table_.place(row, static_cast<std::size_t>(table_.column(names[0]))),
                              names[0], names[1], names[2]));
      for (double& c : v) c /= length;
    }
    return result;
  }

  [[noreturn]] void fail(std::size_t row, const char* column, const std::string& allowed) const {
    const auto at = static_cast<std::size_t>(table_.column(column));
    const double value = table_.at(row, at);
    wrong_use(fmt::format("{}: {} = {}, allowed: {}", table_.place(row, at), column,
                          std::isnan(value) ? std::string("nothing") : fmt::format("{:g}", value),
                          allowed));
  }

 private:
  const NumberTable& table_;
};

void check_names(const NumberTable& table, Kind kind) {
  const Columns& known = columns_of(kind);
  for (const std::string& name : table.names()) {
    if (std::ranges::find(known.all, name) == known.all.end())
      wrong_use(fmt::format("{}: column \"{}\" is not known, allowed in {}: {}", table.path(), name,
                            known.name, fmt::join(known.all, ",")));
  }
  for (const std::string& name : known.required) {
    if (table.column(name) < 0)
      wrong_use(fmt::format("{}: column \"{}\" is missing; {} require {}", table.path(), name,
                            known.name, fmt::join(known.required, ",")));
  }
  const char* value = value_column(kind);
  if ((kind == Kind::kPower || kind == Kind::kIrradiance) && table.column(value) < 0 &&
      table.column("r") < 0)
    wrong_use(
        fmt::format("{}: column \"{}\" is missing, or the columns r,g,b", table.path(), value));
}

constexpr auto kNotNegative = [](double v) { return std::isfinite(v) && v >= 0; };

template <class T>
std::vector<T> taken(const std::vector<T>& all, const std::vector<std::size_t>& rows) {
  std::vector<T> result;
  if (all.empty()) return result;
  result.reserve(rows.size());
  for (const std::size_t row : rows) result.push_back(all[row]);
  return result;
}

}  // namespace

const char* name(Kind kind) { return columns_of(kind).name; }

std::vector<std::string> columns(Kind kind) { return columns_of(kind).all; }

Records read_records(Kind kind, const std::string& path,
                     const std::function<absl::StatusOr<double>(std::string_view)>& light_of_name,
                     const std::function<bool(std::uint64_t)>& is_light,
                     const std::string& lights) {
  auto read = NumberTable::read(
      path,
      {.default_names = columns(kind), .word_column = "light", .number_of_word = light_of_name});
  if (!read.ok()) wrong_use(std::string(read.status().message()));
  const auto table = std::make_shared<const NumberTable>(*std::move(read));
  check_names(*table, kind);
  const Reader reader(*table);
  Records r;
  r.kind = kind;
  r.rows = table->rows();
  r.place = [table](std::size_t row) { return table->place(row); };
  r.points = reader.triples({"x", "y", "z"}, false);
  r.normals = reader.triples({"nx", "ny", "nz"}, true);
  r.geometric_normals = reader.triples({"gx", "gy", "gz"}, true);
  r.light_normals = reader.triples({"lx", "ly", "lz"}, true);
  r.directions = reader.triples({"wx", "wy", "wz"}, true);
  r.targets = reader.triples({"tx", "ty", "tz"}, false);
  r.rgb = reader.triples({"r", "g", "b"}, false);
  for (std::size_t row = 0; row < r.rgb.size(); ++row) {
    for (std::size_t i = 0; i < 3; ++i)
      if (r.rgb[row][i] < 0)
        reader.fail(row, std::array{"r", "g", "b"}[i], "a finite number of at least 0");
  }
  const auto level = [&](const char* column, bool required = false) {
    return reader.numbers(column, "a finite number of at least 0", kNotNegative, required);
  };
  r.pdf = level("pdf", kind == Kind::kDensities);
  r.value = level(value_column(kind), r.rgb.empty() && kind != Kind::kSamples);
  if (!r.rgb.empty()) {
    r.value.resize(r.rows);
    for (std::size_t row = 0; row < r.rows; ++row) {
      const float rgb[] = {static_cast<float>(r.rgb[row][0]), static_cast<float>(r.rgb[row][1]),
                           static_cast<float>(r.rgb[row][2])};
      r.value[row] = cli::luminance(rgb);
    }
  }
  r.distance = reader.numbers("distance", "at least 0, or inf for a light at infinity",
                              [](double v) { return v >= 0; });
  r.selection = reader.numbers(
      "selection", "a probability in (0, 1]", [](double v) { return v > 0 && v <= 1; },
      kind == Kind::kEmission);
  r.drawn = reader.numbers(
      "drawn", "a density above 0", [](double v) { return std::isfinite(v) && v > 0; }, true);
  r.standard_error = level("stderr");
  r.pdf_position = level("pdf_position");
  r.pdf_direction = level("pdf_direction");
  const std::vector<double> visible = reader.numbers(
      "visible", "0 or 1", [](double v) { return v == 0 || v == 1; }, true);
  for (const double v : visible) r.visible.push_back(v == 1);
  const std::vector<double> ids = reader.numbers(
      "light", lights.c_str(),
      [&](double v) {
        return v >= 1 && v < 0x1p63 && v == std::floor(v) &&
               is_light(static_cast<std::uint64_t>(v));
      },
      kind == Kind::kPower);
  for (const double id : ids)
    r.lights.push_back(std::isnan(id) ? 0 : static_cast<std::uint64_t>(id));
  return r;
}

Records rows_of(const Records& all, const std::vector<std::size_t>& rows) {
  Records r;
  r.kind = all.kind;
  r.rows = rows.size();
  r.points = taken(all.points, rows);
  r.normals = taken(all.normals, rows);
  r.geometric_normals = taken(all.geometric_normals, rows);
  r.light_normals = taken(all.light_normals, rows);
  r.directions = taken(all.directions, rows);
  r.targets = taken(all.targets, rows);
  r.lights = taken(all.lights, rows);
  r.pdf = taken(all.pdf, rows);
  r.value = taken(all.value, rows);
  r.rgb = taken(all.rgb, rows);
  r.distance = taken(all.distance, rows);
  r.selection = taken(all.selection, rows);
  r.drawn = taken(all.drawn, rows);
  r.standard_error = taken(all.standard_error, rows);
  r.pdf_position = taken(all.pdf_position, rows);
  r.pdf_direction = taken(all.pdf_direction, rows);
  r.visible = taken(all.visible, rows);
  r.place = [rows, place = all.place](std::size_t row) { return place(rows[row]); };
  return r;
}

}  // namespace lucerna::verify
