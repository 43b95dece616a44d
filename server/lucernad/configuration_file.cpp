#include "server/lucernad/configuration_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <sstream>

#include "server/runtime/text_file.h"

namespace lucerna::config {
namespace {

std::string place_of(const std::string& path, const toml::source_region& region) {
  return fmt::format("{}:{}:{}", path, region.begin.line, region.begin.column);
}

std::string as_text(const toml::node& node) {
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return text.str();
}

/// The texts of a value that has a type of the setting; else nothing.
std::optional<std::vector<std::string>> texts_of(const Setting& setting, const toml::node& node) {
  if (std::holds_alternative<Texts>(setting.value)) {
    const toml::array* array = node.as_array();
    if (array == nullptr) return std::nullopt;
    std::vector<std::string> texts;
    for (const toml::node& element : *array) {
      if (!element.is_string()) return std::nullopt;
      texts.push_back(element.as_string()->get());
    }
    return texts;
  }
  if (std::holds_alternative<Switch>(setting.value)) {
    if (!node.is_boolean()) return std::nullopt;
    return {{node.as_boolean()->get() ? "true" : "false"}};
  }
  const bool text = std::holds_alternative<Text>(setting.value);
  const bool size = std::holds_alternative<Bytes>(setting.value);
  if (node.is_string()) {
    if (!text && !size) return std::nullopt;
    return {{node.as_string()->get()}};
  }
  if (node.is_integer() && !text) return {{fmt::format("{}", node.as_integer()->get())}};
  if (node.is_floating_point() && std::holds_alternative<Real>(setting.value)) {
    return {{fmt::format("{}", node.as_floating_point()->get())}};
  }
  return std::nullopt;
}

std::string type_of(const Setting& setting) {
  if (const auto* text = std::get_if<Text>(&setting.value); text != nullptr && text->names.empty())
    return "a text in quotes";
  if (std::holds_alternative<Texts>(setting.value))
    return "a list of texts, such as [\"a\", \"b\"]";
  return allowed(setting);
}

}  // namespace

FileContent read_file(const std::string& path, const std::vector<Setting>& settings) {
  FileContent content;
  const absl::StatusOr<std::string> text = read_text_file(path);
  if (!text.ok()) {
    content.errors.push_back(fmt::format("{}: {}", path, std::string(text.status().message())));
    return content;
  }
  toml::table table;
  try {
    table = toml::parse(*text, path);
  } catch (const toml::parse_error& error) {
    content.errors.push_back(
        fmt::format("{}: {}", place_of(path, error.source()), std::string(error.description())));
    return content;
  }
  // In the order of the file, not of the alphabet.
  std::vector<std::pair<const toml::key*, const toml::node*>> entries;
  for (const auto& [key, node] : table) entries.emplace_back(&key, &node);
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first->source().begin.line, a.first->source().begin.column) <
           std::pair(b.first->source().begin.line, b.first->source().begin.column);
  });
  for (const auto& [key, node] : entries) {
    const std::string name(key->str());
    const std::string place = place_of(path, key->source());
    const auto setting = std::find_if(settings.begin(), settings.end(),
                                      [&](const Setting& s) { return s.name == name; });
    if (setting == settings.end()) {
      content.errors.push_back(fmt::format(
          "{}: {}: no such setting; lucernad --help lists them, without the dashes", place, name));
      continue;
    }
    if (auto texts = texts_of(*setting, *node)) {
      content.values.push_back({&*setting, *std::move(texts), place});
    } else {
      content.errors.push_back(
          fmt::format("{}: {} = {}, allowed: {}", place, name, as_text(*node), type_of(*setting)));
    }
  }
  return content;
}

}  // namespace lucerna::config
