#include "client/tradeoff/question.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "absl/strings/str_replace.h"

namespace lucerna::tradeoff {
namespace {

// Automatic samples every light of a scene with fewer lights (DirectLight::kFewLights).
constexpr std::uint64_t kManyLights = 21;

struct Selection {
  v1::LightSelection selection;
  const char* words;
};

/// The selections to try, in this order, as long as there is time.
std::vector<Selection> reference_selections(std::uint64_t lights) {
  const Selection all{v1::LIGHT_SELECTION_ALL, "every light, "};
  const Selection power{v1::LIGHT_SELECTION_POWER, "one light by power, "};
  const Selection tree{v1::LIGHT_SELECTION_BVH, "one light by the light BVH, "};
  const Selection chance{v1::LIGHT_SELECTION_UNIFORM, "one light uniformly, "};
  if (lights < 2) return {{v1::LIGHT_SELECTION_ALL, ""}};
  if (lights < kManyLights) return {all, power, chance};
  return {power, tree, all, chance};
}

}  // namespace

v1::Accuracy reference_accuracy(std::size_t way, std::uint64_t lights) {
  v1::Accuracy accuracy;
  accuracy.set_sampler(v1::SAMPLER_INDEPENDENT);
  accuracy.set_combination(v1::COMBINATION_BALANCE_HEURISTIC);
  accuracy.set_area_sampling(v1::AREA_SAMPLING_LOW_DISTORTION);
  accuracy.set_closed_forms(v1::CLOSED_FORMS_OFF);
  accuracy.set_visibility(v1::VISIBILITY_RAYS);
  accuracy.set_light_selection(reference_selections(lights)[way].selection);
  return accuracy;
}

std::vector<ReferenceWay> reference_ways_for(std::uint64_t lights) {
  std::vector<ReferenceWay> ways;
  for (const auto& [selection, words] : reference_selections(lights)) {
    ways.push_back({.words = words + std::string("independent samples, points by area (low "
                                                 "distortion), balance heuristic, no closed "
                                                 "forms, exact rays"),
                    .checked = selection == v1::LIGHT_SELECTION_BVH});
  }
  return ways;
}

std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("_-./:@%+=,", c);
  });
  if (plain) return word;
  return fmt::format("'{}'", absl::StrReplaceAll(word, {{"'", "'\\''"}}));
}

std::string command_line(const QuestionOptions& options, const std::string& command,
                         const std::string& rest) {
  const std::string server =
      options.server.empty() ? "" : " --server " + shell_word(options.server);
  return fmt::format("lucerna {} {}{}{}", command, shell_word(options.scene), rest, server);
}

std::string for_which_server(const Amount& amount, double most, const std::string& option) {
  if (amount.target || amount.value <= most) return "";
  return "  # needs a server with a larger " + option;
}

std::string join_flags(const Setting& setting, const Amount& amount) {
  std::string result = fmt::format(" {}", amount.flags());
  for (const std::string& flag : setting.flags) result += " " + flag;
  return result;
}

std::string floor_flag(const Amount& amount, double dark) {
  if (!amount.target || !(dark * amount.value > 0)) return "";
  return fmt::format(" --floor {:.3g}", dark * amount.value);
}

v1::Accuracy accuracy_of(const Setting& setting, const Amount& amount, double floor) {
  v1::Accuracy accuracy = setting.accuracy;
  if (amount.target) {
    accuracy.mutable_target_error()->set_relative(amount.value);
    accuracy.mutable_target_error()->set_absolute_floor(floor);
  } else {
    accuracy.set_samples(static_cast<std::uint32_t>(amount.value));
  }
  return accuracy;
}

double rays_of(const v1::Cost& cost) {
  return static_cast<double>(cost.camera_rays() + cost.indirect_rays() + cost.shadow_rays());
}

}  // namespace lucerna::tradeoff
