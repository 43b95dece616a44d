// The closed set of scattering functions.
#pragma once

#include <type_traits>
#include <utility>
#include <variant>

#include "server/materials/coated.h"
#include "server/materials/conductor.h"
#include "server/materials/dielectric.h"
#include "server/materials/diffuse.h"
#include "server/materials/metallic_roughness.h"

namespace lucerna {

namespace detail {
/// Checks what every kind must have.
template <std::floating_point Real, typename... Kinds>
requires(Scattering<Kinds, Real>&&...) using ScatteringSet = std::variant<Kinds...>;
}  // namespace detail

/// One scattering function.  The members are those of the concept Scattering.
template <std::floating_point Real>
class Bsdf {
 public:
  using Set = detail::ScatteringSet<Real, Diffuse<Real>, DiffuseTransmission<Real>, Conductor<Real>,
                                    Dielectric<Real>, ThinDielectric<Real>, CoatedDiffuse<Real>,
                                    CoatedConductor<Real>, MetallicRoughness<Real>,
                                    ThinMetallicRoughness<Real>>;

  template <typename Kind>
  requires std::is_constructible_v<Set, Kind>
  // NOLINTNEXTLINE(google-explicit-constructor): any member of the set is one.
  Bsdf(Kind kind) : set_(std::move(kind)) {}

  Rgb<Real> value(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
    return std::visit([&](const auto& s) { return s.value(wo, wi); }, set_);
  }
  SolidAnglePdf<Real> pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
    return std::visit([&](const auto& s) { return s.pdf(wo, wi); }, set_);
  }
  std::optional<ScatterSample<Real>> sample(const Vec3<Real>& wo,
                                            const ScatterValues<Real>& u) const {
    return std::visit([&](const auto& s) { return s.sample(wo, u); }, set_);
  }
  Rgb<Real> single(const Vec3<Real>& wo, Side side) const {
    return std::visit([&](const auto& s) { return s.single(wo, side); }, set_);
  }
  bool all_delta() const {
    return std::visit([](const auto& s) { return s.all_delta(); }, set_);
  }
  Side sides() const {
    return std::visit([](const auto& s) { return std::decay_t<decltype(s)>::kSides; }, set_);
  }
  /// The member, for tests over the whole set.
  const Set& set() const { return set_; }

 private:
  Set set_;
};

}  // namespace lucerna
