// Reads accessors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/gltf/document.h"

namespace lucerna::gltf {

/// The values of accessor `index`, `components` for each element, in the order of the file.
/// Normalised integers become fractions, as do `as_fractions`: integers in [0, 1] or [-1, 1].
/// Sparse values are applied.  Columns of matrices follow each other.
///
/// Fails with the place of the accessor: another type than one with `components` numbers, bytes
/// outside of the buffer, a number that is not finite unless the caller mends those.
std::vector<double> read_numbers(const Document& document, std::size_t index,
                                 std::size_t components, bool is_mended = false);

/// The number of components of one element: 3 for "VEC3".
std::size_t components_of(const Document& document, std::size_t index);

/// The values of a SCALAR accessor of unsigned integers.
std::vector<std::uint32_t> read_indices(const Document& document, std::size_t index);

}  // namespace lucerna::gltf
