// The loops against a simulated target, whose clock the test moves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "client/cli/bench_load.h"
#include "client/cli/rate_search.h"

namespace lucerna {
namespace {

using bench::CallEnd;
using bench::Figures;
using ::testing::ElementsAre;
using ::testing::Pair;

/// A server that answers calls one after the other.
class Simulation final : public bench::Target {
 public:
  /// The time that the call of this number takes, and its status.
  std::function<double(int)> service_s = [](int) { return 1.0; };
  std::function<absl::Status(int)> status = [](int) { return absl::OkStatus(); };
  /// The time that send() takes.
  double send_s = 0;
  /// The time that server_cpu_s() takes.
  double question_s = 0;
  bool tells_cpu = true;
  double stop_at_s = std::numeric_limits<double>::infinity();

  double now_s() override { return now_s_; }
  void send(double due_s) override {
    EXPECT_LE(due_s, now_s_);
    now_s_ += send_s;
    const double begin_s = std::max(now_s_, busy_until_s_);
    const double length_s = service_s(sent_);
    busy_until_s_ = begin_s + length_s;
    cpu_s_ += length_s;
    CallEnd end{.due_s = due_s, .end_s = busy_until_s_, .status = status(sent_)};
    end.bytes_sent = 10;
    end.bytes_received = 100;
    end.items = 4;
    end.samples = 8;
    end.rays = 16;
    ends_.emplace(busy_until_s_, end);
    ++sent_;
    most_in_flight = std::max(most_in_flight, ends_.size());
  }
  std::optional<CallEnd> wait(double until_s) override {
    const double next_s = ends_.empty() ? until_s : ends_.begin()->first;
    if (ends_.empty() || next_s > until_s) {
      now_s_ = std::max(now_s_, until_s);
      return std::nullopt;
    }
    now_s_ = std::max(now_s_, next_s);
    CallEnd end = ends_.begin()->second;
    ends_.erase(ends_.begin());
    return end;
  }
  std::optional<double> server_cpu_s() override {
    now_s_ += question_s;
    if (!tells_cpu) return std::nullopt;
    return cpu_s_;
  }
  void cancel() override { ends_.clear(); }
  bool stopped() override { return now_s_ >= stop_at_s; }

  int sent() const { return sent_; }
  std::size_t most_in_flight = 0;

 private:
  double now_s_ = 1000, busy_until_s_ = 0, cpu_s_ = 0;
  int sent_ = 0;
  std::multimap<double, CallEnd> ends_;
};

TEST(ClosedLoop, KeepsTheCallsInFlightAndStopsWhenStable) {
  Simulation target;
  target.service_s = [](int) { return 0.25; };
  const Figures figures =
      closed_loop(target, 5, {.warm_up_s = 2, .time_s = 100, .window_s = 1, .windows = 3});
  EXPECT_EQ(target.most_in_flight, 5U);
  // Three windows of four calls each.
  EXPECT_TRUE(figures.stable);
  EXPECT_DOUBLE_EQ(figures.seconds, 3);
  EXPECT_EQ(figures.calls(), 12U);
  // Each call waits for the four before it.
  EXPECT_FLOAT_EQ(figures.latency_s(0.5), 1.25);
  EXPECT_FLOAT_EQ(figures.latency_s(1), 1.25);
  EXPECT_EQ(figures.items, 48U);
  EXPECT_EQ(figures.samples, 96U);
  EXPECT_EQ(figures.rays, 192U);
  EXPECT_EQ(figures.bytes_sent, 120U);
  EXPECT_EQ(figures.bytes_received, 1200U);
  EXPECT_DOUBLE_EQ(figures.server_cpu_s.value_or(0), 3);
}

TEST(ClosedLoop, EndsAtTheTimeLimitIfTheThroughputVaries) {
  Simulation target;
  // Slower with every call.
  target.service_s = [](int call) { return 0.01 * (call + 1); };
  const Figures figures = closed_loop(target, 1, {.warm_up_s = 0, .time_s = 10, .window_s = 1});
  EXPECT_FALSE(figures.stable);
  EXPECT_DOUBLE_EQ(figures.seconds, 10);
  // 0.01 n (n + 1) / 2 <= 10.
  EXPECT_EQ(figures.calls(), 44U);
}

TEST(ClosedLoop, CallsThatEndWhileTheServerIsAskedDoNotCount) {
  Simulation target;
  target.service_s = [](int) { return 0.25; };
  target.question_s = 0.6;
  const Figures figures = closed_loop(target, 1, {.warm_up_s = 1, .time_s = 100, .window_s = 1});
  EXPECT_EQ(figures.calls(), 12U);
}

TEST(ClosedLoop, CountsFailuresAndEndsIfAllCallsFail) {
  Simulation target;
  target.service_s = [](int) { return 0.25; };
  target.status = [](int call) {
    return call % 4 == 3 ? absl::ResourceExhaustedError("full") : absl::OkStatus();
  };
  const Figures some = closed_loop(target, 1, {.warm_up_s = 0, .time_s = 100, .window_s = 1});
  EXPECT_EQ(some.calls(), 9U);
  EXPECT_THAT(some.failures, ElementsAre(Pair("RESOURCE_EXHAUSTED", 3)));
  EXPECT_EQ(some.bytes_received, 900U);

  Simulation broken;
  broken.service_s = [](int) { return 0.25; };
  broken.status = [](int) { return absl::UnavailableError("gone"); };
  const Figures none = closed_loop(broken, 1, {.warm_up_s = 0, .time_s = 100, .window_s = 1});
  EXPECT_EQ(none.calls(), 0U);
  EXPECT_EQ(none.failed(), 4U);
  EXPECT_EQ(none.error, absl::UnavailableError("gone"));
}

TEST(ClosedLoop, EndsAfterAStop) {
  Simulation target;
  target.stop_at_s = 1002.5;
  const Figures figures = closed_loop(target, 1, {.warm_up_s = 0, .time_s = 100, .windows = 50});
  EXPECT_EQ(figures.calls(), 3U);
}

TEST(OpenLoop, LatencyCountsFromTheTimeACallWasDue) {
  // A server that one call holds for 50 s.  A loop that sends late would see one long latency; here
  // all calls that were due meanwhile are late.
  Simulation target;
  target.service_s = [](int call) { return call == 100 ? 50.0 : 0.001; };
  const Figures figures = open_loop(target, 10, 1, {.warm_up_s = 1, .time_s = 100});
  EXPECT_NEAR(static_cast<double>(figures.calls()), 1000, 5 * std::sqrt(1000.0));
  // Half of the calls are due in the 50 s; half of these wait for more than 25 s.
  EXPECT_NEAR(figures.latency_s(0.75), 25, 5);
  EXPECT_GT(figures.latency_s(1), 45);
  EXPECT_LT(figures.latency_s(0.25), 0.1);
}

TEST(OpenLoop, LatencyIncludesTheDelayOfABusySender) {
  // 10 calls in a second are due, but the sender manages 5.
  Simulation target;
  target.service_s = [](int) { return 0.001; };
  target.send_s = 0.2;
  const Figures figures = open_loop(target, 10, 1, {.warm_up_s = 0, .time_s = 100});
  EXPECT_GT(figures.latency_s(0.5), 30);
  EXPECT_GT(figures.seconds, 150);
}

TEST(OpenLoop, QueuesAsTheoryOfPoissonArrivalsSays) {
  // M/D/1 at half load: the mean wait is half a service time, and half of the calls do not wait
  // (Pollaczek-Khinchine).
  Simulation target;
  target.service_s = [](int) { return 1.0; };
  const Figures figures = open_loop(target, 0.5, 7, {.warm_up_s = 100, .time_s = 40'000});
  const auto n = static_cast<double>(figures.calls());
  // Poisson: the variance of the count equals its mean.
  EXPECT_NEAR(n, 20'000, 5 * std::sqrt(20'000.0));
  EXPECT_FLOAT_EQ(figures.latency_s(0.45), 1);
  EXPECT_GT(figures.latency_s(0.55), 1.0001);
  double sum_s = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) sum_s += figures.latency_s((i + 0.5) / kSteps);
  // The standard error of the mean is about 0.02, because waits are correlated.
  EXPECT_NEAR(sum_s / kSteps, 1.5, 0.1);
}

TEST(OpenLoop, EqualSeedsGiveEqualArrivals) {
  const auto gaps = [](std::uint64_t seed) {
    bench::PoissonArrivals arrivals(100, seed);
    std::vector<double> result(1000);
    for (double& gap : result) gap = arrivals.next_s();
    return result;
  };
  EXPECT_EQ(gaps(3), gaps(3));
  EXPECT_NE(gaps(3), gaps(4));
}

TEST(OpenLoop, EndsIfTooManyCallsWait) {
  Simulation target;
  target.service_s = [](int) { return 1.0; };
  const Figures figures = open_loop(target, 1000, 1, {.warm_up_s = 0, .time_s = 100});
  EXPECT_TRUE(figures.overloaded);
  EXPECT_EQ(target.most_in_flight, bench::kMostInFlight + 1);
  // All calls count: those in flight have no answer.
  EXPECT_EQ(figures.calls() + figures.failed(), static_cast<std::uint64_t>(target.sent()));
  EXPECT_EQ(figures.failures.at("DEADLINE_EXCEEDED"), bench::kMostInFlight + 1);
}

TEST(OpenLoop, CallsWithoutAnAnswerFail) {
  Simulation target;
  target.service_s = [](int call) { return call == 50 ? 1e6 : 0.001; };
  const Figures figures = open_loop(target, 10, 1, {.warm_up_s = 1, .time_s = 10});
  EXPECT_FALSE(figures.overloaded);
  EXPECT_GT(figures.failures.at("DEADLINE_EXCEEDED"), 20U);
  EXPECT_GT(figures.calls(), 20U);
  // The arrivals of 10 s, and as long for the answers.
  EXPECT_GT(figures.seconds, 19);
  EXPECT_LE(figures.seconds, 20);
}

TEST(OpenLoop, AServerThatDoesNotTellItsTimeIsUnknown) {
  Simulation target;
  target.tells_cpu = false;
  target.service_s = [](int) { return 0.001; };
  EXPECT_FALSE(open_loop(target, 10, 1, {.warm_up_s = 1, .time_s = 10}).server_cpu_s.has_value());
}

TEST(RateSearch, FindsTheHighestRateThatHolds) {
  for (const double truth : {0.3, 1.0, 99.0, 1234.0, 1e5}) {
    for (const double first : {1.0, 100.0, 5000.0}) {
      const auto found =
          bench::highest_rate([&](double rate) { return rate <= truth; }, first, 0.05);
      ASSERT_TRUE(found.has_value());
      EXPECT_LE(*found, truth);
      EXPECT_GE(*found * 1.05, truth);
    }
  }
  EXPECT_FALSE(bench::highest_rate([](double) { return false; }, 100, 0.05).has_value());
  EXPECT_EQ(bench::highest_rate([](double) { return true; }, 1, 0.05), 1 << 20);
}

TEST(RateSearch, FindsTheRateOfASimulatedServer) {
  // M/D/1 with a service time of 1 ms: the calls of a rate near 1000/s wait without end.
  const auto holds = [](double rate) {
    Simulation target;
    target.service_s = [](int) { return 0.001; };
    const Figures figures = open_loop(target, rate, 5, {.warm_up_s = 1, .time_s = 20});
    return figures.failed() == 0 && figures.latency_s(0.99) <= 0.005;
  };
  const auto found = bench::highest_rate(holds, 100, 0.05);
  ASSERT_TRUE(found.has_value());
  // The wait of M/D/1 exceeds 4 service times for 1% of the calls at a load of 0.67 or so.
  EXPECT_GT(*found, 550);
  EXPECT_LT(*found, 800);
}

TEST(RateSearch, ReadsLimits) {
  const auto limit = bench::read_latency_limit("p99.9=20ms");
  ASSERT_TRUE(limit.has_value());
  EXPECT_DOUBLE_EQ(limit->quantile, 0.999);
  EXPECT_DOUBLE_EQ(limit->latency_s, 0.02);
  for (const char* text : {"", "p99", "99=5ms", "p=5ms", "p0=5ms", "p100=5ms", "p99=0s", "p99=-1s",
                           "p99=5 apples", "pnan=5ms", "p99=inf"})
    EXPECT_FALSE(bench::read_latency_limit(text).has_value()) << text;
}

}  // namespace
}  // namespace lucerna
