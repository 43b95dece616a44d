// Options for the methods of a computation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lucerna/v1/accuracy.pb.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

/// One of several methods, by name.  The default "automatic" leaves the choice to the server.
class MethodOption {
 public:
  /// `methods`: names, and numbers of enumerators in the contract.
  MethodOption(const char* flag, const char* help, std::vector<std::pair<const char*, int>> methods)
      : flag_(flag), help_(help), methods_(std::move(methods)) {}

  void add(CLI::App& command);

 protected:
  /// Nothing if the server chooses.
  std::optional<int> number() const;

 private:
  const char* flag_;
  const char* help_;
  std::vector<std::pair<const char*, int>> methods_;
  std::string name_ = "automatic";
};

/// The same with the enumerators' type.
template <typename Way>
struct WayOption : MethodOption {
  using MethodOption::MethodOption;

  /// Nothing if the server chooses.
  std::optional<Way> way() const {
    if (const auto way = number()) return static_cast<Way>(*way);
    return std::nullopt;
  }
};

/// A method option that a command may have without the others.  `kSet` sets the method in a
/// request.
template <typename Way, void (v1::Accuracy::*kSet)(Way)>
struct LoneWayOption : WayOption<Way> {
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

/// --thin-glass, for commands that follow direct light.
struct ThinGlassOption : LoneWayOption<v1::ThinGlass, &v1::Accuracy::set_thin_glass> {
  ThinGlassOption()
      : LoneWayOption("--thin-glass", "Whether direct light passes smooth thin panes",
                      {{"passes", v1::THIN_GLASS_PASSES}, {"blocks", v1::THIN_GLASS_BLOCKS}}) {}
};

/// The methods of single samples of light.
class SampleMethodOptions {
 public:
  void add(CLI::App& command);

  /// Sets the methods that are given; the others leave the request unchanged.
  template <typename Request>
  void put(Request& request) const {
    area_sampling_.put(request);
    light_selection_.put(request);
    if (const auto way = sampler_.way()) request.mutable_accuracy()->set_sampler(*way);
    if (const auto way = visibility_.way()) request.mutable_accuracy()->set_visibility(*way);
    thin_glass_.put(request);
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
  ThinGlassOption thin_glass_;
};

/// All methods, for estimates.
class MethodOptions {
 public:
  void add(CLI::App& command);

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

/// The methods that options such as {"--sampler", "sobol"} choose.  Throws CLI::ParseError.
v1::Accuracy methods_of(const std::vector<std::string>& flags);

}  // namespace lucerna::cli
