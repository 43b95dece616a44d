// Pictures into files, and nothing half-done: under a name of its own until it is complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace lucerna::client {

/// What the file's extension says, in any case.
enum class PictureFormat {
  kExr,  ///< 32-bit float, linear
  kPfm,  ///< 32-bit float, linear
  kPng,  ///< 8 bits, exposed and with the curve of sRGB
};

/// Linear RGB, interleaved, rows from the top.
struct PictureView {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const float> rgb;
  /// Put into the file as its description, where the format has a place for it (PFM has not).
  std::string description{};
};

/// INVALID_ARGUMENT naming the extensions that there are.
absl::StatusOr<PictureFormat> picture_format(const std::string& path);

/// The code of PNG for a linear value: 255 times the curve of sRGB, rounded; clamped to [0, 1]
/// first. [IEC61966]
std::uint8_t srgb8(float linear);

/// A file that is about to be written.
class PictureFile {
 public:
  /// Makes sure that the path can be written, by making a hidden file beside it.
  /// INVALID_ARGUMENT for an extension that is not known, a directory, or a place that cannot be
  /// written to.
  static absl::StatusOr<PictureFile> create(const std::string& path);
  PictureFile(PictureFile&& other) noexcept;
  PictureFile& operator=(PictureFile&& other) noexcept;
  /// Nothing stays of a file that was not written, but its last preview.
  ~PictureFile();
  /// No preview either.
  void keep_no_preview() { keeps_preview_ = false; }

  /// Writes, then takes its name, replacing what was there.  PNG multiplies by 2^exposure_ev first;
  /// the others hold what they are given.
  absl::Status write(const PictureView& picture, double exposure_ev);
  /// The same for a picture that is not finished: write() follows, or another preview.
  absl::Status write_preview(const PictureView& picture, double exposure_ev);

  const std::string& path() const { return path_; }
  PictureFormat format() const { return format_; }

 private:
  PictureFile(std::string path, std::string temporary, PictureFormat format);

  std::string path_;
  std::string temporary_;  ///< empty once it is not needed any more
  PictureFormat format_;
  bool keeps_preview_ = true;
  bool has_preview_ = false;  ///< under its name
};

}  // namespace lucerna::client
