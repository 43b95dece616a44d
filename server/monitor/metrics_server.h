// Serves the metrics over HTTP, for Prometheus.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "server/monitor/figures.h"

namespace lucerna::monitor {

/// Answers GET /metrics until it is destroyed.
class MetricsServer {
 public:
  /// `address`: HOST:PORT; port 0 is a free port.  Calls `figures` for each request, on a thread of
  /// its own.  UNAVAILABLE if it cannot listen there.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> start(const std::string& address,
                                                              std::function<Figures()> figures);
  ~MetricsServer();

  /// The port in use.
  int port() const;

 private:
  struct State;
  explicit MetricsServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace lucerna::monitor
