#include "server/rpc/messages/errors.h"

#include <fmt/core.h>
#include <google/protobuf/util/time_util.h>
#include <google/rpc/error_details.pb.h>
#include <google/rpc/status.pb.h>

#include <algorithm>

#include "server/store/scene_store.h"

namespace lucerna::rpc {
namespace {

using google::protobuf::util::TimeUtil;

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

}  // namespace

std::string shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto within = [&](std::size_t i) { return (text[i] & 0xC0) == 0x80; };
  std::size_t head = 2 * most / 3, tail = text.size() - most / 3;
  while (head > 0 && within(head)) --head;
  while (tail < text.size() && within(tail)) ++tail;
  return text.substr(0, head) + "..." + text.substr(tail);
}

absl::Status error(Reason reason, const std::string& message) {
  return with_reason({entry_of(reason).code, message}, reason);
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

absl::Status no_message() { return error(Reason::kMalformedMessage, "the call has no message"); }

absl::Status unknown_light(std::uint64_t id) {
  return error(Reason::kNoSuchLight,
               fmt::format("light_id = {}, which the scene does not have", id));
}

absl::Status over_limit(const std::string& field, std::uint64_t value, std::uint64_t limit) {
  return error(Reason::kOverLimit,
               fmt::format("{} = {}, limit of this server: {}", field, value, limit));
}

absl::Status check_limit(const std::string& field, std::uint64_t value, std::uint64_t limit) {
  return value > limit ? over_limit(field, value, limit) : absl::OkStatus();
}

absl::Status retry_after(absl::Status status, Reason reason, std::chrono::milliseconds delay) {
  google::rpc::RetryInfo retry;
  *retry.mutable_retry_delay() = TimeUtil::MillisecondsToDuration(delay.count());
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

WireError to_wire(const absl::Status& status) {
  const auto of_code = std::find_if(kErrorReasons.rbegin(), kErrorReasons.rend(),
                                    [&](const auto& r) { return r.code == status.code(); });
  const bool is_hidden = of_code == kErrorReasons.rend() || of_code->reason == Reason::kInternal;
  absl::Status shown =
      is_hidden ? error(Reason::kInternal, "internal error; the server's log has the details")
                : status;
  if (!shown.GetPayload(type_url(google::rpc::ErrorInfo())))
    shown = with_reason(std::move(shown), of_code->reason);
  WireError out;
  out.code = static_cast<int>(shown.code());
  out.message = shortened(std::string(shown.message()), kMostMessage);
  google::rpc::Status wire;
  wire.set_code(out.code);
  wire.set_message(out.message);
  shown.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    auto* detail = wire.add_details();
    detail->set_type_url(std::string(url));
    detail->set_value(std::string(payload));
  });
  out.details = wire.SerializeAsString();
  google::rpc::RetryInfo retry;
  if (const auto payload = shown.GetPayload(type_url(retry));
      payload && retry.ParseFromString(std::string(*payload)))
    out.pushback = std::chrono::milliseconds(TimeUtil::DurationToMilliseconds(retry.retry_delay()));
  return out;
}

}  // namespace lucerna::rpc
