// Parses scene files: directives, their parameters, and included files.
#pragma once

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "server/pbrt/pbrt_builder.h"
#include "server/pbrt/pbrt_token.h"

namespace lucerna::pbrt {

class Parser {
 public:
  Parser(LoadState& context, Builder& builder) : context_(context), builder_(builder) {}

  /// Reads `context.scene_file` and all files that it includes.
  void parse();

 private:
  struct OpenFile {
    const SharedText* name;
    std::string contents;
    Tokenizer tokens;
    bool imported;            ///< by Import: parameters end at its end
    LoadBudget::Share share;  ///< of the contents
  };

  void open(const FilePosition& place, const std::string& name, bool imported);
  /// The next token.  Its text is valid until the next call, since an included file is released at
  /// its end.
  Token next();
  void put_back(const Token& token) { put_back_ = token; }

  void directive(const Token& word);
  bool transform_directive(const Token& word);
  bool settings_directive(const Token& word);
  bool world_directive(const Token& word);

  double number(const std::string& directive);
  std::string string(const std::string& directive);
  Transform::Matrix matrix(const std::string& directive, const FilePosition& place);
  void concatenate(const std::optional<Transform>& transform, const std::string& directive,
                   const FilePosition& place);
  Parameters parameters();
  std::shared_ptr<Parameter> parameter(const Token& declaration);
  /// Makes room for a list of this many words.
  void reserve(Parameter& parameter, std::size_t words);
  /// Counts the memory of a long list.
  void hold(Parameter& parameter, std::uint64_t bytes) const;
  /// Adds value `index`, the next one.
  void value(const Token& token, std::size_t index, Parameter& parameter);

  LoadState& context_;
  Builder& builder_;
  std::map<std::string, SharedText> names_;  ///< file names, to which places point
  std::deque<OpenFile> files_;
  std::optional<Token> put_back_;
  std::uint64_t token_count_ = 0;
  absl::Status
      incomplete_;  ///< error of a directive that was skipped because its file is still missing
};

}  // namespace lucerna::pbrt
