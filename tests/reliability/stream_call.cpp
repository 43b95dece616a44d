#include "tests/reliability/stream_call.h"

#include <utility>

namespace lucerna::reliability {

StreamCall::StreamCall(const std::shared_ptr<grpc::Channel>& channel, const Message& message,
                       std::optional<Clock::time_point> deadline,
                       std::optional<grpc::ByteBuffer> repeated)
    : stub_(channel), first_(message.bytes), repeated_(std::move(repeated)) {
  if (deadline) {
    context_.set_deadline(on_system_clock(*deadline));
  }
  stream_ = stub_.PrepareCall(&context_, message.method, &queue_);
  stream_->StartCall(tag(kStart));
  ++open_;
}

StreamCall::~StreamCall() {
  cancel();
  while (open_ > 0) work(Clock::now() + std::chrono::seconds(1));
  queue_.Shutdown();
  void* none = nullptr;
  bool ok = false;
  while (queue_.Next(&none, &ok)) {
  }
}

void StreamCall::take(Step step, bool ok) {
  --open_;
  switch (step) {
    case kStart: {
      if (ok && repeated_) {
        stream_->Write(first_, tag(kWrite));
      } else if (ok) {
        stream_->WriteLast(first_, grpc::WriteOptions(), tag(kWrite));
      }
      stream_->Read(&answer_, tag(kRead));
      open_ += ok ? 2 : 1;
      break;
    }
    case kWrite:
      if (!ok || !repeated_) break;
      stream_->Write(*repeated_, tag(kWrite));
      ++open_;
      break;
    case kRead:
      if (ok) {
        stream_->Read(&answer_, tag(kRead));
      } else {
        stream_->Finish(&status_, tag(kFinish));
      }
      ++open_;
      break;
    case kFinish:
      ended_ = true;
      break;
  }
}

bool StreamCall::work(Clock::time_point until) {
  const auto deadline = on_system_clock(until);
  void* tag = nullptr;
  bool ok = false;
  while (open_ > 0 && queue_.AsyncNext(&tag, &ok, deadline) == grpc::CompletionQueue::GOT_EVENT) {
    take(static_cast<Step>(reinterpret_cast<std::uintptr_t>(tag)), ok);
    if (Clock::now() >= until) break;
  }
  return ended_;
}

}  // namespace lucerna::reliability
