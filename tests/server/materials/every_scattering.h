// One scattering function of each kind and of each kind of roughness, for tests of the whole set.
#pragma once

#include <string>
#include <vector>

#include "server/materials/bsdf.h"

namespace lucerna::testing {

struct NamedScattering {
  std::string name;
  Bsdf bsdf;
  double eta = 1;            ///< index below the surface over that above it
  bool is_estimate = false;  ///< `value` is one of several
  bool absorbs_nothing = false;
};

inline CoatedConductor coated_metal(double alpha, double base_alpha, const Rgb& k = Rgb(2)) {
  return CoatedConductor({.boundary = {1.5, alpha, alpha},
                          .base = {Rgb(0.2), k, base_alpha, base_alpha},
                          .thickness = 0.01});
}

inline CoatedDiffuse coated_diffuse(double alpha, double reflectance, double thickness) {
  return CoatedDiffuse(
      {.boundary = {1.5, alpha, alpha}, .base = Diffuse(Rgb(reflectance)), .thickness = thickness});
}

/// `x`, `y`: roughness of those that have some.
inline std::vector<NamedScattering> every_scattering(double x = 0.3, double y = 0.15) {
  const Rgb eta{0.2, 0.9, 1.1}, k{3.9, 2.4, 2.2};
  std::vector<NamedScattering> all;
  all.push_back({"diffuse", Diffuse(Rgb{0.8, 0.5, 0.1})});
  all.push_back({"diffuse transmission", DiffuseTransmission(Rgb(0.3), Rgb(0.6))});
  all.push_back({"conductor", Conductor(eta, k, x, y)});
  all.push_back({"mirror", Conductor(eta, k, 0, 0)});
  for (const double index : {1.5, 0.75, 3.0})
    all.push_back({"dielectric of index " + std::to_string(index), Dielectric(index, x, y), index,
                   false, true});
  all.push_back({"smooth dielectric", Dielectric(1.5, 0, 0), 1.5, false, true});
  all.push_back({"thin dielectric", ThinDielectric(1.5), 1, false, true});
  all.push_back({"coated diffuse", coated_diffuse(x, 0.5, 0.01), 1, true});
  all.push_back({"smoothly coated diffuse", coated_diffuse(0, 0.5, 0.01), 1, true});
  all.push_back({"coated conductor", coated_metal(x, y), 1, true});
  all.push_back({"smoothly coated conductor", coated_metal(0, y), 1, true});
  all.push_back({"coated mirror", coated_metal(0, 0), 1, true});
  // glTF: a metal, a dielectric, something between below a coat, and sheets.
  const Rgb base{0.9, 0.6, 0.2};
  const auto gltf = [&](const std::string& name, MetallicRoughnessParams p) {
    p.base = base;
    all.push_back({"glTF " + name, MetallicRoughness(p)});
  };
  const auto sheet = [&](const std::string& name, MetallicRoughnessParams p) {
    p.base = base;
    all.push_back({"glTF " + name, MetallicRoughness(p, Side::kBoth)});
  };
  gltf("metal", {.metallic = 1, .alpha = {x, y}, .turn_rad = 0.4});
  gltf("dielectric", {.alpha = {x, x}});
  gltf("smooth dielectric", {});
  gltf("coated", {.metallic = 0.3, .alpha = {x, y}, .coat = 0.7, .coat_alpha = 0.1});
  gltf("smoothly coated", {.metallic = 0.3, .alpha = {x, y}, .coat = 1});
  sheet("sheet", {.metallic = 0.1,
                  .alpha = {x, y},
                  .turn_rad = -1.0,
                  .f0 = {0.1, 0.2, 0.05},
                  .f90 = 0.8,
                  .transmission = 0.6,
                  .coat = 0.5,
                  .coat_alpha = y});
  sheet("pane", {.transmission = 1});
  return all;
}

}  // namespace lucerna::testing
