// Le.
#include "server/emission_queries.h"

#include "server/rpc/checks.h"
#include "server/rpc/errors.h"
#include "server/rpc/lighting.h"

namespace lucerna::rpc {
namespace {

// Processor time of one ray [s], rounded up from what one core took on the reference scenes.
constexpr double kLeSeconds = 1.5e-6;

}  // namespace

Prepared le(const Context& context, const v1::LeRequest& request, v1::LeResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  LeQuery query;
  const auto points = check_points(context, "points", request.points());
  if (!points.ok()) return points.status();
  query.points = *points;
  const std::size_t n = points->size();
  if (auto s = check_triples("directions", request.directions(), n, "points", false); !s.ok()) {
    return s;
  }
  query.directions = view(request.directions());
  if (request.has_light_id()) {
    const auto light = find_light(**scene, request.light_id());
    if (!light.ok()) return light.status();
    query.light = *light;
  }
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  if (auto s = check_wavelengths(request.wavelengths_nm()); !s.ok()) return s;
  query.time_s = request.time_s();

  Task task;
  task.predicted_s = static_cast<double>(n) * kLeSeconds;
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, response](const std::stop_token& stop) {
    const LeAnswer answer{.radiance_cd_m2 = fill(response->mutable_radiance_cd_m2(), 3 * n),
                          .light_ids = fill(response->mutable_light_ids(), n),
                          .status = fill(response->mutable_status(), n)};
    set_counts(response->mutable_cost(), lucerna::le(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
