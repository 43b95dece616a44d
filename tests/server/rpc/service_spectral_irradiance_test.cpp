// Irradiance at wavelengths.
#include <gmock/gmock.h>

#include <functional>

#include "spectra_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

// The total at each wavelength is the sum of each light's share times its spectrum.  Lights 4 and 6
// are coloured and are requested as grey here.
TEST_F(SpectraServiceTest, IrradianceIsTheSumOverLightsOfEachShareTimesItsSpectrum) {
  std::string grey = kLamps;
  grey.replace(grey.find("[9 6 3]"), 7, "[6 6 6]");
  grey.replace(grey.find("[2 4 9]"), 7, "[4 4 4]");
  const std::vector<double> nm = {420, 555, 640, 1000};
  v1::EstimateIrradianceRequest q = irradiance_request(nm);
  q.set_scene_id(load("grey.pbrt", grey));
  q.set_per_light(true);
  const auto r = service_.answer(q);
  ASSERT_EQ(r.spectral_irradiance_size(), 2 * 4);
  const Spectrum f2 = *Spectrum::create(CieIlluminant{"F2"});
  const Spectrum d65 = *Spectrum::create(CieIlluminant{"D65"});
  const std::vector<std::function<double(double)>> spectra = {
      [](double l) { return planck_per_lumen(l, 3000); },
      [](double l) { return sampled_value(l) / sampled_lumens_per_unit(); },
      [&](double l) { return f2.per_lumen(l); },
      [&](double l) { return d65.per_lumen(l); },
      [](double l) { return planck_per_lumen(l, 6504); },
      [&](double l) { return d65.per_lumen(l); }};
  ASSERT_EQ(r.shares_size(), 6);
  for (int p = 0; p < 2; ++p) {
    for (int k = 0; k < 4; ++k) {
      double expected = 0;
      for (int l = 0; l < 6; ++l) {
        EXPECT_GT(r.shares(l).illuminance_lx(p), 0) << l;
        expected += r.shares(l).illuminance_lx(p) * spectra[static_cast<std::size_t>(l)](nm[k]);
      }
      EXPECT_NEAR(r.spectral_irradiance(4 * p + k), expected, 2e-6 * expected) << p << " " << k;
    }
  }
}

TEST_F(SpectraServiceTest, WavelengthsChangeNoOtherResult) {
  for (const std::string& scene : {lamps_, load("many.pbrt", many_lights())}) {
    v1::EstimateIrradianceRequest q = irradiance_request(table_nm());
    q.set_scene_id(scene);
    auto with = service_.answer(q);
    q.clear_wavelengths_nm();
    auto without = service_.answer(q);
    EXPECT_EQ(without.spectral_irradiance_size(), 0);
    with.clear_spectral_irradiance();
    with.clear_spectral_standard_error();
    with.clear_cost();
    without.clear_cost();
    EXPECT_EQ(with.SerializeAsString(), without.SerializeAsString());
  }

  v1::SampleLiRequest li = sample_request(kF2, {555});
  auto sampled = service_.answer(li);
  li.clear_wavelengths_nm();
  auto plain = service_.answer(li);
  sampled.clear_spectral_value();
  sampled.clear_cost();
  plain.clear_cost();
  EXPECT_EQ(sampled.SerializeAsString(), plain.SerializeAsString());
}

// More lights than are visited one by one.  The drawn lights have their own spectra.
TEST_F(SpectraServiceTest, IrradianceOfManyLightsIntegratesBackToItsIlluminance) {
  v1::EstimateIrradianceRequest q = irradiance_request(table_nm());
  q.set_scene_id(load("many.pbrt", many_lights()));
  const auto r = service_.answer(q);
  for (int p = 0; p < 2; ++p) {
    EXPECT_GT(r.illuminance_lx(p), 0);
    expect_looks_like(rgb(r.irradiance_lx(), p), r.spectral_irradiance(), p);
  }
}

TEST_F(SpectraServiceTest, ReflectedLightHasNoSpectrum) {
  v1::EstimateIrradianceRequest q = irradiance_request({555});
  q.clear_bounces();
  expect_bad_field(service_.status(q), "bounces");
  q.set_bounces(1);
  const grpc::Status s = service_.status(q);
  expect_bad_field(s, "bounces");
  EXPECT_THAT(s.error_message(), HasSubstr("surfaces have a colour and no spectrum"));
  q.set_bounces(0);
  EXPECT_TRUE(service_.status(q).ok());
}

}  // namespace
}  // namespace lucerna::testing
