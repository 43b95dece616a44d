// One picture on many servers.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "lucerna/client/job.h"
#include "lucerna/client/picture.h"

namespace lucerna::client {

struct RenderJobOptions {
  /// What to render; `scene_id` and `final_only` are of no matter, and there is no time budget. The
  /// bits of the picture are those that RenderImage answers to it, whatever the servers, their
  /// number and the tiles.
  v1::RenderImageRequest request;
  /// Also split each tile's samples, into runs of at most so many; 0: only as far as their number
  /// asks for, which must be made of powers of two.  0 with a target error, where pixels have
  /// samples of their own.
  std::uint64_t samples_per_piece = 0;
  /// What is done is kept here, and a job that was interrupted goes on from it.  Empty: nowhere.
  std::string journal = {};
  /// Each piece of the picture when it has become part of it.
  std::function<void(const v1::Tile&, const PictureAssembler& so_far)> on_tile = {};
  JobOptions job = {};
};

struct RenderJobResult {
  Picture picture;
  JobReport report;
  std::size_t pieces = 0;
  std::size_t from_journal = 0;  ///< of these
  /// Of the pieces that were rendered now; the wall time is the job's.
  v1::Cost cost;
};

/// Errors: those of run_job; INVALID_ARGUMENT for tiles or runs that no picture can be made of, and
/// for a time budget;
/// FAILED_PRECONDITION for a journal of another job, UNKNOWN for one that cannot be written.
absl::StatusOr<RenderJobResult> run_render_job(const RenderJobOptions& options);

}  // namespace lucerna::client
