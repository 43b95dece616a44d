#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <utility>

#include "client/library/picture.h"
#include "proto/common/luminance_moments.h"

namespace lucerna {
namespace {

using client::Picture;
using client::PictureAssembler;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct TileParams {
  std::uint32_t x0 = 0, y0 = 0, x1 = 2, y1 = 1;
  std::uint64_t first_block = 0, blocks = 2;
  std::vector<double> sum{}, deviation{};
  std::vector<std::uint32_t> samples{};
  std::vector<float> lower{}, upper{};
};

/// A tile of a picture of 2 x 2 pixels; planes have one value per pixel, equal in all channels.
v1::Tile tile(const TileParams& params) {
  v1::Tile result;
  result.mutable_rect()->set_x0(params.x0);
  result.mutable_rect()->set_y0(params.y0);
  result.mutable_rect()->set_x1(params.x1);
  result.mutable_rect()->set_y1(params.y1);
  result.set_image_width(2);
  result.set_image_height(2);
  result.set_samples_per_block(8);
  result.set_first_block(params.first_block);
  result.set_block_count(params.blocks);
  const auto plane = [](const std::vector<double>& values) {
    std::string bytes;
    for (const double value : values) {
      for (int channel = 0; channel < 3; ++channel) {
        char buffer[sizeof(double)];
        std::memcpy(buffer, &value, sizeof(double));
        bytes.append(buffer, sizeof(double));
      }
    }
    return bytes;
  };
  result.set_sum(plane(params.sum));
  result.set_deviation(plane(params.deviation));
  const auto bytes = [](const auto& numbers) {
    return std::string(reinterpret_cast<const char*>(numbers.data()),
                       numbers.size() * sizeof numbers[0]);
  };
  result.set_samples(bytes(params.samples));
  result.set_lower(bytes(params.lower));
  result.set_upper(bytes(params.upper));
  return result;
}

TEST(PictureAssembler, PlacesTiles) {
  PictureAssembler assembler;
  // Two blocks: pixel = sum / 2, standard error = sqrt(deviation / (2 * 1)).
  ASSERT_TRUE(assembler.add(tile({.y0 = 1, .y1 = 2, .sum = {6, 8}, .deviation = {0, 2}})).ok());
  EXPECT_EQ(assembler.picture().status().code(), absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(assembler.add(tile({.sum = {2, 4}, .deviation = {8, 18}})).ok());
  const auto picture = assembler.picture();
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(picture->width, 2U);
  EXPECT_EQ(picture->height, 2U);
  EXPECT_THAT(picture->pixels, ElementsAre(1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4));
  EXPECT_THAT(picture->standard_error, ElementsAre(2, 2, 2, 3, 3, 3, 0, 0, 0, 1, 1, 1));
}

TEST(PictureAssembler, RefusesTilesThatPartlyOverlap) {
  const auto at = [](std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) {
    const std::size_t pixels = std::size_t{x1 - x0} * (y1 - y0);
    v1::Tile result = tile({.x0 = x0,
                            .y0 = y0,
                            .x1 = x1,
                            .y1 = y1,
                            .sum = std::vector<double>(pixels, 1),
                            .deviation = std::vector<double>(pixels, 0)});
    // The greatest picture: memory is taken for the tiles that came only.
    result.set_image_width(1U << 15);
    result.set_image_height(1U << 15);
    return result;
  };
  PictureAssembler assembler;
  ASSERT_TRUE(assembler.add(at(4, 4, 8, 8)).ok());
  EXPECT_TRUE(assembler.add(at(4, 4, 8, 8)).ok());  // the same tile
  for (const v1::Tile& other : {at(4, 4, 5, 5), at(7, 7, 9, 9), at(0, 0, 5, 5), at(5, 0, 6, 12),
                                at(0, 5, 12, 6), at(0, 0, 12, 12), at(5, 5, 6, 6)})
    EXPECT_EQ(assembler.add(other).code(), absl::StatusCode::kInvalidArgument)
        << other.rect().ShortDebugString();
  for (const v1::Tile& other :
       {at(0, 4, 4, 8), at(8, 4, 12, 8), at(4, 0, 8, 4), at(4, 8, 8, 12), at(0, 0, 4, 4)})
    EXPECT_TRUE(assembler.add(other).ok()) << other.rect().ShortDebugString();
}

TEST(PictureAssembler, CountsSamplesWithAndWithoutSamplePlanes) {
  PictureAssembler assembler;
  const TileParams explicit_samples{.sum = {2, 4},
                                    .deviation = {8, 18},
                                    .samples = {64, 4096},
                                    .lower = {0.5, 1.5},
                                    .upper = {1.5, 2.5}};
  ASSERT_TRUE(assembler.add(tile(explicit_samples)).ok());
  TileParams below = explicit_samples;
  below.y0 = 1;
  below.y1 = 2;
  below.samples = {128, 256};
  below.lower = {0, 1};
  below.upper = {2, 3};
  ASSERT_TRUE(assembler.add(tile(below)).ok());
  Picture picture = *assembler.picture();
  EXPECT_THAT(picture.samples, ElementsAre(64, 4096, 128, 256));
  EXPECT_THAT(picture.lower, ElementsAre(0.5, 1.5, 0, 1));
  EXPECT_THAT(picture.upper, ElementsAre(1.5, 2.5, 2, 3));
  EXPECT_THAT(picture.standard_error, ElementsAre(2, 2, 2, 3, 3, 3, 2, 2, 2, 3, 3, 3));
  // A tile without intervals: 2 blocks of 8 samples.
  ASSERT_TRUE(assembler.add(tile({.y0 = 1, .y1 = 2, .sum = {6, 8}, .deviation = {0, 2}})).ok());
  picture = *assembler.picture();
  EXPECT_THAT(picture.samples, ElementsAre(64, 4096, 16, 16));
  EXPECT_THAT(picture.lower, IsEmpty());
  EXPECT_THAT(picture.upper, IsEmpty());
}

/// Moments of `blocks` blocks of 8 samples each, for the two pixels of a tile.
std::vector<LuminanceMoments> moments(std::uint64_t first, std::uint64_t blocks) {
  BlockMerger<LuminanceMoments> merger(first, 2);
  for (std::uint64_t b = first; b < first + blocks; ++b) {
    BlockMoments lit, dark;
    for (int i = 0; i < 8; ++i) lit.add(static_cast<double>(b) + i, 9);
    for (int i = 0; i < 8; ++i) dark.add(0, 4);
    EXPECT_TRUE(merger.add(b, 1, {lit.result(static_cast<double>(b) + 3.5), dark.result(0)}));
  }
  return merger.total();
}

v1::Tile tile_with_intervals(std::uint64_t first, std::uint64_t blocks) {
  v1::Tile result = tile({.first_block = first,
                          .blocks = blocks,
                          .sum = {moments(first, blocks)[0].blocks.sum, 0},
                          .deviation = {moments(first, blocks)[0].blocks.deviation, 0},
                          .lower = {0, 0},
                          .upper = {1, 1}});
  result.set_moments(bytes_of(moments(first, blocks)));
  return result;
}

TEST(PictureAssembler, MergesIntervals) {
  v1::Tile below = tile_with_intervals(0, 8);
  below.mutable_rect()->set_y0(1);
  below.mutable_rect()->set_y1(2);
  PictureAssembler whole, parts;
  for (PictureAssembler* assembler : {&whole, &parts}) ASSERT_TRUE(assembler->add(below).ok());
  ASSERT_TRUE(whole.add(tile_with_intervals(0, 8)).ok());
  for (const auto& [first, blocks] : {std::pair{0, 4}, {4, 2}, {6, 1}, {7, 1}})
    ASSERT_TRUE(parts
                    .add(tile_with_intervals(static_cast<std::uint64_t>(first),
                                             static_cast<std::uint64_t>(blocks)))
                    .ok());
  const Picture expected = *whole.picture(), picture = *parts.picture();
  ASSERT_EQ(picture.lower.size(), 4U);
  EXPECT_EQ(picture.lower, expected.lower);
  EXPECT_EQ(picture.upper, expected.upper);
  EXPECT_LT(picture.lower[0], 7);
  EXPECT_GT(picture.upper[0], 7);
  // 64 samples that were all 0 beside a light of 4.
  EXPECT_EQ(picture.lower[1], 0);
  EXPECT_NEAR(picture.upper[1], 2.9957 / 64 * 4, 1e-4);
}

TEST(PictureAssembler, RefusesInconsistentIntervals) {
  PictureAssembler assembler;
  const auto refused = [&](const v1::Tile& wrong) {
    const absl::Status status = assembler.add(wrong);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  v1::Tile wrong = tile_with_intervals(0, 2);
  wrong.clear_lower();
  EXPECT_THAT(refused(wrong), HasSubstr("lower and upper belong together"));
  wrong = tile_with_intervals(0, 2);
  wrong.clear_moments();
  EXPECT_THAT(refused(wrong), HasSubstr("moments has 0 bytes, must be 112"));
  wrong = tile_with_intervals(0, 2);
  wrong.clear_lower();
  wrong.clear_upper();
  EXPECT_THAT(refused(wrong), HasSubstr("moments has 112 bytes, must be 0"));
  ASSERT_TRUE(assembler.add(tile_with_intervals(0, 2)).ok());
  EXPECT_THAT(refused(tile({.first_block = 2, .blocks = 2, .sum = {2, 4}, .deviation = {8, 18}})),
              HasSubstr("do not continue"));
}

TEST(PictureAssembler, TilesOfATargetErrorAreMergedByAreaAlone) {
  PictureAssembler assembler;
  const TileParams first{.sum = {2, 4},
                         .deviation = {8, 18},
                         .samples = {64, 4096},
                         .lower = {0.5, 1.5},
                         .upper = {1.5, 2.5}};
  TileParams next = first;
  next.first_block = 2;
  ASSERT_TRUE(assembler.add(tile(first)).ok());
  EXPECT_THAT(std::string(assembler.add(tile(next)).message()),
              HasSubstr("first_block = 2, allowed with a target error: 0"));
  EXPECT_THAT(
      std::string(
          assembler.add(tile({.first_block = 2, .sum = {6, 8}, .deviation = {0, 0}})).message()),
      HasSubstr("do not continue"));
  // Another answer replaces it.
  ASSERT_TRUE(assembler.add(tile(first)).ok());
  // Planes of a wrong size.
  for (auto spoil :
       {+[](TileParams& t) { t.samples.pop_back(); }, +[](TileParams& t) { t.lower.pop_back(); },
        +[](TileParams& t) { t.upper.clear(); }, +[](TileParams& t) { t.samples.clear(); }}) {
    TileParams bad = first;
    spoil(bad);
    EXPECT_THAT(std::string(assembler.add(tile(bad)).message()), HasSubstr(" bytes, must be "));
  }
}

TEST(PictureAssembler, SingleBlockHasNoStandardError) {
  PictureAssembler assembler;
  ASSERT_TRUE(assembler.add(tile({.sum = {2, 4}, .deviation = {8, 18}})).ok());
  ASSERT_TRUE(
      assembler.add(tile({.y0 = 1, .y1 = 2, .blocks = 1, .sum = {6, 8}, .deviation = {0, 0}}))
          .ok());
  const Picture picture = *assembler.picture();
  EXPECT_THAT(picture.pixels, ElementsAre(1, 1, 1, 2, 2, 2, 6, 6, 6, 8, 8, 8));
  EXPECT_THAT(picture.standard_error, IsEmpty());
}

TEST(PictureAssembler, TileFromTheFirstBlockReplacesTheEarlierOne) {
  PictureAssembler assembler;
  ASSERT_TRUE(assembler.add(tile({.y1 = 2, .sum = {9, 9, 9, 9}, .deviation = {1, 1, 1, 1}})).ok());
  ASSERT_TRUE(
      assembler.add(tile({.y1 = 2, .blocks = 4, .sum = {4, 8, 12, 16}, .deviation = {0, 0, 0, 0}}))
          .ok());
  EXPECT_THAT(assembler.picture()->pixels, ElementsAre(1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4));
}

TEST(PictureAssembler, ContinuedBlocksAreMerged) {
  // Blocks of values 1, 3 (sum 4, deviation 2) and 5, 7 (sum 12, deviation 2): together mean 4,
  // deviation 9 + 1 + 1 + 9 = 20, standard error sqrt(20 / 12).
  PictureAssembler assembler;
  ASSERT_TRUE(assembler.add(tile({.y1 = 2, .sum = {4, 4, 4, 4}, .deviation = {2, 2, 2, 2}})).ok());
  ASSERT_TRUE(
      assembler
          .add(
              tile({.y1 = 2, .first_block = 2, .sum = {12, 12, 12, 12}, .deviation = {2, 2, 2, 2}}))
          .ok());
  const Picture picture = *assembler.picture();
  EXPECT_EQ(picture.pixels[0], 4.0F);
  EXPECT_FLOAT_EQ(picture.standard_error[0], 1.29099445F);
}

TEST(PictureAssembler, BlocksThatDoNotContinueAreRefused) {
  PictureAssembler assembler;
  ASSERT_TRUE(assembler.add(tile({.sum = {4, 4}, .deviation = {2, 2}})).ok());
  const absl::Status status =
      assembler.add(tile({.first_block = 4, .sum = {4, 4}, .deviation = {2, 2}}));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("blocks from 4"));
}

TEST(PictureAssembler, PartialOverlapIsRefused) {
  PictureAssembler assembler;
  ASSERT_TRUE(assembler.add(tile({.sum = {4, 4}, .deviation = {2, 2}})).ok());
  const absl::Status status =
      assembler.add(tile({.x0 = 1, .y1 = 2, .sum = {4, 4}, .deviation = {2, 2}}));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("overlaps"));
}

TEST(PictureAssembler, ReturnsTheCurrentPixelsOfATile) {
  PictureAssembler assembler;
  const v1::Tile first = tile({.y0 = 1, .y1 = 2, .sum = {6, 8}, .deviation = {0, 2}});
  EXPECT_EQ(assembler.pixels(first.rect()).status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(assembler.add(first).ok());
  EXPECT_THAT(assembler.pixels(first.rect()).value(), ElementsAre(3, 3, 3, 4, 4, 4));
  // The sums of four blocks are 16 and 8.
  ASSERT_TRUE(
      assembler.add(tile({.y0 = 1, .y1 = 2, .first_block = 2, .sum = {10, 0}, .deviation = {0, 2}}))
          .ok());
  const std::vector<float> so_far = assembler.pixels(first.rect()).value();
  EXPECT_THAT(so_far, ElementsAre(4, 4, 4, 2, 2, 2));
  for (const v1::Tile& other : {tile({}), tile({.y0 = 1, .x1 = 1, .y1 = 2}), tile({.y0 = 2})}) {
    EXPECT_EQ(assembler.pixels(other.rect()).status().code(), absl::StatusCode::kNotFound);
  }

  Picture picture{.width = 2, .height = 2, .pixels = std::vector<float>(12), .standard_error = {}};
  client::put_pixels(first.rect(), so_far, &picture);
  EXPECT_THAT(picture.pixels, ElementsAre(0, 0, 0, 0, 0, 0, 4, 4, 4, 2, 2, 2));
}

TEST(PictureAssembler, InconsistentTilesAreRefused) {
  PictureAssembler assembler;
  const auto refuse = [&](const v1::Tile& bad, const std::string& what) {
    const absl::Status status = assembler.add(bad);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr(what));
  };
  refuse(tile({.sum = {1}, .deviation = {1, 1}}), "bytes");
  refuse(tile({.blocks = 0, .sum = {1, 1}, .deviation = {1, 1}}), "block_count");
  refuse(tile({.x1 = 3, .sum = {1, 1, 1}, .deviation = {1, 1, 1}}), "not within");
  refuse(tile({.x1 = 0, .sum = {}, .deviation = {}}), "empty");
  v1::Tile huge = tile({.sum = {1, 1}, .deviation = {1, 1}});
  huge.set_image_width(1 << 20);
  huge.set_image_height(1 << 20);
  refuse(huge, "2^30");
  ASSERT_TRUE(assembler.add(tile({.sum = {4, 4}, .deviation = {2, 2}})).ok());
  v1::Tile other = tile({.y0 = 1, .y1 = 2, .sum = {4, 4}, .deviation = {2, 2}});
  other.set_image_width(5);
  refuse(other, "5 x 2");
}

}  // namespace
}  // namespace lucerna
