// TestVisibility.
#include <fmt/core.h>

#include "server/estimate/queries/queries.h"
#include "server/estimate/queries/visibility.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

// Processor time [s], rounded up from what one core took on the reference scenes.
constexpr double kShadowRaySeconds = 1.5e-6;

absl::Status check_rays(const v1::Rays& rays, std::size_t n, VisibilityQuery& query) {
  if (auto s = check_triples("rays.directions", rays.directions(), n, "rays", false); !s.ok()) {
    return s;
  }
  const auto lengths = static_cast<std::size_t>(rays.lengths_m_size());
  if (lengths != 0 && lengths != n) {
    return bad_length("rays.lengths_m", lengths, n,
                      fmt::format("one for each of {} rays, or none", n));
  }
  query.directions = view(rays.directions());
  query.lengths_m = view(rays.lengths_m());
  return absl::OkStatus();
}

}  // namespace

Prepared test_visibility(const Context& context, const v1::TestVisibilityRequest& request,
                         v1::TestVisibilityResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  VisibilityQuery query;
  const bool segments = request.has_segments();
  if (!segments && !request.has_rays()) {
    return bad_field("between", "unset", "segments or rays");
  }
  const auto from = check_points(context, segments ? "segments.from" : "rays.from",
                                 segments ? request.segments().from() : request.rays().from());
  if (!from.ok()) return from.status();
  query.from = *from;
  const std::size_t n = from->size();
  if (auto s = check_answer_size(context, segments ? "segments" : "rays", n, answer_size(request));
      !s.ok()) {
    return s;
  }
  if (segments) {
    const auto to = check_points(context, "segments.to", request.segments().to());
    if (!to.ok()) return to.status();
    if (to->size() != n) {
      return bad_length("segments.to.offsets_m", 3 * to->size(), 3 * n,
                        "as many as segments.from.offsets_m");
    }
    query.to = *to;
  } else if (auto s = check_rays(request.rays(), n, query); !s.ok()) {
    return s;
  }
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  if (auto s = check_triples("normals", request.normals(), n, "items", true); !s.ok()) return s;
  query.time_s = request.time_s();
  query.normals = view(request.normals());
  const auto error =
      check_position_error(request.has_position_error_m(), request.position_error_m());
  if (!error.ok()) return error.status();
  query.position_error_m = *error;

  Task task;
  task.predicted_s = static_cast<double>(n) * kShadowRaySeconds;
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, response](const std::stop_token& stop) {
    response->set_count(static_cast<std::uint32_t>(n));
    set_counts(response->mutable_cost(),
               lucerna::test_visibility(*scene, query, fill_bits(response->mutable_visible(), n),
                                        fill(response->mutable_status(), n), stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
