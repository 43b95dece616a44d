// Formats that this room decodes itself, behind the interface of OpenImageIO.  Only for the files
// of this room.
#pragma once

#include <OpenImageIO/imageio.h>
#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string_view>
#include <utility>
#include <vector>

#include "server/pictures/picture_checks.h"
#include "server/pictures/picture_format.h"

namespace lucerna {

/// A picture that is decoded as a whole when its first row is read.
class WholePicture : public OIIO::ImageInput {
 public:
  using OIIO::ImageInput::open;
  const char* format_name() const final { return "lucerna"; }
  bool open(const std::string& name, OIIO::ImageSpec& spec) final;
  bool close() final { return true; }
  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) final;

  /// `bytes` must outlive the object.
  WholePicture(std::string_view bytes, std::stop_token stop)
      : bytes_(bytes), stop_(std::move(stop)) {}

  /// Memory of the decoded picture.
  std::uint64_t decoded_bytes() const { return texels() * stored_bytes(); }

 protected:
  std::string_view bytes() const { return bytes_; }
  /// As number_at(), for at most 4 bytes of the file.
  std::uint32_t number(std::size_t at, std::size_t count,
                       std::endian order = std::endian::little) const {
    return static_cast<std::uint32_t>(number_at(bytes_, at, count, order));
  }
  bool stopped() const { return stop_.stop_requested(); }
  std::size_t width() const { return static_cast<std::size_t>(m_spec.width); }
  std::size_t height() const { return static_cast<std::size_t>(m_spec.height); }
  std::uint64_t texels() const { return std::uint64_t{width()} * height(); }

  static absl::Status ends_early() { return absl::InvalidArgumentError("the file ends early"); }

 private:
  /// Sets `m_spec`: the size, the channels, their type, and "Orientation" as in TIFF.  Sizes may be
  /// of any value: the caller checks them before it reads a row.
  virtual absl::Status read_header() = 0;
  /// Sets the stored texels, whose place is `to`: width x height x stored_bytes, all 0.
  virtual absl::Status decode(std::uint8_t* to) = 0;
  /// Bytes that `decode` stores for each texel.
  virtual std::size_t stored_bytes() const { return m_spec.pixel_bytes(); }
  /// Converts stored texels of a row to those of `m_spec`.
  virtual void convert(const std::uint8_t* stored, void* to) const;

  std::string_view bytes_;
  std::stop_token stop_;
  std::vector<std::uint8_t> stored_;
  bool is_decoded_ = false;
};

/// The reader for a format; null for those that OpenImageIO decodes.  `bytes` must outlive it.
std::unique_ptr<WholePicture> whole_picture(PictureFormat format, std::string_view bytes,
                                            std::stop_token stop);

}  // namespace lucerna
