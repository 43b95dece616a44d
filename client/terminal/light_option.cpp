#include "client/terminal/light_option.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "client/terminal/validators.h"

namespace lucerna::cli {

CLI::Validator light_id_or_name() {
  return {[](std::string& text) -> std::string {
            if (text.empty()) return "empty, must be the id or the name of a light";
            // A mistyped id is not a name.
            return read_number(text) ? whole64(1)(text) : std::string();
          },
          "LIGHT"};
}

std::uint64_t light_id_of(const std::string& word) {
  std::uint64_t id = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  return error == std::errc() && end == word.data() + word.size() ? id : 0;
}

CLI::Option* LightOption::add(CLI::App& command, const std::string& help) {
  return command.add_option("--light", word_, help)->check(light_id_or_name());
}

}  // namespace lucerna::cli
