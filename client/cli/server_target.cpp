#include "client/cli/server_target.h"

#include <sys/prctl.h>

#include <chrono>
#include <utility>

namespace lucerna::bench {
namespace {

using Clock = std::chrono::steady_clock;

// By default Linux may end a wait 50 us late, which an open loop would add to latencies.
constexpr unsigned long kTimerSlackNs = 1000;

Clock::time_point moment(double s) {
  return Clock::time_point(
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s)));
}

}  // namespace

ServerTarget::ServerTarget(const client::Client& client, const client::ByteCalls& calls,
                           Question question, const Requests& requests, client::CallOptions options)
    : client_(client),
      calls_(calls),
      question_(question),
      requests_(requests),
      options_(std::move(options)) {
  prctl(PR_SET_TIMERSLACK, kTimerSlackNs, 0, 0, 0);
}

ServerTarget::~ServerTarget() { cancel(); }

double ServerTarget::now_s() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

void ServerTarget::send(double due_s) {
  {
    const std::lock_guard lock(mutex_);
    ++in_flight_;
  }
  const std::string& request = requests_.bytes[next_];
  next_ = (next_ + 1) % requests_.bytes.size();
  CallEnd begun;
  begun.due_s = due_s;
  begun.bytes_sent = request.size();
  begun.items = requests_.items;
  calls_.call(
      requests_.method, request, {.deadline = options_.deadline, .stop = cancel_.get_token()},
      [this, begun](const absl::StatusOr<std::string>& response) { take(begun, response); });
}

void ServerTarget::take(CallEnd end, const absl::StatusOr<std::string>& response) {
  end.status = response.status();
  if (response.ok()) {
    end.bytes_received = response->size();
    const absl::StatusOr<Answer> answer = read_answer(question_, *response);
    end.status = answer.status();
    if (answer.ok()) {
      end.samples = answer->samples;
      end.rays = answer->rays;
    }
  }
  // The caller has its answer when it has read it.
  end.end_s = now_s();
  // Notifies under the lock, because the target may be destroyed when no call is in flight.
  const std::lock_guard lock(mutex_);
  ends_.push_back(std::move(end));
  --in_flight_;
  changed_.notify_all();
}

std::optional<CallEnd> ServerTarget::wait(double until_s) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, options_.stop, moment(until_s), [&] { return !ends_.empty(); });
  if (ends_.empty()) return std::nullopt;
  CallEnd end = std::move(ends_.front());
  ends_.pop_front();
  return end;
}

std::optional<double> ServerTarget::server_cpu_s() {
  const auto stats = client_.get_stats({}, options_);
  if (!stats.ok() || !stats->has_process()) return std::nullopt;
  return stats->process().cpu_s();
}

void ServerTarget::cancel() {
  cancel_.request_stop();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return in_flight_ == 0; });
  ends_.clear();
  cancel_ = std::stop_source();
}

bool ServerTarget::stopped() {
  return options_.stop.stop_requested() || std::chrono::system_clock::now() >= options_.deadline;
}

}  // namespace lucerna::bench
