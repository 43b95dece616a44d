// A thousand servers and a million pieces in simulated time, with the schedule of real jobs.
//
// Servers differ in speed; one in twenty has a tenth of the usual speed.  They die and restart, or
// hang without an answer.  The time of the schedule is compared with the time that the same servers
// would need if no work were lost, delayed or repeated.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <queue>
#include <random>
#include <set>
#include <type_traits>

#include "client/library/job_schedule.h"

namespace lucerna::client {
namespace {

using Time = JobSchedule::Time;
using ServerId = JobSchedule::ServerId;
using AttemptId = JobSchedule::AttemptId;

// All times in seconds.
constexpr double kLatency = 0.005;
constexpr double kPrepare = 3;       // connect, upload, build
constexpr double kPatience = 10;     // job.cpp's limit for a silent server
constexpr double kKeepalive = 40;    // until gRPC reports that a halted server is gone
constexpr double kMedianPiece = 1;   // on a server of speed 1
constexpr double kSigma = 1;         // of the logarithm
constexpr double kMeanUp = 3600;     // until a server dies
constexpr double kDown = 60;         // until it is back
constexpr double kHaltShare = 0.25;  // share of deaths that are halts

class Simulation final : JobSchedule::Channel {
 public:
  Simulation(std::size_t pieces, std::size_t servers)
      : schedule_({}, *this, at(0)), servers_(servers) {
    schedule_.set_pieces(pieces);
    std::lognormal_distribution<double> piece(std::log(kMedianPiece), kSigma);
    work_.resize(pieces);
    for (double& w : work_) total_ += w = piece(random_);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < servers; ++i) {
      names.push_back("server" + std::to_string(1000 + i));
      servers_[i].speed =
          std::exp(std::normal_distribution(0.0, 0.3)(random_)) * (i % 20 == 7 ? 0.1 : 1);
      later(time_to_death(), [this, i] { die(i); });
    }
    schedule_.list(names, at(0));
  }

  void run() {
    while (!schedule_.over()) {
      const double due = seconds(scheduled([&] { return schedule_.advance(at(now_)); }));
      if (events_.empty() || due < events_.top().when) {
        now_ = std::max(now_, due);
        continue;
      }
      Event event = events_.top();
      events_.pop();
      now_ = std::max(now_, event.when);
      event.what();
    }
  }

  const JobSchedule& schedule() const { return schedule_; }
  double makespan() const { return now_; }
  double longest_piece() const { return *std::max_element(work_.begin(), work_.end()); }
  int deaths() const { return deaths_; }
  double schedule_cpu_s() const { return cpu_.count(); }
  /// When the same servers, with the same up times, would finish the pure work.
  double ideal() const {
    std::vector<std::pair<double, double>> changes;  // changes of the total speed
    for (const Server& server : servers_) {
      for (const auto& [from, to] : server.up_times) {
        changes.emplace_back(from, server.speed);
        changes.emplace_back(to, -server.speed);
      }
      if (server.up) changes.emplace_back(server.up_since, server.speed);
    }
    std::sort(changes.begin(), changes.end());
    double left = total_, speed = 0, time = 0;
    for (const auto& [when, change] : changes) {
      if (left <= speed * (when - time)) break;
      left -= speed * (when - time);
      time = when;
      speed += change;
    }
    return time + left / speed;
  }

 private:
  struct Server {
    double speed = 1;
    bool up = true;
    double up_since = 0;
    std::vector<std::pair<double, double>> up_times;  // finished up times
    int life = 0;                                     // number of its current process
    std::deque<AttemptId> queue;                      // the first is in progress
    int turn = 0;                                     // counts ends of the first
    bool preparing = false;
  };
  struct Event {
    double when;
    std::uint64_t order;
    std::function<void()> what;
    bool operator<(const Event& e) const {
      return when != e.when ? when > e.when : order > e.order;
    }
  };

  static Time at(double s) {
    return Time(std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(s)));
  }
  static double seconds(Time t) {
    return t == Time::max() ? 1e300
                            : std::chrono::duration<double>(t.time_since_epoch()).count() + 1e-9;
  }
  void later(double delay, std::function<void()> what) {
    events_.push({now_ + delay, order_++, std::move(what)});
  }
  double time_to_death() { return std::exponential_distribution(1 / kMeanUp)(random_); }
  /// Time of the schedule itself.
  template <class F>
  std::invoke_result_t<F> scheduled(F f) {
    const auto begun = std::chrono::steady_clock::now();
    struct Add {
      Simulation& s;
      std::chrono::steady_clock::time_point begun;
      ~Add() { s.cpu_ += std::chrono::steady_clock::now() - begun; }
    } add{*this, begun};
    return f();
  }

  void die(ServerId id) {
    Server& server = servers_[id];
    ++deaths_;
    server.up = false;
    server.up_times.emplace_back(server.up_since, now_);
    ++server.life;
    ++server.turn;
    const bool halts = std::bernoulli_distribution(kHaltShare)(random_);
    server.preparing = false;
    for (const AttemptId attempt : std::exchange(server.queue, {}))
      answer(attempt, absl::UnavailableError("gone"), halts ? kKeepalive : kLatency);
    later(kDown, [this, id] {
      Server& back = servers_[id];
      back.up = true;
      back.up_since = now_;
      later(time_to_death(), [this, id] { die(id); });
    });
  }

  void answer(AttemptId attempt, const absl::Status& status, double delay) {
    later(delay, [this, attempt, status] {
      if (!under_way_.erase(attempt)) return;  // it was cancelled
      scheduled([&] { return schedule_.finished(attempt, status, at(now_)); });
    });
  }

  /// The server continues with the first in its queue.
  void work(ServerId id) {
    Server& server = servers_[id];
    if (server.queue.empty()) return;
    const AttemptId attempt = server.queue.front();
    const double time = work_[schedule_.pieces().attempt(attempt).piece] / server.speed;
    later(time, [this, id, attempt, turn = server.turn] {
      Server& s = servers_[id];
      if (turn != s.turn) return;
      ++s.turn;
      s.queue.pop_front();
      answer(attempt, absl::OkStatus(), kLatency);
      work(id);
    });
  }

  // Calls of the schedule.  A death while a server is prepared equals a failure.

  void prepare(ServerId id, const std::string&) override {
    const Server& server = servers_[id];
    const bool up = server.up;
    later(up ? kPrepare : kPatience, [this, id, up, life = server.life] {
      absl::StatusOr<JobSchedule::Prepared> answer = absl::UnavailableError("not there");
      if (up && servers_[id].life == life) answer = JobSchedule::Prepared{"f", "scene"};
      scheduled([&] { schedule_.prepared(id, answer, at(now_)); });
    });
  }

  void renew(ServerId id) override {
    later(2 * kLatency, [this, id, life = servers_[id].life] {
      const Server& server = servers_[id];
      const absl::Status status = server.up && server.life == life ? absl::OkStatus()
                                  : server.up                      ? absl::NotFoundError("scene_id")
                                                                   : absl::UnavailableError("gone");
      scheduled([&] { schedule_.renewed(id, status, at(now_)); });
    });
  }

  void start(AttemptId attempt, ServerId id, std::size_t) override {
    under_way_.insert(attempt);
    if (!servers_[id].up) return answer(attempt, absl::UnavailableError("gone"), kLatency);
    later(kLatency, [this, attempt, id, life = servers_[id].life] {
      Server& server = servers_[id];
      if (!under_way_.contains(attempt)) return;
      if (life != server.life) return answer(attempt, absl::UnavailableError("gone"), kLatency);
      server.queue.push_back(attempt);
      if (server.queue.size() == 1) work(id);
    });
  }

  void cancel(AttemptId attempt) override {
    const ServerId id = schedule_.pieces().attempt(attempt).server;
    later(kLatency, [this, attempt, id] {
      if (!under_way_.contains(attempt)) return;
      Server& server = servers_[id];
      const auto found = std::find(server.queue.begin(), server.queue.end(), attempt);
      if (found != server.queue.end()) {
        const bool first = found == server.queue.begin();
        server.queue.erase(found);
        if (first) {
          ++server.turn;
          work(id);
        }
      }
      answer(attempt, absl::CancelledError(), 0);
    });
  }

  void report(const std::string&) override {}

  std::mt19937_64 random_{20};
  double now_ = 0;
  std::priority_queue<Event> events_;
  std::uint64_t order_ = 0;
  std::set<AttemptId> under_way_;
  std::vector<double> work_;
  double total_ = 0;
  int deaths_ = 0;
  std::chrono::duration<double> cpu_{};
  JobSchedule schedule_;
  std::vector<Server> servers_;
};

TEST(JobSimulation, AThousandServersReachNineTenthsOfIdeal) {
  Simulation simulation(1'000'000, 1000);
  simulation.run();
  EXPECT_TRUE(simulation.schedule().status().ok()) << simulation.schedule().status();
  EXPECT_TRUE(simulation.schedule().pieces().all_done());
  // The number that follows from the rate: 1000 servers for half an hour with one death an hour.
  EXPECT_GT(simulation.deaths(), 300);
  const double share = simulation.ideal() / simulation.makespan();
  EXPECT_GT(share, 0.9);
  EXPECT_LT(share, 1.0);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  RecordProperty("share_of_ideal", std::to_string(share));
  RecordProperty("simulated_s", std::to_string(simulation.makespan()));
  RecordProperty("deaths", simulation.deaths());
  RecordProperty("duplicates", std::to_string(simulation.schedule().duplicates()));
  RecordProperty("schedule_us_per_piece", std::to_string(simulation.schedule_cpu_s()));
  RecordProperty("peak_rss_mib", std::to_string(usage.ru_maxrss / 1024));
}

// Three pieces per server: the last ones decide, and a slow server must not.
TEST(JobSimulation, StragglersDoNotDecideWhenAShortJobEnds) {
  Simulation simulation(3000, 1000);
  simulation.run();
  EXPECT_TRUE(simulation.schedule().pieces().all_done());
  EXPECT_LT(simulation.makespan(), kPrepare + 2 * simulation.longest_piece());
}

}  // namespace
}  // namespace lucerna::client
