// PdfLi and PdfLe without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_pdf_li(const CallContext& context, const v1::PdfLiRequest& request,
                       v1::PdfLiResponse* response);
Prepared handle_pdf_le(const CallContext& context, const v1::PdfLeRequest& request,
                       v1::PdfLeResponse* response);

}  // namespace lucerna::rpc
