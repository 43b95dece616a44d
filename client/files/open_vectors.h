// Opens a file of points or normals by its extension.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/files/vector_file.h"

namespace lucerna::client {

enum class VectorFormat { kNpy, kCsv, kExr };

/// The format that the file's extension names, in upper or lower case.  INVALID_ARGUMENT lists the
/// extensions.
absl::StatusOr<VectorFormat> vector_format(const std::string& path);

/// Opens a file by its extension.  `kind` selects the channels of a map.  INVALID_ARGUMENT names
/// the file and the error in it.
absl::StatusOr<std::unique_ptr<VectorFile>> open_vectors(const std::string& path, VectorKind kind);

}  // namespace lucerna::client
