// Converts double-precision points to the contract's batches of single-precision offsets.
//
//   const std::vector<Double3> points{{0.5, 1.0, 0.8}, {1.5, 1.0, 0.8}};
//   *request.mutable_receivers() = make_points(points);
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::client {

/// A point or a vector in world coordinates.
using Double3 = std::array<double, 3>;

/// World points [m].  Each coordinate is within 2^-24 of the largest offset along its axis.  A
/// coordinate that all points share (a plane, a single point) is exact.  For points far from zero,
/// the offsets are relative to their middle.  This keeps the differences between points accurate.
v1::Points make_points(std::span<const Double3> points);

/// Finds the origin that make_points() chooses, from points that are added one after the other.
/// Points that are not finite are ignored.
class PointOrigin {
 public:
  void add(const Double3& point);
  Double3 origin() const;

 private:
  bool any_ = false;
  Double3 lower_{}, upper_{};
};

/// The same with a given origin.  The parts of a set have the bits of the whole set only if all use
/// its origin.
v1::Points make_points(std::span<const Double3> points, const Double3& origin);

/// Sets `to` to the coordinates x, y, z of each vector in turn, as floats.  For normals and
/// directions of requests.
void fill(const std::vector<Double3>& vectors, google::protobuf::RepeatedField<float>* to);

}  // namespace lucerna::client
