// Rigid motion between key frames: the position at a time, and the swept volume.
#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "lights/maths/transform.h"

namespace lucerna {

/// A rigid map: a rotation R about zero, then a shift.  In double throughout.
struct Pose {
  using Rotation = std::array<Vec3, 3>;  ///< rows

  Rotation r{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3 shift_m;

  Vec3 vector(const Vec3& v) const { return {dot(r[0], v), dot(r[1], v), dot(r[2], v)}; }
  Vec3 point(const Vec3& p) const { return vector(p) + shift_m; }
  /// The inverse.
  Vec3 inverse_vector(const Vec3& v) const { return r[0] * v.x + r[1] * v.y + r[2] * v.z; }
  Vec3 inverse_point(const Vec3& p) const { return inverse_vector(p - shift_m); }

  bool operator==(const Pose&) const = default;
};

/// The transform at a time.
struct KeyTransform {
  double time_s{};
  Transform world_from_light;
};

/// Between two key frames the light-space origin moves along a straight line, and the rotation
/// turns about one axis, both at constant speed.  Before the first and after the last key frame it
/// rests.  This equals pbrt-v4's decomposition for motion without scale and shear.  [Shoemake85]
/// Immutable, so safe to share between threads.
class Motion {
 public:
  struct KeyFrame {
    double time_s{};
    Vec3 position_m;                         ///< of the light-space origin
    std::array<double, 4> turn{1, 0, 0, 0};  ///< since the first frame: a unit quaternion, w first

    /// The angle of rotation since the first frame, in [0, pi], and its unit axis (+z without
    /// rotation).
    std::pair<double, Vec3> angle_and_axis() const;
  };

  /// Two key frames or more.  Errors: fewer key frames; times that are not finite or do not ascend;
  /// positions that are not finite; a motion that scales, shears or mirrors.  The linear part
  /// relative to the first frame must be a rotation to within 1e-6.
  static absl::StatusOr<Motion> create(std::span<const KeyTransform> frames);

  /// The same motion for other origins, both world [m]: positions at the first key frame are
  /// relative to `from_m`, and results to `to_m`.
  Motion about(const Vec3& from_m, const Vec3& to_m) const;

  /// The map from positions at the first key frame to positions at `time_s`. The identity up to the
  /// first key frame, unless `about` changed the coordinates.
  Pose at(double time_s) const;

  /// A box around the volume that the box {lower, upper} sweeps.  The box is at its place in the
  /// first key frame.
  std::pair<Vec3, Vec3> bounds(const Vec3& lower, const Vec3& upper) const;

  /// Positions in the coordinates to which `at` maps.
  std::span<const KeyFrame> key_frames() const { return frames_; }
  std::size_t bytes() const {
    return frames_.capacity() * sizeof(KeyFrame) + turns_.capacity() * sizeof(Turn);
  }

 private:
  /// The rotation from one frame to the next, by the smaller angle.
  struct Turn {
    double angle_rad{};
    Vec3 axis;
  };

  Motion() = default;
  Pose pose(const std::array<double, 4>& turn, const Vec3& position) const;
  Pose between(std::size_t frame, double part) const;

  std::vector<KeyFrame> frames_;
  std::vector<Turn> turns_;
  Vec3 pivot_;  // the light-space origin at the first key frame
};

}  // namespace lucerna
