#include "client/library/status.h"

#include <string>

#include "absl/strings/cord.h"
#include "client/library/client.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace lucerna::client {
namespace {

/// The field violations of the details, in the form that to_absl_status() appends.
std::string violations(const google::rpc::Status& details, const std::string& message) {
  std::string text;
  for (const google::protobuf::Any& detail : details.details()) {
    google::rpc::BadRequest bad_request;
    if (!detail.UnpackTo(&bad_request)) continue;
    for (const auto& violation : bad_request.field_violations()) {
      if (message.find(violation.field()) != std::string::npos &&
          message.find(violation.description()) != std::string::npos) {
        continue;
      }
      text += "; " + violation.field() + ": " + violation.description();
    }
  }
  return text;
}

}  // namespace

absl::Status to_absl_status(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  std::string message = status.error_message();
  google::rpc::Status details;
  const bool has_details =
      !status.error_details().empty() && details.ParseFromString(status.error_details());
  if (has_details) message += violations(details, message);
  // Abseil's codes equal gRPC's, number by number.
  absl::Status result(static_cast<absl::StatusCode>(status.error_code()), message);
  if (has_details) result.SetPayload(kStatusPayloadUrl, absl::Cord(status.error_details()));
  return result;
}

}  // namespace lucerna::client
