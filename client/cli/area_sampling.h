// --area-sampling: the ways to choose points of area lights, by name.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/validators.h"
#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::cli {

class AreaSamplingOption {
 public:
  void add(CLI::App& command) {
    std::vector<std::string> names;
    for (const auto& [name, way] : kWays) names.emplace_back(name);
    command
        .add_option("--area-sampling", name_,
                    "How points of area lights are chosen; default: automatic")
        ->check(one_of(names));
  }

  /// Leaves a request that asks for nothing as it is.
  template <typename Request>
  void put(Request& request) const {
    for (const auto& [name, way] : kWays) {
      if (name_ == name && way != v1::AREA_SAMPLING_UNSPECIFIED) {
        request.mutable_accuracy()->set_area_sampling(way);
      }
    }
  }

 private:
  static constexpr std::array<std::pair<const char*, v1::AreaSampling>, 8> kWays = {
      {{"automatic", v1::AREA_SAMPLING_UNSPECIFIED},
       {"square-root", v1::AREA_SAMPLING_SQUARE_ROOT},
       {"kraemer", v1::AREA_SAMPLING_KRAEMER},
       {"parallelogram", v1::AREA_SAMPLING_PARALLELOGRAM},
       {"rejection", v1::AREA_SAMPLING_REJECTION},
       {"low-distortion", v1::AREA_SAMPLING_LOW_DISTORTION},
       {"solid-angle", v1::AREA_SAMPLING_SOLID_ANGLE},
       {"cosine-solid-angle", v1::AREA_SAMPLING_COSINE_SOLID_ANGLE}}};

  std::string name_ = "automatic";
};

}  // namespace lucerna::cli
