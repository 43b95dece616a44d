// QOI files.  [QOI]  Only for the files of this room.
#pragma once

#include "server/pictures/whole_picture.h"

namespace lucerna {

/// Integers of 8 bits in three or four channels.  If the header says that they are linear, so does
/// the attribute "oiio:ColorSpace".
class QoiPicture final : public WholePicture {
 public:
  using WholePicture::WholePicture;

 private:
  absl::Status read_header() override;
  absl::Status decode(std::uint8_t* to) override;
};

}  // namespace lucerna
