#include "client/tradeoff/settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "client/terminal/method_options.h"

namespace lucerna::tradeoff {
namespace {

using Flags = std::vector<std::string>;

const std::vector<Flags> kAreaSamplings = {
    {"--area-sampling", "square-root"},
    {"--area-sampling", "low-distortion"},
    {"--area-sampling", "solid-angle"},
    {"--area-sampling", "cosine-solid-angle"},
};
const std::vector<Flags> kLightSelections = {
    {"--light-selection", "all"},
    {"--light-selection", "uniform"},
    {"--light-selection", "power"},
    {"--light-selection", "bvh"},
};
const std::vector<Flags> kEstimates = {
    {"--closed-forms", "off"},
    {"--closed-forms", "empty-shafts"},
    {"--combination", "balance-heuristic"},
    {"--combination", "lights"},
    {"--combination", "surfaces"},
    {"--sampler", "independent"},
    {"--samples-per-light", "1"},
    {"--samples-per-light", "4"},
    {"--far-light", "5"},
    {"--visibility", "shadow-maps"},
    {"--thin-glass", "blocks"},
};
// Methods of samples of light that are neither about the choice of a light nor of a point.
const std::vector<Flags> kOfSamples = {
    {"--sampler", "independent"},
    {"--visibility", "shadow-maps"},
    {"--thin-glass", "blocks"},
};
// The gain of closed forms depends on whether each sample takes all lights or one light.
const std::vector<Flags> kPairs = {
    {"--light-selection", "all", "--closed-forms", "off"},
    {"--light-selection", "all", "--closed-forms", "empty-shafts"},
    {"--light-selection", "bvh", "--closed-forms", "off"},
    {"--light-selection", "bvh", "--closed-forms", "empty-shafts"},
};
// Methods that sample by area, since the visible shares of their samples estimate the same
// quantity.
const std::vector<Flags> kByArea = {
    {"--area-sampling", "square-root"},
    {"--area-sampling", "kraemer"},
    {"--area-sampling", "parallelogram"},
    {"--area-sampling", "low-distortion"},
};

}  // namespace

const std::vector<std::string>& query_names() {
  static const std::vector<std::string> names = {"irradiance", "render", "sample", "power",
                                                 "visibility"};
  return names;
}

std::string name(Query query) { return query_names()[static_cast<std::size_t>(query)]; }

std::string Setting::name() const {
  std::string result;
  for (const std::string& flag : flags) {
    const bool option = flag.starts_with("--");
    if (!result.empty()) result += option ? " + " : " ";
    result += option ? flag.substr(2) : flag;
  }
  if (result.empty()) result = "automatic";
  return by_target ? result + ", by target error" : result;
}

std::string Amount::text() const {
  if (target) return fmt::format("error {:g}%", 100 * value);
  return fmt::format("{:.0f} {}", value, value == 1 ? "sample" : "samples");
}

std::string Amount::flags() const {
  return target ? fmt::format("--error {:g}%", 100 * value)
                : fmt::format("--samples {:.0f}", value);
}

Setting make_setting(std::vector<std::string> flags, bool by_target) {
  v1::Accuracy accuracy = cli::methods_of(flags);
  return {.flags = std::move(flags), .accuracy = std::move(accuracy), .by_target = by_target};
}

std::vector<Setting> settings(Query query, const SceneFacts& facts) {
  std::vector<Setting> result = {make_setting({})};
  const auto add = [&](const std::vector<Flags>& more) {
    for (const Flags& flags : more) {
      // With a single light there is nothing to select.
      const bool chooses =
          std::find(flags.begin(), flags.end(), "--light-selection") != flags.end();
      if (!chooses || facts.lights > 1) result.push_back(make_setting(flags));
    }
  };
  switch (query) {
    case Query::kIrradiance:
    case Query::kRender:
      result.push_back(make_setting({}, true));
      add(kLightSelections);
      add(kEstimates);
      add(kAreaSamplings);
      add(kPairs);
      break;
    case Query::kSample:
      result.push_back(make_setting({}, true));
      add(kLightSelections);
      add(kAreaSamplings);
      add(kOfSamples);
      break;
    case Query::kVisibility:
      add(kLightSelections);
      add(kByArea);
      add(kOfSamples);
      break;
    case Query::kPower:
      break;
  }
  return result;
}

std::vector<Amount> amounts(const Setting& setting, std::uint32_t max_samples) {
  if (setting.by_target) {
    std::vector<Amount> result;
    for (const double error : {0.3, 0.1, 0.03, 0.01, 0.003, 0.001}) {
      result.push_back({.target = true, .value = error});
    }
    return result;
  }
  std::vector<Amount> result;
  for (double samples = 1; samples <= max_samples; samples *= 4) {
    result.push_back({.target = false, .value = samples});
  }
  return result;
}

}  // namespace lucerna::tradeoff
