// --area-sampling: the ways to choose points of area lights, by name.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::cli {

struct AreaSamplingOption {
  void add(CLI::App& command) {
    const std::map<std::string, v1::AreaSampling> names = {
        {"automatic", v1::AREA_SAMPLING_UNSPECIFIED},
        {"square-root", v1::AREA_SAMPLING_SQUARE_ROOT},
        {"kraemer", v1::AREA_SAMPLING_KRAEMER},
        {"parallelogram", v1::AREA_SAMPLING_PARALLELOGRAM},
        {"rejection", v1::AREA_SAMPLING_REJECTION},
        {"low-distortion", v1::AREA_SAMPLING_LOW_DISTORTION},
        {"solid-angle", v1::AREA_SAMPLING_SOLID_ANGLE},
        {"cosine-solid-angle", v1::AREA_SAMPLING_COSINE_SOLID_ANGLE}};
    command
        .add_option("--area-sampling", way_,
                    "How points of area lights are chosen; default: automatic")
        ->transform(CLI::CheckedTransformer(names).description(
            "{automatic,square-root,kraemer,parallelogram,rejection,low-distortion,solid-angle,"
            "cosine-solid-angle}"));
  }

  /// Leaves a request that asks for nothing as it is.
  template <typename Request>
  void put(Request& request) const {
    if (way_ != v1::AREA_SAMPLING_UNSPECIFIED) request.mutable_accuracy()->set_area_sampling(way_);
  }

 private:
  v1::AreaSampling way_ = v1::AREA_SAMPLING_UNSPECIFIED;
};

}  // namespace lucerna::cli
