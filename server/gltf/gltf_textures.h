// Textures of glTF materials.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "server/gltf/document.h"
#include "server/materials/texture.h"

namespace lucerna::gltf {

/// How a picture continues and is read between texels.
struct Sampling {
  TextureWrap wrap_s = TextureWrap::kRepeat, wrap_t = TextureWrap::kRepeat;
  ImageFilter filter = ImageFilter::kBilinear;
};
/// That of the sampler of a texture.  Fails on unknown numbers.
Sampling sampling_of(const Document& document, const View& texture);

/// Checks a reference to a texture.  Fails on indices out of range and on numbers that are not
/// finite.
void check_texture(const Document& document, const View& info);

/// The textures of one material.  Meshes have one (u, v) for all of them: that of TEXCOORD_n, with
/// v upwards.  A texture of another set is left out, with a remark.
class TextureSet {
 public:
  /// `has_picture`: the (u, v) are those of an emissive picture.  Then textures must repeat and
  /// have no transform.  `allowed`: whether this picture repeats and has none; if not, no texture
  /// fits.
  TextureSet(const Document& document, std::optional<int> uv_set, bool has_picture, bool allowed)
      : document_(document), uv_set_(uv_set), has_picture_(has_picture), allowed_(allowed) {}

  /// `factor` times the texture `key` of `parent`, or `factor` if there is none.
  ColourValue colour(const std::optional<View>& parent, std::string_view key, PictureKind kind,
                     const Rgb& factor);
  /// The same for the red channel.
  NumberValue number(const std::optional<View>& parent, std::string_view key, PictureKind kind,
                     double factor);
  /// The set that the textures need; nothing if there is no texture.
  std::optional<int> uv_set() const { return any_ ? uv_set_ : std::nullopt; }

 private:
  /// The node of a texture; -1 if it is left out.
  std::int32_t image(const View& info, PictureKind kind);
  bool fits(const View& info, const ImageTexture& texture, int set);

  const Document& document_;
  std::optional<int> uv_set_;
  bool has_picture_, allowed_, any_ = false;
};

}  // namespace lucerna::gltf
