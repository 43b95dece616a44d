// render --servers: one picture on many servers.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "client/cli/preview.h"
#include "client/cli/session.h"
#include "client/render_job.h"

namespace lucerna::cli {

struct ServersOption {
  std::string servers;
  bool upload = false;
  std::string asset_root;
  bool allow_mixed = false;
  std::uint64_t samples_per_piece = 0;
  std::string journal;

  void add(CLI::App& command);
  explicit operator bool() const { return !servers.empty(); }
  /// Ends the program where the others are given without --servers.
  void check() const;

  /// The picture, with a bar and what happens to servers on stderr.
  client::RenderJobResult render(Session& session, const std::string& scene,
                                 const v1::RenderImageRequest& request, Preview& preview) const;
};

/// What is to be said of a picture's bits; empty where they are those of one fingerprint.
std::string describe_mixed(const client::JobReport& report);

}  // namespace lucerna::cli
