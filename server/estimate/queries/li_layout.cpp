#include "server/estimate/queries/li_layout.h"

#include <algorithm>

namespace lucerna {

LiLayout::LiLayout(std::span<const std::uint32_t> samples_per_replicate, std::uint32_t replicates)
    : replicates_(replicates) {
  begins_.reserve(samples_per_replicate.size() + 1);
  for (const std::uint32_t each : samples_per_replicate) {
    begins_.push_back(size_);
    size_ += each > 0 ? std::size_t{each} * replicates : 1;
  }
  begins_.push_back(size_);
}

LiPlace LiLayout::own_place(std::size_t i) const {
  const auto receiver =
      static_cast<std::size_t>(std::ranges::upper_bound(begins_, i) - begins_.begin() - 1);
  const std::size_t each =
      std::max<std::size_t>(1, (begins_[receiver + 1] - begins_[receiver]) / replicates_);
  const std::size_t of_receiver = i - begins_[receiver];
  return {receiver, of_receiver / each, static_cast<std::uint32_t>(of_receiver % each)};
}

}  // namespace lucerna
