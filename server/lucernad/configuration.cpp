#include "server/lucernad/configuration.h"

#include <absl/strings/str_split.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <string_view>

#include "server/lucernad/configuration_file.h"

namespace lucerna::config {
namespace {

constexpr std::string_view kPrefix = "LUCERNAD_";
// Names the configuration file, and is no setting of the file itself.
constexpr char kFileVariable[] = "LUCERNAD_CONFIG";

/// The texts of an environment variable.
std::vector<std::string> split(const Setting& setting, const std::string& text) {
  if (!std::holds_alternative<Texts>(setting.value)) return {text};
  std::vector<std::string> texts = absl::StrSplit(text, ',');
  if (texts.back().empty()) texts.pop_back();
  return texts;
}

}  // namespace

Configuration configure(const Given& given) {
  Configuration result;
  const std::vector<Setting> all = settings(result.options);
  std::map<std::string, std::string> sources;
  const auto take = [&](const Setting& setting, const std::vector<std::string>& texts,
                        const std::string& source, const std::string& where) {
    const absl::Status status = set(setting, texts);
    if (status.ok()) {
      sources[setting.name] = source;
    } else {
      result.errors.push_back(fmt::format("{} = {}", where, std::string(status.message())));
    }
  };

  // From the weakest source to the strongest.  Values that another source overrides are checked
  // too, since they may hold at the next start.
  const auto variable = given.environment.find(kFileVariable);
  std::string file = given.file;
  if (file.empty() && variable != given.environment.end()) file = variable->second;
  if (!file.empty()) {
    FileContent content = read_file(file, all);
    result.errors = std::move(content.errors);
    for (const FileValue& value : content.values) {
      take(*value.setting, value.texts, value.place,
           fmt::format("{}: {}", value.place, value.setting->name));
    }
  }
  std::set<std::string> known = {kFileVariable};
  for (const Setting& setting : all) {
    const std::string name = environment_name(setting);
    known.insert(name);
    const auto found = given.environment.find(name);
    if (found != given.environment.end()) take(setting, split(setting, found->second), name, name);
  }
  for (const auto& [name, value] : given.environment) {
    if (!known.contains(name)) result.warnings.push_back(fmt::format("{}: no such setting", name));
  }
  for (const Setting& setting : all) {
    const auto found = given.flags.find(setting.name);
    if (found != given.flags.end()) {
      take(setting, found->second, flag_name(setting), flag_name(setting));
    }
  }

  for (const Setting& setting : all) {
    const auto source = sources.find(setting.name);
    result.held.push_back({setting.name, text_of(setting),
                           source == sources.end() ? "default" : source->second, setting.reloads});
  }
  AssetStoreOptions& assets = result.options.server.assets;
  assets.stall_time = std::chrono::seconds(result.options.upload_timeout_s);
  assets.keep_parts = std::chrono::seconds(result.options.keep_partial_uploads_s);
  return result;
}

std::map<std::string, std::string> environment() {
  std::map<std::string, std::string> found;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::size_t equals = text.find('=');
    if (!text.starts_with(kPrefix) || equals == std::string_view::npos) continue;
    found.emplace(text.substr(0, equals), text.substr(equals + 1));
  }
  return found;
}

std::string describe(const Configuration& configuration) {
  std::size_t names = 0, values = 0;
  for (const Held& held : configuration.held) {
    names = std::max(names, held.name.size());
    values = std::max(values, held.value.size());
  }
  std::string text;
  for (const Held& held : configuration.held) {
    text += fmt::format("{:{}}  {:{}}  {}\n", held.name, names, held.value, values, held.source);
  }
  return text;
}

}  // namespace lucerna::config
