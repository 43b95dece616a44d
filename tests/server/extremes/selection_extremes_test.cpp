// Lights at infinity beside local ones: every light is chosen, however large the scene is.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/sampling/sobol.h"
#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/extremes_sweep.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

constexpr LightSelection kWays[] = {LightSelection::kAutomatic, LightSelection::kUniform,
                                    LightSelection::kPower, LightSelection::kBvh};

/// `lamps` lamps of 10 cd in a row 2 m above the floor, two skies, a sun and a distant light.
SceneDescription lamps_and_skies(int lamps) {
  SceneDescription d = description(0);
  d.shapes = {floor(2)};
  for (int i = 0; i < lamps; ++i) d.lights.push_back(point_light({0.1 * i - 0.5, 0, 2}, 10));
  d.lights.push_back({UniformInfiniteLightParams{Rgb(1)}, {}});
  d.lights.push_back({UniformInfiniteLightParams{Rgb(0.5)}, {}});
  d.lights.push_back({SunLightParams{{0, 0.6, 0.8}, 0.01, Rgb(3)}, {}});
  d.lights.push_back({DistantLightParams{{0, 0, 1}, Rgb(2)}, {}});
  return d;
}

Receiver on_floor(const Scene& scene) {
  Receiver r(Vec3{0.2, 0.1, 0} - scene.origin());
  r.normal = {0, 0, 1};
  return r;
}

TEST(SelectionExtremes, EachOfSeveralInfiniteLightsIsSampled) {
  Sweep sweep(17, "two skies, a sun and a distant light, with 4 or 20 lamps",
              "every way to choose a light", "sum of all lights' probabilities");
  for (const int lamps : {4, 20}) {
    const auto scene = build(lamps_and_skies(lamps));
    const Receiver receiver = on_floor(*scene);
    const auto lights = static_cast<std::uint32_t>(scene->lights().size());
    for (const LightSelection how : kWays) {
      const std::string way =
          std::to_string(lamps) + " lamps, way " + std::to_string(static_cast<int>(how));
      double sum = 0;
      for (std::uint32_t l = 0; l < lights; ++l) {
        const double p = scene->lights().selector().probability(how, receiver, l);
        // At least a hundredth of the choices where there are two dozen lights.
        EXPECT_GT(p, 0.01) << l << ", " << way;
        sum += p;
      }
      sweep.compare(sum, 1, way);
      std::vector<int> found(lights);
      for (int i = 0; i < 4096; ++i)
        if (const auto choice = scene->lights().choose(how, receiver, (i + 0.5) / 4096))
          ++found[choice->light];
      for (std::uint32_t l = 0; l < lights; ++l) EXPECT_GT(found[l], 0) << l << ", " << way;
    }
  }
  sweep.expect_within(1e-12);
}

TEST(SelectionExtremes, AllLightOfInfiniteAndLocalLightsArrives) {
  Sweep sweep(17, "the same lights on a floor", "every way to choose a light",
              "irradiance of 2^20 samples");
  for (const int lamps : {4, 20}) {
    const auto scene = build(lamps_and_skies(lamps));
    double truth = 1.5 * std::numbers::pi + 3 * 0.8 + 2;  // of a sun of 0.01 rad, off by 1e-6
    for (int i = 0; i < lamps; ++i)
      truth += 20 / std::pow(std::pow(0.1 * i - 0.7, 2) + 0.01 + 4, 1.5);
    for (const LightSelection how : kWays) {
      const IrradiancePoint point{
          Vec3{0.2, 0.1, 0} - scene->origin(), {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}};
      const IrradianceSettings settings{
          .samples_per_block = 1 << 16,
          .block_count = 16,
          .bounces = 0,
          .methods = {.light_selection = how, .closed_forms = ClosedForms::kOff}};
      sweep.compare(luminance(estimate_irradiance(*scene, std::span(&point, 1), settings, {})
                                  .points[0]
                                  .irradiance_lx),
                    truth,
                    std::to_string(lamps) + " lamps, way " + std::to_string(static_cast<int>(how)));
    }
  }
  sweep.expect_within(2e-3);
}

// One far stone can make the sphere of the scene, and so the flux of skies, arbitrarily large.
TEST(SelectionExtremes, OneFarObjectStarvesNoLight) {
  Sweep sweep(19, "an object far from a room of size 1", "1e2 ... 1e9 m",
              "probability of each light");
  for (const int lamps : {4, 20}) {
    const auto alone = build(lamps_and_skies(lamps));
    for (const double far : {1e2, 1e4, 1e6, 1e9}) {
      SceneDescription d = lamps_and_skies(lamps);
      d.shapes.push_back(floor(1, far));
      const auto scene = build(std::move(d));
      EXPECT_GT(scene->sphere().radius_m, far / 4);
      for (const LightSelection how : kWays)
        for (std::uint32_t l = 0; l < scene->lights().size(); ++l) {
          const double p = scene->lights().selector().probability(how, on_floor(*scene), l);
          const double without = alone->lights().selector().probability(how, on_floor(*alone), l);
          sweep.compare(p, without,
                        "light " + std::to_string(l) + ", way " +
                            std::to_string(static_cast<int>(how)) + ", " + std::to_string(far));
        }
    }
  }
  // Lamps are stored in doubles about a middle that is this far away.
  sweep.expect_within(1e-5);
}

}  // namespace
}  // namespace lucerna::testing
