#include "server/monitor/metrics_server.h"

#include <fmt/format.h>
#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <exception>
#include <utility>
#include <vector>

#include "server/monitor/metric_families.h"

namespace lucerna::monitor {
namespace {

class Source final : public prometheus::Collectable {
 public:
  explicit Source(std::function<Figures()> figures) : figures_(std::move(figures)) {}
  std::vector<prometheus::MetricFamily> Collect() const override {
    return metric_families(figures_());
  }

 private:
  std::function<Figures()> figures_;
};

}  // namespace

struct MetricsServer::State {
  std::shared_ptr<Source> source;
  prometheus::Exposer exposer;  // destroyed first, so that no request uses the source any more

  State(const std::string& address, std::function<Figures()> figures)
      : source(std::make_shared<Source>(std::move(figures))),
        // A client that sends half a request keeps a thread until the timeout.  A thread that
        // waits costs little.
        exposer(std::vector<std::string>{"listening_ports", address, "num_threads", "64",
                                         "request_timeout_ms", "5000", "enable_keep_alive", "no"}) {
    exposer.RegisterCollectable(source);
  }
};

absl::StatusOr<std::unique_ptr<MetricsServer>> MetricsServer::start(
    const std::string& address, std::function<Figures()> figures) {
  try {
    return std::unique_ptr<MetricsServer>(
        new MetricsServer(std::make_unique<State>(address, std::move(figures))));
  } catch (const std::exception& e) {
    // The library's only errors are those of its socket.
    return absl::UnavailableError(
        fmt::format("cannot serve metrics on {}: {}", address, std::string(e.what())));
  }
}

MetricsServer::MetricsServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
MetricsServer::~MetricsServer() = default;

int MetricsServer::port() const { return state_->exposer.GetListeningPorts().front(); }

}  // namespace lucerna::monitor
