#include "server/monitor/metrics_server.h"

#include <fmt/format.h>

#include <exception>
#include <utility>

namespace lucerna::monitor {
namespace {

class Source final : public prometheus::Collectable {
 public:
  explicit Source(MetricsServer::Families families) : families_(std::move(families)) {}
  std::vector<prometheus::MetricFamily> Collect() const override { return families_(); }

 private:
  MetricsServer::Families families_;
};

}  // namespace

MetricsServer::MetricsServer(const std::string& address, Families families)
    : source_(std::make_shared<Source>(std::move(families))),
      // A client that sends half a request keeps a thread until the timeout.  A thread that waits
      // costs little.
      exposer_(std::vector<std::string>{"listening_ports", address, "num_threads", "64",
                                        "request_timeout_ms", "5000", "enable_keep_alive", "no"}) {
  exposer_.RegisterCollectable(source_);
}

absl::StatusOr<std::unique_ptr<MetricsServer>> MetricsServer::start(const std::string& address,
                                                                    Families families) {
  try {
    return std::unique_ptr<MetricsServer>(new MetricsServer(address, std::move(families)));
  } catch (const std::exception& e) {
    // The library's only errors are those of its socket.
    return absl::UnavailableError(
        fmt::format("cannot serve metrics on {}: {}", address, std::string(e.what())));
  }
}

}  // namespace lucerna::monitor
