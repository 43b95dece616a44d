#include "server/runtime/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <future>
#include <stop_token>
#include <thread>
#include <vector>

#include "server/runtime/lanes.h"

namespace lucerna {
namespace {

TEST(ParallelChunks, VisitEveryItemOnceInAlignedChunks) {
  Lanes lanes({.threads = 2});
  std::vector<std::atomic<int>> visits(1001);
  std::promise<void> done;
  ASSERT_TRUE(lanes
                  .submit(Lane::kInteractive,
                          {.run =
                               [&](const LaneJobStart&) {
                                 parallel_chunks(visits.size(), 8, {}, [&](auto begin, auto end) {
                                   EXPECT_EQ(begin % 8, 0U);
                                   for (auto i = begin; i < end; ++i) ++visits[i];
                                 });
                                 done.set_value();
                               }})
                  .ok());
  done.get_future().wait();
  for (const auto& v : visits) EXPECT_EQ(v, 1);
}

TEST(ParallelChunks, LeaveOutChunksAfterAStop) {
  std::stop_source stop;
  std::atomic<int> chunks = 0;
  parallel_chunks(1'000'000, 1, stop.get_token(), [&](auto, auto) {
    ++chunks;
    stop.request_stop();
  });
  EXPECT_GE(chunks, 1);
  EXPECT_LT(chunks, 1000);  // at most one per thread
}

TEST(ParallelChunks, StayOnOneThreadWhileOtherJobsKeepTheProcessorsBusy) {
  std::atomic<int> running = 2;
  const SharedProcessors shared(running, 2);
  EXPECT_TRUE(SharedProcessors::are_busy());
  const auto self = std::this_thread::get_id();
  std::size_t visited = 0;
  parallel_chunks(64, 1, {}, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(std::this_thread::get_id(), self);
    visited += end - begin;
  });
  EXPECT_EQ(visited, 64U);
  // The other job ends within the loop, and the rest of the chunks may have help.
  std::atomic<std::size_t> all = 0;
  parallel_chunks(64, 1, {}, [&](std::size_t begin, std::size_t) {
    if (begin < 8) {
      EXPECT_EQ(std::this_thread::get_id(), self);
    }
    if (begin == 7) running = 1;
    ++all;
  });
  EXPECT_EQ(all, 64U);
  EXPECT_FALSE(SharedProcessors::are_busy());
}

TEST(CpuMeter, CountsTheTimeOfAllThreadsThatHelp) {
  Lanes lanes({.threads = 2});
  std::promise<double> seconds;
  constexpr std::int64_t kChunkNs = 2'000'000;
  std::atomic<std::int64_t> burnt_ns = 0;
  ASSERT_TRUE(lanes
                  .submit(Lane::kInteractive, {.run =
                                                   [&](const LaneJobStart&) {
                                                     const CpuMeter meter;
                                                     parallel_chunks(16, 1, {}, [&](auto, auto) {
                                                       const std::int64_t begin = thread_cpu_ns();
                                                       while (thread_cpu_ns() - begin < kChunkNs) {
                                                       }
                                                       burnt_ns += thread_cpu_ns() - begin;
                                                     });
                                                     seconds.set_value(meter.seconds());
                                                   }})
                  .ok());
  // Processor time, not wall time.  It includes the time of all threads and does not depend on
  // other load.
  EXPECT_GE(seconds.get_future().get(), 1e-9 * static_cast<double>(burnt_ns));
  EXPECT_GE(burnt_ns, 16 * kChunkNs);
}

}  // namespace
}  // namespace lucerna
