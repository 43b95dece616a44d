// Renders one picture on several servers.
//
//   RenderJobOptions options;
//   options.request.mutable_accuracy()->set_samples(64);
//   options.job = {.servers = *server_list("a:50051,b:50051"), .load = load_the_scene};
//   const auto result = run_render_job(options);
//   if (result.ok()) save(result->picture);
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "lucerna/client/job.h"
#include "lucerna/client/picture.h"

namespace lucerna::client {

struct RenderJobOptions {
  /// The picture to render.  `scene_id` and `final_only` are ignored; a time budget is not allowed.
  /// The picture has the bits that RenderImage gives for this request, for any servers, any number
  /// of servers and any tile size.
  v1::RenderImageRequest request;
  /// Splits the samples of each tile into runs of at most this many.  0: splits only a number that
  /// is not a power of two, into powers of two.  Must be 0 with a target error, where each pixel
  /// has its own number of samples.
  std::uint64_t samples_per_piece = 0;
  /// The file that keeps finished pieces.  An interrupted job continues from it.  Empty: no
  /// journal.
  std::string journal = {};
  /// Called with each piece when it has become part of the picture.
  std::function<void(const v1::Tile&, const PictureAssembler& so_far)> on_tile = {};
  JobOptions job = {};
};

struct RenderJobResult {
  Picture picture;
  JobReport report;
  std::size_t pieces = 0;
  std::size_t from_journal = 0;  ///< pieces that were done before
  /// Cost of the pieces that were rendered in this run; the wall time is that of the job.
  v1::Cost cost;
};

/// Runs the job.
///
/// Errors:
/// - errors of run_job()
/// - INVALID_ARGUMENT for tile sizes or runs that cannot form a picture, and for a time budget
/// - FAILED_PRECONDITION for the journal of another job
/// - UNKNOWN if the journal cannot be written
absl::StatusOr<RenderJobResult> run_render_job(const RenderJobOptions& options);

}  // namespace lucerna::client
