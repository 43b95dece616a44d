#include "client/terminal/method_options.h"

#include <CLI/CLI.hpp>

#include "client/terminal/validators.h"
#include "lucerna/v1/lighting.pb.h"
#include "proto/common/defaults.h"

namespace lucerna::cli {

void MethodOption::add(CLI::App& command) {
  std::vector<std::string> names = {"automatic"};
  for (const auto& [name, number] : methods_) names.emplace_back(name);
  command.add_option(flag_, name_, std::string(help_) + "; default: automatic")
      ->check(one_of(names));
}

std::optional<int> MethodOption::number() const {
  for (const auto& [name, number] : methods_)
    if (name_ == name) return number;
  return std::nullopt;
}

void SampleMethodOptions::add(CLI::App& command) {
  area_sampling_.add(command);
  light_selection_.add(command);
  sampler_.add(command);
  visibility_.add(command);
  thin_glass_.add(command);
}

void MethodOptions::add(CLI::App& command) {
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

v1::Accuracy methods_of(const std::vector<std::string>& flags) {
  CLI::App app;
  MethodOptions options;
  options.add(app);
  // CLI11 needs the arguments in reverse order.
  app.parse(std::vector<std::string>(flags.rbegin(), flags.rend()));
  v1::EstimateIrradianceRequest request;
  options.put(request);
  return request.accuracy();
}

}  // namespace lucerna::cli
