#include "client/files/write_picture.h"

#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

std::string extension(const std::string& path) {
  std::string result = std::filesystem::path(path).extension().string();
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

absl::Status cannot_write(const std::string& path, const std::string& why) {
  return absl::InvalidArgumentError("cannot write " + path + ": " + why);
}

template <class T>
bool write_with_openimageio(const std::string& path, const PictureView& picture,
                            const OIIO::TypeDesc& type, const T* data, std::string* error) {
  const std::unique_ptr<OIIO::ImageOutput> file = OIIO::ImageOutput::create(path);
  if (!file) {
    *error = OIIO::geterror();
    return false;
  }
  OIIO::ImageSpec spec(static_cast<int>(picture.width), static_cast<int>(picture.height), 3, type);
  spec.attribute("oiio:ColorSpace", type == OIIO::TypeDesc::UINT8 ? "sRGB" : "Linear");
  if (!picture.description.empty()) spec.attribute("ImageDescription", picture.description);
  const bool ok = file->open(path, spec) && file->write_image(type, data) && file->close();
  if (!ok) *error = file->geterror();
  return ok;
}

// OpenImageIO 2.4 reads PFM but does not write it.  Rows start at the bottom; a negative scale
// marks little-endian data.
bool write_pfm(const std::string& path, const PictureView& picture, std::string* error) {
  static_assert(std::endian::native == std::endian::little);
  std::ofstream file(path, std::ios::binary);
  file << "PF\n" << picture.width << ' ' << picture.height << "\n-1.0\n";
  const std::size_t row = std::size_t{picture.width} * 3;
  for (std::size_t y = picture.height; y-- > 0;) {
    file.write(reinterpret_cast<const char*>(picture.rgb.data() + y * row),
               static_cast<std::streamsize>(row * sizeof(float)));
  }
  file.close();
  if (!file) *error = std::strerror(errno);
  return static_cast<bool>(file);
}

}  // namespace

absl::StatusOr<PictureFormat> picture_format(const std::string& path) {
  const std::string type = extension(path);
  if (type == ".exr") return PictureFormat::kExr;
  if (type == ".pfm") return PictureFormat::kPfm;
  if (type == ".png") return PictureFormat::kPng;
  return absl::InvalidArgumentError("cannot write " + path +
                                    ": unknown file type, must be .exr, .png or .pfm");
}

std::uint8_t srgb8(float linear) {
  // Also turns NaN into 0.
  const double value = linear > 0 ? std::min(static_cast<double>(linear), 1.0) : 0.0;
  const double coded =
      value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * coded));
}

PictureFile::PictureFile(std::string path, std::string temporary, PictureFormat format)
    : path_(std::move(path)), temporary_(std::move(temporary)), format_(format) {}

PictureFile::PictureFile(PictureFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      format_(other.format_),
      keeps_preview_(other.keeps_preview_),
      has_preview_(other.has_preview_) {}

PictureFile& PictureFile::operator=(PictureFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(temporary_, other.temporary_);
  std::swap(format_, other.format_);
  std::swap(keeps_preview_, other.keeps_preview_);
  std::swap(has_preview_, other.has_preview_);
  return *this;
}

PictureFile::~PictureFile() {
  if (temporary_.empty()) return;
  ::unlink(temporary_.c_str());
  if (has_preview_ && !keeps_preview_) ::unlink(path_.c_str());
}

absl::StatusOr<PictureFile> PictureFile::create(const std::string& path) {
  LUCERNA_ASSIGN_OR_RETURN(const auto format, picture_format(path));
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return cannot_write(path, "it is a directory");
  const std::filesystem::path target(path);
  // OpenImageIO chooses the format by the extension, so the temporary name has the same extension.
  std::string temporary = (target.parent_path() / ("." + target.stem().string() + "." +
                                                   std::to_string(::getpid()) + extension(path)))
                              .string();
  const int file = ::open(temporary.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
  if (file < 0) return cannot_write(path, std::strerror(errno));
  ::close(file);
  return PictureFile(path, std::move(temporary), format);
}

absl::Status PictureFile::write(const PictureView& picture, double exposure_ev) {
  absl::Status status = write_preview(picture, exposure_ev);
  if (status.ok()) temporary_.clear();
  return status;
}

absl::Status PictureFile::write_preview(const PictureView& picture, double exposure_ev) {
  std::string why;
  bool ok = false;
  switch (format_) {
    case PictureFormat::kExr:
      ok = write_with_openimageio(temporary_, picture, OIIO::TypeDesc::FLOAT, picture.rgb.data(),
                                  &why);
      break;
    case PictureFormat::kPfm:
      ok = write_pfm(temporary_, picture, &why);
      break;
    case PictureFormat::kPng: {
      const double exposure = std::exp2(exposure_ev);
      std::vector<std::uint8_t> codes(picture.rgb.size());
      std::transform(picture.rgb.begin(), picture.rgb.end(), codes.begin(),
                     [&](float value) { return srgb8(static_cast<float>(value * exposure)); });
      ok = write_with_openimageio(temporary_, picture, OIIO::TypeDesc::UINT8, codes.data(), &why);
      break;
    }
  }
  if (!ok) return cannot_write(path_, why);
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) {
    return cannot_write(path_, std::strerror(errno));
  }
  has_preview_ = true;
  return absl::OkStatus();
}

}  // namespace lucerna::client
