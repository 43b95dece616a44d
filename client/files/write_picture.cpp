#include "client/files/write_picture.h"

#include <fcntl.h>
#include <png.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "client/files/map_file.h"
#include "client/files/srgb.h"
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

absl::Status write_exr(const std::string& path, const PictureView& picture) {
  const int width = static_cast<int>(picture.width);
  const int height = static_cast<int>(picture.height);
  LUCERNA_ASSIGN_OR_RETURN(
      const auto file,
      MapWriter::create(path, {0, 0, width, height, 0, 0, width, height},
                        {picture.channels.begin(), picture.channels.end()}, picture.description));
  const std::size_t row = std::size_t{picture.width} * 3;
  for (std::size_t y = 0; y < picture.height; ++y)
    LUCERNA_RETURN_IF_ERROR(file->write_row(picture.rgb.subspan(y * row, row)));
  return file->close();
}

/// The reason of libpng's last error.
void keep_message(png_structp png, png_const_charp message) {
  *static_cast<std::string*>(png_get_error_ptr(png)) = message;
  png_longjmp(png, 1);
}

/// Calls libpng, whose errors jump back to here.  Nothing with a destructor is created after
/// setjmp().
bool write_png(std::FILE* file, png_structp png, png_infop info, const PictureView& picture,
               std::span<const std::uint8_t> codes) {
  // NOLINTNEXTLINE(cert-err52-cpp): libpng reports errors so
  if (setjmp(png_jmpbuf(png))) return false;
  png_init_io(png, file);
  png_set_IHDR(png, info, picture.width, picture.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_ABSOLUTE);
  if (!picture.description.empty()) {
    char key[] = "Description";
    png_text text{};
    text.compression = PNG_TEXT_COMPRESSION_NONE;
    text.key = key;
    // libpng only reads the text.
    text.text = const_cast<char*>(picture.description.c_str());  // NOLINT(*-const-cast)
    text.text_length = picture.description.size();
    png_set_text(png, info, &text, 1);
  }
  png_write_info(png, info);
  const std::size_t row = std::size_t{picture.width} * 3;
  for (std::size_t y = 0; y < picture.height; ++y) png_write_row(png, codes.data() + y * row);
  png_write_end(png, info);
  return true;
}

absl::Status write_png(const std::string& path, const PictureView& picture,
                       std::span<const std::uint8_t> codes) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return absl::UnknownError(std::strerror(errno));
  std::string why;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &why, keep_message, nullptr);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  bool ok = info != nullptr && write_png(file, png, info, picture, codes);
  png_destroy_write_struct(&png, &info);
  if (std::fclose(file) != 0 && ok) {
    ok = false;
    why = std::strerror(errno);
  }
  return ok ? absl::OkStatus() : absl::UnknownError(why);
}

// Rows start at the bottom; a negative scale marks little-endian data.
absl::Status write_pfm(const std::string& path, const PictureView& picture) {
  static_assert(std::endian::native == std::endian::little);
  std::ofstream file(path, std::ios::binary);
  file << "PF\n" << picture.width << ' ' << picture.height << "\n-1.0\n";
  const std::size_t row = std::size_t{picture.width} * 3;
  for (std::size_t y = picture.height; y-- > 0;) {
    file.write(reinterpret_cast<const char*>(picture.rgb.data() + y * row),
               static_cast<std::streamsize>(row * sizeof(float)));
  }
  file.close();
  return file ? absl::OkStatus() : absl::UnknownError(std::strerror(errno));
}

absl::Status write_as(PictureFormat format, const std::string& path, const PictureView& picture,
                      double exposure_ev) {
  if (format == PictureFormat::kExr) return write_exr(path, picture);
  if (format == PictureFormat::kPfm) return write_pfm(path, picture);
  const double exposure = std::exp2(exposure_ev);
  std::vector<std::uint8_t> codes(picture.rgb.size());
  std::transform(picture.rgb.begin(), picture.rgb.end(), codes.begin(),
                 [&](float value) { return srgb8(static_cast<float>(value * exposure)); });
  return write_png(path, picture, codes);
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
  return static_cast<std::uint8_t>(std::lround(255 * srgb_encoded(value)));
}

PictureFile::PictureFile(std::string path, std::string temporary, PictureFormat format)
    : path_(std::move(path)), temporary_(std::move(temporary)), format_(format) {}

PictureFile::PictureFile(PictureFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      format_(other.format_),
      may_be_unnamed_(other.may_be_unnamed_),
      file_(std::exchange(other.file_, -1)),
      unnamed_(other.unnamed_),
      keeps_preview_(other.keeps_preview_),
      has_preview_(other.has_preview_) {}

PictureFile& PictureFile::operator=(PictureFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(temporary_, other.temporary_);
  std::swap(format_, other.format_);
  std::swap(may_be_unnamed_, other.may_be_unnamed_);
  std::swap(file_, other.file_);
  std::swap(unnamed_, other.unnamed_);
  std::swap(keeps_preview_, other.keeps_preview_);
  std::swap(has_preview_, other.has_preview_);
  return *this;
}

PictureFile::~PictureFile() {
  close();
  if (temporary_.empty()) return;
  ::unlink(temporary_.c_str());
  if (has_preview_ && !keeps_preview_) ::unlink(path_.c_str());
}

absl::StatusOr<PictureFile> PictureFile::create(const std::string& path, bool may_be_unnamed) {
  LUCERNA_ASSIGN_OR_RETURN(const auto format, picture_format(path));
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return cannot_write(path, "it is a directory");
  const std::filesystem::path target(path);
  // The temporary name keeps the extension, so a crash leaves a file that viewers know.
  std::string temporary = (target.parent_path() / ("." + target.stem().string() + "." +
                                                   std::to_string(::getpid()) + extension(path)))
                              .string();
  PictureFile file(path, std::move(temporary), format);
  file.may_be_unnamed_ = may_be_unnamed;
  file.remove_leftovers();
  if (const int failed = file.make(); failed != 0) {
    file.temporary_.clear();  // another process may have made it
    return cannot_write(path, std::strerror(failed));
  }
  return file;
}

int PictureFile::make() {
  std::filesystem::path folder = std::filesystem::path(path_).parent_path();
  if (folder.empty()) folder = ".";
  if (may_be_unnamed_) file_ = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  unnamed_ = file_ >= 0;
  if (!unnamed_) return make_hidden();
  // It gets its hidden name for a moment, too.
  ::flock(file_, LOCK_EX | LOCK_NB);
  return 0;
}

int PictureFile::make_hidden() {
  for (;;) {
    file_ = ::open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (file_ < 0) return errno;
    ::flock(file_, LOCK_EX | LOCK_NB);
    // Another process may have locked it first, and removed it.
    struct stat found {};
    if (::fstat(file_, &found) != 0 || found.st_nlink > 0) return 0;
    close();
  }
}

void PictureFile::remove_leftovers() const {
  const std::filesystem::path target(path_);
  std::filesystem::path folder = target.parent_path();
  if (folder.empty()) folder = ".";
  const std::string begin = "." + target.stem().string() + ".", end = extension(path_);
  std::error_code ignored;
  for (std::filesystem::directory_iterator at(folder, ignored), last; !ignored && at != last;
       at.increment(ignored)) {
    const std::string name = at->path().filename().string();
    if (name.size() <= begin.size() + end.size() || !name.starts_with(begin) ||
        !name.ends_with(end)) {
      continue;
    }
    const std::string process = name.substr(begin.size(), name.size() - begin.size() - end.size());
    if (process.find_first_not_of("0123456789") != std::string::npos) continue;
    const int file = ::open(at->path().c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) continue;
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(at->path().c_str());
    ::close(file);
  }
}

void PictureFile::close() {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
}

absl::Status PictureFile::write(const PictureView& picture, double exposure_ev) {
  absl::Status status = write_preview(picture, exposure_ev);
  if (status.ok()) temporary_.clear();
  return status;
}

absl::Status PictureFile::write_preview(const PictureView& picture, double exposure_ev) {
  // A preview before this one took the file.
  if (file_ < 0) {
    if (const int failed = make(); failed != 0) return cannot_write(path_, std::strerror(failed));
  }
  const std::string unnamed = "/proc/self/fd/" + std::to_string(file_);
  const std::string& written_to = unnamed_ ? unnamed : temporary_;
  const absl::Status written = write_as(format_, written_to, picture, exposure_ev);
  if (!written.ok()) return cannot_write(path_, std::string(written.message()));
  // A link cannot replace a file, so the name is temporary for a moment.
  if (unnamed_ &&
      ::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0)
    return cannot_write(path_, std::strerror(errno));
  unnamed_ = false;
  if (::rename(temporary_.c_str(), path_.c_str()) != 0)
    return cannot_write(path_, std::strerror(errno));
  close();
  has_preview_ = true;
  return absl::OkStatus();
}

}  // namespace lucerna::client
