// Serves the metrics over HTTP, for Prometheus.
#pragma once

#include <absl/status/statusor.h>
#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace lucerna::monitor {

/// Answers GET /metrics until it is destroyed.
class MetricsServer {
 public:
  using Families = std::function<std::vector<prometheus::MetricFamily>()>;

  /// `address`: HOST:PORT; port 0 is a free port.  Calls `families` for each request, on a thread
  /// of its own.  UNAVAILABLE if it cannot listen there.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> start(const std::string& address,
                                                              Families families);

  /// The port in use.
  int port() const { return exposer_.GetListeningPorts().front(); }

 private:
  MetricsServer(const std::string& address, Families families);

  std::shared_ptr<prometheus::Collectable> source_;
  prometheus::Exposer exposer_;  // destroyed first, so that no request uses the source any more
};

}  // namespace lucerna::monitor
