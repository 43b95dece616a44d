// Media of .pbrt files: MakeNamedMedium and MediumInterface.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// Homogeneous media that absorb.  Remarks report scattering, emission and other kinds.  Names may
/// be used before they are defined.
class Media {
 public:
  /// Fails if the name is defined twice, or on unknown types.
  void make(LoadState& context, const std::string& name, const ParameterSet& params);
  /// The number of a medium in `context.scene.media`; -1 for "", which is none.
  std::int32_t named(LoadState& context, const std::string& name, const FilePosition& place);
  /// Fails if a name was used and not defined.
  void finish() const;

 private:
  struct Entry {
    std::int32_t number;
    FilePosition place;  ///< of the directive that defines it; before that, of its first use
    bool defined = false;
  };
  Entry& entry(LoadState& context, const std::string& name, const FilePosition& place);

  std::map<std::string, Entry> media_;
};

}  // namespace lucerna::pbrt
