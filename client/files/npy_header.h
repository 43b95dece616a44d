// The header of NumPy files: a magic word, a version, and a Python literal.  [NEP1]
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace lucerna::client {

/// The first bytes of every NumPy file.
inline constexpr std::string_view kNpyMagic("\x93NUMPY", 6);

struct NpyHeader {
  /// The type of a number such as "<f4".  Of a structured array the list as text, such as
  /// "[('x', '<f8'), ('pdf', '<f4')]".
  std::string descr;
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
};

/// Reads the header; `in` is then at the first number.  INVALID_ARGUMENT begins with "name: " and
/// states what is wrong.
absl::StatusOr<NpyHeader> read_npy_header(std::istream& in, const std::string& name);

}  // namespace lucerna::client
