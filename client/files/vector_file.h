// Files of points and normals that are read a run of rows at a time, whatever their length.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace lucerna::client {

/// What the file's extension says, in any case.
enum class VectorFormat { kNpy, kCsv, kExr };

/// INVALID_ARGUMENT naming the extensions that there are.
absl::StatusOr<VectorFormat> vector_format(const std::string& path);

/// Where the texels of a map are: its data window, and the window that a viewer shows.
struct MapWindow {
  int x = 0, y = 0, width = 0, height = 0;
  int full_x = 0, full_y = 0, full_width = 0, full_height = 0;
};

/// Rows of three numbers, points or normals, or of six, both.
class VectorFile {
 public:
  virtual ~VectorFile() = default;
  virtual std::uint64_t rows() const = 0;
  virtual std::size_t columns() const = 0;  ///< 3 or 6
  /// Of a map, whose texels are the rows here, from the top; else null.
  virtual const MapWindow* window() const { return nullptr; }
  /// Rows from `first` on, as many as `values` holds.  INVALID_ARGUMENT that names the file, and of
  /// text the line.  Not thread-safe.
  virtual absl::Status read(std::uint64_t first, std::span<double> values) = 0;
};

enum class VectorKind { kPoints, kNormals };

/// Opens a file by its extension.  `kind` says which channels of a map are meant: points may come
/// with normals, normals alone.  INVALID_ARGUMENT that names the file and what is wrong with it.
absl::StatusOr<std::unique_ptr<VectorFile>> open_vectors(const std::string& path, VectorKind kind);

}  // namespace lucerna::client
