// Row 24: sums of very many samples and of very different fluxes, in the answers of queries.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "server/queries/receiver_irradiance.h"
#include "tests/extremes_sweep.h"
#include "tests/server/rpc/service_fixture.h"
#include "tests/server/scene/scenes.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

TEST(QuerySumsExtremes, IrradianceOfEqualSamples) {
  Sweep sweep(24, "a receiver under a sun so small that each sample is 0.1 lx",
              "1 ... 2^18 samples a block",
              "irradiance, in total, for each light and at a wavelength");
  SceneDescription d = description();
  // The cosine of its edge rounds to 1, so no other direction lies within it.
  d.lights = {{SunLightParams{{0, 0, 1}, 1e-9, Rgb(0.1)}, {"test.pbrt", 5, 1}}};
  const auto scene = build(d);
  const IrradiancePoint point{.position = {}, .position_error = {}, .normal = {0, 0, 1}};
  const std::vector<double> wavelengths_nm{550};
  double spectral = 0;  // of one sample
  for (int log = 0; log <= 18; log += 3)
    for (const std::uint32_t blocks : {1U, 3U}) {
      IrradianceSettings settings;
      settings.samples_per_block = 1U << log;
      settings.block_count = blocks;
      settings.bounces = 0;
      settings.per_light = true;
      settings.methods.closed_forms = ClosedForms::kOff;
      settings.wavelengths_nm = wavelengths_nm;
      const IrradianceResult result =
          estimate_irradiance(*scene, std::span(&point, 1), settings, {});
      EXPECT_FALSE(result.points[0].exact);
      if (log == 0 && blocks == 1) spectral = result.spectral[0];
      const std::string at = std::to_string(settings.samples_per_block);
      sweep.compare(result.points[0].irradiance_lx.g, 0.1, at);
      sweep.compare(result.per_light[0].irradiance_lx.b, 0.1, at + " of the light");
      sweep.compare(result.spectral[0], spectral, at + " at 550 nm");
      float textbook = 0;
      for (std::uint32_t i = 0; i < settings.samples_per_block; ++i) textbook += 0.1F;
      sweep.compare_textbook(textbook / static_cast<float>(settings.samples_per_block), 0.1);
    }
  EXPECT_GT(spectral, 0);
  sweep.expect_within(1e-15);
}

TEST(QuerySumsExtremes, TotalOfVeryDifferentFluxes) {
  Sweep sweep(24, "a light of 1e6 ... 1e30 cd, and 1000 lights of 4e-17 times its intensity",
              "exact and approximate", "total of EstimatePower");
  const TempDirectory folder;
  Service service(scenes_in(folder.path()));
  for (const double large : {1e6, 1e12, 1e18, 1e24, 1e30}) {
    const double small = 4e-17 * large;
    const auto light = [](double cd) {
      return fmt::format("LightSource \"point\" \"rgb I\" [{0} {0} {0}]\n", cd);
    };
    std::string text = "WorldBegin\n" + light(large);
    float textbook = 0;
    const auto flux = [](double cd) { return 4 * std::numbers::pi * cd; };
    textbook += static_cast<float>(flux(large));
    for (int i = 0; i < 1000; ++i) {
      text += light(small);
      textbook += static_cast<float>(flux(small));
    }
    const std::string name = fmt::format("{}.pbrt", large);
    std::ofstream(folder.path() / name) << text;
    auto request = about<v1::EstimatePowerRequest>(service.load(name));
    const double truth = flux(large * (1 + 4e-14));
    for (const auto method :
         {v1::EstimatePowerRequest::METHOD_EXACT, v1::EstimatePowerRequest::METHOD_APPROXIMATE}) {
      request.set_method(method);
      const auto answer = service.answer(request);
      sweep.compare(answer.total().rgb_lm().g(), truth, fmt::format("{} cd", large));
    }
    sweep.compare_textbook(textbook, truth);
  }
  sweep.expect_within(1e-15);
}

}  // namespace
}  // namespace lucerna::testing
