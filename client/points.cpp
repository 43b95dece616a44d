#include "client/points.h"

#include <algorithm>
#include <cmath>

namespace lucerna::client {
namespace {

/// The origin along one axis.
double origin(std::span<const Double3> points, int axis) {
  double lower = points[0][axis];
  double upper = lower;
  for (const Double3& point : points) {
    lower = std::min(lower, point[axis]);
    upper = std::max(upper, point[axis]);
  }
  // Where all are alike, the middle is their value.  Else zero loses at most three bits, and keeps
  // what lies at zero exactly there; it is also the answer where a coordinate is not finite.
  const double middle = lower / 2 + upper / 2;
  return std::abs(middle) > 8 * (upper / 2 - lower / 2) ? middle : 0;
}

}  // namespace

v1::Points make_points(std::span<const Double3> points) {
  v1::Points result;
  if (points.empty()) return result;
  const Double3 zero = {origin(points, 0), origin(points, 1), origin(points, 2)};
  if (zero != Double3{}) {
    result.mutable_origin_m()->set_x(zero[0]);
    result.mutable_origin_m()->set_y(zero[1]);
    result.mutable_origin_m()->set_z(zero[2]);
  }
  result.mutable_offsets_m()->Resize(static_cast<int>(3 * points.size()), 0);
  float* offset = result.mutable_offsets_m()->mutable_data();
  for (const Double3& point : points) {
    for (int axis = 0; axis < 3; ++axis) *offset++ = static_cast<float>(point[axis] - zero[axis]);
  }
  return result;
}

}  // namespace lucerna::client
