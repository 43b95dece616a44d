// Results of a job as the file that was asked for.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "client/irradiance_job.h"
#include "client/vector_file.h"

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
///   x,y,z,illuminance_lx,red_lx,green_lx,blue_lx,standard_error_lx,zero_bound_lx,status
/// for each receiver, numbers with as many digits as tell every bit, status by name.  .exr:
/// channels R, G, B, illuminance.Y, standard_error.Y (where there is more than a sample),
/// zero_bound.Y and status.Y in `window`.  Of both, with a target error the ends of the interval
/// and the samples follow (lower_lx,upper_lx,samples; lower.Y, upper.Y, samples.Y), then
/// wavelengths.  UNKNOWN where it cannot be written.
absl::Status write_irradiance(const IrradianceOutput& options, client::ReceiverSource& receivers,
                              const client::MapWindow* window);

}  // namespace lucerna::cli
