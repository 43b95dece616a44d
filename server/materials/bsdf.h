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
template <typename... Kinds>
requires(Scattering<Kinds>&&...) using ScatteringSet = std::variant<Kinds...>;
}  // namespace detail

/// One scattering function.  The members are those of the concept Scattering.
class Bsdf {
 public:
  using Set =
      detail::ScatteringSet<Diffuse, DiffuseTransmission, Conductor, Dielectric, ThinDielectric,
                            CoatedDiffuse, CoatedConductor, MetallicRoughness>;

  template <typename Kind>
  requires std::is_constructible_v<Set, Kind>
  // NOLINTNEXTLINE(google-explicit-constructor): any member of the set is one.
  Bsdf(Kind kind) : set_(std::move(kind)) {}

  Rgb value(const Vec3& wo, const Vec3& wi) const {
    return std::visit([&](const auto& s) { return s.value(wo, wi); }, set_);
  }
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const {
    return std::visit([&](const auto& s) { return s.pdf(wo, wi); }, set_);
  }
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const {
    return std::visit([&](const auto& s) { return s.sample(wo, u); }, set_);
  }
  Rgb single(const Vec3& wo, Side side) const {
    return std::visit([&](const auto& s) { return s.single(wo, side); }, set_);
  }
  bool all_delta() const {
    return std::visit([](const auto& s) { return s.all_delta(); }, set_);
  }
  Side sides() const {
    return std::visit([](const auto& s) { return s.sides(); }, set_);
  }
  /// The member, for tests over the whole set.
  const Set& set() const { return set_; }

 private:
  Set set_;
};

}  // namespace lucerna
