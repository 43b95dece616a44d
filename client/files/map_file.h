// Light maps: pictures whose texels are points of a surface, read and written some rows at a time.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/files/vector_file.h"

namespace lucerna::client {

/// An OpenEXR file, scan lines or tiles, of one part or several.  Points are its channels P.X, P.Y
/// and P.Z (or Position.*), normals N.X, N.Y and N.Z (or Normal.*), each perhaps after the names of
/// layers and also called R, G and B; without such a layer X, Y and Z, or R, G and B are meant.
/// Points come with normals where the file has both by name.  Points must be 32-bit floats: 16 bits
/// tell no point to better than two thousandths of its coordinate.  Holds at most some 32 MiB of
/// it.
absl::StatusOr<std::unique_ptr<VectorFile>> open_map(const std::string& path, VectorKind kind);

/// An OpenEXR file of 32-bit floats, written from its top to its bottom.
class MapWriter {
 public:
  virtual ~MapWriter() = default;
  /// UNKNOWN where the file cannot be made; its name need not end in .exr.
  static absl::StatusOr<std::unique_ptr<MapWriter>> create(const std::string& path,
                                                           const MapWindow& window,
                                                           const std::vector<std::string>& channels,
                                                           const std::string& description);
  /// The next row: channel by channel for each texel.
  virtual absl::Status write_row(std::span<const float> values) = 0;
  virtual absl::Status close() = 0;
};

}  // namespace lucerna::client
