// What a request and its answer contribute to the record of the call.
#pragma once

#include "server/monitor/call_record.h"
#include "server/monitor/request_id.h"
#include "server/rpc/observed_call.h"

namespace lucerna::rpc {

/// Points of a batch.
inline std::uint64_t count(const v1::Points& points) {
  return static_cast<std::uint64_t>(points.offsets_m_size()) / 3;
}

inline std::uint64_t area(const v1::PixelRect& rect) {
  return static_cast<std::uint64_t>(rect.x1() - rect.x0()) * (rect.y1() - rect.y0());
}

/// The scene that the request names, for the log.
template <typename Request>
void record_request(const Request& request, monitor::CallRecord& record) {
  if constexpr (requires { request.scene_id(); }) {
    if (monitor::is_scene_id(request.scene_id())) record.scene_id = request.scene_id();
  }
}

/// The numbers of a successful call.  Items are receivers, points, rays, segments, lights or
/// pixels.
template <typename Request, typename Response>
void record_answer(const Request& request, const Response& response, monitor::CallRecord& record) {
  if constexpr (requires { request.receivers(); }) {
    record.items = count(request.receivers());
  } else if constexpr (requires { request.points(); }) {
    record.items = count(request.points());
  } else if constexpr (requires { request.count(); }) {
    record.items = request.count();
  } else if constexpr (requires { request.segments(); }) {
    record.items =
        request.has_rays() ? count(request.rays().from()) : count(request.segments().from());
  } else if constexpr (requires { response.lights(); }) {
    record.items = static_cast<std::uint64_t>(response.lights_size());
  } else if constexpr (requires { response.tile(); }) {
    record.items = area(response.tile().rect());
  }
  if constexpr (requires { response.cost(); }) add_counts(response.cost(), record);
  if constexpr (requires { response.scene_id(), response.already_loaded(); }) {
    record.already_loaded = response.already_loaded();
    record.scene_id = response.scene_id();
  }
}

}  // namespace lucerna::rpc
