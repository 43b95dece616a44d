// An open picture, whose texels are read in bands of rows.  Only for the files of this room, since
// it includes OpenImageIO.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "proto/common/status_macros.h"
#include "server/files/image_reader.h"
#include "server/files/load_budget.h"
#include "server/pictures/arrangement.h"
#include "server/pictures/colour_layer.h"
#include "server/pictures/picture_format.h"
#include "server/pictures/whole_picture.h"

namespace lucerna {

class ImageFile {
 public:
  /// Opens the first picture of the file that has colours and checks the size in its header.
  /// `content` must outlive the object.  Errors: those of decode_image, except those about channels
  /// and texels.
  static absl::StatusOr<ImageFile> open(const AssetContent& content, const ImageOptions& options);

  const OIIO::ImageSpec& spec() const { return spec_; }
  std::size_t width() const { return static_cast<std::size_t>(spec_.width); }
  std::size_t height() const { return static_cast<std::size_t>(spec_.height); }
  std::size_t texels() const { return width() * height(); }

  /// The place of the stored texels in the picture.
  const Arrangement& arrangement() const { return arrangement_; }

  /// The channels of the colours; nothing if there are none.
  std::optional<ColourLayer> colours() const {
    return colour_layer(spec_, format_ == PictureFormat::kExr);
  }
  /// What integers mean: what the file says, else what the caller says.
  Encoding encoding() const;
  /// What lights and surfaces do not use of the file.
  std::vector<ImageRemark> remarks();

  /// Calls `use(values, count)` for each band of rows, from the top: the channels `low` to `high`
  /// of `count` texels.  Errors: CANCELLED, a file that ends early or is invalid, no memory, and
  /// the first error of `use`.
  template <typename Value, typename Use>
  absl::Status for_each_band(int low, int high, OIIO::TypeDesc type, Use&& use);

  /// The error for a file that cannot be read as a picture.
  absl::Status unreadable() const;

 private:
  /// Returns no bytes after a request to stop.  So decoders that read the whole file before the
  /// first row end too.  Places outside the file have no bytes.
  class StoppableReader final : public OIIO::Filesystem::IOMemReader {
   public:
    StoppableReader(const std::string& bytes, std::stop_token stop);
    std::size_t read(void* to, std::size_t size) override;
    std::size_t pread(void* to, std::size_t size, std::int64_t offset) override;

   private:
    std::stop_token stop_;
  };
  class MemoryFile;
  /// Memory of OpenImageIO while it decodes.
  std::uint64_t decoder_bytes() const;
  /// Rows of a band: few enough to stop soon, and whole rows of tiles.
  std::size_t rows_at_once() const;
  bool read_rows(std::size_t first, std::size_t rows, int low, int high, OIIO::TypeDesc type,
                 void* to);

  ImageFile(const AssetContent& content, const ImageOptions& options);
  /// Opens the file with OpenImageIO; false if it cannot.
  absl::StatusOr<bool> open_by_library();
  /// Goes on to the first picture with colours: some files begin with depth.
  void find_colours();

  const AssetContent* content_;
  PictureFormat format_;
  ImageOptions options_;
  std::unique_ptr<OIIO::Filesystem::IOProxy> memory_;
  std::shared_ptr<MemoryFile> file_;
  std::unique_ptr<OIIO::ImageInput> input_;  // last of these members: closed first
  std::uint64_t whole_bytes_ = 0;            ///< of a picture that is decoded as a whole
  LoadBudget::Share opened_;                 ///< what the library takes to open the file
  int subimage_ = 0;                         ///< of the picture
  OIIO::ImageSpec spec_;
  Arrangement arrangement_{{}, false};
  std::vector<std::byte> stored_;  ///< a band as the file stores it
};

template <typename Value, typename Use>
absl::Status ImageFile::for_each_band(int low, int high, OIIO::TypeDesc type, Use&& use) {
  const std::size_t most_rows = std::min(rows_at_once(), height());
  const std::size_t per_row = width() * static_cast<std::size_t>(high - low + 1);
  LoadBudget::Share share(options_.budget);
  // The band as values.  If these differ from what the file stores, as that too.
  const std::size_t value_bytes = sizeof(Value) + (spec_.format == type ? 0 : spec_.format.size());
  LUCERNA_RETURN_IF_ERROR(share.resize(most_rows * per_row * value_bytes + decoder_bytes()));
  std::vector<Value> band(most_rows * per_row);
  for (std::size_t row = 0; row < height(); row += most_rows) {
    const std::size_t rows = std::min(most_rows, height() - row);
    const bool ok =
        !options_.stop.stop_requested() && read_rows(row, rows, low, high, type, band.data());
    if (options_.stop.stop_requested()) return absl::CancelledError("loading was cancelled");
    if (!ok) return unreadable();
    LUCERNA_RETURN_IF_ERROR(use(static_cast<const Value*>(band.data()), rows * width()));
  }
  return absl::OkStatus();
}

}  // namespace lucerna
