// Textures: coordinates, pictures and patterns.
#include "server/materials/texture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lucerna {
namespace {

/// Two rows of texels, from the top: 1 2 3 / 4 5 6.
std::shared_ptr<const Texels> digits() {
  std::vector<Rgbf> texels;
  for (int i = 1; i <= 6; ++i) texels.emplace_back(static_cast<float>(i));
  return std::make_shared<const Texels>(**Image::create(3, 2, texels));
}

double value_at(const ImageTexture& texture, Vec2 uv) {
  Textures textures;
  return textures(NumberValue{0, textures.add(texture)}, {.uv = uv});
}

TEST(Texture, PicturesBeginAtTheUpperLeft) {
  const ImageTexture t{.image = digits(), .filter = TextureFilter::kNearest};
  EXPECT_EQ(value_at(t, {0.1, 0.9}), 1);
  EXPECT_EQ(value_at(t, {0.9, 0.9}), 3);
  EXPECT_EQ(value_at(t, {0.1, 0.1}), 4);
}

TEST(Texture, WrapDecidesOutsideOfThePicture) {
  ImageTexture t{.image = digits(), .filter = TextureFilter::kNearest};
  EXPECT_EQ(value_at(t, {1.1, -0.1}), 1);  // repeats
  EXPECT_EQ(value_at(t, {-0.1, 0.1}), 6);
  t.wrap_s = t.wrap_t = TextureWrap::kClamp;
  EXPECT_EQ(value_at(t, {1.1, -0.1}), 6);
  t.wrap_s = t.wrap_t = TextureWrap::kBlack;
  EXPECT_EQ(value_at(t, {1.1, 0.1}), 0);
  for (const double far : {1e300, -1e300, double{INFINITY}, double{NAN}})
    for (const auto wrap : {TextureWrap::kRepeat, TextureWrap::kBlack, TextureWrap::kClamp,
                            TextureWrap::kMirror, TextureWrap::kOctahedral}) {
      t.wrap_s = t.wrap_t = wrap;
      EXPECT_TRUE(std::isfinite(value_at(t, {far, far}))) << far;
    }
}

TEST(Texture, EachCoordinateHasItsWrap) {
  const ImageTexture t{.image = digits(),
                       .wrap_s = TextureWrap::kMirror,
                       .wrap_t = TextureWrap::kClamp,
                       .filter = TextureFilter::kNearest};
  // 1 2 3 | 3 2 1 | 1 2 3, and the upper row above the picture.
  const double row[] = {3, 2, 1, 1, 2, 3, 3, 2, 1, 1};
  for (int i = 0; i < 10; ++i) EXPECT_EQ(value_at(t, {(i - 3 + 0.5) / 3, 5}), row[i]) << i;
  EXPECT_EQ(value_at(t, {1.1, -5}), 6);
}

TEST(Texture, AMirrorHasNoSeam) {
  const ImageTexture t{
      .image = digits(), .wrap_s = TextureWrap::kMirror, .wrap_t = TextureWrap::kMirror};
  EXPECT_NEAR(value_at(t, {0, 0.75}), 1, 1e-12);
  EXPECT_NEAR(value_at(t, {1, 0.25}), 6, 1e-12);
  EXPECT_NEAR(value_at(t, {-1, 1.75}), 6, 1e-12);
}

TEST(Texture, AffineMappingsTurnAndMove) {
  TextureMapping m;
  m.kind = TextureMapping::Kind::kAffine;
  m.axis_s = {0, 2, 0.5};
  m.axis_t = {-3, 0, 0.25};
  const Vec2 st = m({.uv = {10, 100}});
  EXPECT_EQ(st.x, 200.5);
  EXPECT_EQ(st.y, -29.75);
}

TEST(Texture, ACutOffIsAllOrNothing) {
  Textures textures;
  const std::int32_t ramp =
      textures.add(BilerpTexture{.corners = {Rgb(0), Rgb(0), Rgb(1), Rgb(1)}});
  const std::int32_t cut = textures.add(CutOffTexture{{{}, ramp}, 0.25});
  const auto at = [&](double u) { return textures(NumberValue{0, cut}, {.uv = {u, 0}}); };
  EXPECT_EQ(at(0.24), 0);
  EXPECT_EQ(at(0.25), 1);
  EXPECT_EQ(at(0.9), 1);
}

TEST(Texture, BilinearFilterIsTheMeanBetweenTexels) {
  const ImageTexture t{.image = digits()};
  EXPECT_NEAR(value_at(t, {1 / 3.0, 0.5}), (1 + 2 + 4 + 5) / 4.0, 1e-12);
  EXPECT_NEAR(value_at(t, {0, 0.75}), (1 + 3) / 2.0, 1e-12);  // the seam of repetitions
}

TEST(Texture, ScaleAndInversion) {
  ImageTexture t{.image = digits(), .filter = TextureFilter::kNearest, .scale = 0.1};
  EXPECT_NEAR(value_at(t, {0.1, 0.9}), 0.1, 1e-12);
  t.invert = true;
  EXPECT_NEAR(value_at(t, {0.1, 0.9}), 0.9, 1e-12);
  t.scale = 1;
  EXPECT_EQ(value_at(t, {0.9, 0.9}), 0);  // 1 - 3 is not a reflectance
}

TEST(Texture, MappingsGiveTheirCoordinates) {
  const auto at = [](TextureMapping::Kind kind, const Vec3& position) {
    TextureMapping m;
    m.kind = kind;
    m.axis_s = {0, 0, 2};
    m.shift = {0.5, 0.25};
    return m({.uv = {}, .position = position});
  };
  const auto pole = at(TextureMapping::Kind::kSpherical, {0, 0, 3});
  EXPECT_NEAR(pole.x, 0, 1e-15);
  const auto side = at(TextureMapping::Kind::kSpherical, {0, 2, 0});
  EXPECT_NEAR(side.x, 0.5, 1e-15);
  EXPECT_NEAR(side.y, 0.25, 1e-15);
  const auto around = at(TextureMapping::Kind::kCylindrical, {0, -2, 7});
  EXPECT_NEAR(around.x, 0.25, 1e-15);
  EXPECT_EQ(around.y, 7);
  const auto plane = at(TextureMapping::Kind::kPlanar, {1, 3, 4});
  EXPECT_EQ(plane.x, 8.5);
  EXPECT_EQ(plane.y, 3.25);
}

TEST(Texture, PatternsAreMadeOfOtherTextures) {
  Textures textures;
  const std::int32_t checks = textures.add(CheckerboardTexture{
      .mapping = {.scale = {4, 4}}, .parts = {ColourValue{Rgb(0.8)}, ColourValue{}}});
  const std::int32_t half = textures.add(ScaleTexture{{{}, checks}, ColourValue{Rgb(0.5)}});
  const std::int32_t mix =
      textures.add(MixTexture{{ColourValue{{}, half}, ColourValue{Rgb(1)}}, NumberValue{0.25}});
  const auto value = [&](std::int32_t node, Vec2 uv, Vec3 normal = {}) {
    return textures(NumberValue{0, node}, {.uv = uv, .position = {}, .normal = normal});
  };
  EXPECT_EQ(value(half, {0.1, 0.1}), 0.4);
  EXPECT_EQ(value(half, {0.3, 0.1}), 0);
  EXPECT_EQ(value(half, {-0.1, 0.1}), 0);
  EXPECT_NEAR(value(mix, {0.1, 0.1}), 0.4 * 0.75 + 0.25, 1e-15);
  const std::int32_t four =
      textures.add(BilerpTexture{.corners = {Rgb(0), Rgb(1), Rgb(2), Rgb(3)}});
  EXPECT_NEAR(value(four, {0.25, 0.5}), 0.25 * 2 + 0.5, 1e-15);
  const std::int32_t up =
      textures.add(DirectionMixTexture{{ColourValue{Rgb(1)}, ColourValue{}}, {0, 0, 1}});
  EXPECT_NEAR(value(up, {}, {0, 0.6, -0.8}), 0.8, 1e-15);
  const std::int32_t dots =
      textures.add(DotsTexture{.inside = ColourValue{Rgb(1)}, .outside = ColourValue{}});
  int inside = 0;
  constexpr int kPoints = 200;
  for (int i = 0; i < kPoints; ++i)
    for (int k = 0; k < kPoints; ++k) inside += value(dots, {0.1 * i, 0.1 * k}) > 0;
  // Half of the squares hold a disk of radius 0.35.
  EXPECT_NEAR(inside / double(kPoints * kPoints), 0.5 * 3.14159 * 0.35 * 0.35, 0.03);
}

TEST(Texture, PicturesOverTheLimitAreHalvedTheLargestFirst) {
  const auto picture = [](int side, float step) {
    std::vector<Rgbf> texels;
    for (int i = 0; i < side * side; ++i)
      texels.emplace_back(step * static_cast<float>(i), 1.0F, static_cast<float>(i % 7));
    return *Image::create(side, side, std::move(texels));
  };
  constexpr std::size_t kLimit = 100'000;
  Textures textures(kLimit);
  // 32 x 32 floats take 12 kB, 256 x 256 take 786 kB.
  const auto small = textures.picture("small", *picture(32, 0.5F));
  EXPECT_TRUE(textures.halved().empty());
  const auto large = textures.picture("large", *picture(256, 0.25F));
  EXPECT_LE(textures.bytes(), kLimit + 1000);
  EXPECT_EQ(small->width(), 32);
  EXPECT_EQ(large->width(), 64);  // 74 kB; 128 x 128 texels of 6 bytes are 98 kB
  ASSERT_EQ(textures.halved().size(), 1U);
  EXPECT_EQ(textures.halved()[0].name, "large");
  EXPECT_EQ(textures.halved()[0].width, 256);
  EXPECT_EQ(textures.halved()[0].kept_height, 64);
  // The mean stays.
  double sum = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) sum += large->texel(x, y).r / (64 * 64);
  EXPECT_NEAR(sum, 0.25 * (256 * 256 - 1) / 2, 1);
  for (int i = 0; i < 40; ++i) textures.picture("more", *picture(64, 1));
  EXPECT_LE(textures.bytes(), kLimit + 40 * 200);
}

}  // namespace
}  // namespace lucerna
