#include "server/materials/material.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "lights/sampling/hash_number.h"

namespace lucerna {
namespace {

Rgb clamped(const Rgb& c, double low, double high) {
  return {std::clamp(c.r, low, high), std::clamp(c.g, low, high), std::clamp(c.b, low, high)};
}

/// The least index that is not a vacuum of its own: below it, refraction has no meaning.
constexpr double kLeastEta = 1e-3, kMostEta = 1e3;

class Maker {
 public:
  Maker(const Textures& textures, const TexturePoint& p) : textures_(textures), p_(p) {}

  Bsdf operator()(const DiffuseParams& m) const { return Diffuse(share(m.reflectance)); }
  Bsdf operator()(const DiffuseTransmissionParams& m) const {
    Rgb r = share(m.reflectance) * m.scale, t = share(m.transmittance) * m.scale;
    // No more than all light.
    const double most = (r + t).max_component();
    if (most > 1) r = r / most, t = t / most;
    return DiffuseTransmission(r, t);
  }
  Bsdf operator()(const MetalParams& m) const {
    const auto [x, y] = alpha(m.roughness);
    return metal(m, 1, x, y);
  }
  Bsdf operator()(const DielectricParams& m) const {
    const auto [x, y] = alpha(m.roughness);
    return Dielectric(eta(m.eta), x, y);
  }
  Bsdf operator()(const ThinDielectricParams& m) const { return ThinDielectric(eta(m.eta)); }
  Bsdf operator()(const CoatedDiffuseParams& m) const {
    const auto [x, y] = alpha(m.coat.roughness);
    return CoatedDiffuse({.boundary = {eta(m.coat.eta), x, y},
                          .base = Diffuse(share(m.reflectance)),
                          .thickness = thickness(m.coat)});
  }
  Bsdf operator()(const CoatedMetalParams& m) const {
    const auto [x, y] = alpha(m.coat.roughness);
    const auto [base_x, base_y] = alpha(m.metal.roughness);
    const double of_coat = eta(m.coat.eta);
    return CoatedConductor({.boundary = {of_coat, x, y},
                            .base = metal(m.metal, of_coat, base_x, base_y),
                            .thickness = thickness(m.coat)});
  }
  Bsdf operator()(const GltfSurfaceParams& m) const {
    return MetallicRoughness(surface(m), m.transmits() ? Side::kBoth : Side::kReflected);
  }
  Bsdf operator()(const MixParams&) const { return Diffuse(Rgb(0)); }

 private:
  Rgb share(const ColourValue& value) const { return clamped(textures_(value, p_), 0, 1); }
  double unit(const NumberValue& value) const { return std::clamp(textures_(value, p_), 0.0, 1.0); }
  /// [glTF2, appendix B, KHR_materials_specular, _ior, _anisotropy, _clearcoat]
  MetallicRoughnessParams surface(const GltfSurfaceParams& m) const {
    const Rgb surface = share(m.surface);
    const double alpha = surface.g * surface.g, root = (1 - m.ior) / (1 + m.ior);
    const double along = alpha + (1 - alpha) * m.anisotropy * m.anisotropy;
    const double coat_roughness = share(m.coat_roughness).g, specular = unit(m.specular);
    return {.base = share(m.base),
            .metallic = surface.b,
            .alpha = {along, alpha},
            .turn_rad = m.anisotropy_turn_rad,
            .f0 = clamped(textures_(m.specular_colour, p_) * (root * root), 0, 1) * specular,
            .f90 = specular,
            .transmission = unit(m.transmission),
            .coat = unit(m.coat),
            .coat_alpha = coat_roughness * coat_roughness};
  }
  double eta(const NumberValue& value) const {
    return std::clamp(textures_(value, p_), kLeastEta, kMostEta);
  }
  double thickness(const CoatParams& coat) const {
    return std::fmax(0, textures_(coat.thickness, p_));
  }
  Vec2 alpha(const Roughness& r) const {
    const auto one = [&](const NumberValue& value) {
      const double given = std::clamp(textures_(value, p_), 0.0, 1.0);
      return r.remap ? std::sqrt(given) : given;
    };
    return {one(r.u), one(r.v)};
  }
  /// `outside`: the index around the metal.
  Conductor metal(const MetalParams& m, double outside, double alpha_x, double alpha_y) const {
    Rgb n, k;
    if (m.reflectance) {
      // The k of an index with eta 1 and this reflectance at normal incidence.
      const Rgb r = clamped(textures_(*m.reflectance, p_), 0, 0.9999);
      const auto k_of = [](double x) { return 2 * std::sqrt(x) / std::sqrt(1 - x); };
      n = Rgb(1);
      k = {k_of(r.r), k_of(r.g), k_of(r.b)};
    } else {
      constexpr double kMost = 1e6;
      n = clamped(textures_(m.eta, p_), 0, kMost);
      k = clamped(textures_(m.k, p_), 0, kMost);
    }
    return {n / outside, k / outside, alpha_x, alpha_y};
  }

  const Textures& textures_;
  const TexturePoint& p_;
};

}  // namespace

Bsdf bsdf_of(const Material& material, const Textures& textures, const TexturePoint& p) {
  return std::visit(Maker(textures, p), material.params);
}

namespace {

using Materials = absl::FunctionRef<const Material&(std::uint32_t)>;

struct TraitsOf {
  SmoothTraits operator()(const DiffuseParams&) const { return {.is_rough = true}; }
  SmoothTraits operator()(const DiffuseTransmissionParams&) const { return {.is_rough = true}; }
  SmoothTraits operator()(const MetalParams& m) const {
    return {.reflects = may_be_smooth(m.roughness),
            .glossy_alpha = glossy(m.roughness),
            .is_nearly_smooth = is_brushed(m.roughness),
            .has_roughness_texture = !is_constant(m.roughness),
            .is_rough = may_be_rough(m.roughness)};
  }
  SmoothTraits operator()(const DielectricParams& m) const {
    const bool smooth = may_be_smooth(m.roughness);
    return {.reflects = smooth,
            .passes = smooth,
            .eta = constant(m.eta),
            .glossy_alpha = glossy(m.roughness),
            .is_nearly_smooth = glossy(m.roughness) > 0 || is_brushed(m.roughness),
            .has_roughness_texture = !is_constant(m.roughness),
            .is_rough = may_be_rough(m.roughness)};
  }
  SmoothTraits operator()(const ThinDielectricParams&) const {
    return {.reflects = true, .passes = true};
  }
  SmoothTraits operator()(const CoatedDiffuseParams& m) const {
    return {.reflects = may_be_smooth(m.coat.roughness),
            .glossy_alpha = glossy(m.coat.roughness),
            .is_nearly_smooth = is_brushed(m.coat.roughness),
            .has_roughness_texture = !is_constant(m.coat.roughness),
            .is_rough = true};
  }
  SmoothTraits operator()(const CoatedMetalParams& m) const {
    const double coat = glossy(m.coat.roughness);
    return {
        .reflects = may_be_smooth(m.coat.roughness),
        .glossy_alpha = coat > 0 ? coat : glossy(m.metal.roughness),
        .is_nearly_smooth = is_brushed(m.coat.roughness) || is_brushed(m.metal.roughness),
        .has_roughness_texture = !is_constant(m.coat.roughness) || !is_constant(m.metal.roughness),
        .is_rough = may_be_rough(m.coat.roughness) || may_be_rough(m.metal.roughness)};
  }
  SmoothTraits operator()(const GltfSurfaceParams& m) const {
    const auto least = [](const ColourValue& c) { return c.is_constant() ? c.constant.g : 0; };
    const bool smooth = is_smooth(square(least(m.surface)));
    const double alpha = m.surface.is_constant() ? glossy(square(m.surface.constant.g)) : 0;
    const bool has_coat = !m.coat.is_constant() || m.coat.constant > 0;
    return {.reflects = smooth || (has_coat && is_smooth(square(least(m.coat_roughness)))),
            .passes = smooth && m.transmits(),
            .glossy_alpha = alpha,
            .is_nearly_smooth = alpha > 0 && m.transmits(),
            .has_roughness_texture = !m.surface.is_constant(),
            .is_rough = true};
  }
  SmoothTraits operator()(const MixParams&) const { return {}; }

 private:
  static double square(double x) { return x * x; }
  static bool is_smooth(double alpha) { return Microfacets::is_smooth(alpha, alpha); }
  static std::optional<double> constant(const NumberValue& eta) {
    if (!eta.is_constant()) return std::nullopt;
    return std::clamp(eta.constant, kLeastEta, kMostEta);
  }
  static double alpha(const Roughness& r, const NumberValue& v) {
    const double given = std::clamp(v.constant, 0.0, 1.0);
    return r.remap ? std::sqrt(given) : given;
  }
  /// Between a mirror and surfaces whose lobes directions find by themselves.
  static double glossy(double alpha) {
    constexpr double kMostGlossy = 0.15;
    return !is_smooth(alpha) && alpha <= kMostGlossy ? alpha : 0;
  }
  static double glossy(const Roughness& r) {
    return is_constant(r) ? glossy(std::fmax(alpha(r, r.u), alpha(r, r.v))) : 0;
  }
  /// Whether facets are much smoother along u or v than along the other.
  static bool is_brushed(const Roughness& r) {
    if (!is_constant(r)) return false;
    const double u = alpha(r, r.u), v = alpha(r, r.v), least = std::fmin(u, v);
    return (is_smooth(least) || glossy(least) > 0) && std::fmax(u, v) > 2 * least &&
           !is_smooth(std::fmax(u, v));
  }
  static bool is_constant(const Roughness& r) { return r.u.is_constant() && r.v.is_constant(); }
  static bool is_smooth(const Roughness& r) {
    return Microfacets::is_smooth(alpha(r, r.u), alpha(r, r.v));
  }
  static bool may_be_smooth(const Roughness& r) { return !is_constant(r) || is_smooth(r); }
  static bool may_be_rough(const Roughness& r) { return !is_constant(r) || !is_smooth(r); }
};

}  // namespace

void for_each_of_mix(Materials materials, std::uint32_t number,
                     absl::FunctionRef<void(const Material&)> f) {
  // Mixes of mixes may name one material in exponentially many ways.
  std::vector<std::uint32_t> open{number};
  std::set<std::uint32_t> seen{number};
  while (!open.empty()) {
    const Material& m = materials(open.back());
    open.pop_back();
    f(m);
    if (const auto* mix = std::get_if<MixParams>(&m.params))
      for (const std::uint32_t part : mix->materials)
        if (seen.insert(part).second) open.push_back(part);
  }
}

SmoothTraits smooth_traits(Materials materials, std::uint32_t number) {
  SmoothTraits all;
  bool has_eta = false;
  for_each_of_mix(materials, number, [&](const Material& m) {
    const SmoothTraits t = std::visit(TraitsOf(), m.params);
    all.reflects |= t.reflects;
    all.is_rough |= t.is_rough;
    all.turns_normals |= m.normal_map >= 0 || m.bumps >= 0;
    all.glossy_alpha = std::max(all.glossy_alpha, t.glossy_alpha);
    all.is_nearly_smooth |= t.is_nearly_smooth;
    all.has_roughness_texture |= t.has_roughness_texture;
    if (!t.passes) return;
    if (has_eta && all.eta != t.eta)
      all.eta = std::nullopt;
    else
      all.eta = t.eta;
    all.passes = has_eta = true;
  });
  return all;
}

double pane_transmittance(const NumberValue& eta, const Textures& textures, const TexturePoint& p,
                          double cosine) {
  return ThinDielectric(std::clamp(textures(eta, p), kLeastEta, kMostEta))
      .passed(std::fmin(cosine, 1));
}

std::uint32_t chosen(std::span<const Material> materials, std::uint32_t number,
                     const Textures& textures, const TexturePoint& p) {
  double u = -1;
  while (const auto* mix = std::get_if<MixParams>(&materials[number].params)) {
    if (u < 0) u = hash_number({p.position.x, p.position.y, p.position.z});
    const double amount = std::clamp(textures(mix->amount, p), 0.0, 1.0);
    const bool second = u < amount;
    number = mix->materials[second];
    // The rest of the number chooses within a mix of mixes.
    u = second ? u / amount : (u - amount) / (1 - amount);
  }
  return number;
}

}  // namespace lucerna
