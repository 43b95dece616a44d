// Prints text.  The programs print by these functions alone, since servers and files may put escape
// sequences into names and errors.
#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <string>
#include <utility>

#include "proto/common/plain_text.h"

namespace lucerna::shell {

/// Like fmt::print, but the whole text is plain (plain_text).
template <class... Args>
void print_text(std::FILE* file, fmt::format_string<Args...> format, Args&&... args) {
  fmt::print(file, "{}", plain_text(fmt::format(format, std::forward<Args>(args)...)));
}

/// Prints text with the program's own escape sequences.  Foreign parts of it must be plain already.
inline void print_as_is(std::FILE* file, const std::string& text) { fmt::print(file, "{}", text); }

}  // namespace lucerna::shell
