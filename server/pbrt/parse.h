// The syntax of scene files: directives, their parameters, and the files that files include.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "server/pbrt/builder.h"
#include "server/pbrt/token.h"

namespace lucerna::pbrt {

class Parser {
 public:
  Parser(Context& context, Builder& builder) : context_(context), builder_(builder) {}

  /// Reads `context.scene_file` and all that it includes.
  void parse();

 private:
  struct OpenFile {
    const std::string* name;
    std::string contents;
    Tokenizer tokens;
    bool imported;  ///< by Import: parameters do not go on beyond its end
  };

  void open(const Place& place, const std::string& name, bool imported);
  /// The token's text is good until the next call: an included file goes when its end is met.
  Token next();
  void put_back(const Token& token) { put_back_ = token; }

  void directive(const Token& word);
  bool transform_directive(const Token& word);
  bool settings_directive(const Token& word);
  bool world_directive(const Token& word);

  double number(const std::string& directive);
  std::string string(const std::string& directive);
  Transform::Matrix matrix(const std::string& directive, const Place& place);
  void concatenate(const std::optional<Transform>& transform, const std::string& directive,
                   const Place& place);
  Parameters parameters();
  std::shared_ptr<const Parameter> parameter(const Token& declaration);
  void value(const Token& token, Parameter& parameter);

  Context& context_;
  Builder& builder_;
  std::deque<std::string> names_;  ///< of files; places point to them
  std::deque<OpenFile> files_;
  std::optional<Token> put_back_;
  std::uint64_t token_count_ = 0;
  absl::Status incomplete_;  ///< of a directive that was left out, as its file is not there yet
};

}  // namespace lucerna::pbrt
