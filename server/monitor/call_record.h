// What the server records of one call, for its log and its statistics.
#pragma once

#include <cstdint>
#include <string>

#include "server/monitor/calls.h"
#include "server/runtime/lanes.h"

namespace lucerna::monitor {

constexpr const char* name_of(Lane lane) { return lane == Lane::kBulk ? "bulk" : "interactive"; }

/// Holds no content of a scene and no token.
struct CallRecord {
  Call call{};
  std::string request_id{};   ///< see request_id.h
  std::string traceparent{};  ///< of the client, well-formed; else empty
  std::string peer{};         ///< address of the client, as gRPC writes it
  /// Name of the client's token, or of its certificate; else empty.
  std::string caller{};
  std::string scene_id{};  ///< 64 hexadecimal digits, or empty
  int code = 0;            ///< of gRPC

  // Of a successful call.
  std::uint64_t items = 0;  ///< receivers, rays, points, lights or pixels of the answer
  std::uint64_t samples = 0;
  std::uint64_t rays = 0;
  bool already_loaded = false;  ///< LoadScene found the scene in memory

  std::uint64_t request_bytes = 0, response_bytes = 0;
  /// Whether it waited in a lane; else it ran at once or was refused before.
  bool queued = false;
  Lane lane = Lane::kInteractive;
  double queue_s = 0;    ///< time in the lane's queue, over all its jobs
  double compute_s = 0;  ///< wall time of the work, over all its jobs
  double cpu_s = 0;      ///< processor time of all threads that worked on it
  double total_s = 0;    ///< from its arrival to its end
};

}  // namespace lucerna::monitor
