// Lights at a point: luminous intensity as a function of direction, and the inverse square law.
#pragma once

#include <absl/status/statusor.h>

#include <cmath>
#include <concepts>
#include <memory>
#include <optional>
#include <type_traits>

#include "lights/maths/deformation.h"
#include "lights/maths/emission_cone.h"
#include "lights/models/light.h"
#include "lights/models/light_bounds.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

/// A profile: luminous intensity by direction, in world axes about the light's position.  Its
/// members:
/// - `Params` with `position_m`, and `check(params, origin_m)`, which finds the errors in them.
/// - `is_black()`: no direction has light.
/// - `towards(w, v)`: intensity [cd] along the unit vector `w`.  `v` has the same direction and any
///   length, without rounding.  None outside the cone of light.
/// - `sample(u, ray)`: sets direction, density, value and reason of a ray of a light that is not
///   black.  The density belongs to the rounded direction.
/// - `per_sr(w)`: the density of `sample` at a finite `w` [1/sr]; 0 for black lights.
/// - `power()`, `power_approximate()`, `shared_data()`: as in Light.
/// - `table_bytes()`: the memory of its tables.
/// - `cone()`: a cone with all directions of light.
/// Where the value depends on direction, `intensity(w)` is the intensity along `w` [cd].
template <typename P>
concept IntensityProfile = requires(const P& profile, const typename P::Params& params,
                                    const Vec3& v, const Vec3& w, const Vec2& u,
                                    EmissionSample& ray) {
  { P::check(params, v) } -> std::same_as<absl::Status>;
  P(params);
  { profile.params() } -> std::same_as<const typename P::Params&>;
  { profile.is_black() } -> std::same_as<bool>;
  { profile.towards(v, v) } -> std::same_as<std::optional<Rgb>>;
  profile.sample(u, ray);
  { profile.per_sr(w) } -> std::same_as<double>;
  { profile.power() } -> std::same_as<Power>;
  { profile.power_approximate() } -> std::same_as<Power>;
  { profile.cone() } -> std::same_as<EmissionCone>;
  { profile.table_bytes() } -> std::same_as<std::uint64_t>;
  { profile.shared_data() } -> std::same_as<SharedData>;
};

/// Parameters of lights whose transform may scale unequally or shear.  Their member `own_space` has
/// the world vectors of x, y and z of the light's own space, in which its angles are measured; null
/// if all three have equal lengths and right angles.  `in_space(p, map)` returns parameters whose
/// directions are mapped, without an `own_space`.
template <typename Params>
concept Deformable = requires(const Params& params) {
  params.own_space;
};

/// A light at one point.  Immutable, so safe to share between threads.
template <typename Profile>
class IntensityLight final : public DeltaLight {
  static_assert(IntensityProfile<Profile>);

 public:
  using Params = typename Profile::Params;
  /// Profiles that depend on direction have `intensity(w)`; the others have `intensity_cd()`.
  static constexpr bool kSameForAllRays = requires(const Profile& p) { p.intensity_cd(); };

  /// Positions are kept relative to `origin_m`.  Errors: a field out of its domain.
  static absl::StatusOr<IntensityLight> create(const Params& params, const Vec3& origin_m = {}) {
    if constexpr (Deformable<Params>) {
      if (params.own_space != nullptr) {
        const auto map = Deformation::create(*params.own_space);
        if (!map.ok()) return map.status();
        const absl::Status status = Profile::check(in_space(params, *map), origin_m);
        if (!status.ok()) return status;
        return IntensityLight(params, origin_m, *map);
      }
    }
    if (absl::Status status = Profile::check(params, origin_m); !status.ok()) return status;
    return IntensityLight(params, origin_m);
  }

  /// Luminous intensity [cd] towards the unit vector `w` (world axes, from the light).
  Rgb intensity(const Vec3& w) const requires(!kSameForAllRays) {
    return profile_.intensity(is_deformed() ? own(w) : w);
  }
  /// The same, as the `value` of the ray that leaves the light towards `w`.
  Rgb le_leaving(const Vec3&, const Vec3& w, double = 0) const override {
    if constexpr (kSameForAllRays)
      return {};
    else
      return intensity(w);
  }

  /// Intensity over distance squared.  kDegenerate where the receiver is at the light's position.
  /// kOutsideCone where the profile is dark.  kOutOfRange where the receiver or the quotient is not
  /// finite.  [Pharr23, 12.2]
  LightSample sample_li(const Receiver& receiver, Vec2 /*u*/) const override {
    // Defined here for loops over receivers: a call takes longer than the point light's arithmetic.
    LightSample sample;
    const Way way = find_way(position_, receiver.position, sample);
    if (sample.reason != NoLight::kNone) return sample;
    if (profile_.is_black()) {
      sample.reason = NoLight::kBlack;
      return sample;
    }
    Vec3 w = -way.wi, v = receiver.position - position_;
    if (is_deformed()) w = own(w), v = deformed_->map.own_from_world(v);
    const std::optional<Rgb> intensity_cd = profile_.towards(w, v);
    if (intensity_cd)
      set_inverse_square(*intensity_cd, way, sample);
    else
      sample.reason = NoLight::kOutsideCone;
    return sample;
  }

  /// The fields that most samples need.
  struct PlainSample {
    Vec3 wi;
    double distance;
    Rgb value;
  };
  /// The fields of sample_li with the same bits, in a fraction of the time.  Nothing if no light
  /// arrives, or if the squared distance or the value overflows or underflows.
  std::optional<PlainSample> plain_sample_li(const Vec3& receiver) const requires kSameForAllRays {
    const auto way = plain_way(position_ - receiver);
    if (!way) return std::nullopt;
    const Rgb value(profile_.intensity_cd() / way->squared_m2);
    const double sum = value.r + value.g + value.b;
    const auto distance = way->distance_m;
    if (!(sum > 0) || !std::isfinite(sum) || !std::isfinite(distance)) return std::nullopt;
    return PlainSample{way->wi, distance, value};
  }

  /// The light's position and a direction of the profile.  kBlack where the light is black.
  /// kOutsideCone if rounding leads out of the light.  kOutOfRange where the density is not a
  /// positive `double`.
  EmissionSample sample_le(Vec2 /*u_position*/, Vec2 u_direction,
                           const SceneSphere& /*scene*/) const override {
    EmissionSample sample;
    sample.origin = position_;
    if (profile_.is_black())
      sample.reason = NoLight::kBlack;
    else
      sample_direction(u_direction, sample);
    return sample;
  }
  /// 0 at positions other than the light's and for directions that are not finite.
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& /*scene*/,
                     double = 0) const override {
    if (!same_float(position, position_) || !is_finite(direction)) return {};
    return {{}, {per_sr(direction)}};
  }

  /// That of the profile.  Under a deformation from a grid of directions, with the difference to a
  /// coarser grid as its error.
  Power power(const SceneSphere& /*scene*/) const override {
    if (is_deformed()) return deformed_->power;
    return profile_.power();
  }
  /// Without the deformation, as in pbrt-v4.
  Power power_approximate(const SceneSphere& /*scene*/) const override {
    const Power textbook = profile_.power_approximate();
    return is_deformed() ? approximate_power(textbook.lumens, deformed_->power) : textbook;
  }

  /// A point, and the profile's cone.
  std::optional<LightBounds> bounds() const override {
    EmissionCone cone = profile_.cone();
    if (is_deformed()) cone = deformed_->map.world_cone(cone);
    return LightBounds{
        .lower = position_, .upper = position_, .axis = cone.axis, .cone_rad = cone.half_angle_rad};
  }
  /// None: illuminance falls off with distance.
  std::optional<double> cross_section_m2(const SceneSphere& /*scene*/) const override {
    return std::nullopt;
  }
  static LightPlace place(const Params& params) {
    return {.anchor_m = params.position_m, .box_m = Bounds{params.position_m, params.position_m}};
  }
  LightBytes own_bytes() const override {
    return {
        .object = sizeof *this, .data = profile_.table_bytes(), .tables = profile_.table_bytes()};
  }
  SharedData shared_data() const override { return profile_.shared_data(); }
  std::optional<LightParams> made_from() const override;

  const Params& params() const {
    if (is_deformed()) return deformed_->params;
    return profile_.params();
  }
  const Vec3& position() const { return position_; }

 private:
  struct Deformed {
    Deformation map;
    Params params;  ///< in the world; those of the profile are in its own space
    Power power{};
  };
  struct Never {
    const Deformed* operator->() const { return nullptr; }
  };

  IntensityLight(const Params& params, const Vec3& origin_m)
      : DeltaLight(!kSameForAllRays), profile_(params), position_(params.position_m - origin_m) {}
  IntensityLight(const Params& params, const Vec3& origin_m,
                 const Deformation& map) requires Deformable<Params>
      : DeltaLight(!kSameForAllRays),
        profile_(in_space(params, map)),
        position_(params.position_m - origin_m) {
    auto deformed = std::make_shared<Deformed>(Deformed{map, params});
    deformed_ = deformed;
    constexpr int kFine = 128;
    const Rgb fine = mean_flux(kFine), coarse = mean_flux(kFine / 2);
    deformed->power = {fine, std::fabs(luminance(fine) - luminance(coarse))};
  }

  bool is_deformed() const {
    if constexpr (Deformable<Params>)
      return deformed_ != nullptr;
    else
      return false;
  }
  /// The unit vector of the profile's own space for a direction in the world.
  Vec3 own(const Vec3& w) const { return normalized(deformed_->map.own_from_world(w)); }
  double per_sr(const Vec3& w) const {
    if (!is_deformed()) return profile_.per_sr(w);
    const Vec3 unit = normalized(w);
    return double{profile_.per_sr(own(unit))} * deformed_->map.own_sr_per_world_sr(unit);
  }
  void sample_direction(Vec2 u, EmissionSample& sample) const {
    profile_.sample(u, sample);
    if (!is_deformed() || sample.reason != NoLight::kNone) return;
    // Value and density belong to the rounded direction.
    sample.direction = normalized(deformed_->map.world_from_own(sample.direction));
    if constexpr (!kSameForAllRays) sample.value = intensity(sample.direction);
    sample.pdf_direction = {per_sr(sample.direction)};
    settle(sample.pdf_direction.per_sr, sample);
  }
  /// The flux [lm] from `n` times `n` samples at the middles of cells.
  Rgb mean_flux(int n) const {
    Rgb sum;
    if (profile_.is_black()) return sum;
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) {
        EmissionSample ray;
        profile_.sample({(i + 0.5) / n, (k + 0.5) / n}, ray);
        if (ray.reason != NoLight::kNone) continue;
        const Vec3 w = normalized(deformed_->map.world_from_own(ray.direction));
        sum += Rgb(ray.value) /
               (double{ray.pdf_direction.per_sr} * deformed_->map.own_sr_per_world_sr(w) * n * n);
      }
    return sum;
  }

  Profile profile_;
  Vec3 position_;
  /// Null without a deformation.
  [[no_unique_address]] std::conditional_t<Deformable<Params>, std::shared_ptr<const Deformed>,
                                           Never>
      deformed_{};
};

}  // namespace lucerna
