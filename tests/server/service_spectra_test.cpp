// Wavelengths and watts over the wire.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "lights/cie.h"
#include "lights/spectrum.h"
#include "service_fixture.h"
#include "tests/server/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;

// Lights 1 to 6, the last two with a surface.  Everything about the origin sees all but the
// sphere's back.
constexpr char kLamps[] = R"(WorldBegin
LightSource "point" "blackbody I" 3000 "float scale" 10 "point3 from" [0 0 3]
LightSource "point" "spectrum I" [400 1 500 2 600 4 700 2] "point3 from" [1 0 3]
LightSource "distant" "spectrum L" "stdillum-F2" "point3 from" [0 0 1] "point3 to" [0 0 0]
LightSource "point" "rgb I" [9 6 3] "point3 from" [-1 0 3]
AttributeBegin
  Translate 0 1 2
  AreaLightSource "diffuse" "blackbody L" 6504 "float scale" 7
  Shape "sphere" "float radius" 0.3
AttributeEnd
AttributeBegin
  Translate 0 -1 2
  AreaLightSource "diffuse" "rgb L" [2 4 9]
  Shape "sphere" "float radius" 0.3
AttributeEnd
)";
constexpr int kBlackBody = 1, kSampled = 2, kF2 = 3, kRgb = 4, kBlackBodySphere = 5, kRgbSphere = 6;

/// The wavelengths of the observer's table.
std::vector<double> table_nm() {
  std::vector<double> nm;
  for (int k = 0; k < 95; ++k) nm.push_back(360 + 5 * k);
  return nm;
}

/// What a client finds who adds up an answer at every wavelength of the table: XYZ in lumens'
/// units.
template <typename Values>
Vec3<double> summed(const Values& values, int item = 0) {
  Vec3<double> xyz{};
  for (std::size_t k = 0; k < 95; ++k)
    xyz += cie::observer()[k] * (683.0 * 5 * values[95 * item + static_cast<int>(k)]);
  return xyz;
}

/// The 5 nm sum of the answer is the RGB `c`, each channel to a thousandth of the largest.  By the
/// matrix of Rec. 709.
template <typename Values>
void expect_looks_like(const Rgb<double>& c, const Values& values, int item = 0) {
  const Vec3<double> xyz = summed(values, item);
  const double r =
      3.2409699419045213 * xyz.x - 1.5373831775700935 * xyz.y - 0.4986107602930033 * xyz.z;
  const double g =
      -0.9692436362808798 * xyz.x + 1.8759675015077206 * xyz.y + 0.0415550574071756 * xyz.z;
  const double b =
      0.0556300796969936 * xyz.x - 0.2039769588889765 * xyz.y + 1.0569715142428786 * xyz.z;
  ASSERT_GT(c.max_component(), 0);
  EXPECT_NEAR(r, c.r, 1e-3 * c.max_component());
  EXPECT_NEAR(g, c.g, 1e-3 * c.max_component());
  EXPECT_NEAR(b, c.b, 1e-3 * c.max_component());
}

Rgb<double> rgb(const google::protobuf::RepeatedField<float>& v, int i = 0) {
  return {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
}

/// Planck's law per lumen of the 5 nm sum [W/nm/lm].
double planck_per_lumen(double nm, double kelvin) {
  const auto planck = [&](double l) {
    return std::pow(l / 500, -5) / std::expm1(1.438776877e7 / (l * kelvin));
  };
  double y = 0;
  for (std::size_t k = 0; k < 95; ++k)
    y += cie::observer()[k].y * planck(360 + 5 * static_cast<double>(k));
  return planck(nm) / (683 * 5 * y);
}

/// The spectrum of light 2, at luminance 1: by a fine Riemann sum, the observer linear between
/// entries.
double sampled_value(double nm) {
  if (nm < 400 || nm > 700) return 0;
  if (nm < 500) return 1 + (nm - 400) / 100;
  return nm < 600 ? 2 + 2 * (nm - 500) / 100 : 4 - 2 * (nm - 600) / 100;
}
double sampled_lumens_per_unit() {
  double sum = 0;
  constexpr double kStep = 0.01;
  for (double nm = 400 + kStep / 2; nm < 700; nm += kStep) {
    const double x = (nm - 360) / 5;
    const auto k = static_cast<std::size_t>(x);
    const double t = x - static_cast<double>(k);
    sum +=
        sampled_value(nm) * (cie::observer()[k].y * (1 - t) + cie::observer()[k + 1].y * t) * kStep;
  }
  return 683 * sum;
}

/// 24 point lights of three kinds.
std::string many_lights() {
  const char* const kKinds[] = {"\"blackbody I\" 2700", "\"rgb I\" [1 3 5]",
                                "\"spectrum I\" \"stdillum-F11\""};
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 24; ++i)
    text += "LightSource \"point\" " + std::string(kKinds[i % 3]) + " \"point3 from\" [" +
            std::to_string(i % 5) + " " + std::to_string(i % 7) + " 3]\n";
  return text;
}

class SpectraServiceTest : public ::testing::Test {
 protected:
  rpc::ServerOptions options() const {
    rpc::ServerOptions o = service_options();
    o.scene_root = files_.path().string();
    return o;
  }
  std::string load(const std::string& name, const std::string& text) {
    files_.write(name, text);
    return service_.load(name);
  }
  /// One sample of `light` at the origin.
  v1::SampleLiRequest sample_request(std::uint64_t light, const std::vector<double>& nm) const {
    v1::SampleLiRequest q;
    q.set_scene_id(lamps_);
    q.set_light_id(light);
    set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
    set(q.mutable_u()->mutable_u(), 0.5, 0.5);
    q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    return q;
  }
  v1::EstimateIrradianceRequest irradiance_request(const std::vector<double>& nm) const {
    v1::EstimateIrradianceRequest q;
    q.set_scene_id(lamps_);
    q.set_bounces(0);
    q.mutable_accuracy()->set_samples(32);
    set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0, 0.5, 0.25, 0.125);
    set(q.mutable_normals(), 0, 0, 1, 0, 0.6, 0.8);
    q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    return q;
  }
  grpc::Status call(const v1::SampleLiRequest& q, v1::SampleLiResponse* r) {
    return ask([&](auto* c) { return service_.lighting.SampleLi(c, q, r); });
  }
  grpc::Status call(const v1::LeRequest& q, v1::LeResponse* r) {
    return ask([&](auto* c) { return service_.lighting.Le(c, q, r); });
  }
  grpc::Status call(const v1::SampleLeRequest& q, v1::SampleLeResponse* r) {
    return ask([&](auto* c) { return service_.lighting.SampleLe(c, q, r); });
  }
  grpc::Status call(const v1::EstimatePowerRequest& q, v1::EstimatePowerResponse* r) {
    return ask([&](auto* c) { return service_.lighting.EstimatePower(c, q, r); });
  }
  grpc::Status call(const v1::EstimateIrradianceRequest& q, v1::EstimateIrradianceResponse* r) {
    return ask([&](auto* c) { return service_.lighting.EstimateIrradiance(c, q, r); });
  }
  v1::EstimatePowerResponse power(
      const std::string& scene, std::vector<std::uint64_t> lights = {},
      const std::vector<double>& nm = {},
      v1::EstimatePowerRequest::Method method = v1::EstimatePowerRequest::METHOD_EXACT) {
    v1::EstimatePowerRequest q;
    q.set_scene_id(scene);
    q.set_method(method);
    q.mutable_light_ids()->Add(lights.begin(), lights.end());
    q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    v1::EstimatePowerResponse r;
    const grpc::Status s = call(q, &r);
    EXPECT_TRUE(s.ok()) << s.error_message();
    return r;
  }

  SceneFiles files_;
  Service service_{options()};
  std::string lamps_ = load("lamps.pbrt", kLamps);
};

TEST_F(SpectraServiceTest, SampleLiOfLightsWithSpectraIsTheirLuminanceTimesTheSpectrum) {
  const std::vector<double> nm = {650, 400, 555, 100, 2000};
  v1::SampleLiResponse r;
  ASSERT_TRUE(call(sample_request(kBlackBody, nm), &r).ok());
  ASSERT_EQ(r.spectral_value_size(), 5);
  // 10 cd at 3 m.
  for (int k = 0; k < 5; ++k) {
    const double expected = 10.0 / 9 * planck_per_lumen(nm[k], 3000);
    EXPECT_NEAR(r.spectral_value(k), expected, 1e-6 * expected) << nm[k];
  }
  ASSERT_TRUE(call(sample_request(kSampled, nm), &r).ok());
  // 1 cd; 3, 1 and 0 aside: cos is not in the value.
  for (int k = 0; k < 5; ++k) {
    const double expected = 0.1 * sampled_value(nm[k]) / sampled_lumens_per_unit();
    EXPECT_NEAR(r.spectral_value(k), expected, 1e-5 * expected) << nm[k];
  }
  ASSERT_TRUE(call(sample_request(kF2, table_nm()), &r).ok());
  EXPECT_NEAR(summed(r.spectral_value()).y, 1, 1e-6);  // 1 lx
  // Chromaticity of F2: CIE 15, table T.6.
  const Vec3<double> xyz = summed(r.spectral_value());
  EXPECT_NEAR(xyz.x / (xyz.x + xyz.y + xyz.z), 0.3721, 1e-4);
  EXPECT_NEAR(xyz.y / (xyz.x + xyz.y + xyz.z), 0.3751, 1e-4);
}

TEST_F(SpectraServiceTest, RgbLightsIntegrateBackToTheirRgb) {
  v1::SampleLiResponse li;
  ASSERT_TRUE(call(sample_request(kRgb, table_nm()), &li).ok());
  EXPECT_NEAR(li.value(0), 0.9, 1e-6);
  expect_looks_like(rgb(li.value()), li.spectral_value());

  v1::LeRequest le;
  le.set_scene_id(lamps_);
  set(le.mutable_points()->mutable_offsets_m(), 0, -1, 0, 0, -1, 0);
  set(le.mutable_directions(), 0, 0, 1, 1, 0, 0);
  for (const double nm : table_nm()) le.add_wavelengths_nm(nm);
  v1::LeResponse seen;
  ASSERT_TRUE(call(le, &seen).ok());
  EXPECT_EQ(rgb(seen.radiance_cd_m2()), (Rgb<double>{2, 4, 9}));
  expect_looks_like(rgb(seen.radiance_cd_m2()), seen.spectral_radiance());
  for (int k = 95; k < 190; ++k) EXPECT_EQ(seen.spectral_radiance(k), 0);

  v1::SampleLeRequest emit;
  emit.set_scene_id(lamps_);
  emit.set_light_id(kRgbSphere);
  emit.set_count(3);
  emit.mutable_seed()->set_seed(1);
  for (const double nm : table_nm()) emit.add_wavelengths_nm(nm);
  v1::SampleLeResponse rays;
  ASSERT_TRUE(call(emit, &rays).ok());
  for (int i = 0; i < 3; ++i) expect_looks_like(rgb(rays.value(), i), rays.spectral_value(), i);

  const v1::LightPower flux = power(lamps_, {kRgb}, table_nm()).lights(0);
  expect_looks_like({flux.rgb_lm().r(), flux.rgb_lm().g(), flux.rgb_lm().b()},
                    flux.spectral_w_per_nm());
}

TEST_F(SpectraServiceTest, EveryCallTellsTheSameSpectrum) {
  const std::vector<double> nm = {450, 555, 700};
  v1::LeRequest le;
  le.set_scene_id(lamps_);
  set(le.mutable_points()->mutable_offsets_m(), 0, 1, 0);
  set(le.mutable_directions(), 0, 0, 1);
  le.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
  v1::LeResponse seen;
  ASSERT_TRUE(call(le, &seen).ok());
  v1::SampleLeRequest emit;
  emit.set_scene_id(lamps_);
  emit.set_light_id(kBlackBodySphere);
  emit.set_count(1);
  emit.mutable_seed();
  emit.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
  v1::SampleLeResponse rays;
  ASSERT_TRUE(call(emit, &rays).ok());
  v1::SampleLiResponse li;
  v1::SampleLiRequest from_below = sample_request(kBlackBodySphere, nm);
  ASSERT_TRUE(call(from_below, &li).ok());
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

// A total's light at each wavelength is what each light's share says, times its spectrum; light 4
// and 6 are coloured and are asked for as grey here.
TEST_F(SpectraServiceTest, IrradianceIsTheSumOverLightsOfEachShareTimesItsSpectrum) {
  std::string grey = kLamps;
  grey.replace(grey.find("[9 6 3]"), 7, "[6 6 6]");
  grey.replace(grey.find("[2 4 9]"), 7, "[4 4 4]");
  const std::vector<double> nm = {420, 555, 640, 1000};
  v1::EstimateIrradianceRequest q = irradiance_request(nm);
  q.set_scene_id(load("grey.pbrt", grey));
  q.set_per_light(true);
  v1::EstimateIrradianceResponse r;
  const grpc::Status s = call(q, &r);
  ASSERT_TRUE(s.ok()) << s.error_message();
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

TEST_F(SpectraServiceTest, AskingForWavelengthsChangesNothingElse) {
  for (const std::string& scene : {lamps_, load("many.pbrt", many_lights())}) {
    v1::EstimateIrradianceRequest q = irradiance_request(table_nm());
    q.set_scene_id(scene);
    v1::EstimateIrradianceResponse with, without;
    ASSERT_TRUE(call(q, &with).ok());
    q.clear_wavelengths_nm();
    ASSERT_TRUE(call(q, &without).ok());
    EXPECT_EQ(without.spectral_irradiance_size(), 0);
    with.clear_spectral_irradiance();
    with.clear_cost();
    without.clear_cost();
    EXPECT_EQ(with.SerializeAsString(), without.SerializeAsString());
  }

  v1::SampleLiResponse sampled, plain;
  v1::SampleLiRequest li = sample_request(kF2, {555});
  ASSERT_TRUE(call(li, &sampled).ok());
  li.clear_wavelengths_nm();
  ASSERT_TRUE(call(li, &plain).ok());
  sampled.clear_spectral_value();
  sampled.clear_cost();
  plain.clear_cost();
  EXPECT_EQ(sampled.SerializeAsString(), plain.SerializeAsString());
}

// More lights than are visited one by one: what is chosen of them has its own spectrum.
TEST_F(SpectraServiceTest, IrradianceOfManyLightsIntegratesBackToItsIlluminance) {
  v1::EstimateIrradianceRequest q = irradiance_request(table_nm());
  q.set_scene_id(load("many.pbrt", many_lights()));
  v1::EstimateIrradianceResponse r;
  ASSERT_TRUE(call(q, &r).ok());
  for (int p = 0; p < 2; ++p) {
    EXPECT_GT(r.illuminance_lx(p), 0);
    expect_looks_like(rgb(r.irradiance_lx(), p), r.spectral_irradiance(), p);
  }
}

// 683 lm/W at 555 nm: a line of half a nanometre to either side, where the observer's table falls
// by 0.0050 in 5 nm; a triangle's mean distance from its middle is a third of that.
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

// Computed elsewhere: Planck's law in SI units, the whole by quadrature over 10 nm to 0.1 m (which
// agrees with Stefan and Boltzmann's law to 1e-14), the visible part by Simpson's rule at 0.1 nm
// with the observer's table as a cubic spline: 95.367062 lm/W.
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

// More spectra than are kept at a time.
TEST_F(SpectraServiceTest, EachOfManySpectraIsItsOwn) {
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

TEST_F(SpectraServiceTest, ListLightsTellsSpectraAndWatts) {
  v1::ListLightsRequest q;
  q.set_scene_id(lamps_);
  v1::ListLightsResponse r;
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.ListLights(c, q, &r); }).ok());
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
  v1::ListLightsRequest q;
  q.set_scene_id(load("long.pbrt", "WorldBegin\n" + light + light));
  v1::ListLightsResponse r;
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.ListLights(c, q, &r); }).ok());
  ASSERT_EQ(r.lights_size(), 1);
  EXPECT_EQ(r.lights(0).spectrum().sampled().values_size(), 70000);
  q.set_page_token(r.next_page_token());
  r.Clear();
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.ListLights(c, q, &r); }).ok());
  ASSERT_EQ(r.lights_size(), 1);
  EXPECT_EQ(r.lights(0).id(), 2U);
  EXPECT_EQ(r.next_page_token(), "");
}

TEST_F(SpectraServiceTest, GetSceneTellsOfSpectraOnlyWhereThereAreSome) {
  const auto spectra = [&](const std::string& scene) {
    v1::GetSceneRequest q;
    q.set_scene_id(scene);
    v1::GetSceneResponse r;
    EXPECT_TRUE(ask([&](auto* c) { return service_.scenes.GetScene(c, q, &r); }).ok());
    std::vector<v1::ScenePart> found;
    for (const auto& part : r.parts())
      if (part.name() == "spectra") found.push_back(part);
    return found;
  };
  const auto found = spectra(lamps_);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].why(), "4 spectra of 4 lights");
  EXPECT_GT(found[0].bytes(), 4 * 8 * sizeof(double));  // the samples alone, with their wavelengths
  EXPECT_TRUE(
      spectra(load("rgb.pbrt", "WorldBegin LightSource \"point\" \"rgb I\" [1 2 3]")).empty());
}

TEST_F(SpectraServiceTest, WavelengthsAreCheckedEverywhere) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [&](const std::vector<double>& nm, const std::string& field) {
    v1::SampleLiResponse li;
    expect_bad_field(call(sample_request(1, nm), &li), field);
    v1::EstimateIrradianceResponse irradiance;
    expect_bad_field(call(irradiance_request(nm), &irradiance), field);
    v1::LeRequest le;
    le.set_scene_id(lamps_);
    le.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    v1::LeResponse seen;
    expect_bad_field(call(le, &seen), field);
    v1::SampleLeRequest emit;
    emit.set_scene_id(lamps_);
    emit.mutable_seed();
    emit.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    v1::SampleLeResponse rays;
    expect_bad_field(call(emit, &rays), field);
    v1::EstimatePowerRequest power;
    power.set_scene_id(lamps_);
    power.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    v1::EstimatePowerResponse watts;
    expect_bad_field(call(power, &watts), field);
  };
  expect_refused({99.9}, "wavelengths_nm[0]");
  expect_refused({555, 1000001}, "wavelengths_nm[1]");
  expect_refused({kNan}, "wavelengths_nm[0]");
  expect_refused({std::numeric_limits<double>::infinity()}, "wavelengths_nm[0]");
  expect_refused({-555}, "wavelengths_nm[0]");
  expect_refused(std::vector<double>(129, 555), "wavelengths_nm");
  v1::SampleLiResponse r;
  EXPECT_TRUE(call(sample_request(1, std::vector<double>(128, 1e6)), &r).ok());
  EXPECT_TRUE(call(sample_request(1, {100}), &r).ok());
}

TEST_F(SpectraServiceTest, ReflectedLightHasNoSpectrum) {
  v1::EstimateIrradianceRequest q = irradiance_request({555});
  v1::EstimateIrradianceResponse r;
  q.clear_bounces();
  expect_bad_field(call(q, &r), "bounces");
  q.set_bounces(1);
  const grpc::Status s = call(q, &r);
  expect_bad_field(s, "bounces");
  EXPECT_THAT(s.error_message(), HasSubstr("surfaces have a colour and no spectrum"));
  q.set_bounces(0);
  EXPECT_TRUE(call(q, &r).ok());
}

TEST_F(SpectraServiceTest, TheLargestBatchAtTheMostWavelengthsFitsAMessage) {
  v1::SampleLiRequest q = sample_request(kF2, std::vector<double>(128, 555));
  q.clear_u();
  q.mutable_seed();
  q.clear_light_id();
  q.set_test_visibility(true);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * 65536, 0);
  v1::SampleLiResponse r;
  const grpc::Status s = call(q, &r);
  ASSERT_TRUE(s.ok()) << s.error_message();
  EXPECT_EQ(r.spectral_value_size(), 65536 * 128);
  EXPECT_LT(r.ByteSizeLong(), options().limits.max_message_bytes);
}

// A black body of 100 K has 4e72 W a lumen, nearly all about 29 um.
TEST_F(SpectraServiceTest, ValuesThatNoFloatHoldsAreOutOfRange) {
  const std::string scene =
      load("cold.pbrt",
           "WorldBegin LightSource \"point\" \"blackbody I\" 100 \"point3 from\" [0 0 3]\n"
           "AttributeBegin Translate 0 1 2 AreaLightSource \"diffuse\" "
           "\"blackbody L\" 100 Shape \"sphere\" AttributeEnd");
  for (const bool infrared : {false, true}) {
    const double nm = infrared ? 29000 : 800;
    v1::SampleLiRequest q = sample_request(1, {nm});
    q.set_scene_id(scene);
    v1::SampleLiResponse li;
    ASSERT_TRUE(call(q, &li).ok());
    v1::LeRequest le;
    le.set_scene_id(scene);
    set(le.mutable_points()->mutable_offsets_m(), 0, 1, 0);
    set(le.mutable_directions(), 0, 0, 1);
    le.add_wavelengths_nm(nm);
    v1::LeResponse seen;
    ASSERT_TRUE(call(le, &seen).ok());
    v1::SampleLeRequest emit;
    emit.set_scene_id(scene);
    emit.set_light_id(2);
    emit.set_count(1);
    emit.mutable_seed();
    emit.add_wavelengths_nm(nm);
    v1::SampleLeResponse rays;
    ASSERT_TRUE(call(emit, &rays).ok());
    v1::EstimateIrradianceRequest irradiance = irradiance_request({nm});
    irradiance.set_scene_id(scene);
    irradiance.set_per_light(true);
    v1::EstimateIrradianceResponse lx;
    ASSERT_TRUE(call(irradiance, &lx).ok());
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
    // No number of such an item stays behind.
    EXPECT_EQ(lx.spectral_irradiance(0), 0);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(rgb(lx.irradiance_lx(), i), Rgb<double>{});
      EXPECT_EQ(lx.illuminance_lx(i), 0);
      EXPECT_EQ(lx.standard_error_lx(i), 0);
      EXPECT_EQ(lx.zero_bound_lx(i), 0);
      for (const v1::LightShare& share : lx.shares()) {
        EXPECT_EQ(share.illuminance_lx(i), 0) << share.light_id();
        EXPECT_EQ(share.standard_error_lx(i), 0) << share.light_id();
      }
    }
    // Doubles hold it.
    const v1::LightPower flux = power(scene, {1}, {nm}).lights(0);
    EXPECT_GT(flux.power_w(), 1e73);
    EXPECT_TRUE(std::isfinite(flux.power_w()) && std::isfinite(flux.spectral_w_per_nm(0)));
  }
}

}  // namespace
}  // namespace lucerna::testing
