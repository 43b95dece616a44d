// Watts of lamps, and their spectra in ListLights and GetScene.
#include <gmock/gmock.h>

#include "spectra_fixture.h"

namespace lucerna::testing {
namespace {

// 683 lm/W at 555 nm.  The line is half a nanometre wide on either side, where the observer's table
// falls by 0.0050 in 5 nm.  The mean distance from a triangle's middle is a third of that width.
TEST_F(SpectraServiceTest, OneWattAt555NanometresIs683Lumens) {
  const v1::EstimatePowerResponse r =
      power(load("line.pbrt",
                 "WorldBegin LightSource \"point\" "
                 "\"spectrum I\" [554.5 0 555 1 555.5 0] \"float power\" 683"),
            {}, {554.5, 554.75, 555, 556});
  EXPECT_NEAR(r.lights(0).power_lm(), 683, 1e-4);
  const double mean_y = 1 - 0.5 / 3 * (1 - 0.995) / 5;
  EXPECT_NEAR(r.lights(0).power_w(), 1 / mean_y, 1e-5);
  EXPECT_EQ(r.total().power_w(), r.lights(0).power_w());
  // A triangle of area 1 W and base 1 nm is 2 W/nm high.
  EXPECT_EQ(r.total().spectral_w_per_nm(0), 0);
  EXPECT_NEAR(r.total().spectral_w_per_nm(1), 1 / mean_y, 1e-5);
  EXPECT_NEAR(r.total().spectral_w_per_nm(2), 2 / mean_y, 1e-5);
  EXPECT_EQ(r.total().spectral_w_per_nm(3), 0);
}

// Computed independently: Planck's law in SI units, 95.367062 lm/W.  The whole is a quadrature over
// 10 nm to 0.1 m (which agrees with the Stefan-Boltzmann law to 1e-14).  The visible part is by
// Simpson's rule at 0.1 nm, with the observer's table as a cubic spline.
TEST_F(SpectraServiceTest, ABlackBodyOf6504KelvinGives95LumensAWatt) {
  for (const auto method :
       {v1::EstimatePowerRequest::METHOD_EXACT, v1::EstimatePowerRequest::METHOD_APPROXIMATE}) {
    const v1::EstimatePowerResponse r = power(lamps_, {kBlackBodySphere}, {}, method);
    const v1::LightPower& light = r.lights(0);
    EXPECT_NEAR(light.power_lm() / light.power_w(), 95.36706223, 95 * 1e-6);
    EXPECT_EQ(r.total().power_w(), light.power_w());
  }
}

TEST_F(SpectraServiceTest, WattsAreTheIntegralOfTheSpectralFlux) {
  // Linear between the four, so that trapezoids are exact.
  const v1::LightPower light = power(lamps_, {kSampled}, {400, 500, 600, 700}).lights(0);
  const auto& w = light.spectral_w_per_nm();
  EXPECT_NEAR(100 * (w[0] / 2 + w[1] + w[2] + w[3] / 2), light.power_w(), 1e-9 * light.power_w());
  EXPECT_NEAR(light.power_lm(), 4 * kPi, 1e-5);
}

TEST_F(SpectraServiceTest, TotalsHaveWattsWhereAllLightsHave) {
  const v1::EstimatePowerResponse all = power(lamps_, {}, {555});
  ASSERT_EQ(all.lights_size(), 6);
  for (const int id : {kBlackBody, kSampled, kF2, kBlackBodySphere})
    EXPECT_TRUE(all.lights(id - 1).has_power_w()) << id;
  for (const int id : {kRgb, kRgbSphere}) EXPECT_FALSE(all.lights(id - 1).has_power_w()) << id;
  EXPECT_FALSE(all.total().has_power_w());
  double sum = 0;
  for (const auto& light : all.lights()) sum += light.spectral_w_per_nm(0);
  EXPECT_NEAR(all.total().spectral_w_per_nm(0), sum, 1e-12 * sum);
  const v1::EstimatePowerResponse two = power(lamps_, {kBlackBody, kF2});
  EXPECT_NEAR(two.total().power_w(), two.lights(0).power_w() + two.lights(1).power_w(), 1e-12);
  EXPECT_EQ(two.total().spectral_w_per_nm_size(), 0);
  EXPECT_FALSE(power(load("dark.pbrt", "WorldBegin")).total().has_power_w());
}

TEST_F(SpectraServiceTest, ListLightsReportsSpectraAndWatts) {
  const auto r = service_.answer(about<v1::ListLightsRequest>(lamps_));
  ASSERT_EQ(r.lights_size(), 6);
  EXPECT_EQ(r.lights(kBlackBody - 1).spectrum().black_body_k(), 3000);
  EXPECT_EQ(r.lights(kF2 - 1).spectrum().illuminant(), "F2");
  const v1::SampledSpectrum& sampled = r.lights(kSampled - 1).spectrum().sampled();
  EXPECT_THAT(sampled.wavelengths_nm(), ::testing::ElementsAre(400, 500, 600, 700));
  EXPECT_THAT(sampled.values(), ::testing::ElementsAre(1, 2, 4, 2));
  EXPECT_EQ(r.lights(kBlackBodySphere - 1).spectrum().black_body_k(), 6504);
  const v1::EstimatePowerResponse flux = power(lamps_);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(r.lights(i).has_power_w(), r.lights(i).has_spectrum()) << i;
    EXPECT_EQ(r.lights(i).power_w(), flux.lights(i).power_w()) << i;
  }
  EXPECT_FALSE(r.lights(kRgb - 1).has_spectrum());
  EXPECT_FALSE(r.lights(kRgbSphere - 1).has_spectrum());
}

TEST_F(SpectraServiceTest, PagesOfLightsWithLongSpectraAreShort) {
  std::string table;
  for (int i = 0; i < 70000; ++i) table += std::to_string(300 + i / 100.0) + " 1\n";
  files_.write("long.spd", table);
  const std::string light = "LightSource \"point\" \"spectrum I\" \"long.spd\"\n";
  auto q = about<v1::ListLightsRequest>(load("long.pbrt", "WorldBegin\n" + light + light));
  auto r = service_.answer(q);
  ASSERT_EQ(r.lights_size(), 1);
  EXPECT_EQ(r.lights(0).spectrum().sampled().values_size(), 70000);
  q.set_page_token(r.next_page_token());
  r.Clear();
  r = service_.answer(q);
  ASSERT_EQ(r.lights_size(), 1);
  EXPECT_EQ(r.lights(0).id(), 2U);
  EXPECT_EQ(r.next_page_token(), "");
}

TEST_F(SpectraServiceTest, GetSceneListsSpectraOnlyIfThereAreAny) {
  const auto spectra = [&](const std::string& scene) {
    const auto r = service_.answer(about<v1::GetSceneRequest>(scene));
    std::vector<v1::ScenePart> found;
    for (const auto& part : r.parts())
      if (part.name() == "spectra") found.push_back(part);
    return found;
  };
  const auto found = spectra(lamps_);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].why(), "4 spectra of 4 lights");
  EXPECT_GT(found[0].bytes(),
            4 * 8 * sizeof(double));  // at least the samples with their wavelengths
  EXPECT_TRUE(
      spectra(load("rgb.pbrt", "WorldBegin LightSource \"point\" \"rgb I\" [1 2 3]")).empty());
}

}  // namespace
}  // namespace lucerna::testing
