#include "server/pbrt/parse_pbrt.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string_view>
#include <utility>

#include "server/files/printable.h"
#include "server/pbrt/older_pbrt.h"

namespace lucerna::pbrt {
namespace {

constexpr std::uint64_t kTokensPerPoll = 4096;
// A parameter takes far more memory than its shortest text.
constexpr std::size_t kMostParameters = 256;  // of one directive
// A string takes 16 times the memory of its shortest text.
constexpr std::size_t kMostStrings = 256;  // of one parameter

/// The values of a parameter whose type has lists of type `T`.
template <typename T>
T& list_of(Parameter& parameter) {
  T* list = std::get_if<T>(&parameter.values);
  return list != nullptr ? *list : parameter.values.emplace<T>();
}

}  // namespace

void Parser::parse() {
  open({}, context_.scene_file, true);
  for (;;) {
    const Token token = next();
    if (token.kind != Token::Kind::kEnd) {
      try {
        directive(token);
      } catch (const StatusError& failure) {
        // The file may still arrive.  Continue, so that all missing files are found at once.
        if (!absl::IsFailedPrecondition(failure.status())) throw;
        incomplete_ = failure.status();
      }
      continue;
    }
    // `next` stops at the end of imported files and of the first file.
    if (files_.size() == 1) {
      if (!incomplete_.ok()) throw StatusError(incomplete_);
      return builder_.finish(token.place);
    }
    builder_.import_end();
    files_.pop_back();
  }
}

void Parser::open(const FilePosition& place, const std::string& name, bool imported) {
  if (const std::uint64_t most = context_.meter.limits().max_include_depth; files_.size() >= most)
    fail(place, absl::ResourceExhaustedError(
                    fmt::format("files include each other more than {} deep, the limit of the "
                                "server",
                                most)));
  AssetContent content;
  if (files_.empty()) {
    auto read = context_.assets.read_unpacked(name);
    if (!read.ok()) fail(place, read.status());
    content = *std::move(read);
    context_.scene_file = content.name;
  } else {
    content = context_.read(place, name);
  }
  const SharedText* file = &names_.try_emplace(content.name, content.name).first->second;
  for (const OpenFile& open : files_)
    if (open.name == file) fail(place, fmt::format("file \"{}\" includes itself", file->str()));
  files_.push_back(
      {file, std::move(content.bytes), Tokenizer(file, {}), imported, std::move(content.share)});
  // Columns are counted without the mark, as in editors.
  const std::string_view contents = without_byte_order_mark(files_.back().contents);
  files_.back().tokens = Tokenizer(file, contents);
  // Without this check, the error would only report that the first byte is not a directive.
  const std::string_view start = contents.substr(0, 2);
  if (start == "\xff\xfe" || start == "\xfe\xff")
    fail({file, 1, 1}, "the file is UTF-16, expected UTF-8");
}

Token Parser::next() {
  if (put_back_) return *std::exchange(put_back_, std::nullopt);
  if (++token_count_ % kTokensPerPoll == 0) context_.poll();
  for (;;) {
    const Token token = files_.back().tokens.next();
    if (token.kind != Token::Kind::kEnd || files_.back().imported) {
      if (const std::uint64_t most = context_.meter.limits().max_tokens; token_count_ > most)
        fail(token.place, absl::ResourceExhaustedError(
                              fmt::format("more than {} words, strings and brackets in the scene's "
                                          "files, the limit of the server",
                                          most)));
      return token;
    }
    files_.pop_back();
  }
}

double Parser::number(const std::string& directive) {
  return pbrt::number(next(), "a number for " + directive, directive);
}

std::string Parser::string(const std::string& directive) {
  const Token token = next();
  if (token.kind != Token::Kind::kString)
    fail(token.place,
         fmt::format("expected a quoted string for {}, found {}", directive, described(token)));
  return unescaped(token);
}

Transform::Matrix Parser::matrix(const std::string& name, const FilePosition& place) {
  if (const Token token = next(); token.kind != Token::Kind::kOpen)
    fail(token.place, fmt::format("expected '[' after {}, found {}", name, described(token)));
  std::array<double, 16> n;
  for (double& value : n) value = number(name);
  if (const Token token = next(); token.kind != Token::Kind::kClose)
    fail(token.place,
         fmt::format("expected ']' after the 16 numbers of {}, found {}", name, described(token)));
  if (n[3] != 0 || n[7] != 0 || n[11] != 0 || n[15] == 0)
    fail(place, fmt::format("{} is not affine: its fourth, eighth and twelfth number must be "
                            "0, its last must not",
                            name));
  Transform::Matrix m;  // the file lists the columns one after the other
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) m[row][column] = n[4 * column + row] / n[15];
  return m;
}

void Parser::concatenate(const std::optional<Transform>& transform, const std::string& directive,
                         const FilePosition& place) {
  if (!transform) fail(place, fmt::format("this {} has no inverse", directive));
  builder_.concatenate(*transform);
}

Parameters Parser::parameters() {
  Parameters result;
  std::set<std::string_view> names;
  for (;;) {
    const Token token = next();
    if (token.kind != Token::Kind::kString) {
      put_back(token);
      return result;
    }
    if (result.size() == kMostParameters)
      fail(token.place, fmt::format("a directive with more than {} parameters, allowed: at most {}",
                                    kMostParameters, kMostParameters));
    auto read = parameter(token);
    if (!names.insert(read->name).second)
      fail(token.place, fmt::format("parameter \"{}\" is given twice", printable(read->name)));
    result.push_back(std::move(read));
  }
}

std::shared_ptr<Parameter> Parser::parameter(const Token& declaration) {
  const std::string text = unescaped(declaration);
  const std::size_t type_begin = text.find_first_not_of(" \t");
  const std::size_t type_end = text.find_first_of(" \t", type_begin);
  const std::size_t name_begin = text.find_first_not_of(" \t", type_end);
  if (type_begin == std::string::npos || name_begin == std::string::npos)
    fail(declaration.place,
         fmt::format("expected a parameter \"TYPE NAME\", found {}", described(declaration)));
  const std::string_view given = std::string_view(text).substr(type_begin, type_end - type_begin);
  const ParameterType* type = parameter_type(given);
  if (type == nullptr)
    fail(declaration.place,
         fmt::format("unknown parameter type \"{}\", expected one of float integer bool string "
                     "point2 vector2 point3 vector3 normal rgb spectrum blackbody texture{}",
                     printable(given), hint_of_older_pbrt("parameter type", given)));
  auto result = std::make_shared<Parameter>();
  result->type = type->name;
  const std::size_t name_end = text.find_first_of(" \t", name_begin);
  result->name = text.substr(
      name_begin, name_end == std::string::npos ? std::string::npos : name_end - name_begin);
  result->place = declaration.place;
  if (result->type == "rgb") result->primaries = builder_.colour_space();

  std::size_t count = 0;
  Token token = next();
  if (token.kind == Token::Kind::kOpen) {
    // A list that grows exists twice.
    reserve(*result, files_.back().tokens.words_ahead());
    for (token = next(); token.kind != Token::Kind::kClose; token = next()) {
      value(token, count++, *result);
      // A list grows if a part of it follows behind an included file.
      hold(*result, result->capacity_bytes());
    }
  } else {
    value(token, count++, *result);
  }
  const std::size_t per_item = type->values_per_item;
  if (count == 0 || (per_item > 1 && count % per_item != 0))
    fail(declaration.place,
         fmt::format("\"{} {}\" has {} values, expected {}{}", result->type,
                     printable(result->name), count, per_item > 1 ? "a multiple of " : "at least ",
                     per_item > 1 ? per_item : 1));
  return result;
}

void Parser::reserve(Parameter& parameter, std::size_t words) {
  const auto reserve = [&]<typename T>(std::vector<T>& list, std::size_t count) {
    hold(parameter, count * sizeof(T));
    list.reserve(count);
  };
  const std::string_view type = parameter.type;
  if (type == "point3" || type == "vector3" || type == "normal")
    reserve(parameter.values.emplace<Vectors>(), (words + 2) / 3);
  else if (type == "integer")
    reserve(parameter.values.emplace<Integers>(), words);
  else if (words > 0)
    reserve(parameter.values.emplace<Numbers>(), words);
}

void Parser::hold(Parameter& parameter, std::uint64_t bytes) const {
  constexpr std::uint64_t kLongBytes = 1 << 15;
  if (bytes < kLongBytes || bytes == parameter.share.bytes()) return;
  if (parameter.share.bytes() == 0) parameter.share = LoadBudget::Share(context_.meter.budget());
  LoadState::require(parameter.share.resize(bytes));
}

void Parser::value(const Token& token, std::size_t index, Parameter& parameter) {
  const std::string_view type = parameter.type;
  const auto reject = [&](const char* expected) {
    fail(token.place, fmt::format("expected {} or ']' for \"{} {}\", found {}", expected, type,
                                  printable(parameter.name), described(token)));
  };
  const bool is_word = token.kind == Token::Kind::kWord;
  const bool is_string = token.kind == Token::Kind::kString;
  if (type == "string" || type == "texture") {
    if (!is_string) reject("a quoted string");
    if (index == kMostStrings)
      fail(token.place, fmt::format("\"{} {}\" has more than {} strings, allowed: at most {}", type,
                                    printable(parameter.name), kMostStrings, kMostStrings));
    list_of<Strings>(parameter).push_back(unescaped(token));
  } else if (type == "bool") {
    if (!(is_word || is_string) || (token.text != "true" && token.text != "false"))
      reject("true or false");
    list_of<Numbers>(parameter).push_back(token.text == "true" ? 1 : 0);
  } else if (type == "spectrum" && is_string) {
    if (index > 0) reject("a number");
    list_of<Strings>(parameter).push_back(unescaped(token));
  } else {
    if (!is_word || !parameter.strings().empty() ||
        !(token.text.front() == '.' || token.text.front() == '-' || token.text.front() == '+' ||
          (token.text.front() >= '0' && token.text.front() <= '9')))
      reject(type == "integer" ? "an integer" : "a number");
    const double number = pbrt::number(token, "a number", type, parameter.name);
    if (type == "integer") {
      if (number != std::floor(number) || number < -2147483648.0 || number > 2147483647.0)
        reject("an integer of 32 bits");
      list_of<Integers>(parameter).push_back(
          static_cast<std::uint32_t>(static_cast<std::int32_t>(number)));
    } else if (type == "point3" || type == "vector3" || type == "normal") {
      Vectors& vectors = list_of<Vectors>(parameter);
      if (index % 3 == 0) vectors.emplace_back(number, 0.0, 0.0);
      if (index % 3 == 1) vectors.back().y = number;
      if (index % 3 == 2) vectors.back().z = number;
    } else {
      list_of<Numbers>(parameter).push_back(number);
    }
  }
}

void Parser::directive(const Token& word) {
  if (word.kind == Token::Kind::kWord &&
      (transform_directive(word) || settings_directive(word) || world_directive(word)))
    return;
  fail(word.place, fmt::format("expected a directive, found {}{}", described(word),
                               hint_of_older_pbrt("directive", word.text)));
}

}  // namespace lucerna::pbrt
