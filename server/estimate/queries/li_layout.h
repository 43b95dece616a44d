// The order of samples in an answer of SampleLi.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lucerna {

/// The sample of an entry: point `index` of that replicate of the receiver's points.
struct LiPlace {
  std::size_t receiver;
  std::uint64_t replicate;
  std::uint32_t index;
};

/// The samples of an answer, receiver by receiver.
class LiLayout {
 public:
  /// `samples` of each receiver, in one replicate.
  LiLayout(std::size_t receivers, std::uint32_t samples)
      : replicates_(1), each_(samples), size_(receivers * samples) {}
  /// `replicates` of samples_per_replicate[r] samples of receiver r; one sample if that is 0.
  LiLayout(std::span<const std::uint32_t> samples_per_replicate, std::uint32_t replicates);

  std::size_t size() const { return size_; }
  LiPlace place(std::size_t i) const {
    if (!begins_.empty()) return own_place(i);
    if (each_ == 1) return {i, 0, 0};  // a division takes longer than a point light
    return {i / each_, 0, static_cast<std::uint32_t>(i % each_)};
  }
  /// The samples of receiver `r` are [begin(r), begin(r + 1)).
  std::size_t begin(std::size_t r) const { return begins_.empty() ? r * each_ : begins_[r]; }

 private:
  LiPlace own_place(std::size_t i) const;

  std::uint32_t replicates_;
  std::size_t each_ = 0;               // if all receivers have the same number
  std::vector<std::size_t> begins_{};  // of each receiver, and the end; if the numbers differ
  std::size_t size_ = 0;
};

}  // namespace lucerna
