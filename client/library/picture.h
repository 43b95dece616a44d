// Assembles a picture from the tiles of RenderImage and RenderTile.
//
//   PictureAssembler assembler;
//   const auto status = client.render_image(request, [&](const auto& response) {
//     return !response.has_tile() || assembler.add(response.tile()).ok();
//   });
//   const auto picture = assembler.picture();
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna::client {

/// Whether the rectangles cover the same pixels.
bool same_rect(const v1::PixelRect& a, const v1::PixelRect& b);

/// A picture in linear Rec.  709 RGB [cd/m2 times the film's scale], interleaved, rows from the
/// top.
struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// width * height * 3.
  std::vector<float> pixels;
  /// Standard error of each entry of `pixels`.  Empty if some pixel has a single block of samples.
  std::vector<float> standard_error;
  /// Samples of each pixel, width * height.
  std::vector<std::uint32_t> samples{};
  /// Interval of the luminance of each pixel; see Tile.lower.  Empty unless all tiles have
  /// intervals.
  std::vector<float> lower{}, upper{};
  bool may_miss_light = false;  ///< as in a tile
};

/// Writes the pixels of a rectangle within the picture: three floats each, rows from the top.
void put_pixels(const v1::PixelRect& rect, std::span<const float> rgb, Picture* picture);

/// Assembles tiles.  Not thread-safe.
class PictureAssembler {
 public:
  PictureAssembler();
  PictureAssembler(PictureAssembler&&) noexcept;
  PictureAssembler& operator=(PictureAssembler&&) noexcept;
  ~PictureAssembler();

  /// Adds a tile.  Its rectangle must be new, or equal that of an earlier tile.  If they are equal
  /// and the tile's first block is 0 (from RenderImage), it replaces the earlier tile.  If it
  /// continues the earlier blocks (from RenderTile with a sample range), it is merged, with the
  /// same bits as a single tile.
  ///
  /// INVALID_ARGUMENT, without any change, for a tile that is inconsistent (rectangle, plane sizes)
  /// or belongs to a picture of another size.  The same for a tile that partly overlaps another, or
  /// does not continue the earlier blocks.  No tile continues a tile with a target error, since its
  /// pixels have all of their samples.  Either all tiles of a pixel have moments or none.
  absl::Status add(const v1::Tile& tile);

  /// The current pixels of a tile, in the order of put_pixels().  NOT_FOUND if no tile with this
  /// rectangle was added.
  absl::StatusOr<std::vector<float>> pixels(const v1::PixelRect& rect) const;

  /// FAILED_PRECONDITION while pixels are missing.
  absl::StatusOr<Picture> picture() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucerna::client
