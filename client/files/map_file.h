// Light maps: pictures whose texels are points of a surface, read and written in runs of rows.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/files/vector_file.h"

namespace lucerna::client {

/// Opens an OpenEXR file of one or several parts, in scan lines or tiles.
///
/// Points are the channels P.X, P.Y and P.Z (or Position.*), normals N.X, N.Y and N.Z (or
/// Normal.*).  Layer names may come before them, and R, G, B may replace X, Y, Z.  Without such a
/// layer, X, Y and Z, or R, G and B are used.  If the file has both layers, rows have six columns.
///
/// Points must be 32-bit floats, since 16 bits resolve a coordinate to two thousandths at best.
/// Keeps at most about 32 MiB of the file in memory.
absl::StatusOr<std::unique_ptr<VectorFile>> open_map(const std::string& path, VectorKind kind);

/// Writes an OpenEXR file of 32-bit floats, row by row from the top.
class MapWriter {
 public:
  virtual ~MapWriter() = default;
  /// UNKNOWN if the file cannot be created.  Its name need not end in .exr.
  static absl::StatusOr<std::unique_ptr<MapWriter>> create(const std::string& path,
                                                           const MapWindow& window,
                                                           const std::vector<std::string>& channels,
                                                           const std::string& description);
  /// Writes the next row: the channels of each texel, texel after texel.
  virtual absl::Status write_row(std::span<const float> values) = 0;
  virtual absl::Status close() = 0;
};

}  // namespace lucerna::client
