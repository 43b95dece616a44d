// Words that only files of earlier versions of pbrt have.
#pragma once

#include <string_view>

namespace lucerna::pbrt {

inline constexpr std::string_view kIsOfPbrt3 =
    "; this is a pbrt-v3 file; pbrt-v4's --upgrade converts it";

/// What an error about an unknown word adds if the word is one of an earlier pbrt, such as
/// kIsOfPbrt3.  Empty for all other words.  `kind`: the directive, "parameter type", "texture
/// type", "directive", or "parameter" for its type and name.
std::string_view hint_of_older_pbrt(std::string_view kind, std::string_view word);

/// What pbrt-v4 calls a parameter of pbrt-v2 and pbrt-v3; empty for all others.
std::string_view name_in_pbrt_v4(std::string_view parameter);

}  // namespace lucerna::pbrt
