// Spaces of linear RGB other than Rec. 709, and the conversion of their colours.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// CIE chromaticities (x, y) of the primaries and of RGB (1, 1, 1).
struct RgbPrimaries {
  Vec2 red, green, blue, white;
  bool operator==(const RgbPrimaries&) const = default;
};

/// [BT709]
inline constexpr RgbPrimaries kRec709{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
/// Linear values in this space are X, Y and Z.
inline constexpr RgbPrimaries kXyz{{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}};

/// A space that .pbrt files name: "srgb", "dci-p3" (with the white D65, as in pbrt-v4), "rec2020"
/// or "aces2065-1", in upper or lower case.  Null for other names.  [BT2020] [SMPTE432] [SMPTE2065]
const RgbPrimaries* named_primaries(std::string_view name);

/// Converts linear RGB of other primaries to Rec. 709.
class RgbConversion {
 public:
  enum class White {
    kKept,     ///< colours keep their X, Y and Z: for light
    kAdapted,  ///< (1, 1, 1) becomes (1, 1, 1), by Bradford's transform: for reflectances [Lam85]
  };
  /// Nothing if the primaries or the white do not span a space: three points on a line, a white on
  /// one of its edges, values that are not finite.
  static std::optional<RgbConversion> to_rec709(const RgbPrimaries& from, White white);

  /// A colour outside of Rec. 709 has channels below 0.
  Rgb operator()(const Rgb& c) const {
    const Vec3 v{c.r, c.g, c.b};
    return {dot(rows_[0], v), dot(rows_[1], v), dot(rows_[2], v)};
  }

 private:
  explicit RgbConversion(std::array<Vec3, 3> rows) : rows_(std::move(rows)) {}
  std::array<Vec3, 3> rows_;
};

/// Whether a channel is below 0 by more than the rounding of a conversion.
bool is_outside_rec709(const Rgb& c);
/// The colour with its channels below 0 set to 0, at the same luminance.  Black if the luminance is
/// not positive.
Rgb at_edge_of_rec709(const Rgb& c);

}  // namespace lucerna
