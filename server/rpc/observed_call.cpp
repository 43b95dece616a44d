#include "server/rpc/observed_call.h"

#include <fmt/core.h>
#include <google/protobuf/stubs/logging.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>
#include <spdlog/spdlog.h>

#include <string_view>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/monitor/request_id.h"
#include "server/rpc/call.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

/// The value of a client's header; empty if there is none.
std::string_view header(const grpc::ServerContextBase& context, const char* name) {
  const auto& headers = context.client_metadata();
  const auto found = headers.find(name);
  if (found == headers.end()) return {};
  return {found->second.data(), found->second.size()};
}

/// The first name of the client's certificate; empty without one.  Its characters cannot break a
/// line of the log.
std::string certificate_name(const grpc::ServerContextBase& context) {
  const std::shared_ptr<const grpc::AuthContext> who = context.auth_context();
  if (who == nullptr || !who->IsPeerAuthenticated()) return {};
  const std::vector<grpc::string_ref> names = who->GetPeerIdentity();
  if (names.empty()) return {};
  return monitor::printable_name({names.front().data(), names.front().size()});
}

// A caller with too many requests in flight may try again after about one small request.
constexpr std::chrono::milliseconds kQuotaDelay(50);

// The same for a caller whose connection has many answers to take.
constexpr std::chrono::milliseconds kUnsentDelay(1000);

// Answers that may wait on a connection, whatever the largest message.
constexpr std::uint64_t kLeastUnsentBytes = 16 << 20;

// Processor time that an item may take without counting as more items.  Most take microseconds.
constexpr double kItemSeconds = 0.01;

// Of the parser's reason in an error.
constexpr std::size_t kMostReasonBytes = 200;

// What the parser reported on this thread; null while no message is parsed.
thread_local std::string* parser_reason = nullptr;

}  // namespace

ObservedCall::ObservedCall(Runtime& runtime, grpc::CallbackServerContext& context,
                           monitor::Call call)
    : runtime_(runtime), context_(context), deadline_(deadline_of(context.raw_deadline())) {
  const std::string peer = context.peer();
  if (runtime.connections != nullptr) connection_ = runtime.connections->find(peer);
  has_request_ = static_cast<std::size_t>(call) < monitor::kContractCalls;
  if (connection_ != nullptr) {
    runtime.connections->call_begun(*connection_);
    if (has_request_) connection_->request_begun();
  }
  record_.call = call;
  const std::string_view id = header(context, "x-request-id");
  record_.request_id = monitor::is_request_id(id) ? std::string(id) : monitor::make_request_id();
  if (runtime_.on_call) {
    const std::string_view trace = header(context, "traceparent");
    if (monitor::is_traceparent(trace)) record_.traceparent = std::string(trace);
    record_.peer = peer;
    if (runtime.client_certificates) record_.caller = certificate_name(context);
  }
  runtime_.statistics.begin(call);
}

ObservedCall::~ObservedCall() {
  if (connection_ == nullptr) return;
  connection_->call_ended();
  answer_sent(unsent_bytes_);
  runtime_.connections->message_held(0, held_bytes_);
  if (has_request_) connection_->request_left(runtime_.limits.get().max_message_bytes);
}

void ObservedCall::cancelled() const {
  if (connection_ != nullptr) runtime_.connections->count_cancelled(*connection_);
}

void ObservedCall::request_complete() {
  if (connection_ != nullptr && std::exchange(has_request_, false)) connection_->request_complete();
}

void ObservedCall::message_taken(std::size_t bytes) {
  if (connection_ == nullptr) return;
  connection_->message_taken(bytes);
  runtime_.connections->message_held(bytes, std::exchange(held_bytes_, bytes));
}

absl::Status ObservedCall::room_for_answers(std::size_t bytes) const {
  if (connection_ == nullptr) return absl::OkStatus();
  const std::uint64_t most = std::max(runtime_.limits.get().max_message_bytes, kLeastUnsentBytes);
  std::string why;
  const std::uint64_t unsent = connection_->unsent_bytes();
  if (unsent > 0 && unsent + bytes >= most) {
    why = fmt::format("{} bytes of answers wait until this client takes them, allowed: {}", unsent,
                      most);
  } else if (!runtime_.connections->has_room(bytes)) {
    why =
        fmt::format("the answer has {} bytes; too many wait until other clients take them", bytes);
  }
  if (why.empty()) return absl::OkStatus();
  return retry_after(absl::ResourceExhaustedError(why), Reason::kQueueFull, kUnsentDelay);
}

void ObservedCall::answer_begun(std::size_t bytes) {
  if (connection_ == nullptr) return;
  unsent_bytes_ += bytes;
  connection_->answer_begun(bytes);
  runtime_.connections->answer_begun(bytes);
}

void ObservedCall::answer_sent(std::size_t bytes) {
  if (connection_ == nullptr) return;
  unsent_bytes_ -= bytes;
  connection_->answer_sent(bytes);
  runtime_.connections->answer_sent(bytes);
}

absl::Status ObservedCall::admit() {
  absl::StatusOr<access::Admission> admission =
      runtime_.access.admit(record_.call, header(context_, "authorization"), &token_);
  if (!token_.empty()) record_.caller = token_;
  if (absl::IsResourceExhausted(admission.status()))
    return retry_after(admission.status(), Reason::kOverQuota, kQuotaDelay);
  LUCERNA_ASSIGN_OR_RETURN(admission_, std::move(admission));
  return absl::OkStatus();
}

absl::Status ObservedCall::take_items(std::uint64_t items) {
  items_ = items;
  const std::chrono::milliseconds wait = admission_.take_items(items);
  if (wait.count() == 0) return absl::OkStatus();
  return retry_after(
      absl::ResourceExhaustedError(fmt::format(
          "\"{}\" requested {} items, allowed: {} per second; retry in {:.3f} s", caller().name,
          items, caller().quota.items_per_second, 1e-3 * static_cast<double>(wait.count()))),
      Reason::kOverQuota, wait);
}

void ObservedCall::count_work() {
  const auto work = static_cast<std::uint64_t>(record_.cpu_s / kItemSeconds);
  if (items_ == 0 || work <= items_) return;
  admission_.owe_items(work - std::exchange(items_, work));
}

void ObservedCall::add_queue_time(Lane lane, double seconds) {
  record_.queued = true;
  record_.lane = lane;
  record_.queue_s += seconds;
}

std::string ObservedCall::client() const {
  // A caller has one turn, from however many addresses it calls.
  if (!token_.empty()) return "token:" + token_;
  std::string peer = context_.peer();
  // "ipv4:127.0.0.1:40000", "ipv6:%5B::1%5D:40000", but "unix:/path" and "unix:".
  if (peer.starts_with("ipv4:") || peer.starts_with("ipv6:")) peer.resize(peer.rfind(':'));
  return peer;
}

grpc::Status ObservedCall::end(const absl::Status& status) {
  grpc::Status wire = to_grpc(status, context_);
  record_.code = wire.error_code();
  record_.total_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - arrived_).count();
  context_.AddTrailingMetadata("x-request-id", record_.request_id);
  runtime_.statistics.end(record_);
  if (runtime_.on_call) runtime_.on_call(record_);
  return wire;
}

ComputeLimit::ComputeLimit(const Runtime& runtime, LaneJob::Clock::time_point deadline,
                           std::stop_source stop, double used_s)
    : limit_s_(runtime.max_call_s), deadline_(deadline) {
  if (limit_s_ == 0 || deadline != LaneJob::Clock::time_point::max()) return;
  passed_ = std::make_shared<std::atomic<bool>>(false);
  const auto left = std::chrono::duration<double>(std::max(0.0, limit_s_ - used_s));
  alarm_.emplace().Set(
      LaneJob::Clock::now() + std::chrono::duration_cast<LaneJob::Clock::duration>(left),
      [passed = passed_, stop = std::move(stop)](bool rang) mutable {
        if (!rang) return;  // the work ended before
        *passed = true;
        stop.request_stop();
      });
}

absl::Status ComputeLimit::stopped_status() const {
  if (passed_ == nullptr || !*passed_) return rpc::stopped_status(deadline_);
  return absl::DeadlineExceededError(
      fmt::format("the call computed for {:g} s, the most that this server allows without a "
                  "deadline; set a deadline, or send smaller requests",
                  limit_s_));
}

absl::Status parse_message(const grpc::ByteBuffer& bytes, google::protobuf::Message& message) {
  // gRPC keeps the bytes until the call ends.  The parsed message replaces them.
  auto& buffer = const_cast<grpc::ByteBuffer&>(bytes);
  const std::size_t size = buffer.Length();
  std::string why;
  parser_reason = &why;
  bool parsed = false;
  {
    grpc::ProtoBufferReader reader(&buffer);
    parsed = reader.status().ok() && message.ParseFromZeroCopyStream(&reader);
  }
  parser_reason = nullptr;
  buffer.Clear();
  if (parsed) {
    // What is kept of a message, such as a light, must not keep bytes that nobody counts.
    message.DiscardUnknownFields();
    return absl::OkStatus();
  }
  return error(
      Reason::kMalformedMessage,
      fmt::format("{} bytes that are not a message of the type {}{}{}", size, message.GetTypeName(),
                  why.empty() ? "" : ": ", shortened(why, kMostReasonBytes)));
}

absl::Status encode_message(const google::protobuf::Message& message, grpc::ByteBuffer& bytes) {
  bool own_buffer = false;
  const grpc::Status status =
      grpc::GenericSerialize<grpc::ProtoBufferWriter, google::protobuf::MessageLite>(
          message, &bytes, &own_buffer);
  if (status.ok()) return absl::OkStatus();
  return absl::InternalError(status.error_message());
}

void set_up_protobuf_log() {
  google::protobuf::SetLogHandler(
      [](google::protobuf::LogLevel, const char*, int, const std::string& text) {
        if (parser_reason != nullptr) {
          *parser_reason = text;
        } else {
          spdlog::warn("protobuf: " + text);
        }
      });
}

void add_counts(const v1::Cost& cost, monitor::CallRecord& record) {
  record.samples = cost.samples();
  record.rays = cost.camera_rays() + cost.indirect_rays() + cost.shadow_rays();
}

void set_times(const monitor::CallRecord& record, v1::Cost* cost) {
  cost->set_cpu_time_s(record.cpu_s);
  cost->set_wall_time_s(record.compute_s);
  cost->set_queue_time_s(record.queue_s);
}

}  // namespace lucerna::rpc
