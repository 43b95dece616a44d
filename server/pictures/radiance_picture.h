// Radiance pictures (.hdr, .pic).  [Ward91]  Only for the files of this room.
#pragma once

#include "lights/maths/rgb.h"
#include "server/pictures/whole_picture.h"

namespace lucerna {

/// RGBE and XYZE, with the runs of today, those of old files, or none.  Floats in three channels.
///
/// The values are those before the exposure: they are divided by the product of all EXPOSURE lines,
/// and each channel by that of its COLORCORR values.  The attribute "chromaticities" has the
/// PRIMARIES, or those of X, Y and Z.  "Orientation" stands for all eight resolution strings.
/// "gamma line" is a GAMMA line other than 1, which has no effect.  Lines may end with CR LF.
class RadiancePicture final : public WholePicture {
 public:
  using WholePicture::WholePicture;

 private:
  absl::Status read_header() override;
  absl::Status read_line(std::string_view line);
  absl::Status read_resolution(std::string_view line);
  absl::Status decode(std::uint8_t* to) override;
  absl::Status decode_row(std::uint8_t* to);
  absl::Status decode_old_row(std::uint8_t* to);
  std::size_t stored_bytes() const override { return 4; }
  void convert(const std::uint8_t* stored, void* to) const override;

  /// The line at `at_`, without its end; moves `at_` behind it.
  std::string_view next_line();

  std::size_t at_ = 0;
  Rgb exposure_{1, 1, 1};
  std::string_view primaries_, gamma_line_;
  bool is_xyz_ = false;
};

}  // namespace lucerna
