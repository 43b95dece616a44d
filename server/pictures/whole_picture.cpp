#include "server/pictures/whole_picture.h"

#include <cstring>
#include <string>

#include "server/pictures/bmp_picture.h"
#include "server/pictures/qoi_picture.h"
#include "server/pictures/radiance_picture.h"
#include "server/pictures/tga_picture.h"

namespace lucerna {

bool WholePicture::open(const std::string&, OIIO::ImageSpec& spec) {
  if (const absl::Status status = read_header(); !status.ok()) {
    errorfmt("{}", std::string(status.message()));
    return false;
  }
  spec = m_spec;
  return true;
}

bool WholePicture::read_native_scanline(int, int, int y, int, void* data) {
  if (!is_decoded_) {
    stored_.assign(decoded_bytes(), 0);
    if (const absl::Status status = decode(stored_.data()); !status.ok()) {
      errorfmt("{}", std::string(status.message()));
      return false;
    }
    is_decoded_ = true;
  }
  convert(stored_.data() + static_cast<std::size_t>(y) * width() * stored_bytes(), data);
  return true;
}

void WholePicture::convert(const std::uint8_t* stored, void* to) const {
  std::memcpy(to, stored, width() * stored_bytes());
}

std::unique_ptr<WholePicture> whole_picture(PictureFormat format, std::string_view bytes,
                                            std::stop_token stop) {
  switch (format) {
    case PictureFormat::kBmp:
      return std::make_unique<BmpPicture>(bytes, std::move(stop));
    case PictureFormat::kQoi:
      return std::make_unique<QoiPicture>(bytes, std::move(stop));
    case PictureFormat::kRadiance:
      return std::make_unique<RadiancePicture>(bytes, std::move(stop));
    case PictureFormat::kTga:
      return std::make_unique<TgaPicture>(bytes, std::move(stop));
    default:
      return nullptr;
  }
}

}  // namespace lucerna
