// Materials of .pbrt files.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/materials/material.h"
#include "server/pbrt/pbrt_params.h"
#include "server/pbrt/pbrt_textures.h"

namespace lucerna::pbrt {

/// Materials are resolved after the whole file is read, since names may be used before they are
/// defined.
class Materials {
 public:
  /// Starts with the default material: diffuse, 0.5.
  Materials();

  static constexpr std::uint32_t kDefault = 0;

  /// Each returns a reference, which shapes store until `resolve`.
  std::uint32_t add(ParameterSet params);
  std::uint32_t named(const std::string& name, const FilePosition& place);

  /// Fails if the name is defined twice, or the parameter "type" is missing.
  void make_named(const std::string& name, ParameterSet params);

  /// The number of references.
  std::size_t size() const { return materials_.size(); }
  /// Memory of one of them, without its parameters.
  static constexpr std::size_t bytes_of_one() { return sizeof(Entry); }

  TextureTable& textures() { return textures_; }
  const TextureTable& textures() const { return textures_; }

  /// Whether a mesh with this material may need (u, v).  Names that are not yet defined may.
  bool may_need_uv(std::uint32_t reference) const;

  /// Index into `context.scene.materials`, to which the material is added at its first use.
  /// Nothing for an interface between media, which is invisible.  Fails on unknown names.
  std::optional<std::uint32_t> resolve(LoadState& context, std::uint32_t reference);

 private:
  struct Entry {
    std::string_view type;  ///< a known type
    /// Of the directive that defines it.  Before that its place is that of the first use, and when
    /// it is resolved only the place is left.
    ParameterSet params;
    const std::string* name = nullptr;  ///< null if made by Material
    std::uint32_t index = 0;            ///< when it is resolved
    bool defined = false, resolved = false;
  };
  static void define(const std::string& type, ParameterSet params, Entry& entry);
  Material material_of(LoadState& context, const Entry& entry);
  MixParams mix_of(LoadState& context, const Entry& entry);

  LongList<Entry> materials_;
  int nesting_ = 0;  ///< depth of mixes that are being resolved
  std::map<std::string, std::uint32_t> names_;
  TextureTable textures_;
};

}  // namespace lucerna::pbrt
