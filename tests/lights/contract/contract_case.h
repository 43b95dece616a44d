// A case of contract.h without its type, so that each test of the contract is compiled once and not
// for each light.
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lights/models/light.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna::testing {

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
  std::function<std::unique_ptr<const Light>(const Placement&)> make;
  std::function<Receiver(const Vec3&, const Placement&)> receiver;
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
              .make =
                  [](const Placement& at) {
                    return std::make_unique<const typename Case::Light>(Case::make(at));
                  },
              .receiver = Case::receiver};
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
