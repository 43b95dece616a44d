// The interface of files of points and normals, which callers read in runs of rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/status.h"

namespace lucerna::client {

/// The windows of a map: its data window, which holds the texels, and the window that a viewer
/// shows.
struct MapWindow {
  int x = 0, y = 0, width = 0, height = 0;
  int full_x = 0, full_y = 0, full_width = 0, full_height = 0;
};

/// Rows of three numbers (points or normals), or of six (both).
class VectorFile {
 public:
  virtual ~VectorFile() = default;
  virtual std::uint64_t rows() const = 0;
  virtual std::size_t columns() const = 0;  ///< 3 or 6
  /// The window of a map; null for other files.  The rows of a map are its texels, from the top.
  virtual const MapWindow* window() const { return nullptr; }
  /// Reads as many rows as fit into `values`, starting at row `first`.  INVALID_ARGUMENT names the
  /// file, and in a text file the line.  Not thread-safe.
  virtual absl::Status read(std::uint64_t first, std::span<double> values) = 0;
};

/// What the caller needs from a file: points (with normals if the file has them), or only normals.
enum class VectorKind { kPoints, kNormals };

}  // namespace lucerna::client
