// All settings of lucernad.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/lucernad/setting.h"
#include "server/rpc/server.h"

namespace lucerna::config {

/// How the server logs.
struct LogOptions {
  std::string format = "text", level = "info";
  std::uint64_t lines_per_second = 1000;  ///< of calls and of other lines each; 0: no limit
};

struct Options {
  rpc::ServerOptions server;
  LogOptions log;
  std::uint64_t upload_timeout_s = 60;           ///< AssetStoreOptions::stall_time
  std::uint64_t keep_partial_uploads_s = 86400;  ///< AssetStoreOptions::keep_parts
  std::uint64_t drain_seconds = 30;              ///< how long calls may continue after SIGTERM [s]
};

/// The settings, bound to `options`, in the order of the help.  `options` must outlive them.
std::vector<Setting> settings(Options& options);

}  // namespace lucerna::config
