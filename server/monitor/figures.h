// All statistics of a server at one moment.  The metrics and GetStats show the same figures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "server/monitor/calls.h"
#include "server/monitor/process_figures.h"

namespace lucerna::monitor {

/// Upper bounds of the classes of a histogram [s].  A further class has all larger times.
inline constexpr std::array kTimeBounds{1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2,
                                        1e-1, 3e-1, 1.0,  3.0,  10.0, 30.0, 100.0};

struct TimeHistogram {
  std::array<std::uint64_t, kTimeBounds.size() + 1> counts{};  ///< of each class
  double sum_s = 0;
  std::uint64_t count() const {
    std::uint64_t n = 0;
    for (const std::uint64_t c : counts) n += c;
    return n;
  }
};

/// Totals since the start, except `running`.
struct CallFigures {
  std::array<std::uint64_t, kCodes> ended{};  ///< calls by their code
  std::uint64_t running = 0;
  TimeHistogram compute;  ///< wall time of the work, of calls that computed
  double queue_s = 0, cpu_s = 0, total_s = 0;
  std::uint64_t items = 0, samples = 0, rays = 0;
  std::uint64_t request_bytes = 0, response_bytes = 0;

  std::uint64_t calls() const {
    std::uint64_t n = 0;
    for (const std::uint64_t c : ended) n += c;
    return n;
  }
};

struct LaneFigures {
  std::uint64_t waiting = 0, running = 0;  ///< jobs now
  TimeHistogram wait;                      ///< of calls that waited in the lane
};

struct Figures {
  std::string version, fingerprint;
  double time_s = 0;    ///< the server's clock, since 1970-01-01 UTC
  double uptime_s = 0;  ///< since the server started
  std::array<CallFigures, kCalls> calls{};
  std::array<LaneFigures, 2> lanes{};  ///< by number of Lane

  std::uint64_t scenes = 0, leases = 0;
  std::uint64_t memory_budget_bytes = 0;             ///< 0: no limit
  std::map<std::string, std::uint64_t> scene_bytes;  ///< memory of all scenes, by part
  std::uint64_t scenes_built = 0, already_loaded = 0;
  std::uint64_t asset_bytes = 0, asset_budget_bytes = 0;  ///< uploaded files on the disk
  std::uint64_t log_lines_left_out = 0;
  ProcessFigures process;

  std::uint64_t all_scene_bytes() const {
    std::uint64_t bytes = 0;
    for (const auto& [part, b] : scene_bytes) bytes += b;
    return bytes;
  }
};

/// The name of a lane: "interactive" or "bulk".
constexpr const char* lane_name(std::size_t lane) { return lane == 0 ? "interactive" : "bulk"; }

}  // namespace lucerna::monitor
