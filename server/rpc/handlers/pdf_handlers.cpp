#include "server/rpc/handlers/pdf_handlers.h"

#include "proto/common/status_macros.h"
#include "server/queries/emission_queries.h"
#include "server/queries/queries.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/requested_accuracy.h"
#include "server/scene/create_light.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<PdfLiQuery> parse(const CallContext& context, const Scene& scene,
                                 const v1::PdfLiRequest& request) {
  PdfLiQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.receivers,
                           check_points(context, "receivers", request.receivers()));
  const std::size_t n = query.receivers.size();
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "receivers", n, answer_size(request)));
  LUCERNA_ASSIGN_OR_RETURN(query.wi, check_triples("wi", request.wi(), n, "receivers", false));
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_required_light(scene, request));
  LUCERNA_ASSIGN_OR_RETURN(query.time_s, check_time(request.time_s()));
  LUCERNA_ASSIGN_OR_RETURN(query.normals,
                           check_triples("normals", request.normals(), n, "receivers", true));
  LUCERNA_ASSIGN_OR_RETURN(const Methods methods, check_methods(request.accuracy()));
  query.area_sampling = methods.area_sampling;
  return query;
}

/// A density searches all primitives of the light.
double predicted_seconds(const Scene& scene, std::uint32_t light, std::size_t items) {
  constexpr double kPdfSeconds = 200e-9, kPrimitiveSeconds = 20e-9;
  const auto primitives = static_cast<double>(primitive_count(*scene.lights()[light].light));
  return seconds_of(items, kPdfSeconds + kPrimitiveSeconds * primitives);
}

}  // namespace

Prepared handle_pdf_li(const CallContext& context, const v1::PdfLiRequest& request,
                       v1::PdfLiResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const PdfLiQuery query, parse(context, *scene, request));
  const std::size_t n = query.receivers.size();
  const auto run = [scene, query, n, response](const std::stop_token& stop) {
    pdf_li(*scene, query, fill(response->mutable_pdf_per_sr(), n),
           fill(response->mutable_status(), n), stop);
    return finish_batch(response);
  };
  return batch_task(predicted_seconds(*scene, query.light, n), n, response, run);
}

Prepared handle_pdf_le(const CallContext& context, const v1::PdfLeRequest& request,
                       v1::PdfLeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const PointArray points,
                           check_points(context, "points", request.points()));
  const std::size_t n = points.size();
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "points", n, answer_size(request)));
  LUCERNA_ASSIGN_OR_RETURN(const auto directions,
                           check_triples("directions", request.directions(), n, "points", false));
  LUCERNA_ASSIGN_OR_RETURN(const std::uint32_t light, find_required_light(*scene, request));
  LUCERNA_ASSIGN_OR_RETURN(const double time_s, check_time(request.time_s()));
  const auto run = [scene, light, points, directions, time_s, n,
                    response](const std::stop_token& stop) {
    pdf_le(*scene, light, points, directions, time_s,
           fill(response->mutable_pdf_position_per_m2(), n),
           fill(response->mutable_pdf_direction_per_sr(), n), fill(response->mutable_status(), n),
           stop);
    return finish_batch(response);
  };
  return batch_task(predicted_seconds(*scene, light, n), n, response, run);
}

}  // namespace lucerna::rpc
