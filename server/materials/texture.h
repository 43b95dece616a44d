// Textures: values that vary over a surface.
//
// A texture is a node that may use others.  Nodes stand in one array, each after those that it
// uses, so that there are no cycles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "lights/maths/rgb.h"
#include "lights/maths/transform.h"
#include "lights/maths/vec.h"
#include "lights/pictures/image.h"
#include "server/materials/texels.h"

namespace lucerna {

/// A constant, or a texture by its number.
struct ColourValue {
  Rgb constant{};
  std::int32_t texture = -1;  ///< -1: the constant
  bool is_constant() const { return texture < 0; }
};
/// The same for a number; a texture's red channel.
struct NumberValue {
  double constant = 0;
  std::int32_t texture = -1;
  bool is_constant() const { return texture < 0; }
};

/// How a place moves on a surface from one position of a camera's film to the next, in x and in y.
struct Footprint {
  Vec3 position_x, position_y;  ///< world [m]
  Vec2 uv_x, uv_y;
};

/// A place on a surface.
struct TexturePoint {
  Vec2 uv{};        ///< surface coordinates
  Vec3 position{};  ///< world [m]
  Vec3 normal{};    ///< world, unit: the shading normal
  Rgb colour{};     ///< of the vertices around it
  /// The area that textures with kTrilinear and kEwa average over; null: none.
  const Footprint* footprint = nullptr;
};

/// How a texture's coordinates (s, t) follow from the place.
struct TextureMapping {
  enum class Kind : std::uint8_t { kUv, kAffine, kSpherical, kCylindrical, kPlanar };
  Kind kind = Kind::kUv;
  /// kUv: s = scale.x u + shift.x, and so for t.  kAffine: s = (u, v, 1) . axis_s, and so for t.
  /// kPlanar: s = position . axis_s + shift.x.
  Vec2 scale{1, 1}, shift{};
  Vec3 axis_s{1, 0, 0}, axis_t{0, 1, 0};
  Transform texture_from_world{};  ///< for all kinds but kUv and kAffine

  Vec2 operator()(const TexturePoint& p) const;
};

/// How a picture continues beyond its border.  kMirror: each repetition mirrors the one before.
/// kOctahedral is for both coordinates.
enum class TextureWrap : std::uint8_t { kRepeat, kBlack, kClamp, kMirror, kOctahedral };

/// How a texture reads its picture.  The last two use smaller copies of the picture, by the
/// footprint of camera rays.  [Pharr23, 10.4.3 and 10.4.4]
enum class TextureFilter : std::uint8_t { kNearest, kBilinear, kTrilinear, kEwa };
constexpr bool uses_levels(TextureFilter filter) { return filter >= TextureFilter::kTrilinear; }

/// A picture.  Its upper left corner is at s = 0, t = 1.
struct ImageTexture {
  std::shared_ptr<const Texels> image;  ///< not null; with levels if the filter uses them
  TextureMapping mapping{};
  TextureWrap wrap_s = TextureWrap::kRepeat, wrap_t = TextureWrap::kRepeat;
  TextureFilter filter = TextureFilter::kBilinear;
  double most_anisotropy = 8;  ///< kEwa: the longer over the shorter axis of the mean, at least 1
  double scale = 1;
  bool invert = false;  ///< 1 - value, after the scale; not below 0
};
/// Squares of size 1 in (s, t), in turns; cubes in (x, y, z) with `dimension` 3.
struct CheckerboardTexture {
  TextureMapping mapping{};
  int dimension = 2;
  std::array<ColourValue, 2> parts{};
};
/// `part` times `factor`.
struct ScaleTexture {
  ColourValue part{};
  ColourValue factor{};
};
/// 1 where the red channel of `part` is at least `least`, else 0.
struct CutOffTexture {
  ColourValue part{};
  double least = 0.5;
};
/// parts[0] (1 - amount) + parts[1] amount.
struct MixTexture {
  std::array<ColourValue, 2> parts{};
  NumberValue amount{};
};
/// parts[0] where the normal is along `direction`, parts[1] where it is across, as the absolute
/// cosine.
struct DirectionMixTexture {
  std::array<ColourValue, 2> parts{};
  Vec3 direction{0, 1, 0};  ///< world, unit
};
/// Linear between four values at (s, t) = (0, 0), (0, 1), (1, 0) and (1, 1).
struct BilerpTexture {
  TextureMapping mapping{};
  std::array<Rgb, 4> corners{};
};
/// A dot of `inside` in about half of the unit squares of (s, t).
struct DotsTexture {
  TextureMapping mapping{};
  ColourValue inside{}, outside{};
};

/// The colour of the vertices, linear between them.  Only for triangle meshes with colours.
struct VertexColourTexture {};

using TextureNode =
    std::variant<ImageTexture, CheckerboardTexture, ScaleTexture, CutOffTexture, MixTexture,
                 DirectionMixTexture, BilerpTexture, DotsTexture, VertexColourTexture>;

/// A picture that was halved, to fit the memory of textures.
struct HalvedPicture {
  std::string name;
  int width, height;            ///< texels in the file
  int kept_width, kept_height;  ///< texels in memory
};

/// All textures of a scene.  Immutable once made; may be read from any thread.
class Textures {
 public:
  /// `limit_bytes`: the most memory of all pictures together.
  explicit Textures(std::size_t limit_bytes = std::numeric_limits<std::size_t>::max())
      : limit_bytes_(limit_bytes) {}

  /// The texels of a picture.  If all pictures together are over the limit, the largest ones are
  /// halved, the first one of equals first, until they fit.
  /// Halving ends early if `stop` is requested: the pictures then exceed the limit.
  std::shared_ptr<const Texels> picture(const std::string& name, Texels texels,
                                        const std::stop_token& stop = {});
  std::shared_ptr<const Texels> picture(const std::string& name, const Image& image) {
    return picture(name, Texels(image));
  }
  std::size_t limit_bytes() const { return limit_bytes_; }
  std::vector<HalvedPicture> halved() const;
  /// A picture by the name of its file.
  struct Picture {
    std::string name;
    int width, height;  ///< in the file
    std::shared_ptr<Texels> texels;
  };
  std::span<const Picture> pictures() const { return pictures_; }

  /// `node` uses only textures and pictures that were added before.  Returns its number.  Makes the
  /// levels that its filter uses, unless `stop` is requested meanwhile.
  std::int32_t add(TextureNode node, const std::stop_token& stop = {});
  bool empty() const { return nodes_.empty(); }
  std::size_t size() const { return nodes_.size(); }
  std::span<const TextureNode> nodes() const { return nodes_; }

  Rgb operator()(const ColourValue& value, const TexturePoint& p) const {
    return value.is_constant() ? value.constant : at(value.texture, p);
  }
  double operator()(const NumberValue& value, const TexturePoint& p) const {
    return value.is_constant() ? value.constant : at(value.texture, p).r;
  }
  /// Memory, with each picture once.
  std::size_t bytes() const;
  /// The texture if it is a picture; else null.
  const ImageTexture* picture(std::int32_t texture) const {
    return std::get_if<ImageTexture>(&nodes_[static_cast<std::size_t>(texture)]);
  }
  /// Whether a texture uses the footprints of places.
  bool uses_footprints() const { return uses_footprints_; }
  /// Whether the texture depends on (u, v) only, and not on position or normal.
  bool needs_only_uv(std::int32_t texture) const;

 private:
  Rgb at(std::int32_t texture, const TexturePoint& p) const;
  void fit(const std::stop_token& stop);
  std::size_t limit_bytes_;
  bool uses_footprints_ = false;
  std::vector<Picture> pictures_;
  std::vector<TextureNode> nodes_;
};

}  // namespace lucerna
