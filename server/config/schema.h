// All settings of lucernad.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/config/setting.h"
#include "server/rpc/server.h"

namespace lucerna::config {

struct Options {
  rpc::ServerOptions server;
  std::uint64_t drain_seconds = 30;  ///< how long calls may continue after SIGTERM [s]
};

/// The settings, bound to `options`, in the order of the help.  `options` must outlive them.
std::vector<Setting> settings(Options& options);

}  // namespace lucerna::config
