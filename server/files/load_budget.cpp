#include "server/files/load_budget.h"

#include <algorithm>

namespace lucerna {

LoadBudget::~LoadBudget() {
  if (pool_ != nullptr && taken_ > 0) pool_->give_back(taken_);
}

absl::Status LoadBudget::claim(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (pool_ != nullptr && used_ + bytes > taken_) {
    const std::uint64_t least = used_ + bytes - taken_;
    std::uint64_t step = std::max(least, kStepBytes);
    absl::Status status = pool_->take(step);
    // The last bytes of the pool may be fewer than a step.
    if (!status.ok() && step > least) status = pool_->take(step = least);
    if (!status.ok()) {
      if (refusal_.ok()) refusal_ = status;
      return status;
    }
    taken_ += step;
  }
  used_ += bytes;
  return absl::OkStatus();
}

void LoadBudget::release(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  used_ -= std::min(bytes, used_);
  if (pool_ == nullptr || taken_ < used_ + 2 * kStepBytes) return;
  const std::uint64_t spare = taken_ - used_ - kStepBytes;
  pool_->give_back(spare);
  taken_ -= spare;
}

std::uint64_t LoadBudget::used() const {
  const std::lock_guard lock(mutex_);
  return used_;
}

absl::Status LoadBudget::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

LoadBudget::Share& LoadBudget::Share::operator=(Share&& other) noexcept {
  std::swap(budget_, other.budget_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

absl::Status LoadBudget::Share::resize(std::uint64_t bytes) {
  if (budget_ != nullptr && bytes > bytes_) {
    if (absl::Status status = budget_->claim(bytes - bytes_); !status.ok()) return status;
  } else if (budget_ != nullptr) {
    budget_->release(bytes_ - bytes);
  }
  bytes_ = bytes;
  return absl::OkStatus();
}

void LoadBudget::Share::reset() {
  if (budget_ != nullptr) budget_->release(bytes_);
  bytes_ = 0;
}

}  // namespace lucerna
