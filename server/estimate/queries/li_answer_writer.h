// Entries of an answer of SampleLi.
#pragma once

#include <cmath>
#include <limits>

#include "server/estimate/queries/queries.h"
#include "server/runtime/bits.h"

namespace lucerna {

/// Puts samples down in the floats that an answer has, or why they do not fit.  What is called for
/// each of them is always inlined, as calls take longer than a point light does.
class LiAnswerWriter {
 public:
  /// `light_shift_m`: the scene's origin about the receivers'.
  LiAnswerWriter(const SampleLiAnswer& answer, const Vec3<double>& light_shift_m)
      : a_(answer), light_shift_m_(light_shift_m) {}

  /// A sample whatever it says.
  [[gnu::always_inline]] ItemResult put(std::size_t i, const LightSample<double>& s) const {
    if (s.delta) set_bit(a_.delta, i);
    // Where there is no light there may be no direction, and no density either.
    if (const Vec3<float> wi(s.wi); is_finite(wi)) store(a_.wi, i, wi);
    if (!s.delta)
      a_.pdf_per_sr[i] = is_normal_float(s.pdf.per_sr) ? static_cast<float>(s.pdf.per_sr) : 1.0F;
    if (const Vec3<float> normal(s.normal); is_finite(normal)) store(a_.light_normals, i, normal);
    const Vec3<float> point(s.point + light_shift_m_);
    const auto distance = static_cast<float>(s.distance);
    const bool is_far = std::isinf(s.distance);
    if (!is_far && std::isfinite(distance)) {
      a_.distance_m[i] = distance;
      if (is_finite(point)) store(a_.light_offsets_m, i, point);
    }
    NoLight reason = s.reason;
    if (reason == NoLight::kNone) {
      const Vec3<float> value(Vec3<double>(s.value.r, s.value.g, s.value.b));
      const bool has_place = is_far || (std::isfinite(distance) && is_finite(point));
      const bool has_density = s.delta || is_normal_float(s.pdf.per_sr);
      if (is_finite(value) && has_place && has_density)
        store(a_.value, i, value);
      else
        reason = NoLight::kOutOfRange;
    }
    return put_result(i, item_result(reason));
  }

  /// The same of a delta light at `point` where all of it fits; false, with nothing put down,
  /// elsewhere.
  [[gnu::always_inline]] bool put_plain(std::size_t i, const Vec3<double>& wi, double distance_m,
                                        const Rgb<double>& value, const Vec3<double>& point) const {
    const Vec3<float> told_wi(wi), offset(point + light_shift_m_);
    const Vec3<float> told(Vec3<double>(value.r, value.g, value.b));
    const auto distance = static_cast<float>(distance_m);
    // Of all that may not fit a float in one comparison.
    if (!std::isfinite((told.x + told.y + told.z) + distance + (offset.x + offset.y + offset.z)))
      return false;
    store(a_.wi, i, told_wi);
    store(a_.value, i, told);
    store(a_.light_offsets_m, i, offset);
    a_.distance_m[i] = distance;
    put_result(i, ItemResult::kOk);
    set_bit(a_.delta, i);  // last: a byte may alias anything, so that all is loaded anew
    return true;
  }

  /// Of what no light was asked for.
  ItemResult put_none(std::size_t i, ItemResult of_receiver) const {
    a_.pdf_per_sr[i] = 1;
    return put_result(i, of_receiver == ItemResult::kOk ? ItemResult::kBlack : of_receiver);
  }

 private:
  /// Whether a density has all of its digits in a float: one that underflows would divide by 0.
  static bool is_normal_float(double density) {
    const auto rounded = static_cast<float>(density);
    return rounded >= std::numeric_limits<float>::min() && std::isfinite(rounded);
  }
  ItemResult put_result(std::size_t i, ItemResult result) const {
    a_.status[i] = static_cast<int>(result);
    return result;
  }

  const SampleLiAnswer& a_;
  Vec3<double> light_shift_m_;
};

}  // namespace lucerna
