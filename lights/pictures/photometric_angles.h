// The angles of photometric files: which are possible, and the planes that symmetry adds.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace lucerna {

/// The poles of the grid.  In light space, +z is the photometric zero of a hanging luminaire:
/// straight down.  (A spot shines along +z too.)  +x is the photometric horizontal.  So +y is
/// horizontal too, to the right of an observer who looks along +x with the sky above.  V and H are
/// the file's vertical and horizontal angles.  [LM63, 3], and for directions of rotation [Blut22]
enum class PhotometricType : std::uint8_t {
  kC,  ///< V from +z (0) to -z (180); H about that axis, counter-clockwise seen from above: at V 90
       ///< H = 0 is +x and H = 90 is -y
  kB,  ///< H the latitude about a horizontal axis, H = 90 is +y; at H 0 V = 0 is +z, V = 90 is +x
  kA,  ///< V the latitude about the vertical axis, V = 90 is -z; at V 0 H = 0 is +x, H = 90 is +y
};

/// OK for two or more ascending angles [degrees]: of type C within 0 to 180, of types A and B
/// within -90 to 90.
absl::Status check_vertical_angles(PhotometricType type, const std::vector<double>& degrees);

/// OK for ascending angles [degrees]: of type C one or more, of type A two or more, over 360
/// degrees at most; of type B two or more, within -90 to 90.
absl::Status check_horizontal_angles(PhotometricType type, const std::vector<double>& degrees);

/// A range of angles that the standard does not have, and how the rest of the sphere is filled.
struct AngleGap {
  std::string what, instead;
};

/// Nothing for the ranges of the standard: type C from 0 or 90 to 90 or 180, types A and B from -90
/// to 90.  From 0 to 90 is a gap too: readers differ in what they do below 0.  [LM63, 5]
std::optional<AngleGap> vertical_gap(PhotometricType type, const std::vector<double>& degrees);

/// Nothing for the ranges of the standard, and for a circle that only lacks its last plane, which
/// is the first.
std::optional<AngleGap> horizontal_gap(PhotometricType type, const std::vector<double>& degrees);

/// A plane of the web: its horizontal angle, and the plane of the file that it repeats.
struct PhotometricPlane {
  double deg;
  std::size_t of;
};

/// The planes of the file and those that follow from them, ascending.
///
/// Type C, all around:
/// - one plane: symmetric about the axis
/// - more than 180 degrees: no symmetry; the first plane closes the circle
/// - otherwise symmetric about two planes, the nearest multiples of 90 that enclose the file's and
///   are 90 or 180 degrees apart.  From a multiple of 90 to 45 degrees more: about these two.
///
/// Types A and B: from 0 on symmetric about 0, otherwise as in the file.  In type A the first plane
/// closes a circle.
std::vector<PhotometricPlane> all_planes(PhotometricType type, const std::vector<double>& degrees);

}  // namespace lucerna
