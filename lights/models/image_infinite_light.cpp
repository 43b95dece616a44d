#include "lights/models/image_infinite_light.h"

#include <limits>

#include "lights/maths/level_validation.h"
#include "lights/maths/stop_poll.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/emission.h"

namespace lucerna {
namespace {

/// Whether `x` is a positive normal number.
bool is_positive_normal(double x) {
  return x >= std::numeric_limits<double>::min() && std::isfinite(x);
}

/// The integral of the map over the directions of the world [sr], from `n` times `n` of them.
Rgb integral_of(const SphereMap& map, const Deformation& deformation, int n) {
  Rgb sum;
  StopPoll poll;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x, poll()) {
      const Vec3 own =
          direction_from_square(SphereMapping::kEqualArea, {(x + 0.5) / n, (y + 0.5) / n});
      const Vec3 w = normalized(deformation.world_from_own(own));
      sum += map.lookup(own) / deformation.own_sr_per_world_sr(w);
    }
  return sum * (4 * kPi / n / n);
}

}  // namespace

absl::StatusOr<ImageInfiniteLight> ImageInfiniteLight::create(const Params& params, const Vec3&) {
  if (params.map == nullptr) return absl::InvalidArgumentError("infinite.map is missing");
  if (auto s = check_light_value("infinite.radiance", params.radiance_cd_m2, "cd/m2"); !s.ok())
    return s;
  if (auto s = check_light_value("infinite.radiance of the brightest texel",
                                 params.map->brightest() * params.radiance_cd_m2, "cd/m2");
      !s.ok())
    return s;
  if (params.world_from_map.uniform_scale()) return ImageInfiniteLight(params, nullptr);
  const auto map = Deformation::create(axes_of(params.world_from_map));
  if (!map.ok()) return map.status();
  constexpr int kFine = 1024;
  const Rgb fine = integral_of(*params.map, *map, kFine);
  const Rgb coarse = integral_of(*params.map, *map, kFine / 2);
  const double error = std::fabs(luminance(fine) - luminance(coarse));
  return ImageInfiniteLight(params, std::make_shared<const Deformed>(Deformed{*map, fine, error}));
}

ImageInfiniteLight::ImageInfiniteLight(const Params& params,
                                       std::shared_ptr<const Deformed> deformed)
    : LightBeyond(/*leaves_freely=*/true, /*has_irradiance=*/false),
      params_(params),
      axes_(params.world_from_map),
      deformed_(std::move(deformed)) {
  complete_ = std::make_shared<const SphereDistribution>(*params.map);
  const double mean = luminance(params.map->integral()) / (4 * kPi);
  auto compensated = std::make_shared<const SphereDistribution>(*params.map, mean);
  compensated_ = compensated->empty() ? complete_ : std::move(compensated);
}

ImageInfiniteLight::Seen ImageInfiniteLight::look(const SphereDistribution& distribution,
                                                  const Vec3& w) const {
  const Vec3 direction = map_from_world(w);
  return {params_.map->lookup(direction) * params_.radiance_cd_m2,
          per_sr(distribution, w, direction)};
}

LightSample ImageInfiniteLight::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample sample;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  if (complete_->empty() || params_.radiance_cd_m2.is_black()) {
    sample.reason = NoLight::kBlack;
    return sample;
  }
  const auto s = distribution(receiver).sample({double{u.x}, double{u.y}});
  sample.wi = deformed_ ? normalized(deformed_->map.world_from_own(s.direction))
                        : axes_.world_from_map(s.direction);
  sample.distance = std::numeric_limits<double>::infinity();
  const Seen seen = look(distribution(receiver), sample.wi);
  sample.pdf.per_sr = seen.per_sr;
  sample.value = Rgb(seen.radiance);
  if (seen.radiance.is_black())
    sample.reason = NoLight::kOutsideCone;
  else if (!is_positive_normal(sample.pdf.per_sr) || !is_finite(sample.value) ||
           !is_positive_normal(sample.value.max_component()))
    sample.reason = NoLight::kOutOfRange;
  if (sample.reason != NoLight::kNone) {
    sample.value = {};
    sample.pdf.per_sr = 1;
  }
  return sample;
}

SolidAnglePdf ImageInfiniteLight::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  const Vec3 w = map_from_world(wi);
  if (!is_finite(receiver.position) || !is_finite(w) || complete_->empty() ||
      params_.radiance_cd_m2.is_black())
    return {};
  const double density = per_sr(distribution(receiver), wi, w);
  return {is_positive_normal(density) ? density : 0};
}

MostIrradiance ImageInfiniteLight::most_irradiance(const Receiver& receiver) const {
  double all = luminance(params_.map->integral() * params_.radiance_cd_m2), height = 1;
  if (deformed_)
    all *= deformed_->map.most_world_sr_per_own_sr();
  else if (receiver.normal != Vec3{})
    height = params_.map->lit_height(axes_.map_from_world(receiver.normal));
  const double lx = all * height;
  // The density of a bilinear latitude-longitude map may be half of the proportional one.  Samples
  // of an `incomplete` receiver lie only on texels above the map's mean.  Directions of the
  // receiver find the other light.  It is at most pi times the mean, a quarter of the integral.
  return {lx, lx * 2.5};
}

Rgb ImageInfiniteLight::le_escaped(const Vec3&, const Vec3& w) const {
  const Vec3 direction = map_from_world(w);
  if (!is_finite(direction)) return {};
  return Rgb(params_.map->lookup(direction) * params_.radiance_cd_m2);
}

EmissionSample ImageInfiniteLight::sample_le(Vec2 u_position, Vec2 u_direction,
                                             const SceneSphere& scene) const {
  EmissionSample sample;
  const LightSample towards = sample_li(Vec3(), u_direction);
  sample.reason = towards.reason;
  if (sample.reason != NoLight::kNone) return sample;
  start_on_scene_disk(u_position, -normalized(towards.wi), scene, sample);
  sample.pdf_direction = towards.pdf;
  if (sample.reason == NoLight::kNone) sample.value = towards.value;
  return sample;
}

EmissionPdf ImageInfiniteLight::pdf_le(const Vec3& position, const Vec3& direction,
                                       const SceneSphere& scene, double) const {
  const AreaPdf at = scene_disk_pdf(position, direction, scene);
  if (!(at.per_m2 > 0)) return {};
  return {at, pdf_li(Vec3(), -direction)};
}

Power ImageInfiniteLight::power(const SceneSphere& scene) const {
  const Rgb integral =
      (deformed_ ? deformed_->integral : params_.map->integral()) * params_.radiance_cd_m2;
  if (integral.is_black()) return {};
  const double disk = kPi * scene.radius_m * scene.radius_m;
  const double error =
      deformed_ ? deformed_->error * params_.radiance_cd_m2.max_component() * disk : 0;
  return {integral * disk, error};
}

Power ImageInfiniteLight::power_approximate(const SceneSphere& scene) const {
  const Power exact = power(scene);
  if (params_.map->mapping() == SphereMapping::kEqualArea || exact.lumens.is_black()) return exact;
  const Rgb lumens = params_.map->image().mean() * params_.radiance_cd_m2 *
                     (kPi * scene.radius_m * scene.radius_m);
  return approximate_power(lumens, exact);
}

LightBytes ImageInfiniteLight::own_bytes() const {
  const std::uint64_t tables =
      complete_->bytes() + (compensated_ == complete_ ? 0 : compensated_->bytes());
  return {.object = sizeof *this, .data = tables, .tables = tables};
}

std::optional<LightParams> ImageInfiniteLight::made_from() const { return params_; }

}  // namespace lucerna
