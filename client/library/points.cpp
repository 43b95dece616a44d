#include "client/library/points.h"

#include <algorithm>
#include <cmath>

namespace lucerna::client {

void PointOrigin::add(const Double3& point) {
  if (!std::isfinite(point[0]) || !std::isfinite(point[1]) || !std::isfinite(point[2])) return;
  if (!any_) lower_ = upper_ = point;
  any_ = true;
  for (int axis = 0; axis < 3; ++axis) {
    lower_[axis] = std::min(lower_[axis], point[axis]);
    upper_[axis] = std::max(upper_[axis], point[axis]);
  }
}

Double3 PointOrigin::origin() const {
  Double3 result;
  for (int axis = 0; axis < 3; ++axis) {
    // If all coordinates are equal, the middle is their value.  Otherwise the origin zero loses at
    // most three bits, and keeps coordinates that are zero exact.
    const double middle = lower_[axis] / 2 + upper_[axis] / 2;
    const double half = upper_[axis] / 2 - lower_[axis] / 2;
    result[axis] = std::abs(middle) > 8 * half ? middle : 0;
  }
  return result;
}

v1::Points make_points(std::span<const Double3> points) {
  PointOrigin origin;
  for (const Double3& point : points) origin.add(point);
  return make_points(points, origin.origin());
}

v1::Points make_points(std::span<const Double3> points, const Double3& origin) {
  v1::Points result;
  if (origin != Double3{}) {
    result.mutable_origin_m()->set_x(origin[0]);
    result.mutable_origin_m()->set_y(origin[1]);
    result.mutable_origin_m()->set_z(origin[2]);
  }
  result.mutable_offsets_m()->Resize(static_cast<int>(3 * points.size()), 0);
  float* offset = result.mutable_offsets_m()->mutable_data();
  for (const Double3& point : points) {
    for (int axis = 0; axis < 3; ++axis) *offset++ = static_cast<float>(point[axis] - origin[axis]);
  }
  return result;
}

void fill(const std::vector<Double3>& vectors, google::protobuf::RepeatedField<float>* to) {
  to->Resize(static_cast<int>(3 * vectors.size()), 0);
  float* value = to->mutable_data();
  for (const Double3& vector : vectors) {
    for (const double coordinate : vector) *value++ = static_cast<float>(coordinate);
  }
}

}  // namespace lucerna::client
