// The arrays of an answer of sample_li().
#pragma once

#include <cstdint>
#include <vector>

#include "server/queries/queries.h"

namespace lucerna::testing {

struct LiSamples {
  explicit LiSamples(std::size_t n)
      : value(3 * n),
        wi(3 * n),
        distance_m(n),
        light_offsets_m(3 * n),
        light_normals(3 * n),
        pdf_per_sr(n),
        delta((n + 7) / 8),
        visible((n + 7) / 8),
        light_ids(n),
        selection_probability(n),
        status(n) {}
  /// The answer to `query`.
  LiSamples(const Scene& scene, const SampleLiQuery& query)
      : LiSamples(query.receivers.size() * query.samples) {
    sample_li(scene, query, answer(), {});
  }

  SampleLiAnswer answer() {
    return {value.data(),         wi.data(),
            distance_m.data(),    light_offsets_m.data(),
            light_normals.data(), pdf_per_sr.data(),
            delta.data(),         visible.data(),
            light_ids.data(),     selection_probability.data(),
            status.data()};
  }
  std::size_t size() const { return status.size(); }
  bool is_ok(std::size_t i) const { return status[i] == static_cast<int>(ItemResult::kOk); }
  bool is_delta(std::size_t i) const { return (delta[i / 8] >> (i % 8) & 1) != 0; }
  bool is_visible(std::size_t i) const { return (visible[i / 8] >> (i % 8) & 1) != 0; }
  bool operator==(const LiSamples&) const = default;

  std::vector<float> value, wi, distance_m, light_offsets_m, light_normals, pdf_per_sr;
  std::vector<std::uint8_t> delta, visible;
  std::vector<std::uint64_t> light_ids;
  std::vector<double> selection_probability;
  std::vector<int> status;
};

}  // namespace lucerna::testing
