#include "client/files/open_vectors.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "client/files/csv_file.h"
#include "client/files/map_file.h"
#include "client/files/npy_file.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {

absl::StatusOr<VectorFormat> vector_format(const std::string& path) {
  std::string type = std::filesystem::path(path).extension().string();
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (type == ".npy") return VectorFormat::kNpy;
  if (type == ".csv") return VectorFormat::kCsv;
  if (type == ".exr") return VectorFormat::kExr;
  return absl::InvalidArgumentError(path + ": unknown file type, must be .npy, .csv or .exr");
}

absl::StatusOr<std::unique_ptr<VectorFile>> open_vectors(const std::string& path, VectorKind kind) {
  LUCERNA_ASSIGN_OR_RETURN(const VectorFormat format, vector_format(path));
  switch (format) {
    case VectorFormat::kNpy:
      return open_npy(path);
    case VectorFormat::kCsv:
      return open_csv(path);
    case VectorFormat::kExr:
      return open_map(path, kind);
  }
  return absl::InternalError(path);
}

}  // namespace lucerna::client
