// LightingService without gRPC: each function parses a request and returns the task that answers
// it.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared sample_li(const Context& context, const v1::SampleLiRequest& request,
                   v1::SampleLiResponse* response);
Prepared pdf_li(const Context& context, const v1::PdfLiRequest& request,
                v1::PdfLiResponse* response);
Prepared sample_le(const Context& context, const v1::SampleLeRequest& request,
                   v1::SampleLeResponse* response);
Prepared pdf_le(const Context& context, const v1::PdfLeRequest& request,
                v1::PdfLeResponse* response);
Prepared le(const Context& context, const v1::LeRequest& request, v1::LeResponse* response);
Prepared estimate_power(const Context& context, const v1::EstimatePowerRequest& request,
                        v1::EstimatePowerResponse* response);
Prepared test_visibility(const Context& context, const v1::TestVisibilityRequest& request,
                         v1::TestVisibilityResponse* response);
Prepared estimate_irradiance(const Context& context, const v1::EstimateIrradianceRequest& request,
                             v1::EstimateIrradianceResponse* response);

}  // namespace lucerna::rpc
