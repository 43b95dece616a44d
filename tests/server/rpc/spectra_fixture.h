// The services, and a scene of lamps with a spectrum or an RGB colour.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "lights/maths/cie.h"
#include "lights/maths/spectrum.h"
#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {

// Lights 1 to 6; the last two have a surface.  A receiver at the origin sees them all, except for
// the sphere's back.
inline constexpr char kLamps[] = R"(WorldBegin
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
inline constexpr int kBlackBody = 1, kSampled = 2, kF2 = 3, kRgb = 4, kBlackBodySphere = 5,
                     kRgbSphere = 6;

/// The wavelengths of the observer's table.
inline std::vector<double> table_nm() {
  std::vector<double> nm;
  for (int k = 0; k < 95; ++k) nm.push_back(360 + 5 * k);
  return nm;
}

/// The XYZ that a client computes from an answer at every wavelength of the table, in the units of
/// lumens.
template <typename Values>
Vec3 summed(const Values& values, int item = 0) {
  Vec3 xyz{};
  for (std::size_t k = 0; k < 95; ++k)
    xyz += cie::observer()[k] * (683.0 * 5 * values[95 * item + static_cast<int>(k)]);
  return xyz;
}

/// Expects the 5 nm sum of the answer to be the RGB `c`, each channel to a thousandth of the
/// largest.  By the matrix of Rec. 709.
template <typename Values>
void expect_looks_like(const Rgb& c, const Values& values, int item = 0) {
  const Vec3 xyz = summed(values, item);
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

inline Rgb rgb(const google::protobuf::RepeatedField<float>& v, int i = 0) {
  return {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
}

/// Planck's law per lumen of the 5 nm sum [W/nm/lm].
inline double planck_per_lumen(double nm, double kelvin) {
  const auto planck = [&](double l) {
    return std::pow(l / 500, -5) / std::expm1(1.438776877e7 / (l * kelvin));
  };
  double y = 0;
  for (std::size_t k = 0; k < 95; ++k)
    y += cie::observer()[k].y * planck(360 + 5 * static_cast<double>(k));
  return planck(nm) / (683 * 5 * y);
}

/// The spectrum of light 2 at luminance 1: by a fine Riemann sum, with the observer linear between
/// entries.
inline double sampled_value(double nm) {
  if (nm < 400 || nm > 700) return 0;
  if (nm < 500) return 1 + (nm - 400) / 100;
  return nm < 600 ? 2 + 2 * (nm - 500) / 100 : 4 - 2 * (nm - 600) / 100;
}
inline double sampled_lumens_per_unit() {
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
inline std::string many_lights() {
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
  rpc::ServerOptions options() const { return scenes_in(files_.path()); }
  std::string load(const std::string& name, const std::string& text) {
    files_.write(name, text);
    return service_.load(name);
  }
  /// One sample of `light` at the origin.
  v1::SampleLiRequest sample_request(std::uint64_t light, const std::vector<double>& nm) const {
    auto q = about<v1::SampleLiRequest>(lamps_);
    q.set_light_id(light);
    set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
    set(q.mutable_u()->mutable_u(), 0.5, 0.5);
    q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    return q;
  }
  v1::EstimateIrradianceRequest irradiance_request(const std::vector<double>& nm) const {
    auto q = about<v1::EstimateIrradianceRequest>(lamps_);
    q.set_bounces(0);
    q.mutable_accuracy()->set_samples(32);
    set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0, 0.5, 0.25, 0.125);
    set(q.mutable_normals(), 0, 0, 1, 0, 0.6, 0.8);
    q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    return q;
  }
  v1::EstimatePowerResponse power(
      const std::string& scene, std::vector<std::uint64_t> lights = {},
      const std::vector<double>& nm = {},
      v1::EstimatePowerRequest::Method method = v1::EstimatePowerRequest::METHOD_EXACT) {
    auto q = about<v1::EstimatePowerRequest>(scene);
    q.set_method(method);
    q.mutable_light_ids()->Add(lights.begin(), lights.end());
    q.mutable_wavelengths_nm()->Add(nm.begin(), nm.end());
    return service_.answer(q);
  }

  SceneFiles files_;
  Service service_{options()};
  std::string lamps_ = load("lamps.pbrt", kLamps);
};

}  // namespace lucerna::testing
