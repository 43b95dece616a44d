// The option --light: a light by its id or by its name.
#pragma once

#include <cstdint>
#include <string>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace lucerna::cli {

/// A whole number from 1, which is an id, or any other text that is no number, which is a name.
CLI::Validator light_id_or_name();
/// The id; 0 for a name.  `word`: a text that light_id_or_name() accepted.
std::uint64_t light_id_of(const std::string& word);

/// One light of a request.
class LightOption {
 public:
  CLI::Option* add(CLI::App& command, const std::string& help);
  bool given() const { return !word_.empty(); }
  /// The id or the name, as it was typed.
  const std::string& word() const { return word_; }
  /// Sets `light_id` or `light_name` if the option was given.
  template <class Request>
  void put(Request& request) const {
    if (const std::uint64_t id = light_id_of(word_); id != 0) {
      request.set_light_id(id);
    } else if (given()) {
      request.set_light_name(word_);
    }
  }

 private:
  std::string word_;
};

}  // namespace lucerna::cli
