#include "server/runtime/scheduling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "server/runtime/lanes.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

/// Whether this system has time slices for each thread: Linux 6.12 and later.
bool has_time_slices() {
  bool found = false;
  std::thread([&] {
    set_time_slice(TimeSlice::kShort);
    found = time_slice_ns() == 100'000;
  }).join();
  return found;
}

/// The niceness and the time slice of each thread that works on a loop of the lane.
std::set<std::pair<int, std::uint64_t>> threads_of(Lanes& lanes, Lane lane) {
  std::set<std::pair<int, std::uint64_t>> found;
  std::mutex mutex;
  std::promise<void> ended;
  const auto look = [&](std::size_t, std::size_t) {
    const std::lock_guard lock(mutex);
    found.emplace(thread_niceness(), time_slice_ns());
  };
  EXPECT_TRUE(lanes
                  .submit(lane, {.run =
                                     [&](const LaneJobStart&) {
                                       parallel_chunks(10'000, 1, {}, look);
                                       ended.set_value();
                                     }})
                  .ok());
  ended.get_future().wait();
  return found;
}

TEST(Scheduling, ATimeSliceIsSetResetAndInherited) {
  if (!has_time_slices()) GTEST_SKIP() << "this system has no time slices for each thread";
  std::thread([] {
    const std::uint64_t before = time_slice_ns();
    set_time_slice(TimeSlice::kShort);
    EXPECT_EQ(time_slice_ns(), 100'000U);
    std::thread([] { EXPECT_EQ(time_slice_ns(), 100'000U); }).join();
    set_time_slice(TimeSlice::kDefault);
    EXPECT_EQ(time_slice_ns(), before);
  }).join();
}

TEST(Scheduling, ThreadsOfTheBulkLaneAreNicerAndInteractiveOnesHaveShortTurns) {
  std::thread([] {
    // The lanes inherit this, as those of lucernad do.
    set_time_slice(TimeSlice::kShort);
    const int own = thread_niceness();
    Lanes lanes({.threads = 4});
    const bool slices = time_slice_ns() == 100'000;
    // Loads come first in a server, so the bulk lane starts oneTBB's workers.
    for (const auto& [niceness, slice] : threads_of(lanes, Lane::kBulk)) {
      EXPECT_EQ(niceness, std::min(own + 10, 19));
      if (slices) {
        EXPECT_GT(slice, 100'000U);
      }
    }
    bool first = false;
    for (const auto& [niceness, slice] : threads_of(lanes, Lane::kInteractive)) {
      // Workers that came from the bulk lane stay nicer in a process without privileges.
      first = first || niceness == own;
      if (slices) {
        EXPECT_EQ(slice, 100'000U);
      }
    }
    EXPECT_TRUE(first);
  }).join();
}

}  // namespace
}  // namespace lucerna
