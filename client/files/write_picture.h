// Writes pictures to files.  An unfinished file has a temporary name, so readers never see a
// half-written picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace lucerna::client {

/// The format that the file's extension names, in upper or lower case.
enum class PictureFormat {
  kExr,  ///< 32-bit float, linear
  kPfm,  ///< 32-bit float, linear
  kPng,  ///< 8 bits, exposed, sRGB curve
};

/// Names of three channels.
using ChannelNames = std::array<std::string, 3>;

/// Linear RGB, interleaved, rows from the top.
struct PictureView {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const float> rgb;
  /// Written as the file's description if the format has one (PFM has none).
  std::string description{};
  /// In .exr.  The other formats have no names.
  ChannelNames channels{"R", "G", "B"};
};

/// INVALID_ARGUMENT lists the extensions.
absl::StatusOr<PictureFormat> picture_format(const std::string& path);

/// The PNG value of a linear value: 255 times the sRGB curve, rounded.  The linear value is clamped
/// to [0, 1] first.  [IEC61966]
std::uint8_t srgb8(float linear);

/// A picture file that is being written.
class PictureFile {
 public:
  /// Checks that the path can be written, by creating a file beside it.  The file has no name until
  /// it is written, so a killed process leaves nothing.  If the file system has no such files, or
  /// `may_be_unnamed` is false, it has a hidden name and a lock.  The next PictureFile of the same
  /// path removes hidden files without a lock, which killed processes left.  INVALID_ARGUMENT for
  /// an unknown extension, a directory, or a place that cannot be written.
  static absl::StatusOr<PictureFile> create(const std::string& path, bool may_be_unnamed = true);
  PictureFile(PictureFile&& other) noexcept;
  PictureFile& operator=(PictureFile&& other) noexcept;
  /// Removes a file that was not finished, except its last preview.
  ~PictureFile();
  /// Removes the preview too.
  void keep_no_preview() { keeps_preview_ = false; }

  /// Writes the picture, then renames the file, which replaces an existing one.  PNG multiplies by
  /// 2^exposure_ev first; the other formats store the values unchanged.
  absl::Status write(const PictureView& picture, double exposure_ev);
  /// The same for an unfinished picture; write() or another preview follows.
  absl::Status write_preview(const PictureView& picture, double exposure_ev);

  const std::string& path() const { return path_; }
  PictureFormat format() const { return format_; }

 private:
  PictureFile(std::string path, std::string temporary, PictureFormat format);
  /// Makes the file beside the path; an error number, or 0.
  int make();
  int make_hidden();
  void remove_leftovers() const;
  void close();

  std::string path_;
  std::string temporary_;  ///< empty when it is no longer needed
  PictureFormat format_;
  bool may_be_unnamed_ = true;
  int file_ = -1;         ///< open and locked, so that nobody else removes it
  bool unnamed_ = false;  ///< `file_` has no name; else it has the name `temporary_`
  bool keeps_preview_ = true;
  bool has_preview_ = false;  ///< a preview has the final name
};

}  // namespace lucerna::client
