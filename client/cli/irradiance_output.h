// Writes the results of a job in the format of the output file.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/files/open_vectors.h"
#include "client/library/irradiance_job.h"
#include "client/terminal/certainty.h"

namespace lucerna::cli {

struct IrradianceOutput {
  std::string output;   ///< name of the file once it is complete
  std::string results;  ///< file that run_irradiance_job() wrote; deleted afterwards
  client::VectorFormat format;
  v1::EstimateIrradianceRequest request;
  std::uint32_t samples;
  std::string description = {};  ///< for formats that hold one
};

/// The name of a number in the column of statuses, such as "INVALID_INPUT".
std::string status_name(float status);

/// Writes the output file.
///   .npy  the results have this format already
///   .csv  one line for each receiver, the status by its name, numbers with all significant digits:
///         x,y,z,illuminance_lx,red_lx,green_lx,blue_lx,standard_error_lx,zero_bound_lx,status,
///         lower_lx,upper_lx,approximate,unsampled_bound_lx
///   .exr  channels R, G, B, illuminance.Y, zero_bound.Y, status.Y and unsampled_bound.Y in
///         `window`; with two samples or more also standard_error.Y, lower.Y and upper.Y
/// With a target error, .csv has the further columns samples,reached and .exr the channel
/// samples.Y.  The values at the wavelengths come last.
/// UNKNOWN if the file cannot be written.
absl::Status write_irradiance(const IrradianceOutput& options, client::ReceiverSource& receivers,
                              const client::MapWindow* window);

/// Checks the rows that have an answer.  `options` must have a target error.  `header` is the
/// header of the file of results.
absl::StatusOr<TargetCheck> check_results(const IrradianceOutput& options,
                                          const std::string& header, std::uint64_t rows);

}  // namespace lucerna::cli
