#include "server/rpc/convert.h"

#include <fmt/core.h>

#include <numbers>

#include "server/queries.h"

namespace lucerna::rpc {
namespace {

void set(const Vec3<double>& v, v1::Vector3* out) {
  out->set_x(v.x);
  out->set_y(v.y);
  out->set_z(v.z);
}

void set(const Rgb<double>& c, v1::Rgb* out) {
  out->set_r(c.r);
  out->set_g(c.g);
  out->set_b(c.b);
}

void set_kind(const PointLight<float>& l, v1::Light* out) {
  set(l.params().position_m, out->mutable_point()->mutable_position_m());
  set(l.params().intensity_cd, out->mutable_point()->mutable_intensity_cd());
}

void set_kind(const SpotLight<float>& l, v1::Light* out) {
  v1::SpotLight* spot = out->mutable_spot();
  set(l.params().position_m, spot->mutable_position_m());
  set(l.params().axis, spot->mutable_axis());
  set(l.params().intensity_cd, spot->mutable_intensity_cd());
  spot->set_cone_half_angle_rad(l.params().cone_half_angle_rad);
  spot->set_falloff_start_rad(l.params().falloff_start_rad);
  spot->set_profile(l.params().profile == SpotProfile::kQuartic ? v1::SPOT_PROFILE_QUARTIC
                                                                : v1::SPOT_PROFILE_SMOOTHSTEP);
}

void set_kind(const DistantLight<float>& l, v1::Light* out) {
  set(l.params().to_light, out->mutable_distant()->mutable_to_light());
  set(l.params().illuminance_lx, out->mutable_distant()->mutable_illuminance_lx());
}

void set_kind(const SunLight<float>& l, v1::Light* out) {
  v1::SunLight* sun = out->mutable_sun();
  set(l.params().to_light, sun->mutable_to_light());
  set(l.params().illuminance_lx, sun->mutable_illuminance_lx());
  sun->set_angular_diameter_rad(l.params().angular_diameter_rad);
}

void set_kind(const UniformInfiniteLight<float>& l, v1::Light* out) {
  set(l.params().radiance_cd_m2, out->mutable_uniform_infinite()->mutable_radiance_cd_m2());
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

void set_kind(const ImageInfiniteLight<float>& l, v1::Light* out) {
  v1::ImageInfiniteLight* infinite = out->mutable_image_infinite();
  set(*l.params().map, l.params().image_name, infinite->mutable_map());
  set(l.params().radiance_cd_m2, infinite->mutable_radiance_cd_m2());
}

void set_kind(const PortalLight<float>& l, v1::Light* out) {
  v1::ImageInfiniteLight* infinite = out->mutable_image_infinite();
  if (l.params().map != nullptr)
    set(*l.params().map, l.params().image_name, infinite->mutable_map());
  if (l.params().rectified) infinite->mutable_map()->mutable_image()->clear_filter();
  set(l.params().radiance_cd_m2, infinite->mutable_radiance_cd_m2());
  for (const Vec3<double>& corner : l.params().corners_m) set(corner, infinite->add_portal_m());
}

void set(const PhotometricWeb& web, const std::string& name, const std::string& format,
         v1::PhotometricFile* out) {
  out->set_name(name);
  out->set_format(format);
  out->set_flux_lm(web.flux_lm());
}

void set_kind(const GoniometricLight<float>& l, v1::Light* out) {
  v1::GoniometricLight* goniometric = out->mutable_goniometric();
  set(l.params().position_m, goniometric->mutable_position_m());
  set(l.params().intensity, goniometric->mutable_intensity());
  if (l.params().web) {
    set(*l.params().web, l.params().file, l.params().format,
        goniometric->mutable_photometric_file());
  } else if (l.params().map) {
    set(l.params().map->sphere_map(), l.params().file, goniometric->mutable_image());
  }
}

template <typename Message>
void set_axes(const Frame<double>& axes, Message* out) {
  set(normalized(axes.n), out->mutable_axis());
  set(normalized(axes.s), out->mutable_right());
  set(normalized(axes.t), out->mutable_up());
}

void set_kind(const ProjectionLight<float>& l, v1::Light* out) {
  v1::ProjectionLight* projection = out->mutable_projection();
  const ProjectedPictureParams& picture = l.params().picture->params();
  set(l.params().position_m, projection->mutable_position_m());
  set_axes(l.params().axes, projection);
  projection->set_fov_rad(picture.fov_rad);
  projection->set_aspect(picture.aspect);
  set(l.params().intensity_cd, projection->mutable_intensity_cd());
  if (picture.image)
    set(*picture.image, picture.filter, l.params().image_name, projection->mutable_image());
}

void set_kind(const BeamLight<float>& l, v1::Light* out) {
  v1::BeamLight* beam = out->mutable_beam();
  set(l.params().position_m, beam->mutable_position_m());
  set_axes(l.params().axes, beam);
  beam->set_width_m(l.params().width_m);
  beam->set_height_m(l.params().height_m);
  set(l.params().illuminance_lx, beam->mutable_illuminance_lx());
  if (l.params().image)
    set(*l.params().image, l.params().filter, l.params().image_name, beam->mutable_image());
}

v1::AreaShape shape_kind(const TriangleMesh<float>&) { return v1::AREA_SHAPE_TRIANGLE_MESH; }
v1::AreaShape shape_kind(const PatchMesh<float>&) { return v1::AREA_SHAPE_BILINEAR_MESH; }
v1::AreaShape shape_kind(const Sphere<float>&) { return v1::AREA_SHAPE_SPHERE; }
v1::AreaShape shape_kind(const Disk<float>&) { return v1::AREA_SHAPE_DISK; }
v1::AreaShape shape_kind(const Cylinder<float>&) { return v1::AREA_SHAPE_CYLINDER; }

template <template <typename> typename Surface>
v1::AreaShape shape_kind(const Painted<float, Surface>& painted) {
  return shape_kind(painted.surface());
}

template <template <typename> typename Surface>
v1::AreaShape shape_kind(const Panel<float, Surface>& panel) {
  return shape_kind(panel.surface());
}

template <template <typename> typename Shape>
void set_kind(const AreaLight<float, Shape>& l, v1::Light* out) {
  v1::DiffuseAreaLight* area = out->mutable_diffuse_area();
  set(l.emission().radiance_cd_m2, area->mutable_radiance_cd_m2());
  area->set_two_sided(l.emission().two_sided);
  area->set_shape(shape_kind(l.shape()));
  if constexpr (requires { l.shape().size(); }) {
    area->set_primitives(l.shape().size());
  } else {
    area->set_primitives(1);
  }
  if constexpr (requires { l.shape().picture(); }) {
    const Picture& picture = l.shape().picture();
    set(*picture.image, picture.filter, picture.name, area->mutable_image());
  } else if constexpr (requires { l.shape().profile(); }) {
    const PanelProfile& profile = l.shape().profile();
    set(*profile.web, profile.file, profile.format, area->mutable_profile());
    // That of a surface that shines alike in all directions with the same flux.
    const double sides = l.emission().two_sided ? 2 : 1;
    set(l.power({}).lumens / (sides * std::numbers::pi * l.area_m2()),
        area->mutable_radiance_cd_m2());
  }
}

void set_motion(const Motion& motion, const Vec3<double>& origin_m, v1::Motion* out) {
  for (const Motion::KeyFrame& key : motion.key_frames()) {
    v1::KeyFrame* frame = out->add_key_frames();
    const auto [angle_rad, axis] = key.angle_and_axis();
    frame->set_time_s(key.time_s);
    set(origin_m + key.position_m, frame->mutable_position_m());
    set(axis, frame->mutable_axis());
    frame->set_angle_rad(angle_rad);
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

void set_light(const Scene& scene, std::uint32_t light, v1::Light* out) {
  const SceneLight& entry = scene.lights()[light];
  out->set_id(entry.id);
  out->set_source(fmt::format("{}:{}:{}", entry.where.file, entry.where.line, entry.where.column));
  std::visit(
      [&]<typename L>(const L& l) {
        out->set_delta(L::kDelta);
        if constexpr (requires { l.area_m2(); }) out->set_area_m2(l.area_m2());
        if (const auto bounds = l.bounds()) {
          Vec3<double> lower = entry.origin_m + Vec3<double>(bounds->lower);
          Vec3<double> upper = entry.origin_m + Vec3<double>(bounds->upper);
          // A point is where the scene file puts it, not where a float can.
          if constexpr (requires { l.params().position_m; }) {
            if (lower == upper) lower = upper = l.params().position_m;
          }
          set(lower, out->mutable_bounds()->mutable_lower_m());
          set(upper, out->mutable_bounds()->mutable_upper_m());
          if (bounds->cone_rad < std::numbers::pi) {
            set(Vec3<double>(bounds->axis), out->mutable_directions()->mutable_axis());
            out->mutable_directions()->set_half_angle_rad(bounds->cone_rad);
          }
        }
        set_kind(l, out);
      },
      entry.light);
  if (entry.motion) set_motion(*entry.motion, scene.origin(), out->mutable_motion());
  const Power power = light_power(scene, light);
  out->set_power_lm(luminance(power.lumens));
  out->set_power_error_lm(power.error_lumens);
  if (const Spectrum* spectrum = scene.spectrum(light)) {
    set_spectrum(*spectrum, out->mutable_spectrum());
    out->set_power_w(out->power_lm() * spectrum->watts_per_lumen());
  }
}

void set_summary(const StoredScene& stored, v1::SceneSummary* out) {
  const Scene& scene = *stored.scene;
  out->set_scene_id(scene.id());
  out->set_path(stored.path);
  out->set_shapes(scene.shape_count());
  out->set_primitives(scene.primitive_count());
  out->set_lights(scene.lights().size());
  set(scene.origin(), out->mutable_origin_m());
  set(scene.origin() + scene.sphere().center_m, out->mutable_center_m());
  out->set_radius_m(scene.sphere().radius_m);
  out->set_image_width(static_cast<std::uint32_t>(scene.camera().width()));
  out->set_image_height(static_cast<std::uint32_t>(scene.camera().height()));
  const RenderHints& hints = scene.hints();
  if (hints.samples_per_pixel) {
    out->set_samples_per_pixel(static_cast<std::uint32_t>(*hints.samples_per_pixel));
  }
  if (const auto bounces = hinted_bounces(scene)) out->set_bounces(*bounces);
  out->set_shutter_open_s(hints.shutter_open_s);
  out->set_shutter_close_s(hints.shutter_close_s);
  std::uint64_t bytes = 0;
  for (const ScenePart& part : scene.parts()) bytes += part.bytes;
  out->set_bytes(bytes);
}

void add_remarks(const Scene& scene, google::protobuf::RepeatedPtrField<v1::Remark>* out) {
  for (const Remark& remark : scene.remarks()) {
    v1::Remark* r = out->Add();
    r->set_file(remark.where.file);
    r->set_line(static_cast<std::uint32_t>(remark.where.line));
    r->set_column(static_cast<std::uint32_t>(remark.where.column));
    r->set_what(remark.what);
    r->set_instead(remark.instead);
  }
}

void set_parts(const Scene& scene, v1::GetSceneResponse* out) {
  for (const ScenePart& part : scene.parts()) {
    v1::ScenePart* p = out->add_parts();
    p->set_name(part.name);
    p->set_bytes(part.bytes);
    p->set_build_ms(part.build_ms);
    p->set_why(part.why);
  }
  for (const Asset& asset : scene.assets()) {
    v1::NamedAsset* a = out->add_assets();
    a->set_name(asset.name);
    a->set_sha256(asset.sha256);
  }
}

}  // namespace lucerna::rpc
