// The spectra of lamps in each call.
#include "spectra_fixture.h"

namespace lucerna::testing {
namespace {

TEST_F(SpectraServiceTest, SampleLiOfLightsWithSpectraIsTheirLuminanceTimesTheSpectrum) {
  const std::vector<double> nm = {650, 400, 555, 100, 2000};
  auto r = service_.answer(sample_request(kBlackBody, nm));
  ASSERT_EQ(r.spectral_value_size(), 5);
  // 10 cd at 3 m.
  for (int k = 0; k < 5; ++k) {
    const double expected = 10.0 / 9 * planck_per_lumen(nm[k], 3000);
    EXPECT_NEAR(r.spectral_value(k), expected, 1e-6 * expected) << nm[k];
  }
  r = service_.answer(sample_request(kSampled, nm));
  // 1 cd; 3, 1 and 0 aside: the value does not include the cosine.
  for (int k = 0; k < 5; ++k) {
    const double expected = 0.1 * sampled_value(nm[k]) / sampled_lumens_per_unit();
    EXPECT_NEAR(r.spectral_value(k), expected, 1e-5 * expected) << nm[k];
  }
  ASSERT_TRUE(service_.call(sample_request(kF2, table_nm()), &r).ok());
  EXPECT_NEAR(summed(r.spectral_value()).y, 1, 1e-6);  // 1 lx
  // Chromaticity of F2: CIE 15, table T.6.
  const Vec3 xyz = summed(r.spectral_value());
  EXPECT_NEAR(xyz.x / (xyz.x + xyz.y + xyz.z), 0.3721, 1e-4);
  EXPECT_NEAR(xyz.y / (xyz.x + xyz.y + xyz.z), 0.3751, 1e-4);
}

TEST_F(SpectraServiceTest, RgbLightsIntegrateBackToTheirRgb) {
  const auto li = service_.answer(sample_request(kRgb, table_nm()));
  EXPECT_NEAR(li.value(0), 0.9, 1e-6);
  expect_looks_like(rgb(li.value()), li.spectral_value());

  auto le = about<v1::LeRequest>(lamps_);
  set(le.mutable_points()->mutable_offsets_m(), 0, -1, 0, 0, -1, 0);
  set(le.mutable_directions(), 0, 0, 1, 1, 0, 0);
  for (const double nm : table_nm()) le.add_wavelengths_nm(nm);
  const auto seen = service_.answer(le);
  EXPECT_EQ(rgb(seen.radiance_cd_m2()), (Rgb{2, 4, 9}));
  expect_looks_like(rgb(seen.radiance_cd_m2()), seen.spectral_radiance());
  for (int k = 95; k < 190; ++k) EXPECT_EQ(seen.spectral_radiance(k), 0);

  auto emit = about<v1::SampleLeRequest>(lamps_);
  emit.set_light_id(kRgbSphere);
  emit.set_count(3);
  emit.mutable_seed()->set_seed(1);
  for (const double nm : table_nm()) emit.add_wavelengths_nm(nm);
  const auto rays = service_.answer(emit);
  for (int i = 0; i < 3; ++i) expect_looks_like(rgb(rays.value(), i), rays.spectral_value(), i);

  const v1::LightPower flux = power(lamps_, {kRgb}, table_nm()).lights(0);
  expect_looks_like({flux.rgb_lm().r(), flux.rgb_lm().g(), flux.rgb_lm().b()},
                    flux.spectral_w_per_nm());
}

TEST_F(SpectraServiceTest, EveryCallReportsTheSameSpectrum) {
  const std::vector<double> nm = {450, 555, 700};
  auto le = about<v1::LeRequest>(lamps_);
  set(le.mutable_points()->mutable_offsets_m(), 0, 1, 0);
  set(le.mutable_directions(), 0, 0, 1);
  le.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
  const auto seen = service_.answer(le);
  auto emit = about<v1::SampleLeRequest>(lamps_);
  emit.set_light_id(kBlackBodySphere);
  emit.set_count(1);
  emit.mutable_seed();
  emit.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
  const auto rays = service_.answer(emit);
  v1::SampleLiRequest from_below = sample_request(kBlackBodySphere, nm);
  const auto li = service_.answer(from_below);
  // pi L A of a sphere of radius 0.3, at 7 cd/m2.
  const v1::LightPower flux = power(lamps_, {kBlackBodySphere}, nm).lights(0);
  const double area_pi = kPi * 4 * kPi * 0.3 * 0.3;
  EXPECT_NEAR(flux.power_lm(), 7 * area_pi, 1e-5 * flux.power_lm());
  for (int k = 0; k < 3; ++k) {
    const double radiance = 7 * planck_per_lumen(nm[k], 6504);
    EXPECT_NEAR(seen.spectral_radiance(k), radiance, 2e-6 * radiance);
    EXPECT_NEAR(rays.spectral_value(k), radiance, 2e-6 * radiance);
    EXPECT_NEAR(li.spectral_value(k), radiance, 2e-6 * radiance);
    EXPECT_NEAR(flux.spectral_w_per_nm(k), radiance * area_pi, 1e-5 * radiance * area_pi);
  }
}

// More spectra than the server keeps at a time.
TEST_F(SpectraServiceTest, ManyLightsKeepTheirOwnSpectra) {
  std::string text = "WorldBegin\n";
  std::vector<std::uint64_t> ids;
  for (int i = 0; i < 600; ++i) {
    text += "LightSource \"point\" \"float power\" 1 \"blackbody I\" " +
            std::to_string(2000 + 10 * i) + "\n";
    ids.push_back(static_cast<std::uint64_t>(i + 1));
  }
  ids.push_back(1);
  const v1::EstimatePowerResponse r = power(load("temperatures.pbrt", text), ids, {555, 700});
  ASSERT_EQ(r.lights_size(), 601);
  double sum = 0;
  for (int i = 0; i < 601; ++i) {
    const double expected = planck_per_lumen(700, 2000 + 10 * (i % 600));
    EXPECT_NEAR(r.lights(i).spectral_w_per_nm(1), expected, 1e-6 * expected) << i;
    sum += r.lights(i).spectral_w_per_nm(1);
  }
  EXPECT_NEAR(r.total().spectral_w_per_nm(1), sum, 1e-9 * sum);
}

}  // namespace
}  // namespace lucerna::testing
