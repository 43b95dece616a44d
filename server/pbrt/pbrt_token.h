// Splits scene files into tokens.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/pbrt/file_position.h"

namespace lucerna::pbrt {

struct Token {
  enum class Kind : std::uint8_t {
    kEnd,     ///< end of the file
    kWord,    ///< a directive, a number, true or false
    kString,  ///< quoted; `text` is the part between the quotes, with escapes unresolved
    kOpen,
    kClose,
  };
  Kind kind = Kind::kEnd;
  std::string_view text;
  FilePosition place;
};

/// A description for messages: `Shape`, `"sphere"`, `'['` or `the end of the file`.
std::string described(const Token& token);

/// The text of a string with its escapes resolved.  Fails on an unknown escape.
std::string unescaped(const Token& string);

/// The finite number in a word; fails with `expected ...` if there is none.  In messages, `owner`
/// is the directive that it belongs to, or the type of the parameter `name`.
double number(const Token& word, std::string_view expected, std::string_view owner,
              std::string_view name = {});

/// Splits one file into tokens.  Comments run from # to the end of the line.
class Tokenizer {
 public:
  /// `file` and `contents` must outlive the tokenizer and its tokens.
  Tokenizer(const SharedText* file, std::string_view contents);

  /// The next token.  At the end, every call returns kEnd.
  Token next();
  /// The number of words from here to the next quote or bracket.
  std::size_t words_ahead() const;

 private:
  FilePosition place_at(const char* at) const;
  Token string();

  const SharedText* file_;
  const char* at_;
  const char* end_;
  const char* line_begin_;
  int line_ = 1;
};

}  // namespace lucerna::pbrt
