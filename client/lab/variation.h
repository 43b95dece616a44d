// A light as it would be with a mistake: the scene with another light, or the same light seen from
// another place.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "client/library/points.h"
#include "lucerna/v1/light.pb.h"

namespace lucerna::verify {

using client::Double3;

/// A number that does not exist: not given, or not known.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double dot(const Double3& a, const Double3& b);
Double3 cross(const Double3& a, const Double3& b);
Double3 operator+(const Double3& a, const Double3& b);
Double3 operator-(const Double3& a, const Double3& b);
Double3 operator*(double s, const Double3& v);
double length(const Double3& v);
Double3 normalized(const Double3& v);
Double3 double3(const v1::Vector3& v);

/// Three columns: an orthogonal matrix.
using Matrix = std::array<Double3, 3>;
inline constexpr Matrix kIdentity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// A light that is turned by `turn` (or mirrored) about `center`, and `scale` times as large.
///
/// The server has no such light.  It answers the same question about the light as it is, asked from
/// a place that is moved the other way.  Radiances and densities with respect to solid angle do not
/// change under turns and scales of the whole configuration.
struct Variation {
  /// A word for programs, such as "map_mirrored".
  std::string mistake;
  /// For people.
  std::string sentence;
  /// The scene with the changed light; empty: the scene itself.
  std::string scene_id;
  Double3 center{};
  double scale = 1;
  Matrix turn = kIdentity;

  /// The place from which the server's light looks as this one does from `x`.
  Double3 point(const Double3& x) const;
  std::vector<Double3> points(const std::vector<Double3>& all) const;
  /// The same for directions and normals.
  Double3 vector(const Double3& v) const;
  std::vector<Double3> vectors(const std::vector<Double3>& all) const;
  /// The inverse of vector().
  Double3 back(const Double3& v) const;
};

/// The place and the axes of a light: of its picture, its map or its distribution.
struct LightFrame {
  Double3 center{};
  Matrix axes = kIdentity;
  bool has_axes = false;
  /// Whether turns about all axes leave its shape as it is.  Otherwise only those that keep axis z.
  bool all_turns = false;
  /// Whether a quarter turn about z leaves its shape as it is.
  bool quarter_turns = true;
  /// Flat surfaces: axis z is the side that shines.
  bool flat = false;
};
LightFrame frame_of(const v1::Light& light);

/// The variations by which a light may be mirrored or turned: those of LightFrame.  Empty for
/// lights that look the same from all sides.
std::vector<Variation> turned(const v1::Light& light);
/// The light turned about axis z of its frame, counter-clockwise.
Variation turned_about_z(const LightFrame& frame, double degrees);
/// Variations of its size: a radius taken for a diameter, and the other way round.
std::vector<Variation> resized(const v1::Light& light);

/// Lights with another angle: half against full, and degrees against radians.  Only for spots and
/// suns whose level is RGB.  The server makes the scenes; see EditLights.
struct ChangedLight {
  std::string mistake, sentence;
  v1::Light light;
};
std::vector<ChangedLight> with_other_angles(const v1::Light& light);

}  // namespace lucerna::verify
