#include "server/rpc/handlers/pdf_handlers.h"

#include "proto/common/status_macros.h"
#include "server/estimate/queries/emission_queries.h"
#include "server/estimate/queries/predicted_time.h"
#include "server/estimate/queries/queries.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/requested_methods.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<PdfLiQuery> parse(const Context& context, const Scene& scene,
                                 const v1::PdfLiRequest& request) {
  PdfLiQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.receivers,
                           check_points(context, "receivers", request.receivers()));
  const std::size_t n = query.receivers.size();
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "receivers", n, answer_size(request)));
  LUCERNA_RETURN_IF_ERROR(check_triples("wi", request.wi(), n, "receivers", false));
  query.wi = view(request.wi());
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_required_light(scene, request));
  LUCERNA_RETURN_IF_ERROR(check_time(request.has_time_s(), request.time_s()));
  query.time_s = request.time_s();
  LUCERNA_RETURN_IF_ERROR(check_triples("normals", request.normals(), n, "receivers", true));
  query.normals = view(request.normals());
  LUCERNA_ASSIGN_OR_RETURN(const Methods methods, check_methods(request.accuracy()));
  query.area_sampling = methods.area_sampling;
  return query;
}

}  // namespace

Prepared handle_pdf_li(const Context& context, const v1::PdfLiRequest& request,
                       v1::PdfLiResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const PdfLiQuery query, parse(context, *scene, request));
  const std::size_t n = query.receivers.size();
  Task task;
  task.predicted_s = pdf_seconds(scene->lights()[query.light].light, n);
  task.items = n;
  task.cost = response->mutable_cost();
  task.run = [scene, query, n, response](const std::stop_token& stop) {
    lucerna::pdf_li(*scene, query, fill(response->mutable_pdf_per_sr(), n),
                    fill(response->mutable_status(), n), stop);
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared handle_pdf_le(const Context& context, const v1::PdfLeRequest& request,
                       v1::PdfLeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const PointArray points,
                           check_points(context, "points", request.points()));
  const std::size_t n = points.size();
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "points", n, answer_size(request)));
  LUCERNA_RETURN_IF_ERROR(check_triples("directions", request.directions(), n, "points", false));
  LUCERNA_ASSIGN_OR_RETURN(const std::uint32_t light, find_required_light(*scene, request));
  LUCERNA_RETURN_IF_ERROR(check_time(request.has_time_s(), request.time_s()));
  Task task;
  task.predicted_s = pdf_seconds(scene->lights()[light].light, n);
  task.items = n;
  task.cost = response->mutable_cost();
  task.run = [scene, light, points, n, &request, response](const std::stop_token& stop) {
    lucerna::pdf_le(*scene, light, points, view(request.directions()), request.time_s(),
                    fill(response->mutable_pdf_position_per_m2(), n),
                    fill(response->mutable_pdf_direction_per_sr(), n),
                    fill(response->mutable_status(), n), stop);
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
