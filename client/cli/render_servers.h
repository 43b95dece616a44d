// The option --servers: one picture, or the light at many points, on many servers.
#pragma once

#include <string>

#include "client/cli/preview.h"
#include "client/library/held_scene.h"
#include "client/library/render_job.h"
#include "client/terminal/progress.h"
#include "client/terminal/session.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

struct ServersOption {
  std::string servers;
  bool upload = false;
  std::string asset_root;
  std::uint64_t samples_per_piece = 0;
  std::string journal;
  client::HeldScene* held =
      nullptr;  ///< keeps the scene loaded between the pictures of an animation

  /// Adds --servers and the options that need it; with `pictures` also --split-samples.
  void add(CLI::App& command, bool pictures = true);
  explicit operator bool() const { return !servers.empty(); }
  /// Ends the program if the other options are given without --servers.
  void check() const;

  /// A job on these servers, or on the server of --server.  It prints events of servers to stderr.
  /// This object, `bar` and the session must outlive it.  Ends the program for a wrong list.
  client::JobOptions job(Session& session, const std::string& scene, ProgressBar& bar) const;

  /// Renders the picture with a progress bar.
  client::RenderJobResult render(Session& session, const std::string& scene,
                                 const v1::RenderImageRequest& request, Preview& preview) const;
};

/// A note on the fingerprints of a picture's servers; empty for one fingerprint.
std::string describe_mixed(const client::JobReport& report);

}  // namespace lucerna::cli
