#include "client/lab/variation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lucerna::verify {

using std::numbers::pi;

double dot(const Double3& a, const Double3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Double3 cross(const Double3& a, const Double3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Double3 operator+(const Double3& a, const Double3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Double3 operator-(const Double3& a, const Double3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Double3 operator*(double s, const Double3& v) { return {s * v[0], s * v[1], s * v[2]}; }
double length(const Double3& v) { return std::hypot(v[0], v[1], v[2]); }
Double3 normalized(const Double3& v) { return (1 / length(v)) * v; }
Double3 double3(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

Double3 Variation::vector(const Double3& v) const {
  return {dot(turn[0], v), dot(turn[1], v), dot(turn[2], v)};
}
Double3 Variation::back(const Double3& v) const {
  return v[0] * turn[0] + v[1] * turn[1] + v[2] * turn[2];
}
Double3 Variation::point(const Double3& x) const {
  return center + (1 / scale) * vector(x - center);
}
std::vector<Double3> Variation::points(const std::vector<Double3>& all) const {
  std::vector<Double3> result;
  result.reserve(all.size());
  for (const Double3& x : all) result.push_back(point(x));
  return result;
}
std::vector<Double3> Variation::vectors(const std::vector<Double3>& all) const {
  std::vector<Double3> result;
  result.reserve(all.size());
  for (const Double3& v : all) result.push_back(vector(v));
  return result;
}

namespace {

Matrix matrix(const v1::Axes& axes) {
  return {normalized(double3(axes.x())), normalized(double3(axes.y())),
          normalized(double3(axes.z()))};
}

LightFrame frame_of(const v1::DiffuseAreaLight& area) {
  LightFrame f;
  f.flat = area.shape() != v1::AREA_SHAPE_SPHERE && area.shape() != v1::AREA_SHAPE_CYLINDER;
  if (area.has_round()) {
    const v1::RoundShape& round = area.round();
    f.axes = matrix(round.axes());
    // z_min and z_max need not be symmetric.
    f.center = double3(round.center_m()) +
               (round.z_min_m() + round.z_max_m()) / 2 * normalized(double3(round.axes().z()));
    if (f.flat && round.reverse_orientation()) {
      f.axes[2] = -1.0 * f.axes[2];
      f.axes[0] = -1.0 * f.axes[0];
    }
    f.has_axes = true;
    f.all_turns = area.shape() == v1::AREA_SHAPE_SPHERE;
    return f;
  }
  if (area.corners_m_size() >= 3) {
    const Double3 origin = double3(area.corners_m(0));
    const Double3 u = double3(area.corners_m(1)) - origin, v = double3(area.corners_m(2)) - origin;
    const Double3 n = cross(u, v);
    if (length(n) > 0) {
      f.axes = {normalized(u), cross(normalized(n), normalized(u)), normalized(n)};
      f.center = origin + 0.5 * (u + v);
      f.has_axes = true;
      f.quarter_turns = std::fabs(length(u) - length(v)) < 1e-6 * length(u);
    }
  }
  return f;
}

}  // namespace

LightFrame frame_of(const v1::Light& light) {
  LightFrame f;
  switch (light.kind_case()) {
    case v1::Light::kDiffuseArea:
      f = frame_of(light.diffuse_area());
      break;
    case v1::Light::kProjection: {
      const auto& p = light.projection();
      f = {double3(p.position_m()),
           {double3(p.right()), double3(p.up()), double3(p.axis())},
           true,
           false,
           std::fabs(p.aspect() - 1) < 1e-6};
      break;
    }
    case v1::Light::kBeam: {
      const auto& p = light.beam();
      f = {double3(p.position_m()),
           {double3(p.right()), double3(p.up()), double3(p.axis())},
           true,
           false,
           std::fabs(p.width_m() - p.height_m()) < 1e-6 * p.width_m()};
      break;
    }
    case v1::Light::kGoniometric:
      f.center = double3(light.goniometric().position_m());
      f.has_axes = light.goniometric().has_axes();
      if (f.has_axes) f.axes = matrix(light.goniometric().axes());
      f.all_turns = true;
      break;
    case v1::Light::kImageInfinite:
      f.has_axes = light.image_infinite().has_axes() && light.image_infinite().portal_m_size() == 0;
      if (f.has_axes) f.axes = matrix(light.image_infinite().axes());
      f.all_turns = true;
      break;
    default:
      break;
  }
  if (!f.has_axes && light.has_bounds())
    f.center = 0.5 * (double3(light.bounds().lower_m()) + double3(light.bounds().upper_m()));
  return f;
}

namespace {

/// The matrix that takes axis i of the frame to sign[i] times axis to[i].
Matrix permutation(const Matrix& axes, const std::array<int, 3>& to,
                   const std::array<int, 3>& sign) {
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i) {
    // m += sign axes[to] axes[i]^T, by columns.
    const Double3 target = sign[i] * axes[static_cast<std::size_t>(to[i])];
    for (std::size_t column = 0; column < 3; ++column)
      m[column] = m[column] + axes[i][column] * target;
  }
  return m;
}

/// Whether its radiance or intensity follows a picture or a distribution, on a shape that can turn.
bool has_map(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kDiffuseArea: {
      const v1::DiffuseAreaLight& area = light.diffuse_area();
      return (area.has_image() || area.has_profile()) &&
             (area.has_round() || area.corners_m_size() == 4);
    }
    case v1::Light::kProjection:
      return light.projection().has_image();
    case v1::Light::kBeam:
      return light.beam().has_image();
    default:
      return true;  // without a map it has no axes
  }
}

bool is_even(const std::array<int, 3>& to) {
  return (to[0] == 0 && to[1] == 1) || (to[0] == 1 && to[1] == 2) || (to[0] == 2 && to[1] == 0);
}

/// "x becomes -y, y becomes x", or a shorter name for simple cases.
std::pair<std::string, std::string> describe(const std::array<int, 3>& to,
                                             const std::array<int, 3>& sign) {
  constexpr const char* kNames[] = {"x", "y", "z"};
  const int parity = (is_even(to) ? 1 : -1) * sign[0] * sign[1] * sign[2];
  const bool straight = to[0] == 0 && to[1] == 1 && to[2] == 2;
  std::string changes;
  for (std::size_t i = 0; i < 3; ++i) {
    if (to[i] == static_cast<int>(i) && sign[i] > 0) continue;
    changes += fmt::format("{}{} becomes {}{}", changes.empty() ? "" : ", ", kNames[i],
                           sign[i] < 0 ? "-" : "", kNames[to[i]]);
  }
  if (parity < 0)
    return {"map_mirrored",
            fmt::format("the map is mirrored ({} in the axes of the light)", changes)};
  if (straight) {
    for (std::size_t i = 0; i < 3; ++i)
      if (sign[i] > 0)
        return {"map_rotated",
                fmt::format("the map is rotated by 180 degrees about {} of the light", kNames[i])};
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (to[i] != static_cast<int>(i) || sign[i] < 0) continue;
    const std::size_t next = (i + 1) % 3;
    return {"map_rotated", fmt::format("the map is rotated by {} degrees about {} of the light",
                                       sign[next] > 0 ? 90 : -90, kNames[i])};
  }
  return {"map_rotated", fmt::format("the map is rotated ({} in the axes of the light)", changes)};
}

}  // namespace

std::vector<Variation> turned(const v1::Light& light) {
  std::vector<Variation> all;
  const LightFrame frame = frame_of(light);
  if (!frame.has_axes || !has_map(light)) return all;
  std::array<int, 3> to = {0, 1, 2};
  do {
    const bool keeps_z = to[2] == 2;
    if (!keeps_z && !frame.all_turns) continue;
    if (to[0] == 1 && keeps_z && !frame.quarter_turns) continue;
    for (int signs = 0; signs < 8; ++signs) {
      const std::array<int, 3> sign = {(signs & 1) != 0 ? -1 : 1, (signs & 2) != 0 ? -1 : 1,
                                       (signs & 4) != 0 ? -1 : 1};
      if (sign[2] < 0 && !frame.all_turns && light.kind_case() != v1::Light::kDiffuseArea) continue;
      if (frame.flat && sign[2] < 0) continue;
      if (to[0] == 0 && to[1] == 1 && signs == 0) continue;
      auto [mistake, sentence] = describe(to, sign);
      all.push_back({std::move(mistake),
                     std::move(sentence),
                     {},
                     frame.center,
                     1,
                     permutation(frame.axes, to, sign)});
    }
  } while (std::ranges::next_permutation(to).found);
  return all;
}

Variation turned_about_z(const LightFrame& frame, double degrees) {
  const double c = std::cos(degrees * pi / 180), s = std::sin(degrees * pi / 180);
  const Double3 x = c * frame.axes[0] + s * frame.axes[1];
  const Double3 y = c * frame.axes[1] - s * frame.axes[0];
  Matrix m{};
  const Matrix to = {x, y, frame.axes[2]};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t column = 0; column < 3; ++column)
      m[column] = m[column] + frame.axes[i][column] * to[i];
  return {"map_rotated",
          fmt::format("the map is rotated by {:g} degrees about z of the light", degrees),
          {},
          frame.center,
          1,
          m};
}

std::vector<Variation> resized(const v1::Light& light) {
  if (light.kind_case() != v1::Light::kDiffuseArea) return {};
  const bool round = light.diffuse_area().has_round();
  const Double3 center = frame_of(light).center;
  const char* larger = round ? "a diameter is taken for a radius: the light is twice as large"
                             : "a full length is taken for a half: the light is twice as large";
  const char* smaller = round ? "a radius is taken for a diameter: the light is half as large"
                              : "a half length is taken for a full one: the light is half as large";
  return {{"radius_diameter", larger, {}, center, 2, kIdentity},
          {"radius_diameter", smaller, {}, center, 0.5, kIdentity}};
}

namespace {

/// An angle in degrees of which the cosine is taken as if it were in radians.
double degrees_as_radians(double rad) { return std::acos(std::cos(rad * 180 / pi)); }

}  // namespace

std::vector<ChangedLight> with_other_angles(const v1::Light& light) {
  struct Angle {
    const char *mistake, *sentence;
    double (*of)(double);
  };
  static constexpr Angle kAngles[] = {
      {"half_full_angle", "a half angle is taken for a full one: the angle is half as large",
       [](double a) { return a / 2; }},
      {"half_full_angle", "a full angle is taken for a half: the angle is twice as large",
       [](double a) { return 2 * a; }},
      {"degrees", "an angle in degrees is taken for radians",
       [](double a) { return degrees_as_radians(a); }},
      {"degrees", "an angle in radians is taken for degrees",
       [](double a) { return a * pi / 180; }},
  };
  std::vector<ChangedLight> all;
  if (light.has_spectrum() || light.has_motion()) return all;
  for (const Angle& angle : kAngles) {
    ChangedLight changed{angle.mistake, angle.sentence, light};
    if (light.kind_case() == v1::Light::kSpot) {
      v1::SpotLight& spot = *changed.light.mutable_spot();
      const double cone = angle.of(spot.cone_half_angle_rad());
      const double falloff = angle.of(spot.falloff_start_rad());
      if (!(cone > 0 && cone <= pi)) continue;
      spot.set_cone_half_angle_rad(cone);
      spot.set_falloff_start_rad(std::min(falloff, cone));
    } else if (light.kind_case() == v1::Light::kSun) {
      const double diameter = angle.of(light.sun().angular_diameter_rad());
      if (!(diameter > 0 && diameter <= pi)) continue;
      changed.light.mutable_sun()->set_angular_diameter_rad(diameter);
    } else {
      return {};
    }
    all.push_back(std::move(changed));
  }
  return all;
}

}  // namespace lucerna::verify
