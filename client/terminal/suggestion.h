// Corrections for words that the program does not know.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lucerna::cli {

/// Least number of letters to insert, delete, replace or swap with a neighbour that makes `b` of
/// `a`.  No letter takes part in two swaps.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `known` with the least edit distance from `word`, the first of several.  Empty if
/// more than a third of the letters of `word` would change.
std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

}  // namespace lucerna::cli
