// Textures of .pbrt files, and material parameters that may name one.
#pragma once

#include <map>
#include <set>
#include <string>

#include "lights/maths/transform.h"
#include "server/materials/texture.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The textures that a file has defined so far.  Constants, and products and mixtures of constants,
/// become constants.
class TextureTable {
 public:
  /// A Texture directive.  `kind`: float or spectrum.  Adds a node to `context.scene.textures`
  /// unless the texture is constant.  Fails on unknown classes, on names that are defined twice,
  /// and on parts that are not defined before.
  void make(LoadState& context, const std::string& name, const std::string& kind,
            const ParameterSet& params, const Transform& world_from_texture);

  /// A parameter of type rgb, spectrum, float or texture.  Constants are clamped to [0, 1] with a
  /// remark.  Fails on textures that are not defined before.
  ColourValue reflectance(LoadState& context, const ParameterSet& params, const std::string& name,
                          const ColourValue& otherwise) const;
  /// A parameter of type float or texture.
  NumberValue number(const ParameterSet& params, const std::string& name, double otherwise) const;
  /// The "alpha" of a shape, 1 if it is not given.  A texture whose picture cannot be decoded is
  /// grey, but as an alpha it hides nothing.
  NumberValue alpha(const ParameterSet& params) const;
  /// Whether a shape that emits is invisible and shines: its "alpha" is 0, and a constant of
  /// pbrt-v4.  It computes a "mix" or a "scale" of constants at each place, and they darken a
  /// light.
  bool hides_only(const ParameterSet& params) const;
  /// The value of a texture that `parameter` names.
  ColourValue texture(const Parameter& parameter) const;

 private:
  class Maker;
  bool is_computed(const ParameterSet& params, const std::string& name) const;

  std::map<std::string, ColourValue> values_;  ///< by "kind name"
  std::set<std::string> unreadable_;           ///< those without their pictures
  std::set<std::string> computed_;             ///< float constants that pbrt-v4 computes
};

}  // namespace lucerna::pbrt
