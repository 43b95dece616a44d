// What must be true of all that is read, whatever the input.  Anything else ends the program, which
// is a finding.
#pragma once

#include <absl/status/statusor.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <variant>

#include "server/description/scene_description.h"
#include "server/files/photometric_file.h"
#include "server/files/printable.h"

namespace lucerna::fuzz {

inline void require(bool is_so) {
  if (!is_so) std::abort();
}

/// An error can be printed.
inline void require_printable(const absl::Status& error) {
  require(!error.message().empty() && is_printable(std::string(error.message())));
}

/// The indices of a scene are within its lists, and its remarks can be printed.
inline void require_sound(const absl::StatusOr<SceneDescription>& scene) {
  if (!scene.ok()) return require_printable(scene.status());
  for (const ShapeDescription& shape : scene->shapes) {
    require(shape.is_interface || shape.material < scene->materials.size());
    if (const auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry))
      for (const std::uint32_t index : mesh->indices) require(index < mesh->positions.size());
  }
  for (const InstanceDescription& instance : scene->instances)
    require(instance.object < scene->objects.size());
  for (const Remark& remark : scene->remarks)
    require(is_printable(remark.where.file.str() + remark.what + remark.instead));
}

/// The intensities of a photometric file are between 0 and its largest.
inline void require_sound(const absl::StatusOr<PhotometricFile>& file) {
  if (!file.ok()) return require_printable(file.status());
  require(std::isfinite(file->web->flux_lm()) && file->web->flux_lm() >= 0);
  for (const double z : {-1.0, -0.3, 0.0, 0.3, 1.0}) {
    const double cd = file->web->at({0.6, -0.8, z});
    require(cd >= 0 && cd <= file->web->max_cd());
  }
}

}  // namespace lucerna::fuzz
