#include "client/cli/area_light_shape.h"

#include <absl/strings/ascii.h>
#include <absl/strings/strip.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "client/terminal/output.h"

namespace lucerna::cli {
namespace {

using Vector = std::array<double, 3>;

Vector difference(const v1::Vector3& a, const v1::Vector3& b) {
  return {a.x() - b.x(), a.y() - b.y(), a.z() - b.z()};
}

double length(const Vector& v) { return std::hypot(v[0], v[1], v[2]); }

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Six digits of `v` [m], which was a float.  More digits would show its rounding.
std::string metres(double v) { return number(static_cast<float>(v)); }

/// Corners at (u, v) = (0, 0), (1, 0), (0, 1), (1, 1).
std::string describe_patch(const google::protobuf::RepeatedPtrField<v1::Vector3>& corners) {
  if (corners.size() != 4) return "quadrilateral";
  const Vector a = difference(corners[1], corners[0]), b = difference(corners[2], corners[0]);
  const Vector c = difference(corners[3], corners[2]);
  const double width = length(a), height = length(b);
  // Coordinates are floats relative to the middle of the scene, so small differences are rounding.
  constexpr double kTolerance = 1e-4;
  const double least = kTolerance * std::min(width, height);
  const Vector off = {a[0] - c[0], a[1] - c[1], a[2] - c[2]};
  if (length(off) > least || std::fabs(dot(a, b)) > kTolerance * width * height) {
    return "quadrilateral";
  }
  return fmt::format("rectangle {} x {} m", metres(std::max(width, height)),
                     metres(std::min(width, height)));
}

std::string swept(const v1::RoundShape& round) {
  const double degrees = round.phi_max_rad() * 180 / std::numbers::pi;
  return degrees < 360 - 1e-9 ? fmt::format(", {} deg of it", number(degrees)) : "";
}

std::string describe_sphere(const v1::RoundShape& round) {
  const double r = round.radius_m();
  std::string text = fmt::format("sphere of diameter {} m", number(2 * r));
  if (round.z_min_m() > -r * (1 - 1e-9) || round.z_max_m() < r * (1 - 1e-9)) {
    text += fmt::format(" from {} to {} m along {}", number(round.z_min_m()),
                        number(round.z_max_m()), direction(round.axes().z()));
  }
  text += swept(round);
  return round.reverse_orientation() ? text + ", shining inwards" : text;
}

std::string describe_disk(const v1::RoundShape& round) {
  std::string text = round.has_radius_y_m()
                         ? fmt::format("ellipse {} x {} m",
                                       number(2 * std::max(round.radius_m(), round.radius_y_m())),
                                       number(2 * std::min(round.radius_m(), round.radius_y_m())))
                         : fmt::format("disk of diameter {} m", number(2 * round.radius_m()));
  if (round.inner_radius_m() > 0) {
    text +=
        round.has_radius_y_m()
            ? fmt::format(", hole of {}%", number(100 * round.inner_radius_m() / round.radius_m()))
            : fmt::format(", hole of {} m", number(2 * round.inner_radius_m()));
  }
  return text + swept(round);
}

/// Other shapes that run along z.  A server may know more shapes than this program.
std::string describe_other(const v1::DiffuseAreaLight& area) {
  const std::string& name = v1::AreaShape_Name(area.shape());
  if (name.empty() || area.shape() == v1::AREA_SHAPE_UNSPECIFIED)
    return fmt::format("shape {}", static_cast<int>(area.shape()));
  const v1::RoundShape& round = area.round();
  const std::string text = fmt::format(
      "{} of diameter {} m, length {} m{}",
      absl::AsciiStrToLower(absl::StripPrefix(name, "AREA_SHAPE_")), number(2 * round.radius_m()),
      number(round.z_max_m() - round.z_min_m()), swept(round));
  return round.reverse_orientation() ? text + ", shining inwards" : text;
}

}  // namespace

std::string describe_shape(const v1::DiffuseAreaLight& area) {
  switch (area.shape()) {
    case v1::AREA_SHAPE_TRIANGLE_MESH:
      return area.primitives() == 1 ? "triangle" : fmt::format("{} triangles", area.primitives());
    case v1::AREA_SHAPE_BILINEAR_MESH:
      return area.primitives() == 1 ? describe_patch(area.corners_m())
                                    : fmt::format("{} quadrilaterals", area.primitives());
    case v1::AREA_SHAPE_SPHERE:
      return describe_sphere(area.round());
    case v1::AREA_SHAPE_DISK:
      return describe_disk(area.round());
    default:
      return describe_other(area);
  }
}

}  // namespace lucerna::cli
