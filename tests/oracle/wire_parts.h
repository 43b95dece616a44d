// How places and answers are written into requests and messages.
#pragma once

#include <fmt/format.h>

#include <string>

#include "tests/oracle/questioner.h"

namespace lucerna::testing {

using oracle::Amount;
using oracle::Place;
using oracle::Real;
using oracle::Truth;
using oracle::Vec;
using oracle::Way;
using Kind = Verdict::Kind;

inline std::string shown(const Vec& v) {
  return fmt::format("({:.17g}, {:.17g}, {:.17g})", static_cast<double>(v.x),
                     static_cast<double>(v.y), static_cast<double>(v.z));
}
inline std::string shown(const Place& p) {
  return shown(p.at) + " m, normal " + shown(p.normal) + fmt::format(", on shape {}", p.on);
}
inline std::string shown(const Amount& a) {
  return fmt::format("{} +- {}", static_cast<double>(a.value), static_cast<double>(a.bound));
}

/// Each query asks for one point.  It is the batch's origin, so that no coordinate is rounded.
inline void set_point(const Place& p, v1::Points* points) {
  points->mutable_origin_m()->set_x(static_cast<double>(p.at.x));
  points->mutable_origin_m()->set_y(static_cast<double>(p.at.y));
  points->mutable_origin_m()->set_z(static_cast<double>(p.at.z));
  for (int i = 0; i < 3; ++i) points->add_offsets_m(0);
}

template <typename Field>
void add_normal(const Place& p, Field* field) {
  for (const Real x : {p.normal.x, p.normal.y, p.normal.z}) field->Add(static_cast<float>(x));
}

inline Vec vec_of(const google::protobuf::RepeatedField<float>& field, int i) {
  return {field[3 * i], field[3 * i + 1], field[3 * i + 2]};
}

inline Verdict verdict_of(bool right, const std::string& text) {
  return right ? Verdict{Kind::kAgrees} : Verdict{Kind::kWrong, text};
}

}  // namespace lucerna::testing
