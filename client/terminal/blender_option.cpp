#include "client/terminal/blender_option.h"

#include <CLI/CLI.hpp>
#include <utility>
#include <vector>

#include "client/terminal/validators.h"
#include "proto/common/defaults.h"

namespace lucerna::cli {
namespace {

constexpr std::pair<const char*, v1::BlenderLightingMode> kModes[] = {
    {"standard", v1::BLENDER_LIGHTING_MODE_STANDARD},
    {"unitless", v1::BLENDER_LIGHTING_MODE_UNITLESS},
    {"raw", v1::BLENDER_LIGHTING_MODE_RAW}};

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

}  // namespace lucerna::cli
