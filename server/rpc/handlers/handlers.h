// One function for each call, without gRPC.  It checks a request and returns the task that answers
// it.  Each function is in the file that is named by its call; RenderImage is a class.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_edit_lights(const CallContext& context, const v1::EditLightsRequest& request,
                            v1::EditLightsResponse* response);
Prepared handle_estimate_irradiance(const CallContext& context,
                                    const v1::EstimateIrradianceRequest& request,
                                    v1::EstimateIrradianceResponse* response);
Prepared handle_estimate_power(const CallContext& context, const v1::EstimatePowerRequest& request,
                               v1::EstimatePowerResponse* response);
Prepared handle_find_missing_assets(const CallContext& context,
                                    const v1::FindMissingAssetsRequest& request,
                                    v1::FindMissingAssetsResponse* response);
Prepared handle_find_surfaces(const CallContext& context, const v1::FindSurfacesRequest& request,
                              v1::FindSurfacesResponse* response);
Prepared handle_get_scene(const CallContext& context, const v1::GetSceneRequest& request,
                          v1::GetSceneResponse* response);
Prepared handle_le(const CallContext& context, const v1::LeRequest& request,
                   v1::LeResponse* response);
Prepared handle_renew_lease(const CallContext& context, const v1::RenewLeaseRequest& request,
                            v1::RenewLeaseResponse* response);
Prepared handle_release_scene(const CallContext& context, const v1::ReleaseSceneRequest& request,
                              v1::ReleaseSceneResponse* response);
Prepared handle_list_scenes(const CallContext& context, const v1::ListScenesRequest& request,
                            v1::ListScenesResponse* response);
Prepared handle_list_available_scenes(const CallContext& context,
                                      const v1::ListAvailableScenesRequest& request,
                                      v1::ListAvailableScenesResponse* response);
Prepared handle_list_lights(const CallContext& context, const v1::ListLightsRequest& request,
                            v1::ListLightsResponse* response);
Prepared handle_list_leases(const CallContext& context, const v1::ListLeasesRequest& request,
                            v1::ListLeasesResponse* response);
Prepared handle_load_scene(const CallContext& context, const v1::LoadSceneRequest& request,
                           v1::LoadSceneResponse* response);
Prepared handle_pdf_li(const CallContext& context, const v1::PdfLiRequest& request,
                       v1::PdfLiResponse* response);
Prepared handle_pdf_le(const CallContext& context, const v1::PdfLeRequest& request,
                       v1::PdfLeResponse* response);
Prepared handle_render_tile(const CallContext& context, const v1::RenderTileRequest& request,
                            v1::RenderTileResponse* response);
Prepared handle_sample_le(const CallContext& context, const v1::SampleLeRequest& request,
                          v1::SampleLeResponse* response);
Prepared handle_sample_li(const CallContext& context, const v1::SampleLiRequest& request,
                          v1::SampleLiResponse* response);
Prepared handle_test_visibility(const CallContext& context,
                                const v1::TestVisibilityRequest& request,
                                v1::TestVisibilityResponse* response);

}  // namespace lucerna::rpc
