// Writes conformance packs: scenes, and what the server answers about their lights.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/lab/conformance_cases.h"
#include "client/terminal/session.h"

namespace lucerna::conformance {

struct PackOptions {
  std::uint32_t samples = 32;               ///< light samples at each receiver, and rays
  std::uint32_t irradiance_samples = 4096;  ///< at each receiver
  std::uint64_t seed = 0;
};

/// What was written about one case.
struct CaseSummary {
  std::string name, about, kind;
  bool extreme = false;
  std::string scene;  ///< the scene file, relative to the pack
  std::uint64_t samples = 0, densities = 0, emission = 0, irradiances = 0, visibilities = 0;
};

/// Uploads the scene of the case from its files in `directory`/NAME, asks the server, and writes
/// the tables beside the scene file.  The server does not keep the scene.  Any error ends the
/// program.
CaseSummary write_case(cli::Session& session, const Case& scene, const std::string& directory,
                       const PackOptions& options);

/// README.md and manifest.json.
void write_overview(cli::Session& session, const std::vector<CaseSummary>& cases,
                    const std::string& directory, const PackOptions& options);

/// Writes a file, or ends the program.
void write_file(const std::string& path, const std::string& content);

}  // namespace lucerna::conformance
