// The memory that a load holds, counted while it reads and builds.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <mutex>
#include <utility>

namespace lucerna {

/// Memory that several loads share.  Thread-safe.
class MemoryPool {
 public:
  virtual ~MemoryPool() = default;
  /// RESOURCE_EXHAUSTED if this many bytes are not left.  Then it takes nothing.
  virtual absl::Status take(std::uint64_t bytes) = 0;
  virtual void give_back(std::uint64_t bytes) = 0;
};

/// Counts the bytes of one load before they are allocated.  Takes them from the pool in steps of
/// at least kStepBytes, and returns them when it is destroyed.  Thread-safe.
///
/// It counts large arrays only: files, numbers, meshes, pictures and Embree's memory.
class LoadBudget {
 public:
  /// Pools are locked, so many small claims should not each ask them.
  static constexpr std::uint64_t kStepBytes = std::uint64_t{1} << 18;

  /// Without a pool there is no limit.  The pool must outlive the budget.
  explicit LoadBudget(MemoryPool* pool = nullptr) : pool_(pool) {}
  LoadBudget(const LoadBudget&) = delete;
  LoadBudget& operator=(const LoadBudget&) = delete;
  ~LoadBudget();

  /// Counts `bytes` more.  RESOURCE_EXHAUSTED if the pool does not have them; nothing is counted
  /// then.
  absl::Status claim(std::uint64_t bytes);
  void release(std::uint64_t bytes);
  /// Bytes claimed and not yet released.
  std::uint64_t used() const;
  /// The first refusal, or OK.  Libraries that were refused memory report less than this.
  absl::Status refusal() const;

  /// Bytes that are released when it is destroyed.
  class Share {
   public:
    /// Without a budget there is no limit.  The budget must outlive the share.
    explicit Share(LoadBudget* budget = nullptr) : budget_(budget) {}
    Share(Share&& other) noexcept
        : budget_(other.budget_), bytes_(std::exchange(other.bytes_, 0)) {}
    Share& operator=(Share&& other) noexcept;
    ~Share() { reset(); }

    /// Claims or releases the difference.  On an error the share keeps its bytes.
    absl::Status resize(std::uint64_t bytes);
    absl::Status grow(std::uint64_t more) { return resize(bytes_ + more); }
    void reset();
    std::uint64_t bytes() const { return bytes_; }

   private:
    LoadBudget* budget_;
    std::uint64_t bytes_ = 0;
  };

 private:
  MemoryPool* pool_;
  mutable std::mutex mutex_;
  std::uint64_t used_ = 0, taken_ = 0;
  absl::Status refusal_;
};

}  // namespace lucerna
