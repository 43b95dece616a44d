#include "server/pictures/image_file.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "server/pictures/decoding_limits.h"
#include "server/pictures/exr_header.h"
#include "server/pictures/jpeg_source.h"
#include "server/pictures/picture_checks.h"
#include "server/pictures/picture_colours.h"
#include "server/pictures/webp_header.h"

namespace lucerna {
namespace {

constexpr int kMaxChannels = 64;

absl::Status check_spec(const AssetContent& content, const OIIO::ImageSpec& spec,
                        std::uint64_t max_texels) {
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1)
    return bad_picture(content,
                       fmt::format("{} x {} texels of {} channels, allowed: at least 1 x 1 of 1, "
                                   "in one plane",
                                   spec.width, spec.height, spec.nchannels));
  LUCERNA_RETURN_IF_ERROR(check_texels(content, spec.width, spec.height, max_texels));
  if (spec.nchannels > kMaxChannels)
    return bad_picture(content,
                       fmt::format("{} channels, allowed: 1 to {}", spec.nchannels, kMaxChannels));
  return absl::OkStatus();
}

/// Whether the rows of a PNG file are stored in several passes.
bool is_interlaced_png(std::string_view bytes) {
  constexpr std::size_t kInterlace = 28;
  return bytes.size() > kInterlace && bytes[kInterlace] != 0;
}

}  // namespace

/// An unnamed file that holds `bytes`, for formats that OpenImageIO reads only by name.
class ImageFile::MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : fd_(::memfd_create("image", MFD_CLOEXEC)) {
    std::size_t done = 0;
    while (fd_ >= 0 && done < bytes.size()) {
      const ssize_t n = ::write(fd_, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      done += static_cast<std::size_t>(n);
    }
    ok_ = fd_ >= 0 && done == bytes.size();
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  bool ok() const { return ok_; }
  std::string path() const { return fmt::format("/proc/self/fd/{}", fd_); }

 private:
  int fd_;
  bool ok_;
};

ImageFile::StoppableReader::StoppableReader(const std::string& bytes, std::stop_token stop)
    // OpenImageIO 2.4 requires a pointer to non-const bytes, which it only reads.
    : IOMemReader(const_cast<char*>(bytes.data()),  // NOLINT(cppcoreguidelines-pro-type-const-cast)
                  bytes.size()),
      stop_(std::move(stop)) {}

std::size_t ImageFile::StoppableReader::read(void* to, std::size_t size) {
  const std::size_t n = pread(to, size, m_pos);
  m_pos += static_cast<std::int64_t>(n);
  return n;
}

std::size_t ImageFile::StoppableReader::pread(void* to, std::size_t size, std::int64_t offset) {
  // That of OpenImageIO 2.4 reads the memory before the file if an offset is below zero.  EXR files
  // state the offsets of their rows.
  const auto all = static_cast<std::size_t>(m_buf.size());
  if (stop_.stop_requested() || offset < 0 || static_cast<std::size_t>(offset) >= all) return 0;
  const std::size_t n = std::min(size, all - static_cast<std::size_t>(offset));
  std::memcpy(to, m_buf.data() + offset, n);
  return n;
}

ImageFile::ImageFile(const AssetContent& content, const ImageOptions& options)
    : content_(&content), format_(format_of(content)), options_(options), opened_(options.budget) {}

absl::StatusOr<ImageFile> ImageFile::open(const AssetContent& content,
                                          const ImageOptions& options) {
  const PictureFormat format = format_of(content);
  if (format == PictureFormat::kUnknown)
    return bad_picture(content, fmt::format("unknown kind of image, allowed: {}", kKnownFormats));
  if (options.stop.stop_requested()) return absl::CancelledError("loading was cancelled");
  ImageFile file(content, options);
  bool ok = false;
  if (auto whole = whole_picture(format, content.bytes, options.stop)) {
    ok = whole->open("", file.spec_);
    file.whole_bytes_ = whole->decoded_bytes();
    file.input_ = std::move(whole);
  } else {
    LUCERNA_ASSIGN_OR_RETURN(ok, file.open_by_library());
  }
  // A decoder takes a stop for the end of the file.
  if (options.stop.stop_requested()) return absl::CancelledError("loading was cancelled");
  if (!ok) return file.unreadable();
  file.find_colours();
  LUCERNA_RETURN_IF_ERROR(check_spec(content, file.spec_, options.max_texels));
  // OpenImageIO 2.4 reads the EXIF of WebP only if it has the mark of JPEG.
  if (format == PictureFormat::kWebp)
    file.spec_.attribute("Orientation", webp_orientation(content.bytes));
  file.arrangement_ = Arrangement(file.spec_, format == PictureFormat::kExr);
  // The numbers of a display window may exceed an int.
  if (file.arrangement_.width() < 1 || file.arrangement_.height() < 1)
    return bad_picture(content, fmt::format("a display window of {} x {} texels, allowed: at least "
                                            "1 x 1",
                                            file.arrangement_.width(), file.arrangement_.height()));
  LUCERNA_RETURN_IF_ERROR(check_texels(content, file.arrangement_.width(),
                                       file.arrangement_.height(), options.max_texels));
  return file;
}

absl::StatusOr<bool> ImageFile::open_by_library() {
  if (format_ == PictureFormat::kExr)
    LUCERNA_RETURN_IF_ERROR(check_exr_header(*content_, options_.max_texels));
  if (format_ == PictureFormat::kJpeg) LUCERNA_RETURN_IF_ERROR(check_jpeg_scans(*content_));
  if (format_ == PictureFormat::kPng) LUCERNA_RETURN_IF_ERROR(check_png_texts(*content_));
  if (format_ == PictureFormat::kWebp) {
    // The library decodes the picture when it opens the file.
    const auto [width, height] = webp_size(content_->bytes);
    LUCERNA_RETURN_IF_ERROR(check_texels(*content_, width, height, options_.max_texels));
    constexpr std::uint64_t kBytesOfTexel = 3 * 4;  // two canvases, and the decoded picture
    LUCERNA_RETURN_IF_ERROR(opened_.resize(kBytesOfTexel * static_cast<std::uint64_t>(width) *
                                           static_cast<std::uint64_t>(height)));
  }
  // Chosen only by the format: with a file name, OpenImageIO would look for that file.
  const std::string name = library_name(format_);
  input_ = OIIO::ImageInput::create(name);
  if (!input_) return absl::InternalError(content_->name + ": " + first_line(OIIO::geterror()));
  OIIO::ImageSpec config;
  // Use the stored colours, not multiplied by alpha.
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (input_->supports("ioproxy")) {
    if (format_ == PictureFormat::kJpeg)
      memory_ = std::make_unique<JpegSource>(content_->bytes, options_.stop);
    else
      memory_ = std::make_unique<StoppableReader>(content_->bytes, options_.stop);
    OIIO::Filesystem::IOProxy* proxy = memory_.get();
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, static_cast<void*>(&proxy));
    return input_->open("image." + name, spec_, config);
  }
  file_ = std::make_shared<MemoryFile>(content_->bytes);
  if (!file_->ok())
    return absl::ResourceExhaustedError(content_->name + ": " + std::strerror(errno));
  return input_->open(file_->path(), spec_, config);
}

void ImageFile::find_colours() {
  OIIO::ImageSpec spec = spec_;
  while (spec_.deep || !colours()) {
    if (!input_->seek_subimage(++subimage_, 0)) {
      input_->seek_subimage(subimage_ = 0, 0);
      spec_ = std::move(spec);
      return;
    }
    spec_ = input_->spec();
  }
  if (colours()->is_xyz) set_primaries_of_xyz(spec_);
}

absl::Status ImageFile::unreadable() const {
  return unreadable_picture(*content_, input_->geterror());
}

Encoding ImageFile::encoding() const {
  Encoding encoding = options_.encoding;
  if (spec_.get_string_attribute("oiio:ColorSpace") == "Linear" && format_ == PictureFormat::kQoi)
    encoding.gamma = kLinear.gamma;
  return encoding;
}

std::uint64_t ImageFile::decoder_bytes() const {
  if (whole_bytes_ > 0) return whole_bytes_;
  const std::uint64_t row = spec_.scanline_bytes(true);
  const auto rows = [&](int count) {
    return row * static_cast<std::uint64_t>(std::clamp(count, 1, spec_.height));
  };
  if (spec_.tile_height > 0) return rows(spec_.tile_height);
  if (format_ == PictureFormat::kPng && is_interlaced_png(content_->bytes))
    return rows(spec_.height);
  // 16-bit coefficients of 8-bit codes.
  if (format_ == PictureFormat::kJpeg && jpeg_scans(content_->bytes).keeps_coefficients())
    return 2 * rows(spec_.height);
  return rows(spec_.get_int_attribute("tiff:RowsPerStrip", 1));
}

std::size_t ImageFile::rows_at_once() const {
  // About 5 ms of decoding.  Formats that compress several rows together keep them between bands.
  constexpr std::size_t kTexels = std::size_t{1} << 18;
  constexpr std::size_t kLeastRows = 16;
  const std::size_t rows = std::max(kTexels / width(), kLeastRows);
  const auto tile = static_cast<std::size_t>(std::max(spec_.tile_height, 1));
  return (rows + tile - 1) / tile * tile;
}

bool ImageFile::read_rows(std::size_t first, std::size_t rows, int low, int high,
                          OIIO::TypeDesc type, void* to) {
  const int begin = spec_.y + static_cast<int>(first);
  const int end = begin + static_cast<int>(rows);
  if (spec_.tile_width > 0)
    return input_->read_tiles(subimage_, 0, spec_.x, spec_.x + spec_.width, begin, end, spec_.z,
                              spec_.z + 1, low, high + 1, type, to);
  const std::size_t values = rows * width() * static_cast<std::size_t>(high - low + 1);
  if (!spec_.channelformats.empty() || values > std::numeric_limits<int>::max())
    return input_->read_scanlines(subimage_, 0, begin, end, spec_.z, low, high + 1, type, to);
  // read_scanlines() does the same through a buffer of 64 MiB, which it allocates for each band.
  const auto read_native = [&](void* rows_to) {
    return input_->read_native_scanlines(subimage_, 0, begin, end, spec_.z, low, high + 1, rows_to);
  };
  if (spec_.format == type) return read_native(to);
  stored_.resize(values * spec_.format.size());
  return read_native(stored_.data()) &&
         OIIO::convert_pixel_values(spec_.format, stored_.data(), type, to,
                                    static_cast<int>(values));
}

std::vector<ImageRemark> ImageFile::remarks() {
  const std::string& name = content_->name;
  std::vector<ImageRemark> remarks;
  const OIIO::ImageSpec& spec = spec_;
  const auto layer = colours();
  const bool alpha = layer && layer->alpha >= 0;
  if (alpha) remarks.push_back({name + " has an alpha channel", "alpha is ignored", true});
  const int used = layer && layer->is_grey() ? 1 : 3;
  if (const int rest = spec.nchannels - used - (alpha ? 1 : 0); rest > 0)
    remarks.push_back(
        {fmt::format("{} has {} channels besides R, G, B and A", name, rest), "they are ignored"});
  if (layer && layer->others > 0)
    remarks.push_back({fmt::format("{} has {} layers with colours", name, layer->others + 1),
                       fmt::format("the layer \"{}\" is used", first_line(layer->name))});
  if (layer && layer->is_xyz && options_.encoding.meaning != Encoding::Meaning::kData)
    remarks.push_back({name + " has the channels X, Y and Z", "taken as CIE XYZ"});
  const bool has_window = spec.x != spec.full_x || spec.y != spec.full_y ||
                          spec.width != spec.full_width || spec.height != spec.full_height;
  if (has_window && format_ == PictureFormat::kExr)
    remarks.push_back({name + " has a data window that differs from its display window",
                       "the display window is the picture, black outside of the data window; "
                       "pbrt-v4 takes the data window"});
  else if (has_window)
    remarks.push_back(
        {name + " states a place within a larger picture", "the file's texels are the picture"});
  if (const std::string gamma = spec.get_string_attribute("gamma line"); !gamma.empty())
    remarks.push_back({fmt::format("{} has the header line \"{}\"", name, gamma),
                       "its texels are taken as linear, as in pbrt-v4"});
  if (options_.encoding == kSrgb || options_.encoding == kLuminances)
    if (const std::string other = other_colours(*content_, format_, spec); !other.empty())
      remarks.push_back({name + " has " + other, "treated as sRGB, as in pbrt-v4", true});
  if (input_->seek_subimage(1, 0))
    remarks.push_back({name + " has several pictures", subimage_ == 0
                                                           ? "the first one is used"
                                                           : "the first one with colours is used"});
  input_->seek_subimage(subimage_, 0);
  return remarks;
}

}  // namespace lucerna
