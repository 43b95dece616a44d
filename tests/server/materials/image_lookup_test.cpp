// Filters of pictures that average over the footprint of a camera ray.
#include "server/materials/image_lookup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace lucerna {
namespace {

constexpr int kSize = 64;

std::shared_ptr<const Texels> picture(const std::function<double(int, int)>& value,
                                      int width = kSize, int height = kSize) {
  std::vector<Rgbf> texels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) texels.emplace_back(static_cast<float>(value(x, y)));
  auto made = std::make_shared<Texels>(**Image::create(width, height, texels));
  made->make_levels();
  return made;
}

ImageTexture texture(TextureFilter filter, std::shared_ptr<const Texels> image) {
  return {.image = std::move(image), .filter = filter};
}

constexpr TextureFilter kFilters[] = {TextureFilter::kTrilinear, TextureFilter::kEwa};

TEST(ImageLookup, LevelsAreMeans) {
  const auto image = picture([](int x, int y) { return x + 10 * y; }, 5, 3);
  ASSERT_EQ(image->levels(), 4U);  // 5 x 3, 3 x 2, 2 x 1, 1 x 1
  EXPECT_EQ(image->level(1).width(), 3);
  EXPECT_EQ(image->level(1).height(), 2);
  EXPECT_NEAR(image->level(1).texel(0, 0).r, 5.5, 1e-3);  // of 0 1 10 11
  EXPECT_NEAR(image->level(1).texel(2, 1).r, 24, 1e-3);   // alone
  EXPECT_EQ(image->level(3).width() * image->level(3).height(), 1);
  Texels half = *image;
  half.halve();
  EXPECT_EQ(half.levels(), 3U);
  EXPECT_EQ(half.width(), 3);
  EXPECT_LT(half.bytes(), image->bytes());
}

TEST(ImageLookup, AConstantStaysConstant) {
  const auto image = picture([](int, int) { return 0.7; });
  for (const TextureFilter filter : kFilters)
    for (const double size : {0.0, 1e-12, 1e-3, 0.1, 1.0, 30.0, 1e9, 1e300})
      for (const double turn : {0.0, 0.3, 1.5}) {
        const double c = size * std::cos(turn), s = size * std::sin(turn);
        for (const double thin : {1.0, 1e-2, 1e-9, 0.0}) {
          const CoordinateSteps steps{{c, s}, {-s * thin, c * thin}};
          const Rgb value = look_up(texture(filter, image), {0.37, 0.61}, &steps);
          EXPECT_NEAR(value.r, 0.7, 1e-4) << size << " " << turn << " " << thin;
        }
      }
}

TEST(ImageLookup, WithoutAFootprintTheyAreBilinear) {
  const auto image = picture([](int x, int y) { return std::fmod(0.37 * x + 0.11 * x * y, 1); });
  for (int i = 0; i < 100; ++i) {
    const Vec2 st{std::fmod(0.618 * i, 1), std::fmod(0.414 * i, 1)};
    const double bilinear = look_up(texture(TextureFilter::kBilinear, image), st, nullptr).r;
    const CoordinateSteps none{}, tiny{{1e-4, 0}, {0, 1e-4}}, wrong{{NAN, 0}, {0, INFINITY}};
    for (const TextureFilter filter : kFilters)
      for (const CoordinateSteps* steps :
           {static_cast<const CoordinateSteps*>(nullptr), &none, &wrong})
        EXPECT_EQ(look_up(texture(filter, image), st, steps).r, bilinear);
    EXPECT_EQ(look_up(texture(TextureFilter::kTrilinear, image), st, &tiny).r, bilinear);
  }
}

// Waves over 4 texels, whose mean over the footprint is known.
TEST(ImageLookup, WavesVanishWhereTheFootprintIsWide) {
  const auto image =
      picture([](int x, int) { return 0.5 + 0.5 * std::cos(0.5 * std::numbers::pi * (x + 0.5)); });
  const auto contrast = [&](TextureFilter filter, const CoordinateSteps& steps) {
    double most = 0;
    for (int i = 0; i < 64; ++i) {
      const Vec2 st{0.25 + i / 64.0 / 16, 0.5};
      most = std::max(most, std::fabs(look_up(texture(filter, image), st, &steps).r - 0.5));
    }
    return most;
  };
  const double texel = 1.0 / kSize;
  for (const TextureFilter filter : kFilters) {
    EXPECT_GT(contrast(filter, {{0.1 * texel, 0}, {0, 0.1 * texel}}), 0.3);
    EXPECT_LT(contrast(filter, {{8 * texel, 0}, {0, 8 * texel}}), 0.02);
  }
  // Along the waves' crests, only the ellipse stays narrow across them.
  const CoordinateSteps along{{0, 6 * texel}, {texel, 0}};
  EXPECT_GT(contrast(TextureFilter::kEwa, along), 0.15);
  EXPECT_LT(contrast(TextureFilter::kTrilinear, along), 0.02);
  const CoordinateSteps across{{6 * texel, 0}, {0, texel}};
  EXPECT_LT(contrast(TextureFilter::kEwa, across), 0.02);
}

TEST(ImageLookup, AnEllipseMayLieAcrossTheAxes) {
  // Diagonal waves of x - y.
  const auto image =
      picture([](int x, int y) { return 0.5 + 0.5 * std::cos(0.5 * std::numbers::pi * (x - y)); });
  const double texel = 1.0 / kSize, a = 5 * texel, b = 0.7 * texel;
  const auto contrast = [&](const CoordinateSteps& steps) {
    double most = 0;
    for (int i = 0; i < 16; ++i) {
      const Vec2 st{0.5 + i * texel / 4, 0.5};
      most = std::max(most,
                      std::fabs(look_up(texture(TextureFilter::kEwa, image), st, &steps).r - 0.5));
    }
    return most;
  };
  // y goes down and t goes up, so the crests run along (1, -1) in (s, t).
  EXPECT_GT(contrast({{a, -a}, {b, b}}), 0.1);
  EXPECT_LT(contrast({{a, a}, {b, -b}}), 0.02);
}

TEST(ImageLookup, TheLimitCountsLevels) {
  std::vector<Rgbf> texels;
  for (int i = 0; i < kSize * kSize; ++i) texels.emplace_back(static_cast<float>(i % 251));
  const auto image = *Image::create(kSize, kSize, texels);
  Textures plain;
  plain.picture("a", *image);
  const std::size_t bytes = plain.bytes();
  Textures limited(bytes);
  const auto kept = limited.picture("a", *image);
  EXPECT_EQ(kept->width(), kSize);
  EXPECT_FALSE(limited.uses_footprints());
  limited.add(texture(TextureFilter::kEwa, kept));
  EXPECT_TRUE(limited.uses_footprints());
  EXPECT_EQ(kept->width(), kSize / 2);
  EXPECT_EQ(kept->levels(), 6U);
  ASSERT_EQ(limited.halved().size(), 1U);
}

TEST(ImageLookup, FootprintsPassTheMapping) {
  Textures textures;
  const auto image = [&] {
    std::vector<Rgbf> texels;
    for (int i = 0; i < kSize * kSize; ++i) texels.emplace_back(i % 2 == 0 ? 0.0F : 1.0F);
    return textures.picture("stripes", **Image::create(kSize, kSize, texels));
  }();
  ImageTexture t = texture(TextureFilter::kTrilinear, image);
  t.mapping.scale = {3, 3};
  const Footprint uv{.position_x = {}, .position_y = {}, .uv_x = {0.01, 0}, .uv_y = {0, 0.01}};
  const std::int32_t by_uv = textures.add(t);
  t.mapping = {.kind = TextureMapping::Kind::kPlanar};
  const std::int32_t by_place = textures.add(t);
  const Footprint place{
      .position_x = {0.03, 0, 0}, .position_y = {0, 0.03, 0}, .uv_x = {}, .uv_y = {}};
  TexturePoint p{.uv = {48.5 / 192, 0.3}, .position = {16.5 / 64, 0.3, 0}};
  // 0.03 of 64 texels: the mean of about four.
  for (const auto& [number, footprint] : {std::pair{by_uv, &uv}, {by_place, &place}}) {
    p.footprint = nullptr;
    EXPECT_GT(std::fabs(textures(NumberValue{0, number}, p) - 0.5), 0.2);
    p.footprint = footprint;
    EXPECT_NEAR(textures(NumberValue{0, number}, p), 0.5, 0.02);
  }
}

TEST(ImageLookup, AStepOverTheSeamIsShort) {
  Textures textures;
  std::vector<Rgbf> texels;
  for (int i = 0; i < kSize * kSize; ++i) texels.emplace_back(i % kSize < 32 ? 0.0F : 1.0F);
  ImageTexture t = texture(TextureFilter::kTrilinear,
                           textures.picture("halves", **Image::create(kSize, kSize, texels)));
  t.mapping = {.kind = TextureMapping::Kind::kCylindrical};
  const std::int32_t number = textures.add(t);
  // From 0.3 before the seam at -x to 0.05 behind it.
  const auto at = [](double angle) { return Vec3{std::cos(angle), std::sin(angle), 0.3}; };
  const Vec3 from = at(std::numbers::pi - 0.3), to = at(std::numbers::pi + 0.05);
  const Footprint step{.position_x = to - from, .position_y = {0, 0, 1e-3}, .uv_x = {}, .uv_y = {}};
  const TexturePoint p{.position = from, .footprint = &step};
  EXPECT_GT(textures(NumberValue{0, number}, p), 0.8);
}

}  // namespace
}  // namespace lucerna
