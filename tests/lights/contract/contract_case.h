// A case of contract.h without its type, so that each test of the contract is compiled once and not
// for each light.
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lights/models/light_bounds.h"
#include "lights/sampling/emission.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna::testing {

/// The functions of a light.  Functions that the light lacks are empty.
struct CaseLight {
  std::function<LightSample(const Vec3&, Vec2)> sample_li;
  std::function<SolidAnglePdf(const Vec3&, const Vec3&)> pdf_li;
  std::function<Power(const SceneSphere&)> power, power_approximate;
  std::function<EmissionSample(Vec2, Vec2, const SceneSphere&)> sample_le;
  std::function<EmissionPdf(const Vec3&, const Vec3&, const SceneSphere&)> pdf_le;
  std::function<std::optional<LightBounds>()> bounds;
  std::function<std::optional<double>(const SceneSphere&)> cross_section_m2;
};

template <typename Light>
CaseLight case_light(Light made) {
  const auto light = std::make_shared<const Light>(std::move(made));
  CaseLight erased;
  erased.sample_li = [light](const Vec3& p, Vec2 u) { return light->sample_li(p, u); };
  erased.pdf_li = [light](const Vec3& p, const Vec3& w) { return light->pdf_li(p, w); };
  erased.power = [light](const SceneSphere& scene) { return light->power(scene); };
  if constexpr (requires(SceneSphere scene) { light->power_approximate(scene); })
    erased.power_approximate = [light](const SceneSphere& s) {
      return light->power_approximate(s);
    };
  if constexpr (requires(Vec2 u, SceneSphere scene) { light->sample_le(u, u, scene); }) {
    erased.sample_le = [light](Vec2 up, Vec2 ud, const SceneSphere& scene) {
      return light->sample_le(up, ud, scene);
    };
    erased.pdf_le = [light](const Vec3& p, const Vec3& w, const SceneSphere& scene) {
      return light->pdf_le(p, w, scene);
    };
  }
  if constexpr (requires { light->bounds(); })
    erased.bounds = [light] { return std::optional<LightBounds>(light->bounds()); };
  if constexpr (requires(SceneSphere scene) { light->cross_section_m2(scene); })
    erased.cross_section_m2 = [light](const SceneSphere& scene) {
      return std::optional<double>(light->cross_section_m2(scene));
    };
  return erased;
}

/// A region of directions: Region, or the test's own type.
struct CaseRegion {
  std::function<Vec3(double, double)> at;
  std::function<Vec2(const Vec3&)> where;
  std::function<double(double, double)> element_sr;
};

/// The members of a case of contract.h and contract_emission.h.  Functions that the case lacks are
/// empty.
struct LightCase {
  int value_length_power, power_length_power;
  double tolerance, power_tolerance, size;
  int far_field_length_power;
  bool enclosed, confined, enters_by_scene_disk;
  std::function<Vec3()> centre, far_direction;
  std::function<SceneSphere()> scene;
  std::function<std::vector<Vec3>()> receivers;
  std::function<CaseLight(const Placement&)> make;
  std::function<Rgb(const Vec3&, const Vec3&)> value{}, emitted{};
  std::function<CaseRegion(const Vec3&)> region{};
  std::function<double(const Vec3&)> distance_to_surface{};
  std::function<Rgb()> power_by_quadrature{};
  std::function<Vec3(const Vec3&, double, double)> emission_position{};
  std::function<Vec2(const Vec3&, const Vec3&)> emission_where{};
  std::function<double()> emission_area_m2{};
  std::function<Vec3(const Vec3&)> emission_direction{};
  std::function<Region(const Vec3&)> emission_region{};
};

struct SceneDiskCase;  // contract_emission.h

template <typename Case>
LightCase light_case() {
  LightCase c{.value_length_power = Case::kValueLengthPower,
              .power_length_power = Case::kPowerLengthPower,
              .tolerance = Case::kTolerance,
              .power_tolerance = Case::kPowerTolerance,
              .size = Case::kSize,
              .far_field_length_power = Case::kFarFieldLengthPower,
              .enclosed = Case::kEnclosed,
              .confined = false,
              .enters_by_scene_disk = std::derived_from<Case, SceneDiskCase>,
              .centre = Case::centre,
              .far_direction = Case::far_direction,
              .scene = Case::scene,
              .receivers = Case::receivers,
              .make = [](const Placement& at) { return case_light(Case::make(at)); }};
  const Vec3 v;
  if constexpr (requires { Case::kConfined; }) c.confined = Case::kConfined;
  if constexpr (requires { Case::value(v, v); }) c.value = Case::value;
  if constexpr (requires { Case::emitted(v, v); })
    c.emitted = Case::emitted;
  else if constexpr (requires { Case::value(v, v); })
    c.emitted = [](const Vec3& position, const Vec3& direction) {
      return Case::value(position + direction, -direction);
    };
  if constexpr (requires { Case::region(v); })
    c.region = [](const Vec3& receiver) {
      const auto region = Case::region(receiver);
      return CaseRegion{[region](double x, double y) { return region.at(x, y); },
                        [region](const Vec3& w) { return region.where(w); },
                        [region](double x, double y) { return element_sr(region, x, y); }};
    };
  if constexpr (requires { Case::distance_to_surface(v); })
    c.distance_to_surface = Case::distance_to_surface;
  if constexpr (requires { Case::power_by_quadrature(); })
    c.power_by_quadrature = Case::power_by_quadrature;
  if constexpr (requires { Case::emission_position(v, 0., 0.); })
    c.emission_position = Case::emission_position;
  if constexpr (requires { Case::emission_where(v, v); }) c.emission_where = Case::emission_where;
  if constexpr (requires { Case::emission_area_m2(); }) c.emission_area_m2 = Case::emission_area_m2;
  if constexpr (requires { Case::emission_direction(v); })
    c.emission_direction = Case::emission_direction;
  if constexpr (requires { Case::emission_region(v); }) c.emission_region = Case::emission_region;
  return c;
}

}  // namespace lucerna::testing
