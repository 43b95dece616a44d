#include "client/cli/light_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "client/cli/output.h"

namespace lucerna::cli {
namespace {

std::string xyz(const v1::Vector3& v) { return triple(v.x(), v.y(), v.z()); }

/// The unit vector along `v` to four decimals, which is 0.003 degrees.
std::string direction(const v1::Vector3& v) {
  const double length = std::hypot(v.x(), v.y(), v.z());
  // + 0.0: no -0 where roundings leave a little below it.
  const auto rounded = [&](double x) { return std::round(x / length * 1e4) / 1e4 + 0.0; };
  return triple(rounded(v.x()), rounded(v.y()), rounded(v.z()));
}

std::string degrees(double radians) { return number(radians * 180 / std::numbers::pi) + " deg"; }

/// One number where it is grey.  The weights are those of Rec. 709 with white D65, which is what
/// the contract's RGB is.  [ITU-R BT.709]
std::string level(const v1::Rgb& c, const char* unit) {
  if (c.r() == c.g() && c.g() == c.b()) return fmt::format("{} {}", number(c.r()), unit);
  return fmt::format("{} {} (RGB {})",
                     number(0.212639 * c.r() + 0.715169 * c.g() + 0.072192 * c.b()), unit,
                     triple(c.r(), c.g(), c.b()));
}

std::string describe(const v1::ImageInfo& image, const char* mapping = nullptr) {
  std::string how = fmt::format("{} x {} px", image.width(), image.height());
  if (mapping != nullptr) how += std::string(", ") + mapping;
  if (image.filter() == v1::IMAGE_FILTER_NEAREST) how += ", nearest";
  if (image.filter() == v1::IMAGE_FILTER_BILINEAR) how += ", bilinear";
  return fmt::format("image{}{} ({})", image.name().empty() ? "" : " ", image.name(), how);
}

std::string describe(const v1::SphereImage& map) {
  switch (map.mapping()) {
    case v1::SPHERE_MAPPING_EQUAL_AREA:
      return describe(map.image(), "equal-area");
    case v1::SPHERE_MAPPING_LATITUDE_LONGITUDE:
      return describe(map.image(), "latitude-longitude");
    default:
      return describe(map.image());
  }
}

std::string describe(const v1::PhotometricFile& file) {
  return fmt::format("{} ({}, {} lm)", file.name(), file.format(), number(file.flux_lm()));
}

std::string describe(const v1::Spectrum& spectrum) {
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

/// Extents of the light's bounds [m], the smallest first.
std::array<double, 3> extents(const v1::Light& light) {
  const v1::Vector3& a = light.bounds().lower_m();
  const v1::Vector3& b = light.bounds().upper_m();
  std::array<double, 3> e = {b.x() - a.x(), b.y() - a.y(), b.z() - a.z()};
  std::sort(e.begin(), e.end());
  return e;
}

/// Equal but for the rounding of coordinates to floats.
bool alike(double a, double b) { return std::abs(a - b) <= 1e-4 * std::max(a, b); }

/// The shape with its size, as far as area and bounds determine it: a flat quadrilateral that fills
/// its bounds is a rectangle, the boxes of whole disks and spheres tell their diameter.
std::string shape_of(const v1::Light& light) {
  const v1::DiffuseAreaLight& area = light.diffuse_area();
  const auto [least, middle, most] = extents(light);
  const auto count = area.primitives();
  switch (area.shape()) {
    case v1::AREA_SHAPE_TRIANGLE_MESH:
      return count == 1 ? "triangle" : fmt::format("{} triangles", count);
    case v1::AREA_SHAPE_BILINEAR_MESH:
      if (count != 1) return fmt::format("{} quadrilaterals", count);
      if (least <= 1e-4 * middle && alike(light.area_m2(), middle * most)) {
        return fmt::format("rectangle {} x {} m", number(static_cast<float>(most)),
                           number(static_cast<float>(middle)));
      }
      return "quadrilateral";
    case v1::AREA_SHAPE_SPHERE:
      if (alike(least, most) && alike(light.area_m2(), std::numbers::pi * most * most)) {
        return fmt::format("sphere of diameter {} m",
                           number(std::sqrt(light.area_m2() / std::numbers::pi)));
      }
      return "part of a sphere";
    case v1::AREA_SHAPE_DISK: {
      // The box of a disk of normal n has the sides d sqrt(1 - n_i^2), whose squares add up to
      // twice d^2.
      const double d2 = (least * least + middle * middle + most * most) / 2;
      if (alike(light.area_m2(), std::numbers::pi / 4 * d2)) {
        return fmt::format("disk of diameter {} m",
                           number(std::sqrt(light.area_m2() * 4 / std::numbers::pi)));
      }
      return "ring or part of a disk";
    }
    case v1::AREA_SHAPE_CYLINDER: {
      // Along an axis of the world two sides of the box are its diameter and one its length.
      const bool longer = alike(least, middle);
      const double diameter = longer ? least : most, length = longer ? most : least;
      if ((longer || alike(middle, most)) &&
          alike(light.area_m2(), std::numbers::pi * diameter * length)) {
        return fmt::format("cylinder of diameter {} m, length {} m",
                           number(static_cast<float>(diameter)),
                           number(static_cast<float>(length)));
      }
      return "cylinder";
    }
    default:
      return fmt::format("shape {}", static_cast<int>(area.shape()));
  }
}

std::string describe(const v1::SpotLight& spot) {
  const double edge = spot.cone_half_angle_rad() - spot.falloff_start_rad();
  std::string text = "half angle " + degrees(spot.cone_half_angle_rad());
  text += edge > 0 ? ", edge " + degrees(edge) : ", hard edge";
  if (edge > 0 && spot.profile() == v1::SPOT_PROFILE_QUARTIC) text += " (quartic)";
  return text + ", " + level(spot.intensity_cd(), "cd");
}

std::string describe(const v1::GoniometricLight& light) {
  switch (light.distribution_case()) {
    case v1::GoniometricLight::kImage:
      return fmt::format("{}, {} at 1", describe(light.image()), level(light.intensity(), "cd"));
    case v1::GoniometricLight::kPhotometricFile: {
      const v1::Rgb& c = light.intensity();
      std::string text = describe(light.photometric_file());
      if (c.r() != 1 || c.g() != 1 || c.b() != 1) text += ", times " + level(c, "");
      if (text.ends_with(' ')) text.pop_back();
      return text;
    }
    default:
      return level(light.intensity(), "cd");
  }
}

std::string describe_area(const v1::Light& light) {
  const v1::DiffuseAreaLight& area = light.diffuse_area();
  std::string text = shape_of(light) + ", " + level(area.radiance_cd_m2(), "cd/m2");
  if (area.has_image()) text += " at 1, " + describe(area.image());
  if (area.has_profile()) text += ", profile " + describe(area.profile());
  return area.two_sided() ? text + ", two-sided" : text;
}

std::string with_image(std::string text, bool has, const v1::ImageInfo& image) {
  return has ? text + " at 1, " + describe(image) : text;
}

std::string describe_kind(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return level(light.point().intensity_cd(), "cd");
    case v1::Light::kSpot:
      return describe(light.spot());
    case v1::Light::kDistant:
      return level(light.distant().illuminance_lx(), "lx");
    case v1::Light::kUniformInfinite:
      return level(light.uniform_infinite().radiance_cd_m2(), "cd/m2");
    case v1::Light::kDiffuseArea:
      return describe_area(light);
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
      return describe(light.goniometric());
    case v1::Light::kSun:
      return fmt::format("{} across, {}", degrees(light.sun().angular_diameter_rad()),
                         level(light.sun().illuminance_lx(), "lx"));
    case v1::Light::kImageInfinite: {
      const v1::ImageInfiniteLight& sky = light.image_infinite();
      const std::string radiance = level(sky.radiance_cd_m2(), "cd/m2");
      return (sky.has_map() ? fmt::format("{}, {} at 1", describe(sky.map()), radiance)
                            : radiance) +
             (sky.portal_m_size() > 0 ? ", through a portal" : "");
    }
    case v1::Light::KIND_NOT_SET:
      break;
  }
  return "";
}

std::string pointing(const v1::Vector3& position, const v1::Vector3& axis) {
  return xyz(position) + " towards " + direction(axis);
}

/// A box, and the normal of what shines from one side of a plane.
std::string place_of_area(const v1::Light& light) {
  std::string text = xyz(light.bounds().lower_m()) + " to " + xyz(light.bounds().upper_m());
  constexpr double kHemisphere = std::numbers::pi / 2 + 1e-3;
  if (light.has_directions() && light.directions().half_angle_rad() <= kHemisphere) {
    text += ", facing " + direction(light.directions().axis());
  }
  return text;
}

std::string place_of_luminaire(const v1::Light& light) {
  const std::string position = xyz(light.goniometric().position_m());
  if (!light.has_directions()) return position;
  // A bound, a little wider than the cone: no more digits than are meant.
  const double half_angle = light.directions().half_angle_rad() * 180 / std::numbers::pi;
  return fmt::format("{}, within {} deg of {}", position,
                     number(std::round(half_angle * 100) / 100),
                     direction(light.directions().axis()));
}

}  // namespace

std::string type_of(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return "point";
    case v1::Light::kSpot:
      return "spot";
    case v1::Light::kDistant:
      return "distant";
    case v1::Light::kUniformInfinite:
      return "uniform infinite";
    case v1::Light::kDiffuseArea:
      return "area";
    case v1::Light::kProjection:
      return "projection";
    case v1::Light::kBeam:
      return "beam";
    case v1::Light::kGoniometric:
      return "goniometric";
    case v1::Light::kSun:
      return "sun";
    case v1::Light::kImageInfinite:
      return light.image_infinite().has_map() ? "image infinite" : "infinite";
    case v1::Light::KIND_NOT_SET:
      break;
  }
  return "unknown";
}

std::string describe(const v1::Light& light) {
  std::string text = describe_kind(light);
  if (light.has_spectrum()) text += ", " + describe(light.spectrum());
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
      return place_of_luminaire(light);
    case v1::Light::kSun:
      return "from " + direction(light.sun().to_light());
    case v1::Light::kImageInfinite: {
      std::string corners;
      for (const v1::Vector3& corner : light.image_infinite().portal_m()) {
        corners += (corners.empty() ? "" : ", ") + xyz(corner);
      }
      return corners.empty() ? "all around" : "through " + corners;
    }
    case v1::Light::KIND_NOT_SET:
      break;
  }
  return "";
}

std::string light_table(const google::protobuf::RepeatedPtrField<v1::Light>& lights) {
  Table table({{"id"},
               {"type", true},
               {"what", true},
               {"where [m]", true},
               {"area [m2]"},
               {"flux [lm]"},
               {"± [lm]"},
               {"delta", true},
               {"made at", true}});
  for (const v1::Light& light : lights) {
    table.add({std::to_string(light.id()), type_of(light), describe(light), place_of(light),
               light.has_area_m2() ? number(light.area_m2()) : "", number(light.power_lm()),
               light.power_error_lm() == 0 ? "exact" : number(light.power_error_lm()),
               light.delta() ? "yes" : "no", light.source()});
  }
  return table.to_string();
}

}  // namespace lucerna::cli
