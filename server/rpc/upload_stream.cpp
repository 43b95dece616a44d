#include "server/rpc/upload_stream.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

// Hashing larger chunks would delay small queries.
constexpr std::size_t kMostChunkBytes = std::size_t{4} << 20;
// An upload must send this much, or its end, within the time in which it may stall.  Empty or tiny
// chunks would otherwise keep its place for ever.
constexpr std::uint64_t kLeastProgressBytes = std::uint64_t{64} << 10;

absl::Status being_uploaded(absl::Status status) {
  return retry_after(std::move(status), Reason::kAssetBeingUploaded,
                     std::chrono::milliseconds(200));
}

}  // namespace

UploadStream::UploadStream(Runtime& runtime, grpc::CallbackServerContext& context,
                           monitor::Call call)
    : Reactor(runtime, context, call), patience_(runtime.assets->stall_time()) {}

void UploadStream::begin() {
  if (const absl::Status status = admit(); !status.ok()) return finish(status);
  client_ = observed_.client();
  read_next();
}

void UploadStream::read_next() {
  const std::uint64_t bytes = upload_ ? upload_->bytes() : 0;
  if (bytes >= renewed_at_bytes_ + kLeastProgressBytes) {
    patience_ = runtime_.assets->stall_time();
    renewed_at_bytes_ = bytes;
  }
  waits_since_ = std::chrono::steady_clock::now();
  read(patience_);
}

void UploadStream::give_up() {
  // The store may wait for the disk.
  const auto self = std::static_pointer_cast<UploadStream>(shared_from_this());
  runtime_.lanes.resume(Lane::kInteractive,
                        {.run = [self](const LaneJobStart&) { self->finish(self->stalled()); },
                         .client = client_,
                         .connection = observed_.connection()});
}

absl::Status UploadStream::stalled() const {
  return absl::DeadlineExceededError(
      fmt::format("the upload sent less than {} bytes in {} s, the limit", kLeastProgressBytes,
                  runtime_.assets->stall_time().count()));
}

void UploadStream::take(bool ok) {
  patience_ -= std::chrono::steady_clock::now() - waits_since_;
  if (stop_.stop_requested()) return finish(absl::CancelledError("the upload was cancelled"));
  if (!ok) {
    observed_.request_complete();
    return finish(guarded([&] { return end(); }));
  }
  // A full lane refuses only new uploads.
  const auto self = std::static_pointer_cast<UploadStream>(shared_from_this());
  LaneJob job{.run = [self](const LaneJobStart& start) { self->take_message(start); },
              .stop = stop_.get_token(),
              .client = client_,
              .connection = observed_.connection()};
  if (begun_) return runtime_.lanes.resume(Lane::kInteractive, std::move(job));
  const absl::Status queued = runtime_.lanes.submit(Lane::kInteractive, std::move(job));
  if (!queued.ok()) finish(lane_error(queued, Lane::kInteractive));
}

void UploadStream::take_message(const LaneJobStart& start) {
  monitor::CallRecord& record = observed_.record();
  observed_.add_queue_time(Lane::kInteractive, start.queue_time_s);
  if (!start.status.ok()) return finish(start.status);
  record.request_bytes += bytes_.Length();
  const absl::Status status = guarded([&]() -> absl::Status {
    const WorkTime time(record);
    LUCERNA_RETURN_IF_ERROR(parse_message(bytes_, request_));
    if (request_.has_header() != !begun_) {
      return begun_ ? bad_field("part", "header", "chunk, after the header")
                    : bad_field("part", "chunk", "header, before all chunks");
    }
    return begun_ ? take_chunk(request_.chunk()) : take_header(request_.header());
  });
  begun_ = true;
  if (!status.ok() || held_) return finish(status);
  read_next();
}

absl::Status UploadStream::take_header(const v1::AssetHeader& header) {
  header_ = header;
  if (header.sha256().size() != kSha256Bytes) {
    return bad_field("header.sha256", fmt::format("{} bytes", header.sha256().size()),
                     "the 32 bytes of a SHA-256");
  }
  AssetStore& assets = *runtime_.assets;
  const AssetStore::Held held = assets.held(header.sha256());
  if (held.whole) {
    held_ = true;
    response_.set_received_bytes(held.bytes);
    return absl::OkStatus();
  }
  LUCERNA_RETURN_IF_ERROR(
      check_limit("header.size_bytes", header.size_bytes(), assets.max_asset_bytes()));
  const std::uint64_t reach = std::min<std::uint64_t>(held.bytes, header.size_bytes());
  if (header.offset_bytes() > reach) {
    return bad_field("header.offset_bytes", header.offset_bytes(),
                     "[0, {}], the bytes that the server has", reach);
  }
  absl::StatusOr<AssetUpload> upload = assets.upload(
      header.sha256(), header.size_bytes(), header.offset_bytes(),
      {observed_.caller().name, observed_.caller().quota.asset_bytes}, stop_.get_token());
  if (absl::IsFailedPrecondition(upload.status())) return being_uploaded(upload.status());
  if (!upload.ok()) return load_error(upload.status());
  upload_.emplace(*std::move(upload));
  return absl::OkStatus();
}

absl::Status UploadStream::take_chunk(const std::string& chunk) {
  if (chunk.size() > kMostChunkBytes) {
    return bad_field("chunk", fmt::format("{} bytes", chunk.size()), "at most {} bytes",
                     kMostChunkBytes);
  }
  const std::uint64_t rest = upload_->size() - upload_->bytes();
  if (chunk.size() > rest) {
    return bad_field("chunk", fmt::format("{} bytes", chunk.size()),
                     "{} bytes, the rest of header.size_bytes", rest);
  }
  absl::Status status = upload_->append(chunk);
  return absl::IsFailedPrecondition(status) ? being_uploaded(std::move(status)) : status;
}

absl::Status UploadStream::end() {
  if (!upload_) return bad_field("part", "none", "header, before all chunks");
  response_.set_received_bytes(upload_->bytes());
  if (!upload_->complete()) return absl::OkStatus();
  absl::Status status = upload_->finish();
  if (absl::IsInvalidArgument(status)) {
    return bad_field("header.sha256", hexadecimal(header_.sha256()),
                     "{}, the SHA-256 of the received bytes", std::string(status.message()));
  }
  return absl::IsFailedPrecondition(status) ? being_uploaded(std::move(status)) : status;
}

void UploadStream::finish(absl::Status status) {
  upload_.reset();  // stores the received part before the client learns that the call has ended
  if (status.ok()) status = guarded([&] { return encode_message(response_, bytes_); });
  send_last(status);
}

}  // namespace lucerna::rpc
