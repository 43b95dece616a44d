// NumPy files of one array: a header that is a Python literal, then the numbers.  [NEP1: A Simple
// File Format for NumPy Arrays]
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/files/vector_file.h"

namespace lucerna::client {

/// Opens an array of shape (n, 3) or (n, 6) of little-endian float32 or float64 in C order.
/// INVALID_ARGUMENT names the requirement that the file violates.
absl::StatusOr<std::unique_ptr<VectorFile>> open_npy(const std::string& path);

/// The header of an array of shape (rows, columns) of little-endian float32.
std::string npy_header(std::uint64_t rows, std::size_t columns);

}  // namespace lucerna::client
