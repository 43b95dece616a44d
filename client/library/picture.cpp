#include "client/library/picture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "client/library/answer_checks.h"
#include "proto/common/luminance_moments.h"
#include "proto/common/status_macros.h"
#include "proto/common/tile_statistics.h"

namespace lucerna::client {

namespace {

// Planes are copied byte by byte.
static_assert(std::endian::native == std::endian::little);

/// The numbers of a plane; empty if the tile has no such plane.
template <typename Number>
std::vector<Number> plane(const std::string& bytes) {
  std::vector<Number> result(bytes.size() / sizeof(Number));
  if (!result.empty()) std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

std::vector<BlockStatistics> statistics(const v1::Tile& tile) {
  std::vector<BlockStatistics> result(pixel_count(tile.rect()) * 3);
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::memcpy(&result[i].sum, tile.sum().data() + i * sizeof(double), sizeof(double));
    std::memcpy(&result[i].deviation, tile.deviation().data() + i * sizeof(double), sizeof(double));
  }
  return result;
}

/// The value of a pixel's channel with this number of blocks.
float mean(const BlockStatistics& total, double blocks) {
  return static_cast<float>(total.sum / blocks);
}

/// One rectangle of the picture with all blocks added so far.
struct Piece {
  v1::PixelRect rect;
  std::uint32_t samples_per_block = 0;
  std::uint64_t first_block = 0;
  std::uint64_t blocks = 0;
  std::vector<BlockStatistics> total;
  /// Per pixel; empty without a target error.
  std::vector<std::uint32_t> samples;
  std::vector<float> lower, upper;
  /// Per pixel; empty without intervals, and with a target error.
  std::vector<LuminanceMoments> moments;
  /// Created at the first merge.
  struct Mergers {
    BlockMerger<> channels;
    BlockMerger<LuminanceMoments> moments;
  };
  std::optional<Mergers> mergers;

  bool has_intervals() const { return !lower.empty() || !moments.empty(); }
};

Piece make_piece(const v1::Tile& tile) {
  Piece piece{.rect = tile.rect(),
              .samples_per_block = tile.samples_per_block(),
              .first_block = tile.first_block(),
              .blocks = tile.block_count(),
              .total = statistics(tile),
              .samples = plane<std::uint32_t>(tile.samples()),
              .lower = {},
              .upper = {},
              .moments = moments_of(tile.moments()),
              .mergers = std::nullopt};
  // Without a target error, intervals follow from the moments.
  if (!piece.samples.empty()) {
    piece.lower = plane<float>(tile.lower());
    piece.upper = plane<float>(tile.upper());
  }
  return piece;
}

/// Adds the tile's blocks to the piece.  Returns false, without any change, if the tile does not
/// continue the piece.
bool merge_into(const v1::Tile& tile, Piece* piece) {
  if (tile.samples_per_block() != piece->samples_per_block) return false;
  if (!piece->samples.empty() || tile.moments().empty() != piece->moments.empty()) return false;
  std::optional<Piece::Mergers> mergers = piece->mergers;
  if (!mergers) {
    mergers.emplace(
        Piece::Mergers{BlockMerger<>(piece->first_block, piece->total.size()),
                       BlockMerger<LuminanceMoments>(piece->first_block, piece->moments.size())});
    if (!mergers->channels.add(piece->first_block, piece->blocks, piece->total) ||
        !mergers->moments.add(piece->first_block, piece->blocks, piece->moments))
      return false;
  }
  if (!mergers->channels.add(tile.first_block(), tile.block_count(), statistics(tile)) ||
      !mergers->moments.add(tile.first_block(), tile.block_count(), moments_of(tile.moments())))
    return false;
  piece->mergers = std::move(mergers);
  piece->blocks = piece->mergers->channels.blocks();
  piece->total = piece->mergers->channels.total();
  piece->moments = piece->mergers->moments.total();
  return true;
}

/// Writes the statistics of a piece into the picture, except its standard errors if these are not
/// known.
void put_piece(const Piece& piece, Picture& to) {
  const auto n = static_cast<double>(piece.blocks);
  const std::vector<FloatInterval> intervals =
      pixel_intervals(piece.moments, piece.blocks, piece.samples_per_block);
  std::size_t from = 0;
  for (std::size_t y = piece.rect.y0(); y < piece.rect.y1(); ++y) {
    const std::size_t row = y * to.width;
    for (std::size_t i = row + piece.rect.x0(); i < row + piece.rect.x1(); ++i, ++from) {
      for (std::size_t c = 0; c < 3; ++c) {
        const BlockStatistics& total = piece.total[3 * from + c];
        to.pixels[3 * i + c] = mean(total, n);
        if (piece.blocks > 1)
          to.standard_error[3 * i + c] =
              static_cast<float>(std::sqrt(total.deviation / (n * (n - 1))));
      }
      to.samples[i] = piece.samples.empty()
                          ? static_cast<std::uint32_t>(piece.blocks * piece.samples_per_block)
                          : piece.samples[from];
      if (!piece.lower.empty()) {
        to.lower[i] = piece.lower[from];
        to.upper[i] = piece.upper[from];
      } else if (!intervals.empty()) {
        to.lower[i] = intervals[from].lower;
        to.upper[i] = intervals[from].upper;
      }
    }
  }
}

}  // namespace

void put_pixels(const v1::PixelRect& rect, std::span<const float> rgb, Picture* picture) {
  const std::size_t row = 3 * (std::size_t{rect.x1()} - rect.x0());
  for (std::size_t y = rect.y0(); y < rect.y1(); ++y, rgb = rgb.subspan(row)) {
    std::copy_n(rgb.begin(), row,
                picture->pixels.begin() +
                    static_cast<std::ptrdiff_t>(3 * (y * picture->width + rect.x0())));
  }
}

struct PictureAssembler::State {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Piece> pieces;
  /// The spans of each row that pieces cover, by their start.  They grow with the tiles that come:
  /// a server may name any size of its picture.
  struct Span {
    std::uint32_t end;
    std::size_t piece;
  };
  std::map<std::uint32_t, std::map<std::uint32_t, Span>> rows;
  std::size_t owned = 0;
  bool may_miss_light = false;

  std::size_t pixels() const { return std::size_t{width} * height; }

  const Piece* find(const v1::PixelRect& rect) const {
    const auto row = rows.find(rect.y0());
    if (row == rows.end()) return nullptr;
    const auto span = row->second.find(rect.x0());
    if (span == row->second.end()) return nullptr;
    const Piece& piece = pieces[span->second.piece];
    return same_rect(piece.rect, rect) ? &piece : nullptr;
  }
  Piece* find(const v1::PixelRect& rect) {
    return const_cast<Piece*>(std::as_const(*this).find(rect));
  }

  bool overlaps(const v1::PixelRect& rect) const {
    for (auto row = rows.lower_bound(rect.y0()); row != rows.end() && row->first < rect.y1();
         ++row) {
      const auto next = row->second.lower_bound(rect.x0());
      if (next != row->second.end() && next->first < rect.x1()) return true;
      if (next != row->second.begin() && std::prev(next)->second.end > rect.x0()) return true;
    }
    return false;
  }
};

PictureAssembler::PictureAssembler() : state_(std::make_unique<State>()) {}
PictureAssembler::PictureAssembler(PictureAssembler&&) noexcept = default;
PictureAssembler& PictureAssembler::operator=(PictureAssembler&&) noexcept = default;
PictureAssembler::~PictureAssembler() = default;

absl::Status PictureAssembler::add(const v1::Tile& tile) {
  LUCERNA_RETURN_IF_ERROR(check_tile(tile));
  State& state = *state_;
  const v1::PixelRect& rect = tile.rect();
  if (state.pieces.empty()) {
    state.width = tile.image_width();
    state.height = tile.image_height();
  } else if (tile.image_width() != state.width || tile.image_height() != state.height) {
    return absl::InvalidArgumentError(
        describe(rect) + ": of a picture of " + std::to_string(tile.image_width()) + " x " +
        std::to_string(tile.image_height()) + " pixels, but other tiles belong to one of " +
        std::to_string(state.width) + " x " + std::to_string(state.height));
  }
  state.may_miss_light = state.may_miss_light || tile.may_miss_light();
  if (Piece* piece = state.find(rect)) {
    if (tile.first_block() == 0) {
      *piece = make_piece(tile);
    } else if (!merge_into(tile, piece)) {
      return absl::InvalidArgumentError(describe(rect) + ": blocks from " +
                                        std::to_string(tile.first_block()) +
                                        " do not continue the earlier blocks, which end at " +
                                        std::to_string(piece->first_block + piece->blocks));
    }
    return absl::OkStatus();
  }
  if (state.overlaps(rect))
    return absl::InvalidArgumentError(describe(rect) + ": partly overlaps another tile");
  for (std::uint32_t y = rect.y0(); y < rect.y1(); ++y)
    state.rows[y].emplace(rect.x0(), State::Span{rect.x1(), state.pieces.size()});
  state.pieces.push_back(make_piece(tile));
  state.owned += pixel_count(rect);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<float>> PictureAssembler::pixels(const v1::PixelRect& rect) const {
  const Piece* piece = std::as_const(*state_).find(rect);
  if (piece == nullptr) return absl::NotFoundError(describe(rect) + ": not added");
  std::vector<float> result(piece->total.size());
  const auto n = static_cast<double>(piece->blocks);
  std::transform(piece->total.begin(), piece->total.end(), result.begin(),
                 [n](const BlockStatistics& total) { return mean(total, n); });
  return result;
}

absl::StatusOr<Picture> PictureAssembler::picture() const {
  const State& state = *state_;
  if (state.owned == 0 || state.owned < state.pixels()) {
    return absl::FailedPreconditionError("the picture has " + std::to_string(state.owned) + " of " +
                                         std::to_string(state.pixels()) + " pixels");
  }
  Picture result;
  result.width = state.width;
  result.height = state.height;
  result.may_miss_light = state.may_miss_light;
  result.pixels.resize(state.pixels() * 3);
  result.standard_error.resize(result.pixels.size());
  result.samples.resize(state.pixels());
  result.lower.resize(state.pixels());
  result.upper.resize(state.pixels());
  bool has_error = true, has_interval = true;
  for (const Piece& piece : state.pieces) {
    has_error = has_error && piece.blocks > 1;
    has_interval = has_interval && piece.has_intervals();
    put_piece(piece, result);
  }
  if (!has_error) result.standard_error.clear();
  if (!has_interval) {
    result.lower.clear();
    result.upper.clear();
  }
  return result;
}

}  // namespace lucerna::client
