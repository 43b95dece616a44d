#include "server/pictures/picture_colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "server/pictures/picture_checks.h"

namespace lucerna {
namespace {

/// Red, green, blue and white, each x and y.
using Chromaticities = std::array<double, 8>;

/// Whether they are those of Rec. 709, to the digits that files have.
bool are_rec709(const Chromaticities& c) {
  constexpr Chromaticities kRec709Values{0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
  return std::ranges::equal(c, kRec709Values,
                            [](double a, double b) { return std::fabs(a - b) <= 1e-4; });
}

std::uint32_t big_endian(std::string_view bytes) {
  return static_cast<std::uint32_t>(number_at(bytes, 0, 4, std::endian::big));
}

/// The body of the first chunk of this type before the texels, if it has `least` bytes.
std::string_view png_chunk(std::string_view bytes, std::string_view type, std::size_t least) {
  constexpr std::size_t kSignatureBytes = 8, kHeadBytes = 8, kCheckBytes = 4;
  for (std::size_t at = kSignatureBytes; at + kHeadBytes <= bytes.size();) {
    const std::size_t size = big_endian(bytes.substr(at));
    const std::string_view found = bytes.substr(at + 4, 4);
    const std::string_view body = bytes.substr(at + kHeadBytes, size);
    if (found == type && body.size() >= least) return body;
    if (found == "IDAT") break;
    at += kHeadBytes + size + kCheckBytes;
  }
  return {};
}

/// What chunks of less priority than a profile state, in units of 1e-5.
std::string other_png_colours(std::string_view bytes) {
  if (!png_chunk(bytes, "sRGB", 1).empty()) return "";
  constexpr std::uint32_t kSrgbGamma = 45455;
  if (const std::string_view gamma = png_chunk(bytes, "gAMA", 4);
      !gamma.empty() && std::abs(std::int64_t{big_endian(gamma)} - kSrgbGamma) > 500)
    return fmt::format("a gamma of {}", big_endian(gamma) * 1e-5);
  const std::string_view primaries = png_chunk(bytes, "cHRM", 32);
  const auto value = [&](std::size_t i) { return big_endian(primaries.substr(4 * i)) * 1e-5; };
  // The white comes first.
  if (!primaries.empty() &&
      !are_rec709({value(2), value(3), value(4), value(5), value(6), value(7), value(0), value(1)}))
    return "primaries other than those of sRGB";
  return "";
}

}  // namespace

std::optional<RgbPrimaries> stated_primaries(const OIIO::ImageSpec& spec) {
  std::array<float, 8> c{};
  if (!spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), c.data()))
    return std::nullopt;
  Chromaticities values{};
  std::ranges::copy(c, values.begin());
  if (are_rec709(values)) return std::nullopt;
  return RgbPrimaries{{values[0], values[1]},
                      {values[2], values[3]},
                      {values[4], values[5]},
                      {values[6], values[7]}};
}

void set_primaries_of_xyz(OIIO::ImageSpec& spec) {
  constexpr std::array<float, 8> kXyz{1, 0, 0, 1, 0, 0, 1.0F / 3, 1.0F / 3};
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), kXyz.data());
}

std::optional<double> stated_white_cd_m2(const OIIO::ImageSpec& spec) {
  const float white = spec.get_float_attribute("whiteLuminance", 0);
  if (!(white > 0) || !std::isfinite(white)) return std::nullopt;
  return white;
}

std::string other_colours(const AssetContent& content, PictureFormat format,
                          const OIIO::ImageSpec& spec) {
  const bool is_png = format == PictureFormat::kPng;
  // Comes before all other chunks.  [PNG3, 4.3]
  if (const auto codes = is_png ? png_chunk(content.bytes, "cICP", 4) : ""; !codes.empty()) {
    const int primaries = static_cast<unsigned char>(codes[0]),
              transfer = static_cast<unsigned char>(codes[1]);
    constexpr int kRec709 = 1, kSrgb = 13;
    if (primaries == kRec709 && transfer == kSrgb) return "";
    return fmt::format("primaries {} and transfer function {} of H.273", primaries, transfer);
  }
  if (spec.find_attribute("ICCProfile") != nullptr) {
    const std::string name = spec.get_string_attribute("ICCProfile:profile_description");
    if (name.find("sRGB") == std::string::npos)
      return name.empty() ? "a colour profile" : "the colour profile " + first_line(name);
    return "";
  }
  return is_png ? other_png_colours(content.bytes) : "";
}

}  // namespace lucerna
