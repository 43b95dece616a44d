// The words of a scene file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/pbrt/place.h"

namespace lucerna::pbrt {

struct Token {
  enum class Kind : std::uint8_t {
    kEnd,     ///< of the file
    kWord,    ///< a directive, a number, true or false
    kString,  ///< quoted; `text` is what stands between the quotes, escapes as written
    kOpen,
    kClose,
  };
  Kind kind = Kind::kEnd;
  std::string_view text;
  Place place;
};

/// `Shape`, `"sphere"`, `'['` or `the end of the file`, for messages.
std::string described(const Token& token);

/// The text of a string with its escapes resolved.  Fails at an escape that does not exist.
std::string unescaped(const Token& string);

/// The number that a word spells, finite; fails with `expected ...` elsewhere.  For messages,
/// `owner` is the directive that it belongs to, or the type of the parameter `name`.
double number(const Token& word, std::string_view expected, std::string_view owner,
              std::string_view name = {});

/// Splits one file into tokens.  Comments run from # to the end of the line.
class Tokenizer {
 public:
  /// `file` and `contents` outlive the tokenizer and its tokens.
  Tokenizer(const std::string* file, std::string_view contents);

  /// The next token; kEnd again and again at the end.
  Token next();

 private:
  Place place_at(const char* at) const;
  Token string();

  const std::string* file_;
  const char* at_;
  const char* end_;
  const char* line_begin_;
  int line_ = 1;
};

}  // namespace lucerna::pbrt
