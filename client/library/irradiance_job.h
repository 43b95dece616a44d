// Computes irradiance at any number of receivers on several servers, from files into a file.
//
//   IrradianceJobOptions options{
//       .receivers = &source, .results = "out.bin", .journal = "out.journal"};
//   options.request.mutable_accuracy()->set_samples(256);
//   options.job = {.servers = *server_list("a:50051,b:50051"), .load = load_the_scene};
//   const auto result = run_irradiance_job(options);
//
// Receivers are read in runs, and results are written to their rows in the order of their arrival.
// So the memory of this process does not grow with the number of receivers, except for about 100
// bytes per piece.  A piece has at most 8192 receivers.  The requests and answers in progress also
// need memory: JobOptions::window pieces per server, with 24 to 29 bytes per receiver on the wire.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "lucerna/client/batches.h"
#include "lucerna/client/job.h"
#include "lucerna/client/points.h"

namespace lucerna::client {

/// The receivers: points, and the normals of the surfaces there.
class ReceiverSource {
 public:
  virtual ~ReceiverSource() = default;
  virtual std::uint64_t size() const = 0;
  /// Replaces `points` [m] and `normals` (x, y, z interleaved) by receivers [first, first + count).
  /// Only one thread calls it.  The job first reads all receivers once in order, and then any runs,
  /// possibly several times.  An error ends the job.
  virtual absl::Status read(std::uint64_t first, std::size_t count, std::vector<Double3>& points,
                            std::vector<float>& normals) = 0;
};

struct IrradianceJobOptions {
  /// The query for each receiver.  Receivers, normals and `scene_id` are ignored; `per_light` must
  /// be unset.  The results have the bits that EstimateIrradiance gives for one request with all
  /// receivers, made by make_points().  This holds for any servers, any number of servers and any
  /// pieces.
  v1::EstimateIrradianceRequest request;
  ReceiverSource* receivers = nullptr;
  /// The file of the results: `header`, then irradiance_columns() floats for each receiver.
  std::string results;
  std::string header = {};
  /// The file that records which receivers are done.  An interrupted job continues from it and from
  /// the results.  Empty: no journal.
  std::string journal = {};
  /// Receivers of a piece.  0: chosen by the number of samples, at most kGoodBatchItems and the
  /// limit of the servers.
  std::uint32_t items_per_piece = 0;
  JobOptions job;
};

/// Columns of a receiver's results, in this order:
/// - illuminance [lx]
/// - irradiance R, G, B [lx]
/// - standard error of the illuminance [lx]; NaN for a single sample
/// - zero bound [lx]
/// - status (lucerna.v1.ItemStatus, 1 is ITEM_STATUS_OK)
/// - lower and upper end of the interval of the illuminance [lx]; NaN if there is none
/// - part of the upper end that bounds light which no sample finds [lx]
/// - number of samples, only with a target error
/// - irradiance at each of the request's wavelengths [W/m2/nm]
///
/// EstimateIrradianceResponse describes the values.
inline constexpr std::size_t kIrradianceColumns = 10;
inline constexpr std::size_t kStandardErrorColumn = 4, kStatusColumn = 6, kLowerColumn = 7,
                             kUpperColumn = 8, kUnsampledColumn = 9;
inline constexpr std::size_t kSamplesColumn = 10;  ///< only with a target error
std::size_t irradiance_columns(const v1::EstimateIrradianceRequest& request);

struct IrradianceJobResult {
  JobReport report;
  std::size_t pieces = 0;          ///< done in this run
  std::uint64_t from_journal = 0;  ///< receivers that were done before
  std::uint32_t samples = 0;       ///< per receiver
  /// Number of receivers with each status, indexed by the status.  A status that this library does
  /// not know counts as ITEM_STATUS_UNSPECIFIED.
  std::array<std::uint64_t, v1::ItemStatus_ARRAYSIZE> statuses{};
  /// The places of surfaces that this run's answers name in `missed_surfaces`.
  std::set<std::string> missed_surfaces;
  /// Cost of this run; the wall time is that of the job.
  v1::Cost cost;
};

/// Runs the job.  Reads all receivers once before it calls any server.
///
/// Errors:
/// - errors of run_job() and of the receivers
/// - INVALID_ARGUMENT for no receivers, for more than 2^24 pieces, and for a time budget
/// - FAILED_PRECONDITION for the journal of another job, whose results stay unchanged
/// - UNKNOWN if the journal or the results cannot be written, or another job uses them
absl::StatusOr<IrradianceJobResult> run_irradiance_job(const IrradianceJobOptions& options);

}  // namespace lucerna::client
