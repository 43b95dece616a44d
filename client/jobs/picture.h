// Pictures from the tiles that RenderImage and RenderTile answer.
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

/// Linear Rec. 709 RGB [cd/m2, times the film's scale], interleaved, rows from the top.
struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// width * height * 3.
  std::vector<float> pixels;
  /// Standard error of each entry of `pixels`; empty where some pixel has a single block of
  /// samples, which gives none.
  std::vector<float> standard_error;
  /// Samples of each pixel, width * height.
  std::vector<std::uint32_t> samples{};
  /// Of each pixel, where all were asked for with a target error, else empty: the converged
  /// luminance lies between these with the confidence of the target.
  std::vector<float> lower{}, upper{};
};

/// Writes the pixels of a rectangle within the picture: three floats each, rows from the top.
void put_pixels(const v1::PixelRect& rect, std::span<const float> rgb, Picture* picture);

/// Puts tiles together.  Not thread-safe.
class PictureAssembler {
 public:
  PictureAssembler();
  PictureAssembler(PictureAssembler&&) noexcept;
  PictureAssembler& operator=(PictureAssembler&&) noexcept;
  ~PictureAssembler();

  /// A tile whose rectangle is new, or is that of an earlier tile.  In the latter case it replaces
  /// it where its first block is 0 (as RenderImage sends them), and is merged with it where it
  /// continues its blocks (RenderTile of a sample range), which gives the same bits as if all had
  /// been one tile. INVALID_ARGUMENT, and nothing changes, for a tile that is not whole in itself
  /// (rectangle, plane sizes), of a picture of another size, that overlaps others in part, or does
  /// not continue; nothing continues a tile of a target error, whose pixels have samples enough.
  absl::Status add(const v1::Tile& tile);

  /// What the pixels of a tile are so far, as put_pixels() takes them.  NOT_FOUND where no tile of
  /// this rectangle was added.
  absl::StatusOr<std::vector<float>> pixels(const v1::PixelRect& rect) const;

  /// FAILED_PRECONDITION while pixels are missing.
  absl::StatusOr<Picture> picture() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucerna::client
