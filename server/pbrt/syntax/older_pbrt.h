// Words that only files of earlier versions of pbrt have.
#pragma once

#include <string_view>

namespace lucerna::pbrt {

/// What an error about an unknown word adds if the word is one of an earlier pbrt: "; this is a
/// pbrt-v3 file; pbrt-v4's --upgrade converts it".  Empty for all other words.  `kind`: the
/// directive, "parameter type", "texture type" or "directive".
std::string_view hint_of_older_pbrt(std::string_view kind, std::string_view word);

/// What pbrt-v4 calls a parameter of pbrt-v2 and pbrt-v3; empty for all others.
std::string_view name_in_pbrt_v4(std::string_view parameter);

}  // namespace lucerna::pbrt
