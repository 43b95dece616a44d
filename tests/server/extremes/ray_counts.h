// Counts rays with wrong answers.
#pragma once

#include <gtest/gtest.h>
#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <random>
#include <stdexcept>
#include <string>

#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/everything.h"
#include "tests/server/extremes/wire_settings.h"

namespace lucerna::testing {

struct Count {
  std::int64_t rays = 0, leaks = 0, shadows = 0, left_out = 0, textbook = 0;
  Count& operator+=(const Count& c) {
    rays += c.rays, leaks += c.leaks, shadows += c.shadows, left_out += c.left_out;
    textbook += c.textbook;
    return *this;
  }
  /// The server's answer and that of a fixed epsilon, each compared with the reference.
  void add(const ExactAnswer& truth, bool occluded, bool textbook_occluded) {
    ++rays;
    const bool sure = truth.sure();
    if (!sure && !truth.crossings.empty()) {
      ++left_out;
      return;
    }
    leaks += sure && !occluded;
    shadows += !sure && occluded;
    textbook += sure != textbook_occluded;
  }
};

/// `make soak` sets ten times as many rays.
inline std::size_t rays_times() {
  const absl::StatusOr<std::uint64_t> times = whole_number_of("LUCERNA_RAYS_TIMES", 1, 1);
  if (!times.ok()) throw std::runtime_error(std::string(times.status().message()));
  return *times;
}

/// Sums `f(random, count)` over `n` calls.  Each chunk of calls has its own random numbers.
template <typename F>
Count counted(std::size_t n, F&& f) {
  n *= rays_times();
  tbb::enumerable_thread_specific<Count> counts;
  parallel_chunks(n, 4096, {}, [&](std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    std::mt19937_64 random(begin + 1);
    for (std::size_t i = begin; i < end; ++i) f(random, counts.local());
  });
  Count sum;
  for (const Count& c : counts) sum += c;
  return sum;
}

using Random = std::mt19937_64;

inline float uniform(Random& random) { return static_cast<float>(random() >> 40) * 0x1p-24F; }

/// pbrt's first two editions kept a ray off its surface by a constant, and left out as much at the
/// end of a shadow ray.
inline constexpr float kEpsilon = 1e-4F;

/// A line of docs/extremes.md that sums counts.
class RayCounts : public ::testing::Test {
 protected:
  void expect(const Count& c, const Place& place, double left_out) {
    EXPECT_EQ(c.leaks, 0) << place.name;
    EXPECT_EQ(c.shadows, 0) << place.name;
    EXPECT_LT(double(c.left_out), left_out * double(c.rays)) << place.name;
    sum_ += c;
  }
  void finish(Sweep& sweep) const {
    sweep.textbook_count(sum_.textbook);
    sweep.expect_none(sum_.leaks + sum_.shadows, sum_.rays, sum_.left_out);
  }
  Count sum_;
};

}  // namespace lucerna::testing
