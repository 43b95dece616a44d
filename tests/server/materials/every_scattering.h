// One scattering function of each kind and of each kind of roughness, for tests of the whole set.
#pragma once

#include <string>
#include <vector>

#include "server/materials/bsdf.h"

namespace lucerna::testing {

template <std::floating_point Real>
struct NamedScattering {
  std::string name;
  Bsdf<Real> bsdf;
  Real eta = 1;              ///< index below the surface over that above it
  bool is_estimate = false;  ///< `value` is one of several
  bool absorbs_nothing = false;
};

template <std::floating_point Real>
CoatedConductor<Real> coated_metal(Real alpha, Real base_alpha, const Rgb<Real>& k = Rgb<Real>(2)) {
  return CoatedConductor<Real>({.boundary = {Real(1.5), alpha, alpha},
                                .base = {Rgb<Real>(Real(0.2)), k, base_alpha, base_alpha},
                                .thickness = Real(0.01)});
}

template <std::floating_point Real>
CoatedDiffuse<Real> coated_diffuse(Real alpha, Real reflectance, Real thickness) {
  return CoatedDiffuse<Real>({.boundary = {Real(1.5), alpha, alpha},
                              .base = Diffuse<Real>(Rgb<Real>(reflectance)),
                              .thickness = thickness});
}

/// `x`, `y`: roughness of those that have some.
template <std::floating_point Real>
std::vector<NamedScattering<Real>> every_scattering(Real x = Real(0.3), Real y = Real(0.15)) {
  const Rgb<Real> eta{Real(0.2), Real(0.9), Real(1.1)}, k{Real(3.9), Real(2.4), Real(2.2)};
  std::vector<NamedScattering<Real>> all;
  all.push_back({"diffuse", Diffuse<Real>(Rgb<Real>{Real(0.8), Real(0.5), Real(0.1)})});
  all.push_back({"diffuse transmission",
                 DiffuseTransmission<Real>(Rgb<Real>(Real(0.3)), Rgb<Real>(Real(0.6)))});
  all.push_back({"conductor", Conductor<Real>(eta, k, x, y)});
  all.push_back({"mirror", Conductor<Real>(eta, k, 0, 0)});
  for (const Real index : {Real(1.5), Real(0.75), Real(3)})
    all.push_back({"dielectric of index " + std::to_string(index), Dielectric<Real>(index, x, y),
                   index, false, true});
  all.push_back({"smooth dielectric", Dielectric<Real>(Real(1.5), 0, 0), Real(1.5), false, true});
  all.push_back({"thin dielectric", ThinDielectric<Real>(Real(1.5)), 1, false, true});
  all.push_back({"coated diffuse", coated_diffuse<Real>(x, Real(0.5), Real(0.01)), 1, true});
  all.push_back(
      {"smoothly coated diffuse", coated_diffuse<Real>(0, Real(0.5), Real(0.01)), 1, true});
  all.push_back({"coated conductor", coated_metal<Real>(x, y), 1, true});
  all.push_back({"smoothly coated conductor", coated_metal<Real>(0, y), 1, true});
  all.push_back({"coated mirror", coated_metal<Real>(0, 0), 1, true});
  // glTF: a metal, a dielectric, something between below a coat, and sheets.
  const Rgb<Real> base{Real(0.9), Real(0.6), Real(0.2)};
  const auto gltf = [&](const std::string& name, MetallicRoughnessParams<Real> p) {
    p.base = base;
    all.push_back({"glTF " + name, MetallicRoughness<Real>(p)});
  };
  const auto sheet = [&](const std::string& name, MetallicRoughnessParams<Real> p) {
    p.base = base;
    all.push_back({"glTF " + name, ThinMetallicRoughness<Real>(p)});
  };
  gltf("metal", {.metallic = 1, .alpha = {x, y}, .turn_rad = Real(0.4)});
  gltf("dielectric", {.alpha = {x, x}});
  gltf("smooth dielectric", {});
  gltf("coated",
       {.metallic = Real(0.3), .alpha = {x, y}, .coat = Real(0.7), .coat_alpha = Real(0.1)});
  gltf("smoothly coated", {.metallic = Real(0.3), .alpha = {x, y}, .coat = 1});
  sheet("sheet", {.metallic = Real(0.1),
                  .alpha = {x, y},
                  .turn_rad = Real(-1),
                  .f0 = {Real(0.1), Real(0.2), Real(0.05)},
                  .f90 = Real(0.8),
                  .transmission = Real(0.6),
                  .coat = Real(0.5),
                  .coat_alpha = y});
  sheet("pane", {.transmission = 1});
  return all;
}

}  // namespace lucerna::testing
