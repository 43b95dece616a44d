// The figures of a bench as a table and as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/bench_figures.h"
#include "client/cli/rate_search.h"
#include "client/terminal/output.h"

namespace lucerna::bench {

/// One load.
struct Row {
  std::uint64_t batch = 0;
  /// Closed loop: the calls in flight.
  std::optional<std::uint32_t> in_flight;
  /// Open loop: the rate of arrivals [1/s].
  std::optional<double> rate;
  Figures figures;
  /// Whether the load holds the latency limit, if there is one.
  std::optional<bool> holds;
};

/// The result of a search for the highest rate.
struct HighestRate {
  std::uint64_t batch = 0;
  /// Nothing if no rate holds the limit [1/s].
  std::optional<double> rate;
};

struct Report {
  std::string server, question, scene_id;
  std::vector<Row> rows;
  std::optional<LatencyLimit> limit;
  std::vector<HighestRate> found;
};

/// Whether the load had answers only, kept up with its rate, and holds the limit.
bool holds(const Figures& figures, const LatencyLimit& limit);

/// One row for each load.
cli::Table rows_of(const Report& report);
/// What the search for a rate found, one line each.  Empty without a search.
std::string found_of(const Report& report);
/// One line.
std::string json_of(const Report& report);

}  // namespace lucerna::bench
