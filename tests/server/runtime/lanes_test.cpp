#include "server/runtime/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

/// Keeps the two threads of a lane busy until it is released.
class Blockade {
 public:
  Blockade(Lanes& lanes, Lane lane) {
    const std::shared_future<void> opened = open_.get_future().share();
    for (int i = 0; i < 2; ++i) {
      std::promise<void> begun;
      const absl::Status s = lanes.submit(lane, {.run = [&begun, opened](const LaneJobStart&) {
                                            begun.set_value();
                                            opened.wait();
                                          }});
      EXPECT_TRUE(s.ok()) << s;
      begun.get_future().wait();  // one after the other, because the queue may hold only one
    }
  }
  ~Blockade() { release(); }
  void release() {
    if (!std::exchange(released_, true)) open_.set_value();
  }

 private:
  std::promise<void> open_;
  bool released_ = false;
};

absl::StatusCode start_of(Lanes& lanes, Lane lane, LaneJob job) {
  auto code = std::make_shared<std::promise<absl::StatusCode>>();
  job.run = [code](const LaneJobStart& start) { code->set_value(start.status.code()); };
  const absl::Status s = lanes.submit(lane, std::move(job));
  return s.ok() ? code->get_future().get() : s.code();
}

TEST(Lanes, RunsAJobOfEachLane) {
  Lanes lanes({.threads = 2});
  EXPECT_EQ(start_of(lanes, Lane::kInteractive, {}), absl::StatusCode::kOk);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {}), absl::StatusCode::kOk);
  EXPECT_EQ(lanes.threads(), 2);
}

TEST(Lanes, SmallQueriesContinueWhileTheBulkLaneIsBlocked) {
  for (const int threads : {1, 2}) {
    Lanes lanes({.threads = threads});
    Blockade bulk(lanes, Lane::kBulk);
    std::promise<int> sum;
    ASSERT_TRUE(lanes
                    .submit(Lane::kInteractive, {.run =
                                                     [&](const LaneJobStart&) {
                                                       std::atomic<int> n = 0;
                                                       parallel_chunks(100, 1, {},
                                                                       [&](auto, auto) { ++n; });
                                                       sum.set_value(n);
                                                     }})
                    .ok());
    EXPECT_EQ(sum.get_future().get(), 100);
  }
}

TEST(Lanes, RefusesJobsBeyondTheQueue) {
  Lanes lanes({.threads = 1, .bulk_queue = 2});
  std::atomic<int> ran = 0;
  {
    Blockade bulk(lanes, Lane::kBulk);
    const auto count = [&](const LaneJobStart&) { ++ran; };
    EXPECT_TRUE(lanes.submit(Lane::kBulk, {.run = count}).ok());
    EXPECT_TRUE(lanes.submit(Lane::kBulk, {.run = count}).ok());
    const absl::Status refused = lanes.submit(Lane::kBulk, {.run = count});
    EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
    EXPECT_EQ(lanes.pending(Lane::kBulk), 4U);  // two run, two wait
    lanes.resume(Lane::kBulk, {.run = count});  // jobs that were accepted before continue
    EXPECT_EQ(lanes.pending(Lane::kBulk), 5U);
    bulk.release();
    while (lanes.pending(Lane::kBulk) > 0) std::this_thread::yield();
  }
  EXPECT_EQ(ran, 3);
}

TEST(Lanes, DoNotRunCancelledOrLateJobs) {
  Lanes lanes({.threads = 1});
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.stop = stop.get_token()}), absl::StatusCode::kCancelled);
  EXPECT_EQ(start_of(lanes, Lane::kInteractive,
                     {.deadline = LaneJob::Clock::now() - std::chrono::seconds(1)}),
            absl::StatusCode::kDeadlineExceeded);
}

TEST(Lanes, DoNotRunJobsThatCannotMeetTheirDeadline) {
  Lanes lanes({.threads = 1});
  const auto soon = LaneJob::Clock::now() + std::chrono::hours(1);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.deadline = soon, .least_s = 7200}),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.deadline = soon, .least_s = 1e300}),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.deadline = soon, .least_s = 60}), absl::StatusCode::kOk);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.least_s = 1e300}), absl::StatusCode::kOk);
}

/// Records the order in which jobs start.
class Order {
 public:
  /// A job that stays in the lane for an instant.
  LaneJob job(const std::string& name, const std::string& client,
              JobKind kind = JobKind::kComputation) {
    return {.run =
                [this, name](const LaneJobStart&) {
                  const std::lock_guard lock(mutex_);
                  names_.push_back(name);
                },
            .client = client,
            .kind = kind};
  }
  std::vector<std::string> names() {
    const std::lock_guard lock(mutex_);
    return names_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> names_;
};

/// Runs a job of the client until `opened`.
void keep_busy(Lanes& lanes, const char* client, JobKind kind,
               const std::shared_future<void>& opened, Lane lane = Lane::kBulk) {
  std::promise<void> begun;
  EXPECT_TRUE(lanes
                  .submit(lane, {.run =
                                     [&begun, opened](const LaneJobStart&) {
                                       begun.set_value();
                                       opened.wait();
                                     },
                                 .client = client,
                                 .kind = kind})
                  .ok());
  begun.get_future().wait();
}

/// Keeps all places of a kind busy but one.
struct OnePlace {
  OnePlace(Lanes& lanes, JobKind kind) {
    for (const char* client : {"x", "y", "z"}) keep_busy(lanes, client, kind, opened);
  }
  ~OnePlace() { open.set_value(); }
  std::promise<void> open;
  std::shared_future<void> opened = open.get_future().share();
};

TEST(Lanes, ClientsTakeTurns) {
  Lanes lanes({.threads = 1});
  Order order;
  std::promise<void> open;
  const std::shared_future<void> opened = open.get_future().share();
  {
    const OnePlace one(lanes, JobKind::kComputation);
    keep_busy(lanes, "w", JobKind::kComputation, opened);  // the last place
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(lanes.submit(Lane::kBulk, order.job("a", "A")).ok());
    ASSERT_TRUE(lanes.submit(Lane::kBulk, order.job("b", "B")).ok());
    ASSERT_TRUE(lanes.submit(Lane::kBulk, order.job("c", "C")).ok());
    open.set_value();
    while (order.names().size() < 5) std::this_thread::yield();
  }
  EXPECT_EQ(order.names(), (std::vector<std::string>{"a", "b", "c", "a", "a"}));
}

TEST(Lanes, ConnectionsOfAClientTakeTurnsInBothLanes) {
  for (const Lane lane : {Lane::kInteractive, Lane::kBulk}) {
    Lanes lanes({.threads = 1});
    Order order;
    std::promise<void> open, end;
    const std::shared_future<void> opened = open.get_future().share(),
                                   ended = end.get_future().share();
    keep_busy(lanes, "v", JobKind::kComputation, ended, lane);
    if (lane == Lane::kBulk) {
      keep_busy(lanes, "x", JobKind::kComputation, ended);
      keep_busy(lanes, "y", JobKind::kComputation, ended);
    }
    keep_busy(lanes, "w", JobKind::kComputation, opened, lane);  // the last place
    const auto submit = [&](const char* name, const char* client, const void* connection) {
      LaneJob job = order.job(name, client);
      job.connection = connection;
      ASSERT_TRUE(lanes.submit(lane, std::move(job)).ok());
    };
    const char first = 0, second = 0, third = 0;
    for (const char* name : {"a", "b", "c"}) submit(name, "A", &first);
    submit("d", "A", &second);
    submit("e", "A", &second);
    submit("f", "B", &third);
    open.set_value();
    while (order.names().size() < 6) std::this_thread::yield();
    end.set_value();
    EXPECT_EQ(order.names(), (std::vector<std::string>{"a", "f", "d", "b", "e", "c"}));
  }
}

/// Calls that are sent again as soon as they are answered, each by a client and a connection.
class Again {
 public:
  explicit Again(Lanes& lanes) : lanes_(lanes) {}
  ~Again() {
    ended_ = true;
    while (lanes_.pending(Lane::kInteractive) > 0) std::this_thread::yield();
  }
  void send(const std::string& client, const int& connection) {
    const absl::Status sent =
        lanes_.submit(Lane::kInteractive, {.run =
                                               [this, client, &connection](const LaneJobStart&) {
                                                 count(client, connection);
                                                 if (!ended_) send(client, connection);
                                               },
                                           .client = client,
                                           .connection = &connection});
    EXPECT_TRUE(sent.ok()) << sent;
  }
  /// Waits for `all` answers.  Returns the least number that a connection got.
  int least(int all) {
    while (answers_ < all) std::this_thread::yield();
    const std::lock_guard lock(mutex_);
    return std::min_element(counts_.begin(), counts_.end(),
                            [](auto& a, auto& b) { return a.second < b.second; })
        ->second;
  }
  std::size_t served() {
    const std::lock_guard lock(mutex_);
    return counts_.size();
  }

 private:
  void count(const std::string& client, const int& connection) {
    const std::lock_guard lock(mutex_);
    ++counts_[client + std::to_string(connection)];
    ++answers_;
  }
  Lanes& lanes_;
  std::mutex mutex_;
  std::map<std::string, int> counts_;
  std::atomic<int> answers_ = 0;
  std::atomic<bool> ended_ = false;
};

TEST(Lanes, NobodyStarvesBesideOthersThatSendOneCallAfterTheOther) {
  const std::vector<int> connections = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  constexpr int kAnswers = 12'000;
  for (const bool clients : {true, false}) {
    Lanes lanes({.threads = 1});
    std::promise<void> open, end;
    const std::shared_future<void> opened = open.get_future().share(),
                                   ended = end.get_future().share();
    Again calls(lanes);
    // One thread serves all, after all have been sent.
    keep_busy(lanes, "v", JobKind::kComputation, ended, Lane::kInteractive);
    keep_busy(lanes, "w", JobKind::kComputation, opened, Lane::kInteractive);
    for (const int& c : connections) calls.send(clients ? std::to_string(c) : "one", c);
    // One connection has two calls at once.
    calls.send(clients ? "0" : "one", connections.front());
    open.set_value();
    EXPECT_GT(calls.least(kAnswers), kAnswers / 12 / 4);
    EXPECT_EQ(calls.served(), connections.size());
    end.set_value();
  }
}

TEST(Lanes, JobsThatWillProbablyBeLateRunAfterTheOthers) {
  Lanes lanes({.threads = 1});
  Order order;
  std::promise<void> open;
  const std::shared_future<void> opened = open.get_future().share();
  {
    const OnePlace one(lanes, JobKind::kComputation);
    keep_busy(lanes, "w", JobKind::kComputation, opened);  // the last place
    const auto submit = [&](const char* name, double expected_s) {
      LaneJob job = order.job(name, "A");
      job.deadline = LaneJob::Clock::now() + std::chrono::hours(1);
      job.expected_s = expected_s;
      ASSERT_TRUE(lanes.submit(Lane::kBulk, std::move(job)).ok());
    };
    submit("late", 7200);
    submit("close", 2500);
    submit("easy", 60);
    ASSERT_TRUE(lanes.submit(Lane::kBulk, order.job("patient", "A")).ok());
    open.set_value();
    while (order.names().size() < 4) std::this_thread::yield();
  }
  EXPECT_EQ(order.names(), (std::vector<std::string>{"easy", "patient", "close", "late"}));
}

TEST(Lanes, StepsAndWholeComputationsOfAClientTakeTurns) {
  Lanes lanes({.threads = 1});
  Order order;
  std::promise<void> open;
  const std::shared_future<void> opened = open.get_future().share();
  {
    const OnePlace one(lanes, JobKind::kComputation);
    keep_busy(lanes, "w", JobKind::kComputation, opened);  // the last place
    for (int i = 0; i < 4; ++i)
      ASSERT_TRUE(lanes.submit(Lane::kBulk, order.job("step", "A", JobKind::kStep)).ok());
    ASSERT_TRUE(lanes.submit(Lane::kBulk, order.job("tile", "A")).ok());
    open.set_value();
    while (order.names().size() < 5) std::this_thread::yield();
  }
  EXPECT_EQ(order.names()[0], "tile");
}

// Both loads of one client are endless: scenes that include themselves exponentially.
TEST(Lanes, EndlessLoadsOfAClientDelayNeitherComputationsNorLoadsOfOthers) {
  Lanes lanes({.threads = 1});
  std::promise<void> open;
  const std::shared_future<void> opened = open.get_future().share();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(lanes
                    .submit(Lane::kBulk, {.run = [opened](const LaneJobStart&) { opened.wait(); },
                                          .client = "attacker",
                                          .kind = JobKind::kLoad})
                    .ok());
  }
  while (lanes.load(Lane::kBulk).running < 2) std::this_thread::yield();
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.client = "attacker"}), absl::StatusCode::kOk);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.client = "other"}), absl::StatusCode::kOk);
  EXPECT_EQ(start_of(lanes, Lane::kBulk, {.client = "other", .kind = JobKind::kLoad}),
            absl::StatusCode::kOk);
  EXPECT_EQ(lanes.load(Lane::kBulk).waiting, 1U);  // the attacker's third
  open.set_value();
}

TEST(Lanes, AFullQueueDropsJobsThatNobodyWaitsFor) {
  Lanes lanes({.threads = 1, .bulk_queue = 1});
  Blockade bulk(lanes, Lane::kBulk);
  std::stop_source stop;
  std::promise<absl::StatusCode> dropped;
  ASSERT_TRUE(
      lanes
          .submit(Lane::kBulk,
                  {.run = [&](const LaneJobStart& s) { dropped.set_value(s.status.code()); },
                   .stop = stop.get_token()})
          .ok());
  const auto nothing = [](const LaneJobStart&) {};
  EXPECT_FALSE(lanes.submit(Lane::kBulk, {.run = nothing}).ok());
  stop.request_stop();
  EXPECT_TRUE(lanes.submit(Lane::kBulk, {.run = nothing}).ok());
  EXPECT_EQ(dropped.get_future().get(), absl::StatusCode::kCancelled);
}

TEST(Lanes, AnswerWaitingJobsAtTheirEnd) {
  auto lanes = std::make_unique<Lanes>(LaneOptions{.threads = 1});
  auto bulk = std::make_unique<Blockade>(*lanes, Lane::kBulk);
  std::promise<absl::StatusCode> waiting;
  ASSERT_TRUE(
      lanes
          ->submit(Lane::kBulk,
                   {.run = [&](const LaneJobStart& s) { waiting.set_value(s.status.code()); }})
          .ok());
  std::thread end([&] { lanes.reset(); });
  EXPECT_EQ(waiting.get_future().get(), absl::StatusCode::kUnavailable);
  bulk->release();
  end.join();
}

}  // namespace
}  // namespace lucerna
