// From double-precision points to the contract's batches of single-precision offsets.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::client {

/// A point or a vector in world coordinates.
using Double3 = std::array<double, 3>;

/// World points [m], each coordinate within 2^-24 of the largest offset along its axis; a
/// coordinate that all points share (a plane, a single point) is exact.  Far from zero the offsets
/// are from the points' middle, so that they keep their differences.
v1::Points make_points(std::span<const Double3> points);

/// The origin that make_points() chooses, found of points that come one after the other.  Those
/// that are not finite do not count.
class PointOrigin {
 public:
  void add(const Double3& point);
  Double3 origin() const;

 private:
  bool any_ = false;
  Double3 lower_{}, upper_{};
};

/// The same about an origin that is given: where a set is asked about in parts, they agree to the
/// bit only about one origin.
v1::Points make_points(std::span<const Double3> points, const Double3& origin);

/// Sets `to` to the coordinates x, y, z of each vector in turn, as floats: normals and directions
/// of requests.
void fill(const std::vector<Double3>& vectors, google::protobuf::RepeatedField<float>* to);

}  // namespace lucerna::client
