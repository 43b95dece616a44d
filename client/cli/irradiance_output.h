// Results of a job as the file that was asked for.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/files/open_vectors.h"
#include "client/jobs/irradiance_job.h"
#include "client/terminal/certainty.h"

namespace lucerna::cli {

struct IrradianceOutput {
  std::string output;   ///< the name that the file gets once it is complete
  std::string results;  ///< as run_irradiance_job() left them; gone afterwards
  client::VectorFormat format;
  v1::EstimateIrradianceRequest request;
  std::uint32_t samples;
  std::string description = {};  ///< for files that have a place for it
};

/// "INVALID_INPUT", of a status as it stands in a column.
std::string status_name(float status);

/// Of .npy the results are the file already.  .csv: a line of
///   x,y,z,illuminance_lx,red_lx,green_lx,blue_lx,standard_error_lx,zero_bound_lx,status,
///   lower_lx,upper_lx,approximate
/// for each receiver, numbers with as many digits as tell every bit, status by name.  .exr:
/// channels R, G, B, illuminance.Y, zero_bound.Y, status.Y and, where there is more than a sample,
/// standard_error.Y, lower.Y and upper.Y in `window`.  Of both, with a target error the samples
/// follow (samples,reached; samples.Y), then wavelengths.  UNKNOWN where it cannot be written.
absl::Status write_irradiance(const IrradianceOutput& options, client::ReceiverSource& receivers,
                              const client::MapWindow* window);

/// Of the rows that have an answer; `options` with a target error.  `header`: of the results.
absl::StatusOr<TargetCheck> check_results(const IrradianceOutput& options,
                                          const std::string& header, std::uint64_t rows);

}  // namespace lucerna::cli
