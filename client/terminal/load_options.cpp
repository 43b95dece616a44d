#include "client/terminal/load_options.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "client/terminal/light_option.h"
#include "client/terminal/point_options.h"
#include "client/terminal/validators.h"
#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"

namespace lucerna::cli {
namespace {

constexpr std::pair<const char*, v1::BlenderLightingMode> kModes[] = {
    {"standard", v1::BLENDER_LIGHTING_MODE_STANDARD},
    {"unitless", v1::BLENDER_LIGHTING_MODE_UNITLESS},
    {"raw", v1::BLENDER_LIGHTING_MODE_RAW}};

absl::Status wrong_set(const std::string& given, const std::string& allowed) {
  return absl::InvalidArgumentError(fmt::format("--set \"{}\": {}", given, allowed));
}

/// One --set: LIGHT.FIELD=VALUE.  A name may have points and equals signs.
struct Setting {
  std::string light, field, value;
};

absl::StatusOr<Setting> parse(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const std::size_t point = equals == std::string::npos ? equals : text.rfind('.', equals);
  if (point == std::string::npos || point == 0)
    return wrong_set(text, "must be LIGHT.FIELD=VALUE, such as 3.scale=0.5");
  return Setting{text.substr(0, point), text.substr(point + 1, equals - point - 1),
                 text.substr(equals + 1)};
}

void put(const std::vector<double>& v, v1::Vector3* out) {
  out->set_x(v[0]);
  out->set_y(v[1]);
  out->set_z(v[2]);
}

absl::Status apply(const std::string& text, const Setting& setting, v1::LightChange& change) {
  const absl::StatusOr<std::vector<double>> numbers = parse_numbers(setting.value);
  const auto are = [&](std::size_t n) { return numbers.ok() && numbers->size() == n; };
  if (setting.field == "scale") {
    if (!are(1)) return wrong_set(text, "scale is a number");
    change.set_scale((*numbers)[0]);
  } else if (setting.field == "tint") {
    if (!are(3)) return wrong_set(text, "tint is three numbers R,G,B");
    change.mutable_tint()->set_r((*numbers)[0]);
    change.mutable_tint()->set_g((*numbers)[1]);
    change.mutable_tint()->set_b((*numbers)[2]);
  } else if (setting.field == "on") {
    if (setting.value != "true" && setting.value != "false")
      return wrong_set(text, "on is true or false");
    change.set_on(setting.value == "true");
  } else if (setting.field == "shift") {
    if (!are(3)) return wrong_set(text, "shift is three numbers X,Y,Z [m]");
    put(*numbers, change.mutable_placement()->mutable_shift_m());
  } else if (setting.field == "turn") {
    if (!are(4)) return wrong_set(text, "turn is an axis and an angle X,Y,Z,DEGREES");
    put(*numbers, change.mutable_placement()->mutable_turn_axis());
    change.mutable_placement()->set_turn_rad((*numbers)[3] * std::numbers::pi / 180);
  } else {
    return wrong_set(text, "the field must be scale, tint, on, shift or turn");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::uint64_t>> lights_of(const std::string& option,
                                                     const std::string& word,
                                                     const EditOption::Named& named) {
  if (const std::uint64_t id = light_id_of(word); id != 0) return std::vector{id};
  if (named != nullptr) return named(word);
  return absl::InvalidArgumentError(
      fmt::format("{} \"{}\": the light must be an id; use names with lucerna edit", option, word));
}

}  // namespace

void BlenderOption::add(CLI::App& app) {
  std::vector<std::string> modes;
  for (const auto& [name, mode] : kModes) modes.emplace_back(name);
  CLI::Option* const blender =
      app.add_option("--blender", mode_,
                     "When a .gltf or .glb file from Blender is loaded: the Lighting Mode with "
                     "which Blender exported it; turns its lights into cd, lx and cd/m2")
          ->check(one_of(modes));
  app.add_option("--lumens-per-watt", lumens_per_watt_,
                 "With --blender: the light of one of Blender's watts [lm]; default: 683")
      ->type_name("LM")
      ->check(checked_number("a number above 0, at most 1000000",
                             [](double v) { return v > 0 && v <= kMostLumensPerWatt; }))
      ->needs(blender);
}

std::optional<v1::BlenderLevels> BlenderOption::levels() const {
  if (mode_.empty()) return std::nullopt;
  v1::BlenderLevels levels;
  for (const auto& [name, mode] : kModes)
    if (mode_ == name) levels.set_mode(mode);
  if (lumens_per_watt_) levels.set_lumens_per_watt(*lumens_per_watt_);
  return levels;
}

void EditOption::add(CLI::App& app) {
  app.add_option("--set", sets_,
                 "When a scene file is loaded: change a light.  LIGHT.FIELD=VALUE with the fields "
                 "scale, tint=R,G,B, on=true|false, shift=X,Y,Z and turn=X,Y,Z,DEGREES; may be "
                 "repeated")
      ->type_name("EDIT")
      ->expected(1)
      ->take_all();
  app.add_option("--remove", removed_,
                 "When a scene file is loaded: remove this light; may be repeated")
      ->type_name("LIGHT")
      ->expected(1)
      ->take_all();
  app.add_option("--add", added_,
                 "When a scene file is loaded: add the lights of this scene file, a path under the "
                 "scene root; may be repeated")
      ->type_name("PATH")
      ->expected(1)
      ->take_all();
}

absl::StatusOr<EditOption::Edits> EditOption::edits(const Named& named) const {
  std::map<std::uint64_t, v1::LightChange> changes;
  for (const std::string& text : sets_) {
    LUCERNA_ASSIGN_OR_RETURN(const Setting setting, parse(text));
    LUCERNA_ASSIGN_OR_RETURN(const auto ids, lights_of("--set", setting.light, named));
    for (const std::uint64_t id : ids) {
      changes[id].set_light_id(id);
      LUCERNA_RETURN_IF_ERROR(apply(text, setting, changes[id]));
    }
  }
  Edits edits;
  for (auto& [id, change] : changes) *edits.Add()->mutable_change() = std::move(change);
  for (const std::string& word : removed_) {
    LUCERNA_ASSIGN_OR_RETURN(const auto ids, lights_of("--remove", word, named));
    for (const std::uint64_t id : ids) edits.Add()->set_remove(id);
  }
  for (const std::string& path : added_) edits.Add()->mutable_add()->set_path(path);
  return edits;
}

}  // namespace lucerna::cli
