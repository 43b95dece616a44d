// Pictures that come in pieces, shown by the viewer tev (https://github.com/Tom94/tev) as they
// come.
//
// The viewer is never waited for: a thread of its own sends what is newest of each piece, and the
// memory is that of one picture, however slow the viewer is.  One that is not there, or goes away,
// is tried again every two seconds and then gets all there is.
//
// The protocol is that of tev's README, "Over the Network", and src/Ipc.cpp: packets over TCP, each
// with its length and kind before it; CreateImage, then UpdateImage (its third version) for
// rectangles of 32-bit floats.  tev answers nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna::client {

/// Where tev listens unless it is told otherwise.
inline constexpr std::uint16_t kTevPort = 14158;

/// Shows one picture after the other.  Thread-safe.
class TevSender {
 public:
  /// `address`: HOST, HOST:PORT or [IPV6]:PORT; whether somebody listens there matters later.
  /// `on_event` is told once, in whichever thread, that the viewer cannot be had or does not take
  /// what it is sent; it must not call this again.
  ///
  /// INVALID_ARGUMENT for what is no address, or a name that cannot be resolved.
  static absl::StatusOr<std::unique_ptr<TevSender>> create(
      const std::string& address, std::function<void(const std::string&)> on_event = {});
  TevSender(const TevSender&) = delete;
  TevSender& operator=(const TevSender&) = delete;
  /// Sends no more.
  ~TevSender();

  /// A new picture, black so far; it replaces one that the viewer has under this name.  What was
  /// not yet sent of the picture before is not sent any more.  INVALID_ARGUMENT for an empty
  /// picture or one of more than 2^30 pixels.
  absl::Status begin(const std::string& name, std::uint32_t width, std::uint32_t height);
  /// Linear Rec. 709 RGB of a rectangle, three floats a pixel, rows from the top.  INVALID_ARGUMENT
  /// where it is not within the picture, or `rgb` is of another length.
  absl::Status update(const v1::PixelRect& rect, std::span<const float> rgb);

  /// Waits until the viewer has been sent everything; false where it takes no byte for `patience`,
  /// takes more than ten times that in all, or was found not to be there; at once where it has
  /// taken nothing since such a wait.
  bool flush(std::chrono::milliseconds patience);

 private:
  class Impl;
  explicit TevSender(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace lucerna::client
