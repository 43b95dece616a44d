// SIGTERM while calls arrive.
#include <fmt/core.h>
#include <grpc/health/v1/health.pb.h>
#include <signal.h>

#include <atomic>
#include <map>
#include <optional>
#include <stdexcept>
#include <thread>

#include "proto/common/quantile.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

/// Asks for the health of the server until it is not serving, and returns when that was.
class HealthWatch {
 public:
  explicit HealthWatch(const std::string& target) : stub_(make_channel(target)) {
    const grpc::health::v1::HealthCheckRequest request;
    const grpc::Slice slice(request.SerializeAsString());
    const grpc::ByteBuffer bytes(&slice, 1);
    stream_ = stub_.PrepareCall(&context_, "/grpc.health.v1.Health/Watch", &queue_);
    stream_->StartCall(nullptr);
    next();
    stream_->WriteLast(bytes, grpc::WriteOptions(), nullptr);
    next();
    (void)read();  // SERVING
    thread_ = std::thread([this] {
      while (true) {
        const auto status = read();
        if (status == grpc::health::v1::HealthCheckResponse::SERVING) continue;
        if (status) at_ = Clock::now();
        return;
      }
    });
  }
  ~HealthWatch() {
    context_.TryCancel();
    if (thread_.joinable()) thread_.join();
    grpc::Status status;
    stream_->Finish(&status, nullptr);
    next();
    queue_.Shutdown();
    void* tag = nullptr;
    bool ok = false;
    while (queue_.Next(&tag, &ok)) {
    }
  }
  HealthWatch(const HealthWatch&) = delete;
  HealthWatch& operator=(const HealthWatch&) = delete;

  /// When the server stopped serving; nothing if the stream ended without saying so.
  std::optional<Clock::time_point> wait() {
    thread_.join();
    return at_;
  }

 private:
  bool next() {
    void* tag = nullptr;
    bool ok = false;
    return queue_.Next(&tag, &ok) && ok;
  }
  std::optional<grpc::health::v1::HealthCheckResponse::ServingStatus> read() {
    grpc::ByteBuffer bytes;
    stream_->Read(&bytes, nullptr);
    grpc::Slice slice;
    if (!next() || !bytes.DumpToSingleSlice(&slice).ok()) return std::nullopt;
    grpc::health::v1::HealthCheckResponse response;
    response.ParseFromArray(slice.begin(), static_cast<int>(slice.size()));
    return response.status();
  }

  grpc::CompletionQueue queue_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream_;
  std::thread thread_;
  std::optional<Clock::time_point> at_;
};

// Longer than a server drains.
constexpr Seconds kPatience(120);

/// One server, and a sender that counts what happens to its calls.
void one_server(const SceneFiles& files, std::vector<double>& not_serving_ms,
                std::map<std::string, int>& ends) {
  Subject subject(files);
  const std::vector<Message> messages = {subject.one_item(), subject.irradiance(1024, 64),
                                         subject.tile(64, 64)};
  HealthWatch health(subject.target());
  Traffic traffic(subject.target());
  bool told = false;
  Clock::time_point signal;
  const auto stop = after(Clock::now(), Seconds(0.5));
  const auto on_end = [&](const Ended& call) {
    const std::string& text = call.status.error_message();
    // Only a server that did not accept the call gives this reason.  One that has ended takes no
    // connection.
    const bool draining = call.status.error_details().find("DRAINING") != std::string::npos ||
                          text.find("failed to connect") != std::string::npos;
    if (call.status.ok()) {
      ++ends["ok"];
    } else if (told && draining) {
      ++ends["refused"];
    } else {
      ++ends[fmt::format("{} {}", static_cast<int>(call.status.error_code()), text)];
    }
  };
  std::size_t sent = 0;
  const auto end = after(stop, Seconds(1));
  while (Clock::now() < end) {
    while (traffic.running() < 12)
      traffic.begin(messages[sent++ % messages.size()], Clock::now(), kPatience);
    traffic.poll(after(Clock::now(), Seconds(0.002)), on_end);
    if (!told && Clock::now() >= stop) {
      told = true;
      signal = Clock::now();
      ::kill(subject.server().process_id(), SIGTERM);
      const auto at = health.wait();
      if (at) not_serving_ms.push_back(1e3 * Seconds(*at - signal).count());
    }
    if (told && ends.contains("refused")) break;  // what follows is refused too
  }
  while (traffic.running() > 0) traffic.poll(after(Clock::now(), Seconds(0.01)), on_end);
  if (const int exit = subject.server().stop(); exit != 0)
    ++ends[fmt::format("exit status {}", exit)];
}

/// Calls that go on until the server is gone.  Returns how many end with a code that clients do not
/// repeat.
int calls_that_clients_give_up(const SceneFiles& files) {
  Subject subject(files);
  Traffic traffic(subject.target());
  const Message message = subject.one_item();
  int given_up = 0, good = 0;
  bool gone = false;
  const auto on_end = [&](const Ended& call) {
    if (call.status.error_code() == grpc::StatusCode::UNAVAILABLE) {
      gone |= call.status.error_message().find("failed to connect") != std::string::npos;
    } else if (call.status.ok()) {
      ++good;
    } else {
      fmt::print("    {} {}\n", static_cast<int>(call.status.error_code()),
                 call.status.error_message());
      ++given_up;
    }
  };
  const auto stop = after(Clock::now(), Seconds(0.2)), last = after(stop, kPatience);
  bool told = false;
  while (!gone && Clock::now() < last) {
    while (traffic.running() < 64) traffic.begin(message, Clock::now(), kPatience);
    traffic.poll(after(Clock::now(), Seconds(0.001)), on_end);
    if (!told && Clock::now() >= stop) {
      told = true;
      ::kill(subject.server().process_id(), SIGTERM);
    }
  }
  while (traffic.running() > 0) traffic.poll(after(Clock::now(), Seconds(0.01)), on_end);
  if (!gone || good == 0) throw std::runtime_error("the server did not end under calls");
  return given_up;
}

}  // namespace

void drain(const Settings& settings, Report& report) {
  const SceneFiles files;
  const int repeats = settings.brief ? 2 : 20;
  std::vector<double> not_serving_ms;
  std::map<std::string, int> ends;
  for (int i = 0; i < repeats; ++i) one_server(files, not_serving_ms, ends);
  report.at_least("drains that said NOT_SERVING", static_cast<double>(not_serving_ms.size()),
                  repeats, "");
  report.time("SIGTERM until NOT_SERVING, most", quantile(not_serving_ms, 1), 100, "ms");
  report.note("calls that succeeded", ends["ok"], "calls");
  report.note("calls that were refused by a draining server", ends["refused"], "calls");
  int failed = 0;
  for (const auto& [why, count] : ends) {
    if (why == "ok" || why == "refused") continue;
    fmt::print("    {} x {}\n", count, why);
    failed += count;
  }
  report.at_most("accepted calls and servers that failed", failed, 0, "calls");
  int given_up = 0;
  for (int i = 0; i < 2 * repeats; ++i) given_up += calls_that_clients_give_up(files);
  report.at_most("calls that end as if their client had cancelled them", given_up, 0, "calls");

  // Two servers.  Each in turn ends and starts again, and clients go on.
  int good = 0, bad = 0;
  for (int i = 0; i < repeats; ++i) {
    std::optional<Subject> first(std::in_place, files), second(std::in_place, files);
    const std::string target = "ipv4:" + first->target() + "," + second->target();
    const auto client = value_of(client::Client::connect({.target = target}), "connect");
    std::atomic<int> succeeded{0}, failed_calls{0};
    std::vector<std::jthread> senders;
    for (int s = 0; s < 4; ++s) {
      senders.emplace_back([&](const std::stop_token& stop) {
        v1::EstimateIrradianceRequest query;
        query.set_scene_id(first->scene());
        *query.mutable_receivers() = points_above(256);
        for (int n = 0; n < 256; ++n)
          for (const float x : {0.0F, 0.0F, 1.0F}) query.add_normals(x);
        while (!stop.stop_requested()) {
          const auto answer =
              client.estimate_irradiance(query, client::CallOptions::within(kPatience));
          if (!answer.ok()) fmt::print("    {}\n", answer.status().ToString());
          ++(answer.ok() ? succeeded : failed_calls);
        }
      });
    }
    const auto wait_for_calls = [&](int more) {
      for (const int until = succeeded + failed_calls + more; succeeded + failed_calls < until;)
        std::this_thread::yield();
    };
    wait_for_calls(40);
    (i % 2 == 0 ? first : second)->server().stop();
    wait_for_calls(40);
    for (std::jthread& sender : senders) sender.request_stop();
    senders.clear();
    good += succeeded;
    bad += failed_calls;
  }
  report.note("with a second server: calls that succeeded", good, "calls");
  report.at_most("with a second server: calls that failed", bad, 0, "calls");
}

}  // namespace lucerna::reliability
