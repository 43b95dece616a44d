// --servers: one picture, or the light at many points, on many servers.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "client/cli/preview.h"
#include "client/jobs/held_scene.h"
#include "client/jobs/render_job.h"
#include "client/terminal/progress.h"
#include "client/terminal/session.h"

namespace lucerna::cli {

struct ServersOption {
  std::string servers;
  bool upload = false;
  std::string asset_root;
  std::uint64_t samples_per_piece = 0;
  std::string journal;
  client::HeldScene* held = nullptr;  ///< who brings the scene, where pictures follow each other

  /// --servers and what goes with them; `pictures`: with --split-samples.
  void add(CLI::App& command, bool pictures = true);
  explicit operator bool() const { return !servers.empty(); }
  /// Ends the program where the others are given without --servers.
  void check() const;

  /// A job of these servers, or of the one that --server names; tells what happens to servers on
  /// stderr.  This, `bar` and the session outlive it.  Ends the program where `servers` cannot be.
  client::JobOptions job(Session& session, const std::string& scene, ProgressBar& bar) const;

  /// The picture, with a bar and what happens to servers on stderr.
  client::RenderJobResult render(Session& session, const std::string& scene,
                                 const v1::RenderImageRequest& request, Preview& preview) const;
};

/// What is to be said of a picture's bits; empty where they are those of one fingerprint.
std::string describe_mixed(const client::JobReport& report);

}  // namespace lucerna::cli
