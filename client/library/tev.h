// Shows unfinished pictures in the viewer tev (https://github.com/Tom94/tev).
//
// Callers never wait for the viewer.  A thread sends the newest pixels of each rectangle.  It needs
// memory for one picture, even if the viewer is slow.  If the viewer is absent, it tries to connect
// every two seconds, and then sends the whole picture.
//
// The protocol is described in tev's README, "Over the Network", and in src/Ipc.cpp.  Packets are
// sent over TCP, each with its length and its kind in front.  CreateImage comes first, then
// UpdateImage (its third version) for rectangles of 32-bit floats.  tev sends no answers.
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

/// The port on which tev listens by default.
inline constexpr std::uint16_t kTevPort = 14158;

/// Shows one picture after the other.  Thread-safe.
class TevSender {
 public:
  /// `address`: HOST, HOST:PORT or [IPV6]:PORT.  The viewer may start later.  `on_event` receives
  /// at most one message, in any thread, if the viewer cannot be reached or does not accept the
  /// bytes.  It must not call this object.
  ///
  /// INVALID_ARGUMENT for a text that is not an address, or a name that cannot be resolved.
  static absl::StatusOr<std::unique_ptr<TevSender>> create(
      const std::string& address, std::function<void(const std::string&)> on_event = {});
  TevSender(const TevSender&) = delete;
  TevSender& operator=(const TevSender&) = delete;
  /// Stops sending.
  ~TevSender();

  /// Begins a new, black picture.  It replaces the viewer's picture of this name.  Drops unsent
  /// pixels of the earlier picture.  INVALID_ARGUMENT for an empty picture or one of more than 2^30
  /// pixels.
  absl::Status begin(const std::string& name, std::uint32_t width, std::uint32_t height);
  /// Sets the linear Rec. 709 RGB of a rectangle: three floats for each pixel, rows from the top.
  /// INVALID_ARGUMENT if the rectangle is not within the picture, or `rgb` has another length.
  absl::Status update(const v1::PixelRect& rect, std::span<const float> rgb);

  /// Waits until all pixels are sent.  Returns false if the viewer accepts no byte for `patience`,
  /// needs more than ten times that in all, or is absent.  After such a failure, returns false at
  /// once until the viewer accepts bytes again.
  bool flush(std::chrono::milliseconds patience);

 private:
  class Impl;
  explicit TevSender(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace lucerna::client
