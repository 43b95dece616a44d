// What the headers of pictures say: exposures, primaries, the order of rows, windows and layers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/files/image_reader.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using testing::decoded_picture;
using testing::expect_near;
using testing::first_texel;
using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::written;

constexpr const char* kRgbe = "FORMAT=32-bit_rle_rgbe\n";
constexpr const char* kXyze = "FORMAT=32-bit_rle_xyze\n";

/// A Radiance file; (128, 64, 32, 129) is (1, 0.5, 0.25).
std::string radiance(const std::string& header, const std::string& resolution,
                     const std::vector<std::array<int, 4>>& texels) {
  std::string bytes = "#?RADIANCE\n" + header + "\n" + resolution + "\n";
  for (const auto& texel : texels)
    for (const int byte : texel) bytes += static_cast<char>(byte);
  return bytes;
}
constexpr std::array kTexel{128, 64, 32, 129};

TEST(RadiancePicture, ExposuresAndColourCorrectionsAreDividedOut) {
  const auto with = [](const std::string& lines) {
    return first_texel(radiance(lines + kRgbe, "-Y 1 +X 1", {kTexel}));
  };
  EXPECT_EQ(with(""), Rgbf(1, 0.5F, 0.25F));
  EXPECT_EQ(with("EXPOSURE=2.0\n"), Rgbf(0.5F, 0.25F, 0.125F));
  EXPECT_EQ(with("EXPOSURE= 2\nEXPOSURE=+4e0\n"), Rgbf(0.125F, 0.0625F, 0.03125F));
  EXPECT_EQ(with("COLORCORR=2 4 8\nEXPOSURE=0.5\nCOLORCORR=1 1 0.5\n"), Rgbf(1, 0.25F, 0.125F));
  // Lines of an earlier picture begin with a tab.  Others have no meaning for the colours.
  EXPECT_EQ(with("\tEXPOSURE=2\nSOFTWARE=EXPOSURE=3\nexposure=5\nPIXASPECT=2\n"),
            Rgbf(1, 0.5F, 0.25F));
  EXPECT_EQ(remarks_of(decoded_picture(
                radiance(std::string("EXPOSURE=2\n") + kRgbe, "-Y 1 +X 1", {kTexel}))),
            "");
}

TEST(RadiancePicture, AGammaIsARemark) {
  const auto with = [](const std::string& line) {
    return decoded_picture(radiance(line + kRgbe, "-Y 1 +X 1", {kTexel}));
  };
  const DecodedImage d = with("GAMMA=2.2\n");
  EXPECT_EQ(d.image->texel(0, 0), Rgbf(1, 0.5F, 0.25F));
  EXPECT_EQ(remarks_of(d),
            "a.hdr has the header line \"GAMMA=2.2\" -> its texels are taken as linear, as in "
            "pbrt-v4\n");
  for (const char* line : {"GAMMA=1\n", "GAMMA= 1.000\n", "\tGAMMA=2.2\n"})
    EXPECT_EQ(remarks_of(with(line)), "") << line;
  EXPECT_THAT(remarks_of(with("GAMMA=x\n")), HasSubstr("\"GAMMA=x\""));
}

TEST(RadiancePicture, LinesMayEndWithCrLf) {
  std::string bytes = "#?RGBE\r\nEXPOSURE=2\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n";
  for (const int byte : kTexel) bytes += static_cast<char>(byte);
  EXPECT_EQ(first_texel(bytes), Rgbf(0.5F, 0.25F, 0.125F));
}

TEST(RadiancePicture, PrimariesAreConvertedWithTheirLuminance) {
  const auto with = [](const std::string& primaries, const std::array<int, 4>& texel) {
    return decoded_picture(radiance("PRIMARIES=" + primaries + "\n" + kRgbe, "-Y 1 +X 1", {texel}));
  };
  const std::string rec2020 = "0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290";
  const DecodedImage grey = with(rec2020, {128, 128, 128, 129});
  expect_near(grey.image->texel(0, 0), {1, 1, 1}, 1e-5);
  EXPECT_EQ(remarks_of(grey), "");
  // [BT2087]: 0.5 of green and 1 of red, of luminance 0.2627 + 0.3390.
  const DecodedImage orange = with(rec2020, {128, 64, 0, 129});
  expect_near(orange.image->texel(0, 0), {1.6605 - 0.2938, -0.1246 + 0.56645, 0}, 0.02);
  EXPECT_NEAR(luminance(Rgb(orange.image->texel(0, 0))), 0.2627 + 0.3390, 1e-4);
  EXPECT_THAT(remarks_of(orange), HasSubstr("1 texel with a colour outside of Rec. 709"));
  // Radiance's own: luminances 0.265, 0.670, 0.065 and equal amounts of white.
  const std::string own = "0.640 0.330 0.290 0.600 0.150 0.060 0.3333 0.3333";
  EXPECT_NEAR(luminance(Rgb(with(own, {128, 0, 0, 129}).image->texel(0, 0))), 0.265, 5e-4);
  EXPECT_NEAR(luminance(Rgb(with(own, {0, 128, 0, 129}).image->texel(0, 0))), 0.670, 5e-4);
  const DecodedImage line = with("0.1 0.1 0.2 0.2 0.3 0.3 0.3 0.3", kTexel);
  EXPECT_EQ(line.image->texel(0, 0), Rgbf(1, 0.5F, 0.25F));
  EXPECT_THAT(remarks_of(line), HasSubstr("span no colour space -> treated as Rec. 709"));
}

TEST(RadiancePicture, XyzeIsConverted) {
  // X, Y and Z of D65 white, (0.9505, 1, 1.0891), at an exponent of 2^-7.
  const Rgbf c = first_texel(radiance(kXyze, "-Y 1 +X 1", {{122, 128, 139, 129}}));
  expect_near(c, {1, 1, 1}, 0.02);
  EXPECT_NEAR(luminance(Rgb(c)), 1, 1e-6);  // Y
}

TEST(RadiancePicture, AllEightResolutionStringsStandUpright) {
  // The picture has 2 rows and 3 columns: a b c over d e f.
  const std::array<std::pair<const char*, const char*>, 8> kOrders{{{"-Y 2 +X 3", "abcdef"},
                                                                    {"-Y 2 -X 3", "cbafed"},
                                                                    {"+Y 2 +X 3", "defabc"},
                                                                    {"+Y 2 -X 3", "fedcba"},
                                                                    {"+X 3 -Y 2", "adbecf"},
                                                                    {"-X 3 -Y 2", "cfbead"},
                                                                    {"+X 3 +Y 2", "daebfc"},
                                                                    {"-X 3 +Y 2", "fcebda"}}};
  for (const auto& [resolution, order] : kOrders) {
    SCOPED_TRACE(resolution);
    std::vector<std::array<int, 4>> texels;
    for (const char c : std::string(order)) texels.push_back({c, c, c, 136});
    const DecodedImage d = decoded_picture(radiance(kRgbe, resolution, texels));
    ASSERT_EQ(d.image->width(), 3);
    ASSERT_EQ(d.image->height(), 2);
    std::string seen;
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 3; ++x) seen += static_cast<char>(d.image->texel(x, y).r);
    EXPECT_EQ(seen, "abcdef");
    EXPECT_EQ(remarks_of(d), "");
  }
}

TEST(RadiancePicture, RunsOfOldAndNewFilesAreRead) {
  // (1, 1, 1, n) repeats the texel before n times, then 256 n times.
  std::vector<std::array<int, 4>> old{kTexel, {1, 1, 1, 3}, {1, 1, 1, 1}, {0, 0, 128, 129}};
  const DecodedImage d = decoded_picture(radiance(kRgbe, "-Y 1 +X 261", old));
  EXPECT_EQ(d.image->texel(259, 0), Rgbf(1, 0.5F, 0.25F));
  EXPECT_EQ(d.image->texel(260, 0), Rgbf(0, 0, 1));
  // A row of 8: a run of red, single greens, runs of the others.
  std::string fresh = "#?RADIANCE\n" + std::string(kRgbe) + "\n-Y 1 +X 8\n";
  for (const int byte : {2, 2, 0, 8, 136, 128, 8, 0, 1, 2, 3, 4, 5, 6, 128, 136, 0, 136, 129})
    fresh += static_cast<char>(byte);
  const DecodedImage n = decoded_picture(fresh);
  EXPECT_EQ(n.image->texel(0, 0), Rgbf(1, 0, 0));
  EXPECT_EQ(n.image->texel(7, 0), Rgbf(1, 1, 0));
}

TEST(RadiancePicture, WrongHeadersAndRowsAreErrorsThatSaySo) {
  const auto error = [](const std::string& bytes) {
    return message(decode_image({"a.hdr", bytes}).status());
  };
  const std::string one = "-Y 1 +X 1";
  EXPECT_THAT(error(radiance("FORMAT=ascii\n", one, {kTexel})), HasSubstr("32-bit_rle_xyze"));
  for (const char* line : {"EXPOSURE=0", "EXPOSURE=-1", "EXPOSURE=x", "EXPOSURE=nan",
                           "EXPOSURE=1e999", "COLORCORR=1 2", "PRIMARIES=1 2 3"})
    EXPECT_THAT(error(radiance(std::string(line) + "\n" + kRgbe, one, {kTexel})),
                HasSubstr(line[0] == 'P' ? "eight chromaticities" : "numbers above 0"))
        << line;
  for (const char* resolution : {"", "-Y 1", "-Y 1 -Y 1", "-Y 1 +X -1", "-Y 1 +X 3e9", "-Z 1 +X 1"})
    EXPECT_THAT(error(radiance(kRgbe, resolution, {kTexel})), HasSubstr("allowed: -Y HEIGHT"))
        << resolution;
  EXPECT_THAT(error(radiance(kRgbe, "-Y 2 +X 1", {kTexel})), HasSubstr("ends early"));
  EXPECT_THAT(error(radiance(kRgbe, "-Y 1 +X 2", {{1, 1, 1, 2}})), HasSubstr("a run of 2"));
  EXPECT_THAT(error(radiance(kRgbe, "-Y 1 +X 2", {kTexel, {1, 1, 1, 2}})), HasSubstr("a run of 2"));
  EXPECT_THAT(error(radiance(kRgbe, "-Y 1 +X 8", {{2, 2, 0, 9}})), HasSubstr("a row of 9 texels"));
  EXPECT_THAT(error(radiance(kRgbe, "-Y 1 +X 8", {{2, 2, 0, 8}, {255, 1, 1, 1}})),
              HasSubstr("127 texels at the place 0"));
  EXPECT_EQ(decode_image({"a.hdr", radiance(kRgbe, "-Y 60000 +X 60000", {kTexel})}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(PictureHeaders, OrientationFlagsTurnThePicture) {
  // Stored as a b c over d e f; where the first row and the first column are, as in TIFF.
  const std::array<std::pair<int, const char*>, 8> kTurned{{{1, "abcdef"},
                                                            {2, "cbafed"},
                                                            {3, "fedcba"},
                                                            {4, "defabc"},
                                                            {5, "adbecf"},
                                                            {6, "daebfc"},
                                                            {7, "fcebda"},
                                                            {8, "cfbead"}}};
  for (const auto& [orientation, expected] : kTurned)
    for (const auto type : {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::FLOAT}) {
      SCOPED_TRACE(orientation);
      OIIO::ImageSpec spec(3, 2, 3, type);
      spec.attribute("Orientation", orientation);
      std::vector<float> values;
      for (const char c : std::string("abcdef"))
        for (int i = 0; i < 3; ++i) values.push_back(static_cast<float>(c - 'a' + i) / 255);
      const std::string bytes = written("a.tif", spec, values);
      const auto d = decode_image({"a.tif", bytes}, {.encoding = kLinear});
      const auto surface = decode_surface({"a.tif", bytes}, {.encoding = kLinear});
      ASSERT_TRUE(d.ok() && surface.ok()) << d.status() << surface.status();
      EXPECT_EQ(remarks_of(*d), "");
      ASSERT_EQ(d->image->width(), orientation < 5 ? 3 : 2);
      ASSERT_EQ(d->image->height(), orientation < 5 ? 2 : 3);
      std::string seen, codes;
      for (int y = 0; y < d->image->height(); ++y)
        for (int x = 0; x < d->image->width(); ++x)
          seen += static_cast<char>('a' + std::lround(d->image->texel(x, y).r * 255));
      EXPECT_EQ(seen, expected);
      if (!surface->codes) continue;
      EXPECT_EQ(surface->codes->width, d->image->width());
      for (std::size_t i = 0; i < surface->codes->codes.size(); i += 3)
        codes += static_cast<char>('a' + surface->codes->codes[i]);
      EXPECT_EQ(codes, expected);
    }
}

/// A block of EXIF with one entry: the orientation.  [TIFF6]
std::string exif(int orientation) {
  return std::string("II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18) +
         static_cast<char>(orientation) + std::string(7, '\0');
}

/// A file of 3 x 2 texels.
std::string three_by_two(const std::string& name) {
  const OIIO::ImageSpec spec(3, 2, 3, OIIO::TypeDesc::UINT8);
  return written(name, spec, std::vector<std::uint8_t>(18, 128));
}

/// A chunk of a PNG file.
std::string png_chunk(const std::string& type, const std::string& body) {
  std::string size(4, '\0');
  size[3] = static_cast<char>(body.size());
  const std::string checked = type + body;
  const uLong check =
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  std::string bytes = size + checked;
  for (int i = 3; i >= 0; --i) bytes += static_cast<char>(check >> (8 * i));
  return bytes;
}

/// A PNG file with these chunks before its texels.
std::string png_with(const std::string& chunks) {
  constexpr std::size_t kHeaderEnd = 33;
  return three_by_two("a.png").insert(kHeaderEnd, chunks);
}

/// A WebP file with this block of EXIF.  [RFC9649]
std::string webp_with_exif(const std::string& block) {
  const std::string plain = three_by_two("a.webp");
  const auto size = [](std::size_t n) {
    return std::string{static_cast<char>(n), static_cast<char>(n >> 8U), 0, 0};
  };
  std::string body = "WEBPVP8X" + size(10) + std::string("\x08\0\0\0\x02\0\0\x01\0\0", 10) +
                     plain.substr(12) + "EXIF" + size(block.size()) + block;
  return "RIFF" + size(body.size()) + body;
}

TEST(PictureHeaders, OrientationsInExifTurnThePicture) {
  for (const auto& [name, bytes] :
       {std::pair<std::string, std::string>{"a.webp", webp_with_exif(exif(6))},
        {"b.webp", webp_with_exif(std::string("Exif\0\0", 6) + exif(6))},
        {"a.png", png_with(png_chunk("eXIf", exif(6)))}}) {
    const auto d = testing::value_of(decode_image({name, bytes}));
    EXPECT_EQ(d.image->width(), 2) << name;
    EXPECT_EQ(d.image->height(), 3) << name;
  }
  for (const std::string& block : {exif(1), exif(0), exif(9), exif(6).substr(0, 12), std::string()})
    EXPECT_EQ(decoded_picture(webp_with_exif(block)).image->width(), 3);
}

TEST(PictureHeaders, CodesOfPngFilesOtherThanSrgbAreRemarks) {
  const auto remarks = [](const std::string& chunks) {
    return remarks_of(decoded_picture(png_with(chunks)));
  };
  const std::string srgb = png_chunk("sRGB", std::string(1, '\0'));
  const std::string srgb_codes = png_chunk("cICP", testing::chars({1, 13, 0, 1}));
  const std::string gamma = png_chunk("gAMA", testing::chars({0, 1, 0x86, 0xa0}));
  EXPECT_EQ(remarks(srgb), "");
  EXPECT_EQ(remarks(gamma), "a.hdr has a gamma of 1 -> treated as sRGB, as in pbrt-v4\n");
  EXPECT_EQ(remarks(srgb + gamma), "");
  // [PNG3, 4.3]: cICP comes before all others.
  EXPECT_EQ(remarks(srgb_codes), "");
  EXPECT_EQ(remarks(srgb_codes + gamma), "");
  const std::string pq = png_chunk("cICP", testing::chars({9, 16, 0, 1}));
  for (const std::string& chunks : {pq, srgb + pq, gamma + pq})
    EXPECT_EQ(remarks(chunks),
              "a.hdr has primaries 9 and transfer function 16 of H.273 -> treated as sRGB, as in "
              "pbrt-v4\n");
}

TEST(PictureHeaders, TheScaleOfAPfmFileIsApplied) {
  for (const bool grey : {false, true}) {
    std::string bytes = grey ? "Pf\n1 1\n-2.5\n" : "PF\n1 1\n-2.5\n";
    const float values[3]{2, 4, 8};
    bytes.append(reinterpret_cast<const char*>(values), (grey ? 1 : 3) * sizeof(float));
    EXPECT_EQ(first_texel(bytes), grey ? Rgbf(5) : Rgbf(5, 10, 20));
  }
}

}  // namespace
}  // namespace lucerna
