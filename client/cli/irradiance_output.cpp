#include "client/cli/irradiance_output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "client/map_file.h"
#include "client/result_file.h"

namespace lucerna::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRowsPerRead = 4096;

absl::Status write_csv(const std::string& path, const client::ResultFile& results,
                       const IrradianceOutput& options, client::ReceiverSource& receivers) {
  std::ofstream file(path, std::ios::binary);
  fmt::memory_buffer text;
  const auto to = std::back_inserter(text);
  fmt::format_to(to,
                 "x,y,z,illuminance_lx,red_lx,green_lx,blue_lx,standard_error_lx,"
                 "zero_bound_lx,status");
  if (options.request.accuracy().has_target_error())
    fmt::format_to(to, ",lower_lx,upper_lx,samples");
  for (const double nm : options.request.wavelengths_nm())
    fmt::format_to(to, ",irradiance_{}nm_w_m2_nm", nm);
  std::vector<client::Double3> points;
  std::vector<float> normals, rows;
  const std::size_t columns = results.columns();
  for (std::uint64_t first = 0; first < results.rows() && file;) {
    const std::size_t count = std::min<std::uint64_t>(kRowsPerRead, results.rows() - first);
    if (absl::Status s = receivers.read(first, count, points, normals); !s.ok()) return s;
    rows.resize(count * columns);
    if (absl::Status s = results.read(first, rows); !s.ok()) return s;
    for (std::size_t i = 0; i < count; ++i) {
      fmt::format_to(to, "\n{},{},{}", points[i][0], points[i][1], points[i][2]);
      for (std::size_t c = 0; c < columns; ++c) {
        const float value = rows[i * columns + c];
        if (c == client::kStatusColumn) {
          fmt::format_to(to, ",{}", status_name(value));
        } else {
          fmt::format_to(to, ",{}", value);
        }
      }
    }
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    text.clear();
    first += count;
  }
  file << '\n';
  file.close();
  return file ? absl::OkStatus() : absl::UnknownError(path + ": " + std::strerror(errno));
}

absl::Status write_map(const std::string& path, const client::ResultFile& results,
                       const IrradianceOutput& options, const client::MapWindow& window) {
  std::vector<std::string> names = {"illuminance.Y", "R",       "G", "B", "standard_error.Y",
                                    "zero_bound.Y",  "status.Y"};
  if (options.request.accuracy().has_target_error())
    names.insert(names.end(), {"lower.Y", "upper.Y", "samples.Y"});
  for (const double nm : options.request.wavelengths_nm())
    names.push_back(fmt::format("irradiance.{}nm", nm));
  // A column of NaN tells nobody anything, and pictures of NaN upset programs.
  const bool has_error = options.samples != 1;
  std::vector<std::string> channels = names;
  if (!has_error) channels.erase(channels.begin() + client::kStandardErrorColumn);
  auto file = client::MapWriter::create(path, window, channels, options.description);
  if (!file.ok()) return file.status();
  const auto width = static_cast<std::size_t>(window.width);
  std::vector<float> row(width * results.columns());
  for (std::uint64_t first = 0; first < results.rows(); first += width) {
    row.resize(width * results.columns());
    if (absl::Status s = results.read(first, row); !s.ok()) return s;
    if (!has_error) {
      std::size_t at = 0, kept = 0;
      for (; at < row.size(); ++at) {
        if (at % results.columns() != client::kStandardErrorColumn) row[kept++] = row[at];
      }
      row.resize(kept);
    }
    if (absl::Status s = (*file)->write_row(row); !s.ok()) return s;
  }
  return (*file)->close();
}

}  // namespace

std::string status_name(float status) {
  const int number = static_cast<int>(status);
  if (!v1::ItemStatus_IsValid(number)) return fmt::format("{}", number);
  const std::string name = v1::ItemStatus_Name(static_cast<v1::ItemStatus>(number));
  return name.substr(std::string_view("ITEM_STATUS_").size());
}

absl::Status write_irradiance(const IrradianceOutput& options, client::ReceiverSource& receivers,
                              const client::MapWindow* window) {
  std::string complete = options.results;
  if (options.format != client::VectorFormat::kNpy) {
    complete = options.results + "." + std::to_string(::getpid());
    const auto results = client::ResultFile::open(options.results, {}, receivers.size(),
                                                  client::irradiance_columns(options.request));
    absl::Status status = results.status();
    if (status.ok()) {
      status = options.format == client::VectorFormat::kCsv
                   ? write_csv(complete, *results, options, receivers)
                   : write_map(complete, *results, options, *window);
    }
    if (!status.ok()) {
      ::unlink(complete.c_str());
      return status;
    }
  }
  if (::rename(complete.c_str(), options.output.c_str()) != 0)
    return absl::UnknownError(options.output + ": " + std::strerror(errno));
  if (complete != options.results) ::unlink(options.results.c_str());
  return absl::OkStatus();
}

}  // namespace lucerna::cli
