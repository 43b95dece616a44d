#include "lights/maths/motion.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucerna {
namespace {

using Quaternion = std::array<double, 4>;

Vec3 imaginary(const Quaternion& q) { return {q[1], q[2], q[3]}; }

Quaternion product(const Quaternion& a, const Quaternion& b) {
  const Vec3 u = imaginary(a), v = imaginary(b);
  const Vec3 w = v * a[0] + u * b[0] + cross(u, v);
  return {a[0] * b[0] - dot(u, v), w.x, w.y, w.z};
}

Quaternion conjugate(const Quaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }

Quaternion unit(const Quaternion& q) {
  const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / n, q[1] / n, q[2] / n, q[3] / n};
}

/// The quaternion of a rotation matrix, computed from its largest component, so that nothing
/// cancels.  [Shepperd78]
Quaternion quaternion_of(const Transform::Matrix& m) {
  const double trace = m[0][0] + m[1][1] + m[2][2];
  int largest = -1;  // of the diagonal; -1: the trace
  double value = trace;
  for (int i = 0; i < 3; ++i)
    if (m[i][i] > value) value = m[i][i], largest = i;
  if (largest < 0)
    return unit({1 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]});
  const int i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
  Quaternion q{};
  q[0] = m[k][j] - m[j][k];
  q[1 + i] = 1 + m[i][i] - m[j][j] - m[k][k];
  q[1 + j] = m[j][i] + m[i][j];
  q[1 + k] = m[k][i] + m[i][k];
  return unit(q);
}

/// Whether the linear part is a rotation to within 1e-6.
bool is_rotation(const Transform::Matrix& m) {
  constexpr double kTolerance = 1e-6;
  const auto column = [&](int j) { return Vec3{m[0][j], m[1][j], m[2][j]}; };
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::fabs(dot(column(i), column(j)) - (i == j ? 1 : 0)) <= kTolerance)) return false;
  return dot(cross(column(0), column(1)), column(2)) > 0;
}

/// The angle, in [0, 2 pi), and the axis.  Exact for small angles too, unlike an arc cosine.
std::pair<double, Vec3> angle_and_axis_of(const Quaternion& q) {
  const Vec3 v = imaginary(q);
  const double sine = length(v);
  if (!(sine > 0)) return {0, {0, 0, 1}};
  return {2 * std::atan2(sine, q[0]), normalized(v)};
}

}  // namespace

std::pair<double, Vec3> Motion::KeyFrame::angle_and_axis() const {
  Quaternion q = turn;
  if (q[0] < 0) q = {-q[0], -q[1], -q[2], -q[3]};
  return angle_and_axis_of(q);
}

absl::StatusOr<Motion> Motion::create(std::span<const KeyTransform> frames) {
  if (frames.size() < 2)
    return absl::InvalidArgumentError(
        fmt::format("motion of {} key frames, allowed: 2 or more", frames.size()));
  Motion motion;
  const Transform back = frames[0].world_from_light.inverse();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double t = frames[i].time_s;
    if (!std::isfinite(t) || (i > 0 && !(t > frames[i - 1].time_s)))
      return absl::InvalidArgumentError(fmt::format(
          "motion.time_s = {} of key frame {}, allowed: finite and ascending", t, i + 1));
    KeyFrame frame{t, frames[i].world_from_light.point({})};
    if (!is_finite(frame.position_m))
      return absl::InvalidArgumentError(
          fmt::format("motion: key frame {} has no finite position", i + 1));
    if (i > 0) {
      const Transform relative = frames[i].world_from_light * back;
      if (!is_rotation(relative.matrix()))
        return absl::InvalidArgumentError(
            fmt::format("motion that scales or shears (key frame {} against the first), allowed: "
                        "rotations and translations",
                        i + 1));
      frame.turn = quaternion_of(relative.matrix());
      const Quaternion step = product(frame.turn, conjugate(motion.frames_.back().turn));
      // q and -q are the same rotation.  Use the one with the shorter way.
      if (step[0] < 0)
        frame.turn = {-frame.turn[0], -frame.turn[1], -frame.turn[2], -frame.turn[3]};
      const auto [angle, axis] =
          angle_and_axis_of(product(frame.turn, conjugate(motion.frames_.back().turn)));
      motion.turns_.push_back({angle, axis});
    }
    motion.frames_.push_back(frame);
  }
  motion.pivot_ = motion.frames_[0].position_m;
  return motion;
}

Motion Motion::about(const Vec3& from_m, const Vec3& to_m) const {
  Motion moved = *this;
  moved.pivot_ = pivot_ - from_m;
  for (KeyFrame& f : moved.frames_) f.position_m = f.position_m - to_m;
  return moved;
}

Pose Motion::pose(const Quaternion& q, const Vec3& position) const {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Pose p;
  p.r = {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
  p.shift_m = position - p.vector(pivot_);
  return p;
}

Pose Motion::between(std::size_t i, double part) const {
  const KeyFrame &a = frames_[i], &b = frames_[i + 1];
  const double half = turns_[i].angle_rad * part / 2;
  const Vec3 v = turns_[i].axis * std::sin(half);
  const Vec3 position = a.position_m * (1 - part) + b.position_m * part;
  return pose(unit(product({std::cos(half), v.x, v.y, v.z}, a.turn)), position);
}

Pose Motion::at(double time_s) const {
  // Key frames themselves are exact.
  if (!(time_s > frames_.front().time_s))
    return pose(frames_.front().turn, frames_.front().position_m);
  if (time_s >= frames_.back().time_s) return pose(frames_.back().turn, frames_.back().position_m);
  const auto after = std::ranges::upper_bound(frames_, time_s, {}, &KeyFrame::time_s);
  const auto i = static_cast<std::size_t>(after - frames_.begin()) - 1;
  const KeyFrame &a = frames_[i], &b = frames_[i + 1];
  if (time_s == a.time_s) return pose(a.turn, a.position_m);
  // Halved first: the difference of two finite times may overflow.
  return between(i, (time_s / 2 - a.time_s / 2) / (b.time_s / 2 - a.time_s / 2));
}

std::pair<Vec3, Vec3> Motion::bounds(const Vec3& lower, const Vec3& upper) const {
  const auto corner = [&](int c) {
    return Vec3{(c & 1) != 0 ? upper.x : lower.x, (c & 2) != 0 ? upper.y : lower.y,
                (c & 4) != 0 ? upper.z : lower.z};
  };
  double reach = 0;  // from the pivot
  for (int c = 0; c < 8; ++c) reach = std::fmax(reach, length(corner(c) - pivot_));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  double pad = 0, largest = 0;
  const auto add = [&](const Pose& p) {
    for (int c = 0; c < 8; ++c) {
      const Vec3 q = p.point(corner(c));
      largest = std::fmax(largest, max_abs(q));
      low = {std::fmin(low.x, q.x), std::fmin(low.y, q.y), std::fmin(low.z, q.z)};
      high = {std::fmax(high.x, q.x), std::fmax(high.y, q.y), std::fmax(high.z, q.z)};
    }
  };
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    constexpr double kStep_rad = 1.0 / 16;
    const int steps = 1 + static_cast<int>(turns_[i].angle_rad / kStep_rad);
    for (int k = 0; k <= steps; ++k) add(between(i, double(k) / steps));
    // Between two steps a point is at most |f''| / 8 away from the chord, the error of linear
    // interpolation.  Here |f''| = reach angle^2.
    const double angle = turns_[i].angle_rad / steps;
    pad = std::fmax(pad, reach * angle * angle / 8);
  }
  // A few roundings in double of each number.
  pad += 64 * std::numeric_limits<double>::epsilon() * (largest + reach + max_abs(pivot_));
  const Vec3 around{pad, pad, pad};
  return {low - around, high + around};
}

}  // namespace lucerna
