// Pictures are decoded in bands of rows: whole, stoppable, and in little memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "server/files/image_reader.h"
#include "server/materials/texels.h"
#include "tests/server/files/limited_pool.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using testing::LimitedPool;
using testing::pfm;
using testing::written;

/// A byte that differs between neighbours and between rows.
std::uint8_t code_at(int x, int y, int c) {
  return static_cast<std::uint8_t>(7 * x + 31 * y + 101 * c + x * y % 13);
}

std::vector<std::uint8_t> codes(int width, int height, int channels) {
  std::vector<std::uint8_t> all;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) all.push_back(code_at(x, y, c));
  return all;
}

Texels texels_of(const DecodedSurface& s) {
  if (!s.codes) return Texels(*s.image);
  return Texels(s.codes->width, s.codes->height, s.codes->is_grey, s.codes->codes, s.codes->values);
}

/// Checks that a surface gets exactly the values of the picture as floats.
void expect_same(const AssetContent& content, Encoding encoding, bool is_coded) {
  const auto image = decode_image(content, {.encoding = encoding});
  const auto surface = decode_surface(content, {.encoding = encoding});
  ASSERT_TRUE(image.ok()) << image.status();
  ASSERT_TRUE(surface.ok()) << surface.status();
  ASSERT_EQ(surface->codes.has_value(), is_coded) << content.name;
  ASSERT_EQ(image->remarks.size(), surface->remarks.size());
  const Texels texels = texels_of(*surface);
  ASSERT_EQ(texels.width(), image->image->width());
  ASSERT_EQ(texels.height(), image->image->height());
  for (int y = 0; y < texels.height(); ++y)
    for (int x = 0; x < texels.width(); ++x)
      ASSERT_EQ(texels.texel(x, y), Rgb(image->image->texel(x, y))) << x << " " << y;
}

// Three and more bands of 2^18 texels.
constexpr int kWidth = 700, kHeight = 1300;

TEST(PictureBands, EveryRowArrivesWhateverTheFormat) {
  const auto values = codes(kWidth, kHeight, 3);
  OIIO::ImageSpec flat(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8);
  OIIO::ImageSpec strips = flat;
  strips.attribute("tiff:RowsPerStrip", 37);
  OIIO::ImageSpec tiles = flat;
  tiles.tile_width = 64, tiles.tile_height = 48;
  for (const auto& [name, spec] :
       {std::pair{"a.png", flat}, std::pair{"a.tif", strips}, std::pair{"b.tif", tiles}}) {
    const auto d = testing::value_of(
        decode_surface({name, written(name, spec, values)}, {.encoding = kLinear}));
    ASSERT_TRUE(d.codes.has_value());
    EXPECT_FALSE(d.codes->is_grey);
    EXPECT_EQ(d.codes->codes, values) << name;
    EXPECT_EQ(d.codes->values[51], 0.2F);
  }
}

TEST(PictureBands, TiledAndPlainExrFilesHaveTheSameTexels) {
  std::vector<float> values;
  for (const std::uint8_t code : codes(kWidth, kHeight, 3)) values.push_back(code / 3.0F);
  OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeDesc::FLOAT);
  // The data window begins elsewhere.  The picture is the display window, and black beside it.
  spec.x = -20, spec.y = 33;
  for (const int tile : {0, 48}) {
    spec.tile_width = tile, spec.tile_height = tile;
    const auto d = testing::value_of(decode_image({"a.exr", written("a.exr", spec, values)}));
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        Rgbf texel;
        if (x < kWidth + spec.x && y >= spec.y) {
          const std::size_t i = 3 * (static_cast<std::size_t>(y - spec.y) * kWidth +
                                     static_cast<std::size_t>(x - spec.x));
          texel = {values[i], values[i + 1], values[i + 2]};
        }
        ASSERT_EQ(d.image->texel(x, y), texel) << x << ", " << y;
      }
  }
}

TEST(PictureBands, SurfacesGetTheValuesOfThePicture) {
  using Type = OIIO::TypeDesc;
  for (const int channels : {1, 2, 3, 4})
    for (const Encoding encoding : {kSrgb, kLinear, Encoding{2.2}, Encoding{90}}) {
      const OIIO::ImageSpec spec(256, 40, channels, Type::UINT8);
      expect_same({"a.png", written("a.png", spec, codes(256, 40, channels))}, encoding, true);
    }
  const OIIO::ImageSpec wide(20, 20, 3, Type::UINT16);
  expect_same({"a.png", written("a.png", wide, codes(20, 20, 3))}, kSrgb, false);
  expect_same({"a.pfm", pfm(2, 1, {1, 2, 3, 0.25F, 5e4F, 0})}, kSrgb, false);
}

TEST(PictureBands, APictureIsGreyUntilItsFirstColour) {
  const OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8);
  std::vector<std::uint8_t> values;
  for (int i = 0; i < kWidth * kHeight; ++i) values.insert(values.end(), 3, i % 251);
  const auto grey = testing::value_of(decode_surface({"a.png", written("a.png", spec, values)}));
  EXPECT_TRUE(grey.codes->is_grey);
  EXPECT_EQ(grey.codes->codes.size(), std::size_t{kWidth} * kHeight);
  for (const std::size_t coloured : {std::size_t{0}, values.size() / 2 + 1, values.size() - 2}) {
    auto changed = values;
    changed[coloured] ^= 1U;
    const auto colour =
        testing::value_of(decode_surface({"a.png", written("a.png", spec, changed)}));
    EXPECT_FALSE(colour.codes->is_grey);
    EXPECT_EQ(colour.codes->codes, changed);
  }
}

TEST(PictureBands, AlphaOfBytesIsThatOfOneRead) {
  const OIIO::ImageSpec spec(kWidth, kHeight, 4, OIIO::TypeDesc::UINT8);
  const auto values = codes(kWidth, kHeight, 4);
  const auto alpha = testing::value_of(decode_alpha({"a.png", written("a.png", spec, values)}));
  ASSERT_EQ(alpha.values.size(), values.size() / 4);
  for (std::size_t i = 0; i < alpha.values.size(); ++i)
    ASSERT_FLOAT_EQ(alpha.values[i], static_cast<float>(values[4 * i + 3]) / 255);
}

TEST(PictureBands, AStopEndsTheDecodingAfterABand) {
  // The first colour asks the budget for memory, in the middle of the picture.
  std::vector<std::uint8_t> values(std::size_t{3} * kWidth * kHeight);
  values[values.size() / 2] = 1;
  const OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8);
  const std::string bytes = written("a.png", spec, values);
  LimitedPool pool;
  LoadBudget budget(&pool);
  std::stop_source stop;
  pool.on_take = [&] {
    const std::uint64_t grey = std::uint64_t{kWidth} * kHeight, band = std::uint64_t{3} << 18;
    if (pool.taken() >= grey + band - LoadBudget::kStepBytes) stop.request_stop();
  };
  const auto d = decode_surface({"a.png", bytes}, {.stop = stop.get_token(), .budget = &budget});
  EXPECT_TRUE(stop.stop_requested());
  EXPECT_TRUE(absl::IsCancelled(d.status())) << d.status();
  EXPECT_EQ(budget.used(), 0);
}

TEST(PictureBands, AStoppedLoadDecodesNothing) {
  std::stop_source stop;
  stop.request_stop();
  const OIIO::ImageSpec spec(2, 2, 3, OIIO::TypeDesc::UINT8);
  const AssetContent content{"a.png", written("a.png", spec, codes(2, 2, 3))};
  EXPECT_TRUE(absl::IsCancelled(decode_image(content, {.stop = stop.get_token()}).status()));
  EXPECT_TRUE(absl::IsCancelled(decode_surface(content, {.stop = stop.get_token()}).status()));
  EXPECT_TRUE(absl::IsCancelled(decode_alpha(content, {.stop = stop.get_token()}).status()));
}

TEST(PictureBands, SurfacesOfBytesTakeAByteForEachCode) {
  const OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8);
  const AssetContent content{"a.png", written("a.png", spec, codes(kWidth, kHeight, 3))};
  LimitedPool pool;
  LoadBudget budget(&pool);
  const auto d = testing::value_of(decode_surface(content, {.budget = &budget}));
  const std::uint64_t needed = std::uint64_t{3} * kWidth * kHeight;
  EXPECT_EQ(budget.used(), needed);
  EXPECT_EQ(d.codes->codes.capacity(), needed);
  // A band, and the steps of the budget.
  EXPECT_LT(pool.most(), needed + (std::uint64_t{3} << 18) + 8 * LoadBudget::kStepBytes);
}

TEST(PictureBands, PicturesOverTheBudgetAreRefusedBeforeTheyAreDecoded) {
  const OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8);
  // Cut off after its header: an attempt to decode it would report that.
  const AssetContent content{"a.png",
                             written("a.png", spec, codes(kWidth, kHeight, 3)).substr(0, 2000)};
  LimitedPool pool(std::uint64_t{kWidth} * kHeight - 1);
  LoadBudget budget(&pool);
  const ImageOptions options{.budget = &budget};
  EXPECT_TRUE(absl::IsResourceExhausted(decode_surface(content, options).status()));
  EXPECT_TRUE(absl::IsResourceExhausted(decode_image(content, options).status()));
  EXPECT_EQ(pool.taken(), 0);
}

}  // namespace
}  // namespace lucerna
