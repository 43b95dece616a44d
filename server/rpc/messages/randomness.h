// The sample values of a request.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <span>
#include <string>

#include "lucerna/v1/lighting.pb.h"
#include "server/estimate/queries/queries.h"

namespace lucerna::rpc {

/// Either a seed, or views of the request's own values.
struct Randomness {
  std::optional<SeedRange> seed;
  std::span<const float> u;
  std::span<const double> u_light;
};

/// The sample values that a request needs.
struct SampleValuesWanted {
  std::size_t samples;
  std::size_t per_sample;  ///< entries of `u`
  bool light_named;        ///< true: no `u_light`; false: one for each sample
  std::string of;          ///< the samples' name in errors: "samples", "rays"
};

/// INVALID_ARGUMENT for wrong lengths.  Does not check the values.
absl::StatusOr<Randomness> check_sample_values(const v1::SampleValues& values,
                                               const SampleValuesWanted& wanted);

/// Seed 0 if neither values nor a seed are set.  Errors: as above.
template <typename Request>
absl::StatusOr<Randomness> check_randomness(const Request& request,
                                            const SampleValuesWanted& wanted);

/// INVALID_ARGUMENT for a value outside of [0, 1], or of [0, 1) for `u_light`.  Accepts values that
/// are not finite: the query gives their items a status.
absl::Status check_u(const v1::SampleValues& values);

extern template absl::StatusOr<Randomness> check_randomness(const v1::SampleLiRequest&,
                                                            const SampleValuesWanted&);
extern template absl::StatusOr<Randomness> check_randomness(const v1::SampleLeRequest&,
                                                            const SampleValuesWanted&);

}  // namespace lucerna::rpc
