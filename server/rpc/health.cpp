#include "server/rpc/health.h"

#include <grpc/health/v1/health.pb.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "server/rpc/messages/errors.h"
#include "server/rpc/services.h"

namespace lucerna::rpc {
namespace {

using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

/// The empty name means the whole server.
bool exists(const std::string& service) {
  return service.empty() || std::ranges::count(service_names(), service) > 0;
}

HealthCheckResponse::ServingStatus status_of(bool serving) {
  return serving ? HealthCheckResponse::SERVING : HealthCheckResponse::NOT_SERVING;
}

absl::Status encode(int status, grpc::ByteBuffer& bytes) {
  HealthCheckResponse response;
  response.set_status(static_cast<HealthCheckResponse::ServingStatus>(status));
  return encode_message(response, bytes);
}

}  // namespace

void HealthCheck::take(bool ok) {
  if (!ok) return finish(no_message());
  HealthCheckRequest request;
  absl::Status status = parse_message(bytes_, request);
  if (status.ok() && !exists(request.service()))
    status = absl::NotFoundError("the server has no such service");
  if (status.ok()) status = encode(status_of(runtime_.serving.serving()), bytes_);
  send_last(status);
}

void HealthWatch::finish(absl::Status status) {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(finished_, true)) return;
  }
  Reactor::finish(std::move(status));
}

void HealthWatch::take(bool ok) {
  if (!ok) return finish(no_message());
  HealthCheckRequest request;
  absl::Status status = parse_message(bytes_, request);
  if (!status.ok()) return finish(status);
  {
    const std::lock_guard lock(mutex_);
    next_ = HealthCheckResponse::SERVICE_UNKNOWN;
  }
  if (exists(request.service())) {
    const std::weak_ptr<Reactor> weak = weak_from_this();
    const auto stopped = [this, weak] {
      const auto self = weak.lock();
      if (self == nullptr) return;
      {
        const std::lock_guard lock(mutex_);
        next_ = HealthCheckResponse::NOT_SERVING;
      }
      advance();
    };
    const bool serving = runtime_.serving.watch(this, stopped);
    const std::lock_guard lock(mutex_);
    // It may have stopped meanwhile.
    if (next_ == HealthCheckResponse::SERVICE_UNKNOWN) next_ = status_of(serving);
  }
  advance();
}

void HealthWatch::OnCancel() {
  Reactor::OnCancel();
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  advance();
}

void HealthWatch::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    cancelled_ |= !ok;
  }
  advance();
}

void HealthWatch::advance() {
  bool end = false;
  {
    const std::lock_guard lock(mutex_);
    if (writing_ || finished_) return;
    end = finished_ = cancelled_;
    writing_ = !end && next_.has_value();
    if (!end && !writing_) return;
    if (writing_) end = finished_ = !encode(*next_, bytes_).ok();
    next_.reset();
  }
  if (end) return Reactor::finish(cancelled());
  StartWrite(&bytes_);
}

}  // namespace lucerna::rpc
