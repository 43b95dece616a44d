// Lights as messages, one function for each kind.
#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <type_traits>
#include <variant>

#include "lights/shapes/all_shapes.h"
#include "server/queries/queries.h"
#include "server/rpc/messages/convert.h"

namespace lucerna::rpc {
namespace {

using rpc::set;  // in addition to those here

/// Axes with their lengths.
void set_lengths(const Frame& axes, v1::Axes* out) {
  set(axes.s, out->mutable_x());
  set(axes.t, out->mutable_y());
  set(axes.n, out->mutable_z());
}

/// The unit vectors of axes of any lengths.
void set(const Frame& axes, v1::Axes* out) {
  set(normalized(axes.s), out->mutable_x());
  set(normalized(axes.t), out->mutable_y());
  set(normalized(axes.n), out->mutable_z());
}

void set_kind(const PointLightParams& p, v1::Light* out) {
  set(p.position_m, out->mutable_point()->mutable_position_m());
  set(p.intensity_cd, out->mutable_point()->mutable_intensity_cd());
}

v1::SpotProfile to_proto(SpotProfile profile) {
  switch (profile) {
    case SpotProfile::kSmoothstep:
      return v1::SPOT_PROFILE_SMOOTHSTEP;
    case SpotProfile::kQuadratic:
      return v1::SPOT_PROFILE_QUADRATIC;
    case SpotProfile::kQuartic:
      return v1::SPOT_PROFILE_QUARTIC;
  }
  return v1::SPOT_PROFILE_UNSPECIFIED;
}

void set_kind(const SpotLightParams& p, v1::Light* out) {
  v1::SpotLight* spot = out->mutable_spot();
  set(p.position_m, spot->mutable_position_m());
  set(p.axis, spot->mutable_axis());
  set(p.intensity_cd, spot->mutable_intensity_cd());
  spot->set_cone_half_angle_rad(p.cone_half_angle_rad);
  spot->set_falloff_start_rad(p.falloff_start_rad);
  spot->set_profile(to_proto(p.profile));
}

void set_kind(const DistantLightParams& p, v1::Light* out) {
  set(p.to_light, out->mutable_distant()->mutable_to_light());
  set(p.illuminance_lx, out->mutable_distant()->mutable_illuminance_lx());
}

void set_kind(const SunLightParams& p, v1::Light* out) {
  v1::SunLight* sun = out->mutable_sun();
  set(p.to_light, sun->mutable_to_light());
  set(p.illuminance_lx, sun->mutable_illuminance_lx());
  sun->set_angular_diameter_rad(p.angular_diameter_rad);
}

void set_kind(const UniformInfiniteLightParams& p, v1::Light* out) {
  set(p.radiance_cd_m2, out->mutable_uniform_infinite()->mutable_radiance_cd_m2());
}

void set(const Image& image, ImageFilter filter, const std::string& name, v1::ImageInfo* out) {
  out->set_name(name);
  out->set_width(static_cast<std::uint32_t>(image.width()));
  out->set_height(static_cast<std::uint32_t>(image.height()));
  out->set_filter(filter == ImageFilter::kNearest ? v1::IMAGE_FILTER_NEAREST
                                                  : v1::IMAGE_FILTER_BILINEAR);
}

void set(const SphereMap& map, const std::string& name, v1::SphereImage* out) {
  set(map.image(), map.filter(), name, out->mutable_image());
  out->set_mapping(map.mapping() == SphereMapping::kEqualArea
                       ? v1::SPHERE_MAPPING_EQUAL_AREA
                       : v1::SPHERE_MAPPING_LATITUDE_LONGITUDE);
}

void set_kind(const ImageInfiniteLightParams& p, v1::Light* out) {
  v1::ImageInfiniteLight* infinite = out->mutable_image_infinite();
  set(*p.map, p.image_name, infinite->mutable_map());
  set(axes_of(p.world_from_map), infinite->mutable_axes());
  set(p.radiance_cd_m2, infinite->mutable_radiance_cd_m2());
}

void set_kind(const PortalLightParams& p, v1::Light* out) {
  v1::ImageInfiniteLight* infinite = out->mutable_image_infinite();
  if (p.map != nullptr) {
    set(*p.map, p.image_name, infinite->mutable_map());
    set(axes_of(p.world_from_map), infinite->mutable_axes());
  }
  if (p.rectified) infinite->mutable_map()->mutable_image()->clear_filter();
  set(p.radiance_cd_m2, infinite->mutable_radiance_cd_m2());
  for (const Vec3& corner : p.corners_m) set(corner, infinite->add_portal_m());
}

/// `source`: GoniometricLightParams with a web, or PanelProfile.
template <typename Source>
void set(const Source& source, v1::PhotometricFile* out) {
  out->set_name(source.file);
  out->set_format(source.format);
  out->set_flux_lm(source.web->flux_lm());
  out->set_flux_unit(source.web_unit);
}

void set_kind(const GoniometricLightParams& p, v1::Light* out) {
  v1::GoniometricLight* goniometric = out->mutable_goniometric();
  set(p.position_m, goniometric->mutable_position_m());
  set(p.intensity, goniometric->mutable_intensity());
  if (p.web) {
    set(p, goniometric->mutable_photometric_file());
  } else if (p.map) {
    set(p.map->sphere_map(), p.file, goniometric->mutable_image());
  }
  if (p.web || p.map) set(p.axes, goniometric->mutable_axes());
}

/// Sets where a projector points, and the directions of its picture's sides.
template <typename Message>
void set_axes(const Frame& axes, Message* out) {
  set(normalized(axes.n), out->mutable_axis());
  set(normalized(axes.s), out->mutable_right());
  set(normalized(axes.t), out->mutable_up());
}

void set_kind(const ProjectionLightParams& p, v1::Light* out) {
  v1::ProjectionLight* projection = out->mutable_projection();
  const ProjectedPictureParams& picture = p.picture->params();
  set(p.position_m, projection->mutable_position_m());
  set_axes(p.axes, projection);
  projection->set_fov_rad(picture.fov_rad);
  projection->set_aspect(picture.aspect);
  set(p.intensity_cd, projection->mutable_intensity_cd());
  if (picture.image) set(*picture.image, picture.filter, p.image_name, projection->mutable_image());
}

void set_kind(const BeamLightParams& p, v1::Light* out) {
  v1::BeamLight* beam = out->mutable_beam();
  set(p.position_m, beam->mutable_position_m());
  set_axes(p.axes, beam);
  beam->set_width_m(p.width_m);
  beam->set_height_m(p.height_m);
  set(p.illuminance_lx, beam->mutable_illuminance_lx());
  if (p.image) set(*p.image, p.filter, p.image_name, beam->mutable_image());
}

template <typename Primitive>
void set_shape(const Mesh<Primitive>& mesh, const Vec3& origin_m, v1::DiffuseAreaLight* out) {
  constexpr bool kTriangles = std::is_same_v<Primitive, Triangle>;
  out->set_shape(kTriangles ? v1::AREA_SHAPE_TRIANGLE_MESH : v1::AREA_SHAPE_BILINEAR_MESH);
  out->set_primitives(mesh.size());
  if (mesh.size() != 1) return;
  const auto add = [&](const Vec3& corner) { set(origin_m + corner, out->add_corners_m()); };
  const auto& p = mesh.primitive(0);
  if constexpr (kTriangles) {
    for (const auto& corner : {p.a, p.b, p.c}) add(corner);
  } else {
    for (const auto& corner : {p.p00, p.p10, p.p01, p.p11}) add(corner);
  }
}

/// The scale of a round shape.  In the world, lengths along z are `along` times as long, and
/// lengths across `across` times.
struct RoundScale {
  double across, along;
};
template <typename Params>
RoundScale set_round(const Params& params, const Vec3& center, v1::RoundShape* out) {
  const Frame axes = axes_of(params.world_from_object);
  const RoundScale scale{length(axes.s), length(axes.n)};
  set(axes, out->mutable_axes());
  set(params.world_from_object.point(center), out->mutable_center_m());
  out->set_radius_m(scale.across * params.radius_m);
  out->set_phi_max_rad(params.phi_max_rad);
  out->set_reverse_orientation(params.reverse_orientation);
  return scale;
}

void set_shape(const Sphere& sphere, const Vec3&, v1::DiffuseAreaLight* out) {
  const SphereParams& p = sphere.params();
  out->set_shape(v1::AREA_SHAPE_SPHERE);
  out->set_primitives(1);
  const double scale = set_round(p, {}, out->mutable_round()).along;
  out->mutable_round()->set_z_min_m(scale * std::fmax(p.z_min_m, -p.radius_m));
  out->mutable_round()->set_z_max_m(scale * std::fmin(p.z_max_m, p.radius_m));
}

void set_shape(const Disk& disk, const Vec3&, v1::DiffuseAreaLight* out) {
  const DiskParams& p = disk.params();
  out->set_shape(v1::AREA_SHAPE_DISK);
  out->set_primitives(1);
  v1::RoundShape* round = out->mutable_round();
  round->set_inner_radius_m(set_round(p, {0, 0, p.height_m}, round).across * p.inner_radius_m);
  const Frame axes = axes_of(p.world_from_object);
  const double x = length(axes.s), y = length(axes.t);
  // Up to rounding, as in `Transform::uniform_scale`.
  const bool is_circle =
      std::fabs(x - y) <= 1e-6 * x && std::fabs(dot(axes.s, axes.t)) <= 1e-6 * x * y;
  if (!is_circle) round->set_radius_y_m(y * p.radius_m);
}

/// Other shapes that run along z.
template <QuadricShape S>
void set_shape(const S& shape, const Vec3&, v1::DiffuseAreaLight* out) {
  const auto& p = shape.params();
  v1::AreaShape kind = v1::AREA_SHAPE_UNSPECIFIED;
  v1::AreaShape_Parse(absl::StrCat("AREA_SHAPE_", absl::AsciiStrToUpper(std::string(S::kName))),
                      &kind);
  out->set_shape(kind);
  out->set_primitives(1);
  const double scale = set_round(p, {}, out->mutable_round()).along;
  out->mutable_round()->set_z_min_m(scale * p.z_min_m);
  out->mutable_round()->set_z_max_m(scale * p.z_max_m);
}

void set_kind(const AreaLight& l, const Vec3& origin_m, v1::Light* out) {
  v1::DiffuseAreaLight* area = out->mutable_diffuse_area();
  set(l.emission().radiance_cd_m2, area->mutable_radiance_cd_m2());
  area->set_two_sided(l.emission().two_sided);
  visit_shape(l.shape(), [&](const auto& shape) { set_shape(shape, origin_m, area); });
  if (const Picture* picture = l.picture())
    set(*picture->image, picture->filter, picture->name, area->mutable_image());
  if (const PanelProfile* profile = l.profile()) {
    set(*profile, area->mutable_profile());
    const Vec3 down = normalized(l.shape().normals().axis);
    const Vec3 c0 = normalized(profile->tangent - down * dot(down, profile->tangent));
    const Vec3 c90 = profile->mirrored ? cross(c0, down) : cross(down, c0);
    set({c0, c90, down}, area->mutable_profile_axes());
    // The radiance of a surface with the same flux, equal in all directions.
    const double sides = l.emission().two_sided ? 2 : 1;
    set(l.power({}).lumens / (sides * std::numbers::pi * l.shape().area()),
        area->mutable_radiance_cd_m2());
  }
}

void set_spectrum(const Spectrum& spectrum, v1::Spectrum* out) {
  if (const auto* body = std::get_if<BlackBody>(&spectrum.source())) {
    out->set_black_body_k(body->kelvin);
  } else if (const auto* illuminant = std::get_if<CieIlluminant>(&spectrum.source())) {
    out->set_illuminant(illuminant->name);
  } else {
    const auto& s = std::get<SampledSpectrum>(spectrum.source());
    v1::SampledSpectrum* sampled = out->mutable_sampled();
    sampled->mutable_wavelengths_nm()->Add(s.wavelengths_nm.begin(), s.wavelengths_nm.end());
    sampled->mutable_values()->Add(s.values.begin(), s.values.end());
  }
}

}  // namespace

void set_motion(const Motion& motion, const Vec3& origin_m, v1::Motion* out) {
  for (const Motion::KeyFrame& key : motion.key_frames()) {
    v1::KeyFrame* frame = out->add_key_frames();
    const auto [angle_rad, axis] = key.angle_and_axis();
    frame->set_time_s(key.time_s);
    set(origin_m + key.position_m, frame->mutable_position_m());
    set(axis, frame->mutable_axis());
    frame->set_angle_rad(angle_rad);
  }
}

std::string power_unit(const Scene& scene, std::uint32_t light) {
  const Light& of = *scene.lights()[light].light;
  if (const auto* surface = dynamic_cast<const AreaLight*>(&of))
    return surface->profile() != nullptr ? surface->profile()->flux_unit : "";
  const LightParams params = *of.made_from();
  const auto* goniometric = std::get_if<GoniometricLightParams>(&params);
  return goniometric != nullptr ? goniometric->flux_unit : "";
}

namespace {

/// `exact_m`: the place of a light at a point as its file gives it, not rounded with an origin.
void set_bounds(const LightBounds& bounds, const Vec3& origin_m, const std::optional<Vec3>& exact_m,
                v1::Light* out) {
  Vec3 lower = origin_m + bounds.lower, upper = origin_m + bounds.upper;
  if (exact_m && lower == upper) lower = upper = *exact_m;
  set(lower, out->mutable_bounds()->mutable_lower_m());
  set(upper, out->mutable_bounds()->mutable_upper_m());
  if (bounds.cone_rad < std::numbers::pi) {
    set(bounds.axis, out->mutable_directions()->mutable_axis());
    out->mutable_directions()->set_half_angle_rad(bounds.cone_rad);
  }
}

template <typename Params>
void set_free_light(const Params& p, v1::Light* out) {
  if constexpr (requires { p.own_space; })
    if (p.own_space) set_lengths(*p.own_space, out->mutable_own_axes());
  if constexpr (requires { p.world_from_map; })
    if (!p.world_from_map.uniform_scale())
      set_lengths(axes_of(p.world_from_map), out->mutable_own_axes());
  set_kind(p, out);
}

/// The position in the light's parameters, if they have one.
std::optional<Vec3> position_of(const std::optional<LightParams>& params) {
  if (!params) return std::nullopt;
  return std::visit(
      [](const auto& p) -> std::optional<Vec3> {
        if constexpr (requires { p.position_m; }) return p.position_m;
        return std::nullopt;
      },
      *params);
}

}  // namespace

void set_light(const Scene& scene, std::uint32_t light, v1::Light* out) {
  const SceneLight& entry = scene.lights()[light];
  out->set_id(entry.id);
  out->set_name(std::string(scene.lights().names().of(light)));
  out->set_samples_per_light(entry.samples);
  const SourceLocation where = scene.lights().source_of(entry);
  out->set_source(where.line > 0
                      ? fmt::format("{}:{}:{}", where.file.str(), where.line, where.column)
                      : where.file.str());
  const Vec3& origin_m = scene.lights().origin_of(entry);
  const Light& of = *entry.light;
  const std::optional<LightParams> params = of.made_from();
  out->set_delta(of.is_delta());
  if (const auto bounds = of.bounds()) set_bounds(*bounds, origin_m, position_of(params), out);
  if (params) std::visit([&](const auto& p) { set_free_light(p, out); }, *params);
  if (const auto* surface = dynamic_cast<const AreaLight*>(&of)) {
    out->set_area_m2(surface->shape().area());
    set_kind(*surface, origin_m, out);
    out->mutable_diffuse_area()->set_invisible(entry.is_unseen);
  }
  if (entry.moving != nullptr)
    set_motion(entry.moving->motion, scene.origin(), out->mutable_motion());
  const Power power = light_power(scene, light);
  out->set_power_lm(luminance(power.lumens));
  out->set_power_error_lm(power.error_lumens);
  out->set_power_unit(power_unit(scene, light));
  if (const Spectrum* spectrum = scene.lights().spectrum(light)) {
    set_spectrum(*spectrum, out->mutable_spectrum());
    out->set_power_w(out->power_lm() * spectrum->watts_per_lumen());
  }
}

}  // namespace lucerna::rpc
