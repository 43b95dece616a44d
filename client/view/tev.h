// Shows unfinished pictures in the viewer tev (https://github.com/Tom94/tev).
//
// Callers never wait for the viewer.  A thread sends the newest pixels of each piece, and the
// memory is that of one picture, however slow the viewer is.  An absent viewer is tried again every
// two seconds; then it gets the whole picture.
//
// The protocol is that of tev's README, "Over the Network", and src/Ipc.cpp.  Packets go over TCP,
// each with its length and kind in front: CreateImage, then UpdateImage (its third version) for
// rectangles of 32-bit floats.  tev sends no answers.
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
  /// `address`: HOST, HOST:PORT or [IPV6]:PORT.  No viewer need listen there yet.  `on_event` gets
  /// one message, in any thread, if the viewer cannot be reached or does not take the bytes.  It
  /// must not call this object.
  ///
  /// INVALID_ARGUMENT for a text that is no address, or a name that cannot be resolved.
  static absl::StatusOr<std::unique_ptr<TevSender>> create(
      const std::string& address, std::function<void(const std::string&)> on_event = {});
  TevSender(const TevSender&) = delete;
  TevSender& operator=(const TevSender&) = delete;
  /// Stops sending.
  ~TevSender();

  /// Begins a new, black picture.  It replaces the viewer's picture of this name.  Unsent pixels of
  /// the picture before are dropped.  INVALID_ARGUMENT for an empty picture or one of more than
  /// 2^30 pixels.
  absl::Status begin(const std::string& name, std::uint32_t width, std::uint32_t height);
  /// Sets the linear Rec. 709 RGB of a rectangle: three floats for each pixel, rows from the top.
  /// INVALID_ARGUMENT if the rectangle is not within the picture, or `rgb` has another length.
  absl::Status update(const v1::PixelRect& rect, std::span<const float> rgb);

  /// Waits until all pixels are sent.  Returns false if the viewer takes no byte for `patience`,
  /// needs more than ten times that in all, or is absent.  After such a failure it returns false at
  /// once until the viewer takes bytes again.
  bool flush(std::chrono::milliseconds patience);

 private:
  class Impl;
  explicit TevSender(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace lucerna::client
