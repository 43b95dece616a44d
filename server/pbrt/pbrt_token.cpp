#include "server/pbrt/pbrt_token.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace lucerna::pbrt {
namespace {

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

bool ends_word(char c) { return is_space(c) || c == '"' || c == '[' || c == ']'; }

}  // namespace

std::string described(const Token& token) {
  switch (token.kind) {
    case Token::Kind::kEnd:
      return "the end of the file";
    case Token::Kind::kOpen:
      return "'['";
    case Token::Kind::kClose:
      return "']'";
    case Token::Kind::kWord:
    case Token::Kind::kString:
      break;
  }
  return fmt::format("\"{}\"", printable(token.text));
}

std::string unescaped(const Token& string) {
  const std::string_view text = string.text;
  if (text.find('\\') == std::string_view::npos) return std::string(text);
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\') {
      result += text[i];
      continue;
    }
    // The tokenizer never ends a string right after a backslash.
    switch (const char c = text[++i]) {
      case 'b':
        result += '\b';
        break;
      case 'f':
        result += '\f';
        break;
      case 'n':
        result += '\n';
        break;
      case 'r':
        result += '\r';
        break;
      case 't':
        result += '\t';
        break;
      case '\\':
      case '\'':
      case '"':
        result += c;
        break;
      default:
        fail(string.place, fmt::format("unknown escape \"\\{}\" in a string, allowed: "
                                       "\\b \\f \\n \\r \\t \\\\ \\' \\\"",
                                       printable({&c, 1})));
    }
  }
  return result;
}

double number(const Token& word, std::string_view expected, std::string_view owner,
              std::string_view name) {
  std::string_view text = word.text;
  const auto reject = [&]() {
    fail(word.place, fmt::format("expected {}, found {}", expected, described(word)));
  };
  if (word.kind != Token::Kind::kWord) reject();
  const bool plus = text.front() == '+';
  if (plus) text.remove_prefix(1);
  // from_chars also accepts "inf" and "nan", and a minus after the plus.
  const std::size_t first = !plus && !text.empty() && text.front() == '-' ? 1 : 0;
  if (first >= text.size() || !((text[first] >= '0' && text[first] <= '9') || text[first] == '.'))
    reject();
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, value);
  if (rest != end || code == std::errc::invalid_argument) reject();
  if (code == std::errc::result_out_of_range) {
    value = std::strtod(std::string(text).c_str(), nullptr);
    constexpr double kLargest = std::numeric_limits<double>::max();
    if (!std::isfinite(value))
      fail(word.place,
           fmt::format(
               "number {} of {} does not fit a double, allowed: [-{:.6g}, {:.6g}]",
               printable(word.text),
               name.empty() ? std::string(owner) : fmt::format("\"{} {}\"", owner, printable(name)),
               kLargest, kLargest));
  }
  return value;
}

Tokenizer::Tokenizer(const SharedText* file, std::string_view contents)
    : file_(file),
      at_(contents.data()),
      end_(contents.data() + contents.size()),
      line_begin_(at_) {}

FilePosition Tokenizer::place_at(const char* at) const {
  return {file_, line_, static_cast<int>(at - line_begin_) + 1};
}

Token Tokenizer::next() {
  for (;;) {
    while (at_ != end_ && is_space(*at_)) {
      if (*at_++ == '\n') {
        ++line_;
        line_begin_ = at_;
      }
    }
    if (at_ == end_ || *at_ != '#') break;
    while (at_ != end_ && *at_ != '\n' && *at_ != '\r') ++at_;
  }
  const FilePosition place = place_at(at_);
  if (at_ == end_) return {Token::Kind::kEnd, {}, place};
  if (*at_ == '"') return string();
  const char* begin = at_++;
  if (*begin == '[') return {Token::Kind::kOpen, {begin, 1}, place};
  if (*begin == ']') return {Token::Kind::kClose, {begin, 1}, place};
  while (at_ != end_ && !ends_word(*at_)) ++at_;
  return {Token::Kind::kWord, {begin, static_cast<std::size_t>(at_ - begin)}, place};
}

std::size_t Tokenizer::words_ahead() const {
  std::size_t words = 0;
  bool in_word = false;
  for (const char* at = at_; at != end_; ++at) {
    if (!in_word && *at == '#') {
      while (at != end_ && *at != '\n' && *at != '\r') ++at;
      if (at == end_) break;
    }
    if (ends_word(*at) && !is_space(*at)) break;
    words += !in_word && !is_space(*at);
    in_word = !is_space(*at);
  }
  return words;
}

Token Tokenizer::string() {
  const FilePosition place = place_at(at_);
  const char* begin = ++at_;
  while (at_ != end_ && *at_ != '"' && *at_ != '\n') {
    if (*at_ == '\\' && at_ + 1 != end_) ++at_;
    ++at_;
  }
  if (at_ == end_ || *at_ != '"') fail(place, "expected '\"' at the end of this string");
  return {Token::Kind::kString, {begin, static_cast<std::size_t>(at_++ - begin)}, place};
}

}  // namespace lucerna::pbrt
