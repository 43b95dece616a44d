#include "proto/common/tile_statistics.h"

namespace lucerna {

BlockStatistics merge(const BlockStatistics& a, std::uint64_t na, const BlockStatistics& b,
                      std::uint64_t nb) {
  if (na == 0) return b;
  if (nb == 0) return a;
  const auto count_a = static_cast<double>(na), count_b = static_cast<double>(nb);
  const double difference = b.sum / count_b - a.sum / count_a;
  return {a.sum + b.sum, a.deviation + b.deviation +
                             difference * difference * (count_a * count_b / (count_a + count_b))};
}

}  // namespace lucerna
