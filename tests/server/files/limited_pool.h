// A pool of memory for tests.
#pragma once

#include <absl/status/status.h>

#include <algorithm>
#include <cstdint>
#include <functional>

#include "server/files/load_budget.h"

namespace lucerna::testing {

/// Has `limit` bytes and remembers the most that were taken at once.  Not thread-safe.
class LimitedPool final : public MemoryPool {
 public:
  explicit LimitedPool(std::uint64_t limit = ~std::uint64_t{0}) : limit_(limit) {}

  absl::Status take(std::uint64_t bytes) override {
    if (on_take) on_take();
    if (bytes > limit_ - taken_) return absl::ResourceExhaustedError("the pool is empty");
    taken_ += bytes;
    most_ = std::max(most_, taken_);
    return absl::OkStatus();
  }
  void give_back(std::uint64_t bytes) override { taken_ -= bytes; }

  std::uint64_t taken() const { return taken_; }
  std::uint64_t most() const { return most_; }

  std::function<void()> on_take;

 private:
  std::uint64_t limit_, taken_ = 0, most_ = 0;
};

}  // namespace lucerna::testing
