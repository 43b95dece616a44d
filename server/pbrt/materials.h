// Materials and textures.  All surfaces are diffuse.  Other materials get a remark and are replaced
// by the nearest diffuse material.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// Materials are resolved after the whole file is read, since names may be used before they are
/// defined.
class Materials {
 public:
  /// Starts with the default material: diffuse, 0.5.
  Materials();

  static constexpr std::uint32_t kDefault = 0;

  /// Each returns a reference, which shapes store until `resolve`.
  std::uint32_t add(const std::string& type, ParameterSet params, const Place& place);
  std::uint32_t named(const std::string& name, const Place& place);

  /// Fails if the name is defined twice, or the parameter "type" is missing.
  void make_named(const std::string& name, ParameterSet params, const Place& place);

  /// `kind` is float or spectrum.  The texture is evaluated at once, since only constants are
  /// modelled.
  void make_texture(Context& context, const std::string& name, const std::string& kind,
                    const std::string& type, const ParameterSet& params, const Place& place);

  /// Index into `context.scene.materials`, to which the material is added at its first use.
  /// Nothing for an interface between media, which is invisible.  Fails on unknown names.
  std::optional<std::uint32_t> resolve(Context& context, std::uint32_t reference);

 private:
  struct Material {
    std::string type;
    ParameterSet params;
    Place place;       ///< of the directive that defines it; before that, of its first use
    std::string name;  ///< empty if made by Material
    bool defined = false;
    bool resolved = false;
    std::optional<std::uint32_t> index;
  };
  Rgb<double> texture_or_value(Context& context, const ParameterSet& params,
                               const std::string& name, const Rgb<double>& otherwise) const;
  Rgb<double> diffuse_of(Context& context, const Material& material);

  std::vector<Material> materials_;
  int nesting_ = 0;  ///< depth of mixes that are being resolved
  std::map<std::string, std::uint32_t> names_;
  std::map<std::string, Rgb<double>> textures_;  ///< by "kind name"
};

}  // namespace lucerna::pbrt
