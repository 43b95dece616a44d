// Materials and textures.  Surfaces are diffuse; what a file asks for beyond that is reported, and
// the nearest diffuse surface stands in.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// Materials are resolved when the whole file is read, since a name may be used before it is made.
class Materials {
 public:
  /// Begins with the one material that shapes have before any directive: diffuse, 0.5.
  Materials();

  static constexpr std::uint32_t kDefault = 0;

  /// Each returns the reference that shapes keep until `resolve`.
  std::uint32_t add(const std::string& type, ParameterSet params, const Place& place);
  std::uint32_t named(const std::string& name, const Place& place);

  /// Fails where the name is made twice or the parameter "type" is missing.
  void make_named(const std::string& name, ParameterSet params, const Place& place);

  /// `kind` is float or spectrum.  Evaluated at once: only constants are modelled.
  void make_texture(Context& context, const std::string& name, const std::string& kind,
                    const std::string& type, const ParameterSet& params, const Place& place);

  /// Index into `context.scene.materials`, where the material is put at its first use.  Nothing for
  /// an interface between media: such a surface is not to be seen.  Fails on unknown names.
  std::optional<std::uint32_t> resolve(Context& context, std::uint32_t reference);

 private:
  struct Material {
    std::string type;
    ParameterSet params;
    Place place;       ///< of the directive that makes it, or, until then, of its first use
    std::string name;  ///< empty: made by Material
    bool defined = false;
    bool resolved = false;
    std::optional<std::uint32_t> index;
  };
  Rgb<double> texture_or_value(Context& context, const ParameterSet& params,
                               const std::string& name, const Rgb<double>& otherwise) const;
  Rgb<double> diffuse_of(Context& context, const Material& material);

  std::vector<Material> materials_;
  int nesting_ = 0;  ///< of mixes that are being resolved
  std::map<std::string, std::uint32_t> names_;
  std::map<std::string, Rgb<double>> textures_;  ///< by "kind name"
};

}  // namespace lucerna::pbrt
