// A query of one item while renders use all processors.
#include <cmath>
#include <stop_token>
#include <thread>

#include "proto/common/quantile.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

/// Pictures that never end, on threads of their own.
class Renders {
 public:
  Renders(const Subject& subject, int streams) {
    for (int i = 0; i < streams; ++i) {
      threads_.emplace_back([&subject](const std::stop_token& stop) {
        v1::RenderImageRequest request;
        request.set_scene_id(subject.scene());
        request.set_final_only(true);
        request.mutable_accuracy()->set_samples(1 << 20);
        const auto client =
            value_of(client::Client::connect({.target = subject.target()}), "connect");
        client::CallOptions options;
        options.stop = stop;
        (void)client.render_image(
            request, [](const v1::RenderImageResponse&) { return true; }, options);
      });
    }
  }

 private:
  std::vector<std::jthread> threads_;
};

}  // namespace

void priority(const Settings& settings, Report& report) {
  const SceneFiles files;
  Subject subject(files);
  Traffic traffic(subject.target());
  const Seconds time(settings.brief ? 1 : 15);
  // Fifty calls in a second, so that the queries themselves take little.
  const auto ask = [&] {
    const auto calls = open_loop(traffic, {subject.one_item()}, 50, time, Seconds(60));
    report.at_least("queries of one item that succeed",
                    static_cast<double>(latencies(calls, grpc::StatusCode::OK).size()),
                    static_cast<double>(calls.size()), "calls");
    return 1e3 * quantile(latencies(calls, grpc::StatusCode::OK), 0.99);
  };
  (void)ask();
  const double idle_ms = ask();
  const Renders renders(subject, 4);
  const double before = subject.cpu_s();
  const double busy_ms = ask();
  report.at_least("processor time of the renders meanwhile", subject.cpu_s() - before, 0.1, "s");
  report.note("p99 of one item, idle", idle_ms, "ms");
  report.time("p99 of one item, beside renders", busy_ms, 5, "ms");
  report.time("the same over idle", busy_ms / idle_ms, 3, "");
}

}  // namespace lucerna::reliability
