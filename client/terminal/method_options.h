// Options for the methods of a computation.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/terminal/validators.h"
#include "lucerna/v1/accuracy.pb.h"
#include "proto/common/defaults.h"

namespace lucerna::cli {

/// One of several methods, by name.  The default "automatic" leaves the choice to the server.
template <typename Way>
class WayOption {
 public:
  WayOption(const char* flag, const char* help, std::vector<std::pair<const char*, Way>> ways)
      : flag_(flag), help_(help), ways_(std::move(ways)) {}

  void add(CLI::App& command) {
    std::vector<std::string> names = {"automatic"};
    for (const auto& [name, way] : ways_) names.emplace_back(name);
    command.add_option(flag_, name_, std::string(help_) + "; default: automatic")
        ->check(one_of(names));
  }

  /// Nothing if the server chooses.
  std::optional<Way> way() const {
    for (const auto& [name, way] : ways_)
      if (name_ == name) return way;
    return std::nullopt;
  }

 private:
  const char* flag_;
  const char* help_;
  std::vector<std::pair<const char*, Way>> ways_;
  std::string name_ = "automatic";
};

/// A method option that a command may have without the others.  `kSet` sets the method in a
/// request.
template <typename Way, void (v1::Accuracy::*kSet)(Way)>
class LoneWayOption : public WayOption<Way> {
 public:
  using WayOption<Way>::WayOption;

  /// Sets the methods that are given; the others leave the request unchanged.
  template <typename Request>
  void put(Request& request) const {
    if (const auto way = this->way()) (request.mutable_accuracy()->*kSet)(*way);
  }
};

/// --area-sampling, for commands without the other methods.
struct AreaSamplingOption : LoneWayOption<v1::AreaSampling, &v1::Accuracy::set_area_sampling> {
  AreaSamplingOption()
      : LoneWayOption("--area-sampling", "How to choose points of area lights",
                      {{"square-root", v1::AREA_SAMPLING_SQUARE_ROOT},
                       {"kraemer", v1::AREA_SAMPLING_KRAEMER},
                       {"parallelogram", v1::AREA_SAMPLING_PARALLELOGRAM},
                       {"rejection", v1::AREA_SAMPLING_REJECTION},
                       {"low-distortion", v1::AREA_SAMPLING_LOW_DISTORTION},
                       {"solid-angle", v1::AREA_SAMPLING_SOLID_ANGLE},
                       {"cosine-solid-angle", v1::AREA_SAMPLING_COSINE_SOLID_ANGLE}}) {}
};

/// --light-selection, for commands that choose a light for each sample.
struct LightSelectionOption
    : LoneWayOption<v1::LightSelection, &v1::Accuracy::set_light_selection> {
  LightSelectionOption()
      : LoneWayOption("--light-selection", "How to choose the light of a sample",
                      {{"all", v1::LIGHT_SELECTION_ALL},
                       {"uniform", v1::LIGHT_SELECTION_UNIFORM},
                       {"power", v1::LIGHT_SELECTION_POWER},
                       {"bvh", v1::LIGHT_SELECTION_BVH}}) {}
};

/// The methods of single samples of light.
class SampleMethodOptions {
 public:
  void add(CLI::App& command) {
    area_sampling_.add(command);
    light_selection_.add(command);
    sampler_.add(command);
    visibility_.add(command);
  }

  /// Sets the methods that are given; the others leave the request unchanged.
  template <typename Request>
  void put(Request& request) const {
    area_sampling_.put(request);
    light_selection_.put(request);
    if (const auto way = sampler_.way()) request.mutable_accuracy()->set_sampler(*way);
    if (const auto way = visibility_.way()) request.mutable_accuracy()->set_visibility(*way);
  }

 private:
  AreaSamplingOption area_sampling_;
  LightSelectionOption light_selection_;
  WayOption<v1::Sampler> sampler_{
      "--sampler",
      "Generator of the sample values",
      {{"sobol", v1::SAMPLER_SOBOL}, {"independent", v1::SAMPLER_INDEPENDENT}}};
  WayOption<v1::Visibility> visibility_{
      "--visibility",
      "How to test whether lights are visible",
      {{"rays", v1::VISIBILITY_RAYS}, {"shadow-maps", v1::VISIBILITY_SHADOW_MAPS}}};
};

/// All methods, for estimates.
class MethodOptions {
 public:
  void add(CLI::App& command) {
    samples_.add(command);
    command
        .add_option("--samples-per-light", samples_per_light_,
                    "Points that each sample takes on a light; default: as in the scene file, or 1")
        ->check(whole(1, kMostSamplesPerLight));
    command
        .add_option("--far-light", far_light_radii_,
                    "Treat area lights farther away than this many radii as points; a radius is "
                    "half the diagonal of the light's bounding box; default: never")
        ->check(positive());
    combination_.add(command);
    closed_forms_.add(command);
  }

  /// Sets the methods that are given; the others leave the request unchanged.
  template <typename Request>
  void put(Request& request) const {
    samples_.put(request);
    if (samples_per_light_) request.mutable_accuracy()->set_samples_per_light(*samples_per_light_);
    if (far_light_radii_) request.mutable_accuracy()->set_far_light_radii(*far_light_radii_);
    if (const auto way = combination_.way()) request.mutable_accuracy()->set_combination(*way);
    if (const auto way = closed_forms_.way()) request.mutable_accuracy()->set_closed_forms(*way);
  }

 private:
  SampleMethodOptions samples_;
  std::optional<std::uint32_t> samples_per_light_;
  std::optional<double> far_light_radii_;
  WayOption<v1::Combination> combination_{
      "--combination",
      "How to combine samples of lights with samples of directions",
      {{"power-heuristic", v1::COMBINATION_POWER_HEURISTIC},
       {"balance-heuristic", v1::COMBINATION_BALANCE_HEURISTIC},
       {"lights", v1::COMBINATION_LIGHTS},
       {"surfaces", v1::COMBINATION_SURFACES}}};
  WayOption<v1::ClosedForms> closed_forms_{
      "--closed-forms",
      "Where to use closed forms of unoccluded light instead of samples",
      {{"off", v1::CLOSED_FORMS_OFF}, {"empty-shafts", v1::CLOSED_FORMS_EMPTY_SHAFTS}}};
};

}  // namespace lucerna::cli
