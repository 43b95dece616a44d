#include "client/cli/light_table.h"

#include <absl/strings/str_replace.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "client/cli/area_light_shape.h"
#include "client/terminal/luminance.h"
#include "client/terminal/output.h"

namespace lucerna::cli {
namespace {

/// Bounds are rounded outwards, so a flat bound at 0 reaches to the smallest floats beside 0.
double coordinate(double x) { return std::fabs(x) < std::numeric_limits<float>::min() ? 0 : x; }

std::string xyz(const v1::Vector3& v) {
  return triple(coordinate(v.x()), coordinate(v.y()), coordinate(v.z()));
}

std::string degrees(double radians) { return number(radians * 180 / std::numbers::pi) + " deg"; }

/// One number for a level that is grey in the printed digits.
std::string level(const v1::Rgb& c, const std::string& unit = {}) {
  const std::string r = number(c.r()), g = number(c.g()), b = number(c.b());
  const std::string behind = unit.empty() ? "" : " " + unit;
  if (r == g && g == b) return g + behind;
  const double rgb[] = {c.r(), c.g(), c.b()};
  return fmt::format("{}{} (RGB {} {} {})", number(luminance(rgb)), behind, r, g, b);
}

std::string describe_light(const v1::ImageInfo& image, const char* mapping = nullptr) {
  std::string how = fmt::format("{} x {} px", image.width(), image.height());
  if (mapping != nullptr) how += std::string(", ") + mapping;
  if (image.filter() == v1::IMAGE_FILTER_NEAREST) how += ", nearest";
  if (image.filter() == v1::IMAGE_FILTER_BILINEAR) how += ", bilinear";
  return fmt::format("image{}{} ({})", image.name().empty() ? "" : " ", image.name(), how);
}

std::string describe_light(const v1::SphereImage& map) {
  switch (map.mapping()) {
    case v1::SPHERE_MAPPING_EQUAL_AREA:
      return describe_light(map.image(), "equal-area");
    case v1::SPHERE_MAPPING_LATITUDE_LONGITUDE:
      return describe_light(map.image(), "latitude-longitude");
    default:
      return describe_light(map.image());
  }
}

std::string describe_light(const v1::PhotometricFile& file) {
  return fmt::format("{} ({}, {} {})", file.name(), file.format(), number(file.flux_lm()),
                     file.flux_unit().empty() ? "lm" : file.flux_unit());
}

std::string describe_light(const v1::Spectrum& spectrum) {
  switch (spectrum.kind_case()) {
    case v1::Spectrum::kBlackBodyK:
      return fmt::format("black body {} K", number(spectrum.black_body_k()));
    case v1::Spectrum::kIlluminant:
      return "CIE illuminant " + spectrum.illuminant();
    case v1::Spectrum::kSampled: {
      const auto& nm = spectrum.sampled().wavelengths_nm();
      if (nm.empty()) return "spectrum";
      return fmt::format("spectrum {} to {} nm", number(nm[0]), number(nm[nm.size() - 1]));
    }
    default:
      return "spectrum";
  }
}

std::string describe_light(const v1::SpotLight& spot) {
  const double edge = spot.cone_half_angle_rad() - spot.falloff_start_rad();
  std::string text = "half angle " + degrees(spot.cone_half_angle_rad());
  text += edge > 0 ? ", edge " + degrees(edge) : ", hard edge";
  if (edge > 0 && spot.profile() == v1::SPOT_PROFILE_QUADRATIC) text += " (quadratic)";
  if (edge > 0 && spot.profile() == v1::SPOT_PROFILE_QUARTIC) text += " (quartic)";
  return text + ", " + level(spot.intensity_cd(), "cd");
}

std::string describe_light(const v1::GoniometricLight& light) {
  switch (light.distribution_case()) {
    case v1::GoniometricLight::kImage:
      return fmt::format("{}, {} at 1", describe_light(light.image()),
                         level(light.intensity(), "cd"));
    case v1::GoniometricLight::kPhotometricFile: {
      const std::string times = level(light.intensity());
      const std::string text = describe_light(light.photometric_file());
      return times == "1" ? text : text + ", times " + times;
    }
    default:
      return level(light.intensity(), "cd");
  }
}

/// The flux of a panel relative to its file.  A one-sided panel has no flux to its back.
std::string flux_of_panel(const v1::DiffuseAreaLight& area, double area_m2) {
  const double of_1 = (area.two_sided() ? 2 : 1) * std::numbers::pi * area_m2;
  const double file_lm = area.profile().flux_lm();
  if (!(of_1 > 0 && file_lm > 0)) return "";
  v1::Rgb times;
  times.set_r(area.radiance_cd_m2().r() * of_1 / file_lm);
  times.set_g(area.radiance_cd_m2().g() * of_1 / file_lm);
  times.set_b(area.radiance_cd_m2().b() * of_1 / file_lm);
  const std::string text = level(times);
  return text == "1" ? "" : ", flux times " + text;
}

std::string describe_light(const v1::DiffuseAreaLight& area, double area_m2) {
  std::string text = describe_shape(area) + ", " + level(area.radiance_cd_m2(), "cd/m2");
  if (area.has_image()) text += " at 1, " + describe_light(area.image());
  if (area.has_profile()) {
    text += ", profile " + describe_light(area.profile()) + flux_of_panel(area, area_m2);
  }
  if (area.two_sided()) text += ", two-sided";
  return area.invisible() ? text + ", invisible" : text;
}

std::string with_image(std::string text, bool has, const v1::ImageInfo& image) {
  return has ? text + " at 1, " + describe_light(image) : text;
}

/// The field of `kind` that is set; null: none.
const google::protobuf::FieldDescriptor* kind_field(const v1::Light& light) {
  return light.GetReflection()->GetOneofFieldDescriptor(
      light, light.GetDescriptor()->FindOneofByName("kind"));
}

/// The words for a kind that has no others here.
std::string fields_of(const v1::Light& light) {
  const auto* kind = kind_field(light);
  if (kind == nullptr) return "";
  return "{" + light.GetReflection()->GetMessage(light, kind).ShortDebugString() + "}";
}

std::string describe_kind(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return level(light.point().intensity_cd(), "cd");
    case v1::Light::kSpot:
      return describe_light(light.spot());
    case v1::Light::kDistant:
      return level(light.distant().illuminance_lx(), "lx");
    case v1::Light::kUniformInfinite:
      return level(light.uniform_infinite().radiance_cd_m2(), "cd/m2");
    case v1::Light::kDiffuseArea:
      return describe_light(light.diffuse_area(), light.area_m2());
    case v1::Light::kProjection: {
      const v1::ProjectionLight& p = light.projection();
      return with_image(fmt::format("{} on the shorter side, aspect {}, {}", degrees(p.fov_rad()),
                                    number(p.aspect()), level(p.intensity_cd(), "cd")),
                        p.has_image(), p.image());
    }
    case v1::Light::kBeam: {
      const v1::BeamLight& b = light.beam();
      return with_image(fmt::format("{} x {} m, {}", number(b.width_m()), number(b.height_m()),
                                    level(b.illuminance_lx(), "lx")),
                        b.has_image(), b.image());
    }
    case v1::Light::kGoniometric:
      return describe_light(light.goniometric());
    case v1::Light::kSun:
      return fmt::format("{} across, {}", degrees(light.sun().angular_diameter_rad()),
                         level(light.sun().illuminance_lx(), "lx"));
    case v1::Light::kImageInfinite: {
      const v1::ImageInfiniteLight& sky = light.image_infinite();
      const std::string radiance = level(sky.radiance_cd_m2(), "cd/m2");
      return (sky.has_map() ? fmt::format("{}, {} at 1", describe_light(sky.map()), radiance)
                            : radiance) +
             (sky.portal_m_size() > 0 ? ", through a portal" : "");
    }
    default:
      return fields_of(light);
  }
}

std::string pointing(const v1::Vector3& position, const v1::Vector3& axis) {
  return xyz(position) + " towards " + direction(axis);
}

bool is_left_handed(const v1::Axes& axes) {
  const v1::Vector3 &x = axes.x(), &y = axes.y(), &z = axes.z();
  return x.x() * (y.y() * z.z() - y.z() * z.y()) + x.y() * (y.z() * z.x() - y.x() * z.z()) +
             x.z() * (y.x() * z.y() - y.y() * z.x()) <
         0;
}

bool is_type(const v1::PhotometricFile& file, char type) {
  return file.format().ends_with(std::string(", type ") + type);
}

/// The turn of a luminaire about its downward axis.
std::string turn_of_luminaire(const v1::PhotometricFile& file, const v1::Axes& axes) {
  // The direction of x: plane C0 of type C and EULUMDAT; V = 90 of type B; the beam of type A.
  const char* x = is_type(file, 'A') ? "V 0 H 0" : is_type(file, 'B') ? "V 90" : "C0";
  return fmt::format(", {} to {}{}", x, direction(axes.x()),
                     is_left_handed(axes) ? ", mirrored" : "");
}

/// Direction of a luminaire and its turn about that direction.
std::string aim_of_luminaire(const v1::PhotometricFile& file, const v1::Axes& axes) {
  if (!is_type(file, 'A')) {
    return " towards " + direction(axes.z()) + turn_of_luminaire(file, axes);
  }
  return fmt::format(" towards {}, down to {}{}", direction(axes.x()), direction(axes.z()),
                     is_left_handed(axes) ? ", mirrored" : "");
}

/// The turn of a picture around a point; empty if it is not turned.
std::string turn_of_picture(const v1::Axes& axes) {
  const std::string x = direction(axes.x()), y = direction(axes.y()), z = direction(axes.z());
  if (x == "1 0 0" && y == "0 1 0" && z == "0 0 1") return "";
  return ", +x to " + x + ", +y to " + y + ", +z to " + z;
}

/// Bounding box; the normal of a one-sided plane; the axis of a tube.
std::string place_of_area(const v1::Light& light) {
  std::string text = xyz(light.bounds().lower_m()) + " to " + xyz(light.bounds().upper_m());
  constexpr double kHemisphere = std::numbers::pi / 2 + 1e-3;
  if (light.has_directions() && light.directions().half_angle_rad() <= kHemisphere) {
    text += ", facing " + direction(light.directions().axis());
  }
  const v1::DiffuseAreaLight& area = light.diffuse_area();
  if (area.shape() == v1::AREA_SHAPE_CYLINDER && area.has_round()) {
    text += ", along " + direction(area.round().axes().z());
  }
  return area.has_profile_axes() ? text + turn_of_luminaire(area.profile(), area.profile_axes())
                                 : text;
}

std::string place_of_goniometric(const v1::Light& light) {
  const v1::GoniometricLight& lamp = light.goniometric();
  std::string text = xyz(lamp.position_m());
  if (lamp.has_photometric_file() && lamp.has_axes()) {
    text += aim_of_luminaire(lamp.photometric_file(), lamp.axes());
  } else if (lamp.has_axes()) {
    text += turn_of_picture(lamp.axes());
  }
  if (!light.has_directions()) return text;
  // The bound is a little wider than the cone, so two decimals are enough.
  const double half_angle = light.directions().half_angle_rad() * 180 / std::numbers::pi;
  return fmt::format("{}, within {} deg of {}", text, number(std::round(half_angle * 100) / 100),
                     direction(light.directions().axis()));
}

std::string place_of_sky(const v1::ImageInfiniteLight& sky) {
  std::string corners;
  for (const v1::Vector3& corner : sky.portal_m()) {
    corners += (corners.empty() ? "through " : ", ") + xyz(corner);
  }
  return (corners.empty() ? "all around" : corners) +
         (sky.has_axes() ? turn_of_picture(sky.axes()) : "");
}

}  // namespace

std::string type_of(const v1::Light& light) {
  if (light.has_diffuse_area()) return "area";
  if (light.has_image_infinite() && !light.image_infinite().has_map()) return "infinite";
  const auto* kind = kind_field(light);
  return kind == nullptr ? "unknown" : absl::StrReplaceAll(kind->name(), {{"_", " "}});
}

std::string describe_light(const v1::Light& light) {
  std::string text = describe_kind(light);
  if (light.has_own_axes()) text += ", scaled unequally";
  if (light.has_spectrum()) text += ", " + describe_light(light.spectrum());
  if (light.has_power_w()) text += fmt::format(", {} W", number(light.power_w()));
  if (const auto& frames = light.motion().key_frames(); frames.size() > 1) {
    text += fmt::format(", moves from {} to {} s", number(frames[0].time_s()),
                        number(frames[frames.size() - 1].time_s()));
  }
  return text;
}

std::string place_of(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return xyz(light.point().position_m());
    case v1::Light::kSpot:
      return pointing(light.spot().position_m(), light.spot().axis());
    case v1::Light::kDistant:
      return "from " + direction(light.distant().to_light());
    case v1::Light::kUniformInfinite:
      return "all around";
    case v1::Light::kDiffuseArea:
      return place_of_area(light);
    case v1::Light::kProjection:
      return pointing(light.projection().position_m(), light.projection().axis());
    case v1::Light::kBeam:
      return pointing(light.beam().position_m(), light.beam().axis());
    case v1::Light::kGoniometric:
      return place_of_goniometric(light);
    case v1::Light::kSun:
      return "from " + direction(light.sun().to_light());
    case v1::Light::kImageInfinite:
      return place_of_sky(light.image_infinite());
    case v1::Light::KIND_NOT_SET:
      return "";
    default:
      return light.has_bounds() ? place_of_area(light) : "at infinity";
  }
}

bool is_at_infinity(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kDistant:
    case v1::Light::kSun:
    case v1::Light::kUniformInfinite:
    case v1::Light::kImageInfinite:
      return true;
    default:
      return false;
  }
}

std::string flux_text(double lumens, bool from_infinity) {
  return (from_infinity ? "*" : "") + number(lumens);
}

Cell flux_cell(double lumens, bool from_infinity) {
  return {flux_text(lumens, from_infinity), number_cell(lumens).values()};
}

Cell error_cell(double lumens) { return lumens == 0 ? Cell("exact", {"0"}) : number_cell(lumens); }

std::string light_notes(const google::protobuf::RepeatedPtrField<v1::Light>& lights) {
  const bool any = std::any_of(lights.begin(), lights.end(), is_at_infinity);
  return any ? std::string(kFluxFromInfinity) + "\n" : "";
}

Table light_table(const google::protobuf::RepeatedPtrField<v1::Light>& lights) {
  const bool any_name = std::any_of(lights.begin(), lights.end(),
                                    [](const v1::Light& light) { return !light.name().empty(); });
  std::vector<Table::Column> columns = {{"id"}};
  if (any_name) columns.push_back({"name", true});
  const std::string in_lumens = lumens_header(lights);
  columns.insert(columns.end(), {{"type", true},
                                 {"what", true},
                                 {"where [m]", true},
                                 {"area [m2]"},
                                 {"flux" + in_lumens},
                                 {"±" + in_lumens}});
  if (in_lumens.empty()) columns.push_back({"unit", true});
  columns.insert(columns.end(), {{"delta", true}, {"made at", true}});
  Table table(columns);
  for (const v1::Light& light : lights) {
    std::vector<Cell> row = {std::to_string(light.id())};
    if (any_name) row.push_back(light.name());
    row.insert(row.end(), {type_of(light), describe_light(light), place_of(light),
                           light.has_area_m2() ? number_cell(light.area_m2()) : Cell(),
                           flux_cell(light.power_lm(), is_at_infinity(light)),
                           error_cell(light.power_error_lm())});
    if (in_lumens.empty()) row.push_back(flux_unit(light));
    row.insert(row.end(), {light.delta() ? "yes" : "no", light.source()});
    table.add(std::move(row));
  }
  return table;
}

}  // namespace lucerna::cli
