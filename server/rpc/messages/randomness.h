// The sample values of a request.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "lucerna/v1/lighting.pb.h"
#include "proto/common/status_macros.h"
#include "server/queries/queries.h"
#include "server/rpc/messages/checks.h"

namespace lucerna::rpc {

/// The sample values that a request needs.
struct SampleValuesWanted {
  std::size_t samples;
  std::size_t per_sample;  ///< entries of `u`
  bool light_named;        ///< true: no `u_light`; false: one for each sample
  std::string of;          ///< the samples' name in errors: "samples", "rays"
};

/// INVALID_ARGUMENT for wrong lengths.  Does not check the values.
absl::Status check_sample_values(const v1::SampleValues& values, const SampleValuesWanted& wanted);

/// Sets the seed of the query, or views of the request's own values.  Seed 0 if neither is set.
/// Errors: as above.
template <typename Request, typename Query>
absl::Status put_randomness(const Request& request, const SampleValuesWanted& wanted,
                            Query& query) {
  if (!request.has_u()) {
    query.seed = SeedRange{request.seed().seed(), request.seed().first_item()};
    return absl::OkStatus();
  }
  LUCERNA_RETURN_IF_ERROR(check_sample_values(request.u(), wanted));
  query.u = view(request.u().u());
  query.u_light = view(request.u().u_light());
  return absl::OkStatus();
}

/// INVALID_ARGUMENT for a value outside of [0, 1], or of [0, 1) for `u_light`.  Accepts values that
/// are not finite: the query gives their items a status.
absl::Status check_u(const v1::SampleValues& values);

}  // namespace lucerna::rpc
