#include "server/rpc/messages/errors.h"

#include <fmt/core.h>
#include <google/protobuf/duration.pb.h>
#include <google/rpc/error_details.pb.h>
#include <google/rpc/status.pb.h>

#include <algorithm>
#include <array>

#include "server/store/scene_store.h"

namespace lucerna::rpc {
namespace {

constexpr char kTypePrefix[] = "type.googleapis.com/";
constexpr char kDomain[] = "lucerna";
// gRPC drops an error whose headers exceed 8 KiB.  The message is sent twice: as the message, with
// up to three bytes for one, and in the details, together with the field violations.
constexpr std::size_t kMostMessage = 800;
constexpr std::size_t kMostValue = 200;

std::string type_url(const google::protobuf::Message& m) {
  return kTypePrefix + m.GetDescriptor()->full_name();
}

void attach(absl::Status& status, const google::protobuf::Message& detail) {
  status.SetPayload(type_url(detail), absl::Cord(detail.SerializeAsString()));
}

absl::Status with_reason(absl::Status status, Reason reason) {
  google::rpc::ErrorInfo info;
  info.set_reason(entry_of(reason).name);
  info.set_domain(kDomain);
  attach(status, info);
  return status;
}

struct Row {
  absl::StatusCode code;
  int grpc_code;  // as in grpc/status.h
  Reason reason;  // if the error does not have its own
};
// Clients retry only UNAVAILABLE automatically.
constexpr std::array kTable{
    Row{absl::StatusCode::kCancelled, 1, Reason::kCancelled},
    Row{absl::StatusCode::kInvalidArgument, 3, Reason::kInvalidInput},
    Row{absl::StatusCode::kDeadlineExceeded, 4, Reason::kDeadlinePassed},
    Row{absl::StatusCode::kNotFound, 5, Reason::kNotFound},
    Row{absl::StatusCode::kPermissionDenied, 7, Reason::kNotAllowed},
    Row{absl::StatusCode::kResourceExhausted, 8, Reason::kResourceExhausted},
    Row{absl::StatusCode::kFailedPrecondition, 9, Reason::kWrongState},
    Row{absl::StatusCode::kUnimplemented, 12, Reason::kNoSuchCall},
    Row{absl::StatusCode::kInternal, 13, Reason::kInternal},
    Row{absl::StatusCode::kUnavailable, 14, Reason::kUnavailable},
    Row{absl::StatusCode::kUnauthenticated, 16, Reason::kUnauthenticated},
};

}  // namespace

std::string shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto within = [&](std::size_t i) { return (text[i] & 0xC0) == 0x80; };
  std::size_t head = 2 * most / 3, tail = text.size() - most / 3;
  while (head > 0 && within(head)) --head;
  while (tail < text.size() && within(tail)) ++tail;
  return text.substr(0, head) + "..." + text.substr(tail);
}

absl::Status bad_field(const std::string& field, const std::string& value,
                       const std::string& allowed) {
  const std::string description =
      fmt::format("{} = {}, allowed: {}", field, shortened(value, kMostValue), allowed);
  absl::Status status = absl::InvalidArgumentError(description);
  google::rpc::BadRequest bad;
  auto* violation = bad.add_field_violations();
  violation->set_field(field);
  violation->set_description(description);
  attach(status, bad);
  return with_reason(std::move(status), Reason::kBadField);
}

absl::Status bad_length(const std::string& field, std::size_t length, std::size_t expected_length,
                        const std::string& expected) {
  return bad_field(field, fmt::format("{} numbers", length), "{} numbers, {}", expected_length,
                   expected);
}

absl::Status malformed_message(const std::string& type, std::size_t bytes, const std::string& why) {
  return with_reason(absl::InvalidArgumentError(
                         fmt::format("{} bytes that are not a message of the type {}{}{}", bytes,
                                     type, why.empty() ? "" : ": ", shortened(why, kMostValue))),
                     Reason::kMalformedMessage);
}

absl::Status no_message() {
  return with_reason(absl::InvalidArgumentError("the call has no message"),
                     Reason::kMalformedMessage);
}

absl::Status no_such_call() { return absl::UnimplementedError("the server has no such call"); }

absl::Status unknown_scene(const std::string& id) {
  return with_reason(absl::NotFoundError(fmt::format("scene_id = \"{}\", which is not loaded",
                                                     shortened(id, kMostValue))),
                     Reason::kSceneNotLoaded);
}

absl::Status unknown_light(std::uint64_t id) {
  return with_reason(
      absl::NotFoundError(fmt::format("light_id = {}, which the scene does not have", id)),
      Reason::kNoSuchLight);
}

absl::Status unknown_light_name(const std::string& field, const std::string& name,
                                const std::string& names) {
  return with_reason(absl::NotFoundError(fmt::format(
                         "{} = \"{}\", which the scene does not have; {}", field, name, names)),
                     Reason::kNoSuchLight);
}

absl::Status over_limit(const std::string& field, std::uint64_t value, std::uint64_t limit) {
  return with_reason(absl::ResourceExhaustedError(
                         fmt::format("{} = {}, limit of this server: {}", field, value, limit)),
                     Reason::kOverLimit);
}

absl::Status check_limit(const std::string& field, std::uint64_t value, std::uint64_t limit) {
  return value > limit ? over_limit(field, value, limit) : absl::OkStatus();
}

absl::Status retry_after(absl::Status status, Reason reason, std::chrono::milliseconds delay) {
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(delay.count() / 1000);
  retry.mutable_retry_delay()->set_nanos(static_cast<int>(delay.count() % 1000) * 1'000'000);
  attach(status, retry);
  return with_reason(std::move(status), reason);
}

absl::Status load_error(absl::Status status) {
  if (status.GetPayload(kOverQuotaPayload)) {
    status.ErasePayload(kOverQuotaPayload);
    return with_reason(std::move(status), Reason::kOverQuota);
  }
  const absl::optional<absl::Cord> delay = status.GetPayload(kRetryAfterPayload);
  if (!delay) return status;
  const std::chrono::milliseconds wait(std::stoll(std::string(*delay)));
  status.ErasePayload(kRetryAfterPayload);
  return retry_after(std::move(status), Reason::kMemoryLeased, wait);
}

absl::Status draining() {
  return with_reason(absl::UnavailableError("the server is shutting down"), Reason::kDraining);
}

WireError to_wire(const absl::Status& status) {
  const auto* row = std::find_if(kTable.begin(), kTable.end(),
                                 [&](const Row& r) { return r.code == status.code(); });
  WireError error;
  google::rpc::Status wire;
  const auto add_details = [&](const absl::Status& from) {
    from.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
      auto* detail = wire.add_details();
      detail->set_type_url(std::string(url));
      detail->set_value(std::string(payload));
    });
  };
  if (row == kTable.end() || row->code == absl::StatusCode::kInternal) {
    const absl::Status hidden = with_reason(
        absl::InternalError("internal error; the server's log has the details"), Reason::kInternal);
    error.code = 13;
    error.message = std::string(hidden.message());
    add_details(hidden);
  } else {
    error.code = row->grpc_code;
    error.message = shortened(std::string(status.message()), kMostMessage);
    absl::Status full = status;
    if (!full.GetPayload(type_url(google::rpc::ErrorInfo()))) {
      full = with_reason(std::move(full), row->reason);
    }
    add_details(full);
    if (const auto payload = full.GetPayload(type_url(google::rpc::RetryInfo()))) {
      google::rpc::RetryInfo retry;
      if (retry.ParseFromString(std::string(*payload))) {
        error.pushback = std::chrono::milliseconds(retry.retry_delay().seconds() * 1000 +
                                                   retry.retry_delay().nanos() / 1'000'000);
      }
    }
  }
  wire.set_code(error.code);
  wire.set_message(error.message);
  error.details = wire.SerializeAsString();
  return error;
}

}  // namespace lucerna::rpc
