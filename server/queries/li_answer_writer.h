// Writes entries of an answer of SampleLi.
#pragma once

#include <cmath>
#include <limits>

#include "server/queries/queries.h"
#include "server/runtime/bits.h"

namespace lucerna {

/// Writes samples as the floats of an answer, or the reason why they do not fit.  Members that
/// run for each sample are always inlined, because a call takes longer than a point light.
class LiAnswerWriter {
 public:
  /// `light_shift_m`: the scene's origin about the receivers' origin.
  LiAnswerWriter(const SampleLiAnswer& answer, const Vec3& light_shift_m)
      : a_(answer), light_shift_m_(light_shift_m) {}

  /// Writes any sample.
  [[gnu::always_inline]] ItemResult put(std::size_t i, const LightSample& s) const {
    if (s.delta) set_bit(a_.delta, i);
    // Samples without light may lack a direction and a density.
    if (const Vec3f wi(s.wi); is_finite(wi)) store(a_.wi, i, wi);
    if (!s.delta)
      a_.pdf_per_sr[i] = is_normal_float(s.pdf.per_sr) ? static_cast<float>(s.pdf.per_sr) : 1.0F;
    if (const Vec3f normal(s.normal); is_finite(normal)) store(a_.light_normals, i, normal);
    const Vec3f point(s.point + light_shift_m_);
    const auto distance = static_cast<float>(s.distance);
    const bool is_far = std::isinf(s.distance);
    if (!is_far && std::isfinite(distance)) {
      a_.distance_m[i] = distance;
      if (is_finite(point)) store(a_.light_offsets_m, i, point);
    }
    NoLight reason = s.reason;
    if (reason == NoLight::kNone) {
      const Vec3f value(Vec3(s.value.r, s.value.g, s.value.b));
      const bool has_place = is_far || (std::isfinite(distance) && is_finite(point));
      const bool has_density = s.delta || is_normal_float(s.pdf.per_sr);
      if (is_finite(value) && has_place && has_density)
        store(a_.value, i, value);
      else
        reason = NoLight::kOutOfRange;
    }
    return put_result(i, item_result(reason));
  }

  /// Writes a sample of a delta light at `point` if all of it fits.  Returns false, with
  /// nothing written, if it does not.
  [[gnu::always_inline]] bool put_plain(std::size_t i, const Vec3& wi, double distance_m,
                                        const Rgb& value, const Vec3& point) const {
    const Vec3f wi_float(wi), offset(point + light_shift_m_);
    const Vec3f value_float(Vec3(value.r, value.g, value.b));
    const auto distance = static_cast<float>(distance_m);
    // One comparison for all values that may not fit a float.
    if (!std::isfinite((value_float.x + value_float.y + value_float.z) + distance +
                       (offset.x + offset.y + offset.z)))
      return false;
    store(a_.wi, i, wi_float);
    store(a_.value, i, value_float);
    store(a_.light_offsets_m, i, offset);
    a_.distance_m[i] = distance;
    put_result(i, ItemResult::kOk);
    // Written last: a byte may alias anything, so the compiler loads everything again after it.
    set_bit(a_.delta, i);
    return true;
  }

  /// Writes an entry for which no light was sampled.
  ItemResult put_none(std::size_t i, ItemResult of_receiver) const {
    a_.pdf_per_sr[i] = 1;
    return put_result(i, of_receiver == ItemResult::kOk ? ItemResult::kBlack : of_receiver);
  }

 private:
  /// Whether a density is a normal float.  Dividing by a density that underflows would divide by 0.
  static bool is_normal_float(double density) {
    const auto rounded = static_cast<float>(density);
    return rounded >= std::numeric_limits<float>::min() && std::isfinite(rounded);
  }
  ItemResult put_result(std::size_t i, ItemResult result) const {
    a_.status[i] = static_cast<int>(result);
    return result;
  }

  const SampleLiAnswer& a_;
  Vec3 light_shift_m_;
};

}  // namespace lucerna
