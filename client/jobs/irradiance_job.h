// The light that arrives at any number of receivers, by many servers, from files into a file.
//
// The receivers are read run by run, and results are written where they belong as they arrive, in
// whatever order.  So what this process holds does not grow with their number, but for some 100
// bytes a piece (of 8192 receivers where samples are few): else it is the requests and answers
// that are under way, 24 and at most 29 bytes a receiver on the wire, JobOptions::window pieces a
// server.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lucerna/client/batches.h"
#include "lucerna/client/job.h"
#include "lucerna/client/points.h"

namespace lucerna::client {

/// Where light arrives: points, and the normals of the surfaces there.
class ReceiverSource {
 public:
  virtual ~ReceiverSource() = default;
  virtual std::uint64_t size() const = 0;
  /// Puts receivers [first, first + count) into `points` and `normals` (x, y, z interleaved), in
  /// place of what they held.  One thread at a time; in order once, then any run, and the same runs
  /// again.  Errors end the job.
  virtual absl::Status read(std::uint64_t first, std::size_t count, std::vector<Double3>& points,
                            std::vector<float>& normals) = 0;
};

struct IrradianceJobOptions {
  /// What to ask of each receiver: receivers, normals and `scene_id` are of no matter, `per_light`
  /// must be unset.  The bits are those that EstimateIrradiance answers to all receivers in one
  /// request made by make_points(), whatever the servers, their number and the pieces.
  v1::EstimateIrradianceRequest request;
  ReceiverSource* receivers = nullptr;
  /// The file of the results: `header`, then for each receiver irradiance_columns() floats.
  std::string results;
  std::string header = {};
  /// Which receivers are done is kept here, and a job that was interrupted goes on from it and the
  /// file of results.  Empty: nowhere.
  std::string journal = {};
  /// 0: by the number of samples, at most kGoodBatchItems and as the servers allow.
  std::uint32_t items_per_piece = 0;
  JobOptions job;
};

/// Of a receiver's results, in this order:
///   illuminance [lx]; irradiance R, G, B [lx]; standard error of the illuminance [lx], NaN where a
///   single sample gives none; zero bound [lx]; status (lucerna.v1.ItemStatus, 1 where all is
///   well); the ends of the interval that holds the illuminance [lx], NaN likewise; with a target
///   error the samples; then the irradiance at each of the request's wavelengths [W/m2/nm]
/// as EstimateIrradianceResponse describes them.
inline constexpr std::size_t kIrradianceColumns = 9;
inline constexpr std::size_t kStandardErrorColumn = 4, kStatusColumn = 6, kLowerColumn = 7,
                             kUpperColumn = 8;
inline constexpr std::size_t kSamplesColumn = 9;  ///< with a target error
std::size_t irradiance_columns(const v1::EstimateIrradianceRequest& request);

struct IrradianceJobResult {
  JobReport report;
  std::size_t pieces = 0;          ///< that were done now
  std::uint64_t from_journal = 0;  ///< receivers
  std::uint32_t samples = 0;       ///< for each receiver
  /// How many receivers have each status, by its number.
  std::array<std::uint64_t, 8> statuses{};
  /// Of what was done now; the wall time is the job's.
  v1::Cost cost;
};

/// Reads all receivers once before it asks any server.
///
/// Errors: those of run_job and of the receivers; INVALID_ARGUMENT where there are none, or too
/// many for so small pieces (2^24), and for a time budget; FAILED_PRECONDITION for the journal of
/// another job, whose results stay as they are; UNKNOWN where the journal or the results cannot be
/// written, or another job has them.
absl::StatusOr<IrradianceJobResult> run_irradiance_job(const IrradianceJobOptions& options);

}  // namespace lucerna::client
