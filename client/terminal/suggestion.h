// Corrections for words that the program does not know.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lucerna::cli {

/// The least number of edits that change `a` into `b`.  An edit inserts, deletes or replaces a
/// letter, or swaps two neighbours.  No letter takes part in two swaps.  This is the optimal string
/// alignment distance.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `known` with the least edit distance from `word`; the first of several.  Empty if
/// the distance is more than a third of the length of `word`.
std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

}  // namespace lucerna::cli
