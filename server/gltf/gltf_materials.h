// Materials of a glTF file.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/description/scene_description.h"
#include "server/gltf/gltf_textures.h"

namespace lucerna::gltf {

/// Whether this folder reads the extension `name` of materials or of their textures.
bool is_material_extension(std::string_view name);

/// How a surface with a material emits.
struct MaterialEmission {
  Rgb radiance_cd_m2;
  std::optional<Picture> picture;
  int uv_set = 0;  ///< of the picture: TEXCOORD_0 and so on
  /// From the (u, v) of a vertex, v downwards as in the file, to the (u, v) of the picture, v
  /// upwards.  Rows of an affine map.
  double uv[2][3] = {{1, 0, 0}, {0, -1, 1}};
  TextureWrap wrap_u = TextureWrap::kClamp, wrap_v = TextureWrap::kClamp;
  bool is_transformed = false;
};

/// Fills SceneDescription::materials.
class Materials {
 public:
  explicit Materials(const Document& document) : document_(document) {}

  /// Reads the pictures of all materials, so that one answer lists all missing files.
  void read_pictures();

  struct Use {
    std::uint32_t material;  ///< index into SceneDescription::materials
    bool double_sided = false;
    std::shared_ptr<const MaterialEmission> emission;  ///< null: it does not emit
    std::optional<int> uv_set{};                       ///< of its textures; nothing if it has none
    NumberValue alpha{1};                              ///< the same as in ShapeDescription
    bool needs_tangents = false;                       ///< whether the frame of its surface matters
  };
  /// The material with this index; without an index, glTF's default material.  `has_colours`:
  /// vertex colours are factors of its base colour.
  const Use& use(std::optional<std::size_t> index, bool has_colours);

 private:
  Use make(const View& material, bool has_colours);
  std::shared_ptr<const MaterialEmission> emission(const View& material);
  void note_left_out(const View& material);
  bool apply_texture(const View& texture, MaterialEmission& emission);

  const Document& document_;
  /// By index, the default material at the end; without and with vertex colours.
  std::vector<std::optional<Use>> uses_[2];
};

}  // namespace lucerna::gltf
