// Invalid wavelengths, too many wavelengths, and light that exceeds floats.
#include <limits>

#include "every_query.h"
#include "spectra_fixture.h"

namespace lucerna::testing {
namespace {

TEST_F(SpectraServiceTest, WavelengthsAreCheckedEverywhere) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [&](const std::vector<double>& nm, const std::string& field) {
    int queries = 0;
    for_each_query(lamps_, 1, [&](auto q) {
      if constexpr (requires { q.mutable_wavelengths_nm(); }) {
        ++queries;
        q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
        expect_bad_field(service_.status(q), field);
      }
    });
    EXPECT_EQ(queries, 5);
  };
  expect_refused({99.9}, "wavelengths_nm[0]");
  expect_refused({555, 1000001}, "wavelengths_nm[1]");
  expect_refused({kNan}, "wavelengths_nm[0]");
  expect_refused({std::numeric_limits<double>::infinity()}, "wavelengths_nm[0]");
  expect_refused({-555}, "wavelengths_nm[0]");
  expect_refused(std::vector<double>(129, 555), "wavelengths_nm");
  EXPECT_TRUE(service_.status(sample_request(1, std::vector<double>(128, 1e6))).ok());
  EXPECT_TRUE(service_.status(sample_request(1, {100})).ok());
}

TEST_F(SpectraServiceTest, TheLargestBatchAtTheMostWavelengthsFitsAMessage) {
  v1::SampleLiRequest q = sample_request(kF2, std::vector<double>(128, 555));
  q.clear_u();
  q.mutable_seed();
  q.clear_light_id();
  q.set_test_visibility(true);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * 65536, 0);
  const auto r = service_.answer(q);
  EXPECT_EQ(r.spectral_value_size(), 65536 * 128);
  EXPECT_LT(r.ByteSizeLong(), options().limits.max_message_bytes);
}

// A black body of 100 K has 4e72 W per lumen, nearly all about 29 um.
TEST_F(SpectraServiceTest, ValuesBeyondFloatsAreOutOfRange) {
  const std::string scene =
      load("cold.pbrt",
           "WorldBegin LightSource \"point\" \"blackbody I\" 100 \"point3 from\" [0 0 3]\n"
           "AttributeBegin Translate 0 1 2 AreaLightSource \"diffuse\" "
           "\"blackbody L\" 100 Shape \"sphere\" AttributeEnd");
  for (const bool infrared : {false, true}) {
    const double nm = infrared ? 29000 : 800;
    v1::SampleLiRequest q = sample_request(1, {nm});
    q.set_scene_id(scene);
    const auto li = service_.answer(q);
    auto le = about<v1::LeRequest>(scene);
    set(le.mutable_points()->mutable_offsets_m(), 0, 1, 0);
    set(le.mutable_directions(), 0, 0, 1);
    le.add_wavelengths_nm(nm);
    const auto seen = service_.answer(le);
    auto emit = about<v1::SampleLeRequest>(scene);
    emit.set_light_id(2);
    emit.set_count(1);
    emit.mutable_seed();
    emit.add_wavelengths_nm(nm);
    const auto rays = service_.answer(emit);
    v1::EstimateIrradianceRequest irradiance = irradiance_request({nm});
    irradiance.set_scene_id(scene);
    irradiance.set_per_light(true);
    const auto lx = service_.answer(irradiance);
    if (!infrared) {
      EXPECT_EQ(li.status_size() + seen.status_size() + rays.status_size() + lx.status_size(), 0);
      EXPECT_GT(li.spectral_value(0), 0);
      EXPECT_GT(lx.illuminance_lx(0), 0);
      EXPECT_GT(lx.shares(1).illuminance_lx(0), 0);
      continue;
    }
    ASSERT_EQ(li.status_size(), 1);
    EXPECT_EQ(li.status(0), v1::ITEM_STATUS_OUT_OF_RANGE);
    EXPECT_EQ(li.spectral_value(0), 0);
    EXPECT_EQ(li.value(0), 0);
    ASSERT_EQ(seen.status_size(), 1);
    EXPECT_EQ(seen.status(0), v1::ITEM_STATUS_OUT_OF_RANGE);
    ASSERT_EQ(rays.status_size(), 1);
    EXPECT_EQ(rays.status(0), v1::ITEM_STATUS_OUT_OF_RANGE);
    ASSERT_EQ(lx.status_size(), 2);
    EXPECT_EQ(lx.status(0), v1::ITEM_STATUS_OUT_OF_RANGE);
    // No number of such an item remains.
    EXPECT_EQ(lx.spectral_irradiance(0), 0);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(rgb(lx.irradiance_lx(), i), Rgb{});
      EXPECT_EQ(lx.illuminance_lx(i), 0);
      EXPECT_EQ(lx.standard_error_lx(i), 0);
      EXPECT_EQ(lx.zero_bound_lx(i), 0);
      for (const v1::LightShare& share : lx.shares()) {
        EXPECT_EQ(share.illuminance_lx(i), 0) << share.light_id();
        EXPECT_EQ(share.standard_error_lx(i), 0) << share.light_id();
      }
    }
    // Doubles hold the value.
    const v1::LightPower flux = power(scene, {1}, {nm}).lights(0);
    EXPECT_GT(flux.power_w(), 1e73);
    EXPECT_TRUE(std::isfinite(flux.power_w()) && std::isfinite(flux.spectral_w_per_nm(0)));
  }
}

}  // namespace
}  // namespace lucerna::testing
