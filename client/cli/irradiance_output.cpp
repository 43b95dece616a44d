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

#include "client/files/map_file.h"
#include "client/library/result_file.h"
#include "proto/common/status_macros.h"

namespace lucerna::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRowsPerRead = 4096;

/// Adds the receiver to `check`.  Returns whether it met the target; false if it has no answer.
bool add_row(const float* row, TargetCheck& check) {
  const float status = row[client::kStatusColumn];
  return is_answered(static_cast<int>(status)) &&
         check.add(row[0], row[client::kLowerColumn],
                   row[client::kUpperColumn] - row[client::kUnsampledColumn],
                   static_cast<std::uint64_t>(row[client::kSamplesColumn]) + kDefaultBlocks);
}

absl::Status write_csv(const std::string& path, const client::ResultFile& results,
                       const IrradianceOutput& options, client::ReceiverSource& receivers) {
  std::ofstream file(path, std::ios::binary);
  std::string text =
      "x,y,z,illuminance_lx,red_lx,green_lx,blue_lx,standard_error_lx,"
      "zero_bound_lx,status,lower_lx,upper_lx,approximate,unsampled_bound_lx";
  const v1::Accuracy& accuracy = options.request.accuracy();
  const bool approximate = is_approximate(accuracy);
  TargetCheck check(accuracy.target_error());
  if (accuracy.has_target_error()) text += ",samples,reached";
  for (const double nm : options.request.wavelengths_nm())
    text += fmt::format(",irradiance_{}nm_w_m2_nm", nm);
  std::vector<client::Double3> points;
  std::vector<float> normals, rows;
  const std::size_t columns = results.columns();
  for (std::uint64_t first = 0; first < results.rows() && file;) {
    const std::size_t count = std::min<std::uint64_t>(kRowsPerRead, results.rows() - first);
    LUCERNA_RETURN_IF_ERROR(receivers.read(first, count, points, normals));
    rows.resize(count * columns);
    LUCERNA_RETURN_IF_ERROR(results.read(first, rows));
    for (std::size_t i = 0; i < count; ++i) {
      text += fmt::format("\n{},{},{}", points[i][0], points[i][1], points[i][2]);
      const float* row = rows.data() + i * columns;
      for (std::size_t c = 0; c < columns; ++c) {
        if (c == client::kStatusColumn) {
          text += fmt::format(",{}", status_name(row[c]));
        } else {
          text += fmt::format(",{}", row[c]);
        }
        if (c == client::kUpperColumn) text += fmt::format(",{}", approximate);
        if (c == client::kSamplesColumn && accuracy.has_target_error())
          text += fmt::format(",{}", add_row(row, check));
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
  std::vector<std::string> names = {
      "illuminance.Y", "R",        "G",       "B",       "standard_error.Y",
      "zero_bound.Y",  "status.Y", "lower.Y", "upper.Y", "unsampled_bound.Y"};
  if (options.request.accuracy().has_target_error()) names.emplace_back("samples.Y");
  for (const double nm : options.request.wavelengths_nm())
    names.push_back(fmt::format("irradiance.{}nm", nm));
  // A single sample has no error.  Its columns would be NaN, which some programs cannot show.
  const bool has_error = options.samples != 1;
  const auto kept_column = [has_error](std::size_t c) {
    return has_error || (c != client::kStandardErrorColumn && c != client::kLowerColumn &&
                         c != client::kUpperColumn);
  };
  std::vector<std::string> channels;
  for (std::size_t c = 0; c < names.size(); ++c) {
    if (kept_column(c)) channels.push_back(names[c]);
  }
  LUCERNA_ASSIGN_OR_RETURN(const auto file,
                           client::MapWriter::create(path, window, channels, options.description));
  const auto width = static_cast<std::size_t>(window.width);
  std::vector<float> row(width * results.columns());
  for (std::uint64_t first = 0; first < results.rows(); first += width) {
    row.resize(width * results.columns());
    LUCERNA_RETURN_IF_ERROR(results.read(first, row));
    if (!has_error) {
      std::size_t at = 0, kept = 0;
      for (; at < row.size(); ++at) {
        if (kept_column(at % results.columns())) row[kept++] = row[at];
      }
      row.resize(kept);
    }
    LUCERNA_RETURN_IF_ERROR(file->write_row(row));
  }
  return file->close();
}

}  // namespace

std::string status_name(float status) {
  const int number = static_cast<int>(status);
  if (!v1::ItemStatus_IsValid(number)) return fmt::format("{}", number);
  const std::string name = v1::ItemStatus_Name(static_cast<v1::ItemStatus>(number));
  return name.substr(std::string_view("ITEM_STATUS_").size());
}

absl::StatusOr<TargetCheck> check_results(const IrradianceOutput& options,
                                          const std::string& header, std::uint64_t rows) {
  LUCERNA_ASSIGN_OR_RETURN(const client::ResultFile results,
                           client::ResultFile::open(options.results, header, rows,
                                                    client::irradiance_columns(options.request)));
  TargetCheck check(options.request.accuracy().target_error());
  std::vector<float> values;
  for (std::uint64_t first = 0; first < rows; first += kRowsPerRead) {
    const std::size_t count = std::min<std::uint64_t>(kRowsPerRead, rows - first);
    values.resize(count * results.columns());
    LUCERNA_RETURN_IF_ERROR(results.read(first, values));
    for (std::size_t i = 0; i < count; ++i) add_row(values.data() + i * results.columns(), check);
  }
  return check;
}

absl::Status write_irradiance(const IrradianceOutput& options, client::ReceiverSource& receivers,
                              const client::MapWindow* window) {
  std::string complete = options.results;
  if (options.format != client::VectorFormat::kNpy) {
    // The next run overwrites what a killed one leaves.  ResultFile admits one process at a time.
    complete = options.results + ".complete";
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
