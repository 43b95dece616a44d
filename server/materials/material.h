// Materials: the parameters of a scattering function, constant or from textures.
#pragma once

#include <absl/functional/function_ref.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "server/materials/bsdf.h"
#include "server/materials/texture.h"

namespace lucerna {

/// Roughness along u and v.  With `remap`, alpha is its square root, as in pbrt-v4.
struct Roughness {
  NumberValue u{}, v{};
  bool remap = true;
};

struct DiffuseParams {
  ColourValue reflectance{Rgb(0.5)};
};
struct DiffuseTransmissionParams {
  ColourValue reflectance{Rgb(0.25)}, transmittance{Rgb(0.25)};
  double scale = 1;  ///< of both
};
/// A metal's complex index, relative to the outside.  Or a reflectance at normal incidence, from
/// which an index with eta 1 follows.
struct MetalParams {
  ColourValue eta{Rgb(1)}, k{};
  std::optional<ColourValue> reflectance{};
  Roughness roughness{};
};
struct DielectricParams {
  NumberValue eta{1.5};
  Roughness roughness{};
};
struct ThinDielectricParams {
  NumberValue eta{1.5};
};
/// A clear coat.
struct CoatParams {
  NumberValue eta{1.5}, thickness{0.01};
  Roughness roughness{};
};
struct CoatedDiffuseParams {
  ColourValue reflectance{Rgb(0.5)};
  CoatParams coat{};
};
struct CoatedMetalParams {
  MetalParams metal{};
  CoatParams coat{};
};
/// A surface of a glTF file.  Factors of textures are applied.
struct GltfSurfaceParams {
  ColourValue base{Rgb(1)};
  /// Green: roughness, the square root of alpha.  Blue: metallic.  As in glTF's pictures.
  ColourValue surface{Rgb(1)};
  double ior = 1.5;  ///< 0, or at least 1
  /// Factors of what a dielectric's facets reflect: at all angles, and along the normal.
  NumberValue specular{1};
  ColourValue specular_colour{Rgb(1)};
  NumberValue transmission{0};
  NumberValue coat{0};
  ColourValue coat_roughness{};  ///< green
  double anisotropy = 0, anisotropy_turn_rad = 0;

  bool transmits() const { return !transmission.is_constant() || transmission.constant > 0; }
};
/// Each point has one of two materials, the second with probability `amount`.  Numbers of
/// materials that come before this one.
struct MixParams {
  std::array<std::uint32_t, 2> materials{};
  NumberValue amount{0.5};
};

using MaterialParams = std::variant<DiffuseParams, DiffuseTransmissionParams, MetalParams,
                                    DielectricParams, ThinDielectricParams, CoatedDiffuseParams,
                                    CoatedMetalParams, GltfSurfaceParams, MixParams>;

/// The second axis of a surface's frame, for normal maps and anisotropy.  The first is along u, the
/// third is the shading normal.
enum class FrameAlong : std::uint8_t {
  kCross,  ///< cross(normal, along u), as in pbrt-v4
  kV,      ///< the same or its opposite, on the side to which v grows, as in glTF
};

struct Material {
  MaterialParams params{};
  /// Tangent-space normals, from a picture whose channels are (n + 1) / 2; -1: none.
  std::int32_t normal_map = -1;
  double normal_scale = 1;  ///< of the x and y of these normals
  FrameAlong second_axis = FrameAlong::kCross;
  /// A height over the surface [m], which only tilts the shading normal; -1: none.  Not with a
  /// normal map.
  std::int32_t bumps = -1;

  /// The reflectance of a diffuse material without textures; null for all others.
  const Rgb* plain_diffuse() const {
    const auto* diffuse = std::get_if<DiffuseParams>(&params);
    return diffuse != nullptr && diffuse->reflectance.is_constant() && normal_map < 0 && bumps < 0
               ? &diffuse->reflectance.constant
               : nullptr;
  }
};

/// What a material does with light in single directions.
struct SmoothTraits {
  bool reflects = false, passes = false;  ///< at some point of it
  /// The index below the surface over that above, for light that passes; 1 where it keeps its
  /// direction.  Nothing if it differs from point to point.
  std::optional<double> eta = 1;
  bool turns_normals = false;  ///< by a map
  /// Roughness alpha of facets that reflect nearly like a mirror, the largest one of a mix; 0 if
  /// there are none, or if it differs from point to point.
  double glossy_alpha = 0;
  /// Whether it sends light on nearly in single directions in another way than by such facets: it
  /// passes, or the facets are rougher along u or v.
  bool is_nearly_smooth = false;
  bool has_roughness_texture = false;
  bool is_rough = false;  ///< whether it scatters light in other directions too

  bool is_smooth() const { return reflects || passes; }
  bool is_glossy() const { return glossy_alpha > 0; }
};
/// Calls `f` with each material of a mix, of mixes within it too, once; or with the material
/// itself. `materials`: the material of a number.
void for_each_of_mix(absl::FunctionRef<const Material&(std::uint32_t)> materials,
                     std::uint32_t number, absl::FunctionRef<void(const Material&)> f);

/// Those of a mix are those of all its materials together.
SmoothTraits smooth_traits(absl::FunctionRef<const Material&(std::uint32_t)> materials,
                           std::uint32_t number);

inline Material diffuse_material(const Rgb& reflectance) {
  return {.params = DiffuseParams{{reflectance}}};
}

/// The scattering function of `material` at a place.  Values of textures are clamped to their
/// domain.  Not for mixes; see `chosen`.
Bsdf bsdf_of(const Material& material, const Textures& textures, const TexturePoint& p);

/// The share of light that passes a smooth thin pane straight on, at an angle of this cosine to its
/// normal, at least 0.  `eta`: as in ThinDielectricParams.
double pane_transmittance(const NumberValue& eta, const Textures& textures, const TexturePoint& p,
                          double cosine);

/// The number of the material itself, or of the part of a mix at this place.  The choice depends on
/// the position only, as in pbrt-v4.
std::uint32_t chosen(std::span<const Material> materials, std::uint32_t number,
                     const Textures& textures, const TexturePoint& p);

}  // namespace lucerna
