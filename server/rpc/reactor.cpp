#include "server/rpc/reactor.h"

#include <fmt/core.h>

#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {

void OpenStream::begin() {
  has_slot_ = --runtime_.stream_slots >= 0;
  if (has_slot_) return Reactor::begin();
  ++runtime_.stream_slots;
  finish(retry_after(absl::ResourceExhaustedError("too many streams of health and reflection"),
                     Reason::kQueueFull, std::chrono::seconds(1)));
}

void Reactor::OnCancel() {
  stop_.request_stop();
  observed_.cancelled();
}

void Reactor::begin() { read(idle_time()); }

absl::Status Reactor::admit() {
  in_flight_ = runtime_.calls.begin();
  return in_flight_ ? observed_.admit() : error(Reason::kDraining, "the server is shutting down");
}

void Reactor::read(std::chrono::steady_clock::duration patience) {
  const Waits::Wait wait = wait_ =
      runtime_.waits.until(patience == patience.max() ? Waits::Clock::time_point::max()
                                                      : Waits::Clock::now() + patience);
  reading_ = wait.id;
  const std::weak_ptr<Reactor> weak = weak_from_this();
  StartRead(&bytes_);
  // The message may have been taken by now.
  runtime_.waits.add(wait, [weak, id = wait.id] {
    const auto self = weak.lock();
    std::uint64_t expected = id;
    if (self != nullptr && self->reading_.compare_exchange_strong(expected, 0)) self->give_up();
  });
  if (reading_ != wait.id) runtime_.waits.remove(wait);
}

void Reactor::OnReadDone(bool ok) {
  const Waits::Wait wait = wait_;
  if (ok) observed_.message_taken(bytes_.Length());
  if (reading_.exchange(0) == 0) return;
  runtime_.waits.remove(wait);
  take(ok);
}

std::chrono::steady_clock::duration Reactor::idle_time() const {
  return runtime_.idle_s > 0 ? std::chrono::seconds(runtime_.idle_s)
                             : std::chrono::steady_clock::duration::max();
}

absl::Status Reactor::stalled() const {
  return absl::DeadlineExceededError(
      fmt::format("the request did not arrive within {} s, the limit", runtime_.idle_s));
}

void Reactor::send_last(const absl::Status& status) {
  absl::Status sent = status;
  if (sent.ok()) sent = observed_.room_for_answers(bytes_.Length());
  if (!sent.ok()) return Finish(observed_.end(sent));
  observed_.answer_begun(bytes_.Length());
  observed_.record().response_bytes = bytes_.Length();
  StartWriteAndFinish(&bytes_, {}, observed_.end(sent));
}

}  // namespace lucerna::rpc
