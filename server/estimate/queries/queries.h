// Batches of questions about lights, over plain arrays: what services compute, without their
// messages.  All work here runs in the caller's oneTBB arena and is a function of its arguments
// alone.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>

#include "server/estimate/paths/render.h"
#include "server/scene/scene.h"

namespace lucerna {

/// What came of one item; the numbers are those of ItemStatus in lucerna/v1/accuracy.proto.
enum class ItemResult : int {
  kOk = 1,
  kBehind,
  kOutsideCone,
  kDegenerate,
  kBlack,
  kOutOfRange,
  kInvalidInput,
  kInsideSolid,
};
inline ItemResult item_result(NoLight reason) {
  // In the same order: no call and no table in the loop over samples of a point light.
  constexpr auto kRank = [](ItemResult r) { return static_cast<int>(r) - 1; };
  static_assert(kRank(ItemResult::kOk) == static_cast<int>(NoLight::kNone) &&
                kRank(ItemResult::kBehind) == static_cast<int>(NoLight::kBehind) &&
                kRank(ItemResult::kOutsideCone) == static_cast<int>(NoLight::kOutsideCone) &&
                kRank(ItemResult::kDegenerate) == static_cast<int>(NoLight::kDegenerate) &&
                kRank(ItemResult::kBlack) == static_cast<int>(NoLight::kBlack) &&
                kRank(ItemResult::kOutOfRange) == static_cast<int>(NoLight::kOutOfRange));
  return static_cast<ItemResult>(static_cast<int>(reason) + 1);
}

/// World points as messages hold them: offsets x, y, z interleaved [m] from one origin [m].
struct PointArray {
  Vec3<double> origin_m;
  std::span<const float> offsets_m;
  std::size_t size() const { return offsets_m.size() / 3; }
};

/// Triple `i` of an interleaved array.
inline Vec3<float> triple(std::span<const float> v, std::size_t i) {
  return {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
}

inline void store(float* array, std::size_t i, const Vec3<float>& v) {
  array[3 * i] = v.x;
  array[3 * i + 1] = v.y;
  array[3 * i + 2] = v.z;
}

/// Whether a vector of a request says a direction: it may have any length but 0.
inline bool is_direction(const Vec3<float>& v) { return is_finite(v) && v != Vec3<float>{}; }

/// A point of a batch, about the scene's origin.
struct ScenePoint {
  Vec3<double> position;  ///< within floats
  float error = 0;        ///< how far each coordinate may be off, rounded to float too [m]
  ItemResult result = ItemResult::kOk;
};

/// Moves points of one batch to scene coordinates, in double.
class ToScene {
 public:
  /// `position_error_m`: unset for the default, 4 ulps: 2^-21 of the largest coordinate among
  /// offset and scene position, and 2^-50 of the origin's, which is a double.
  ToScene(const Scene& scene, const PointArray& points, std::optional<float> position_error_m);

  /// kInvalidInput where an offset is not finite, kOutOfRange where no float holds the result.
  [[gnu::always_inline]] ScenePoint operator()(std::size_t i) const {
    ScenePoint p;
    const Vec3<float> offset = triple(offsets_m_, i);
    p.position = shift_m_ + Vec3<double>(offset);
    if (!is_finite(Vec3<float>(p.position))) [[unlikely]] {
      p.position = {};
      p.result = is_finite(offset) ? ItemResult::kOutOfRange : ItemResult::kInvalidInput;
      return p;
    }
    constexpr float kRelative =
        static_cast<float>(kDefaultUlps) * std::numeric_limits<float>::epsilon();
    p.error = position_error_m_ ? *position_error_m_
                                : kRelative * std::fmax(max_abs(offset),
                                                        static_cast<float>(max_abs(p.position))) +
                                      static_cast<float>(origin_error_m_);
    return p;
  }

 private:
  static constexpr double kDefaultUlps = 4;

  std::span<const float> offsets_m_;
  Vec3<double> shift_m_;  ///< the points' origin about the scene's
  double origin_error_m_;
  std::optional<float> position_error_m_;
};

struct SeedRange {
  std::uint64_t seed = 0;
  std::uint64_t first_item = 0;
};

/// Puts down id and probability of the light that item `i` is spent on; where there is none, the id
/// stays 0 and the probability is 1, so that nobody divides by 0.
void put_choice(const Scene& scene, const std::optional<LightChoice>& choice, std::size_t i,
                std::uint64_t* light_ids, double* selection_probability);

struct SampleLiQuery {
  PointArray receivers;
  std::uint32_t samples = 1;             ///< for each receiver
  std::optional<std::uint32_t> light{};  ///< index; unset: chosen for each sample
  std::optional<SeedRange> seed{};       ///< set: `u` and `u_light` are not read
  std::span<const float> u{};            ///< two a sample, in [0, 1] or not finite
  std::span<const double> u_light{};     ///< one a sample, in [0, 1), where `light` is unset
  double time_s = 0;
  bool test_visibility = false;
  std::span<const float> normals{};  ///< three a receiver, or none
  std::optional<float> position_error_m{};
  Methods methods{};
  std::span<const double> wavelengths_nm{};
};

/// Arrays to be filled, of receivers x samples entries (or triples), receiver by receiver; all
/// start as zeros.  A density is 1 where a sample that is not kOk has none that a float holds.
struct SampleLiAnswer {
  float* value;
  float* wi;
  float* distance_m;
  float* light_offsets_m;  ///< relative to the receivers' origin
  float* light_normals;
  float* pdf_per_sr;
  std::uint8_t* delta;              ///< bits
  std::uint8_t* visible;            ///< bits, with `test_visibility`
  std::uint64_t* light_ids;         ///< where the light is chosen
  double* selection_probability;    ///< where the light is chosen
  int* status;                      ///< ItemResult
  float* spectral_value = nullptr;  ///< one for each wavelength, sample by sample
};

/// Where no light can be chosen, in a scene without lights or where those that are left reach the
/// receiver in no way, a sample is kBlack, its light 0, chosen with certainty.  A sample
/// of which the value at a wavelength does not fit a float is kOutOfRange, its value 0.
/// Stops early (the answer is then of no use) where `stop` is asked for.
WorkCounts sample_li(const Scene& scene, const SampleLiQuery& query, const SampleLiAnswer& answer,
                     std::stop_token stop);

struct PdfLiQuery {
  std::uint32_t light = 0;  ///< index
  PointArray receivers;
  std::span<const float> wi;         ///< three a receiver, of any length but 0
  std::span<const float> normals{};  ///< as in SampleLiQuery
  AreaSampling area_sampling = AreaSampling::kAutomatic;
  double time_s = 0;
};

/// The density with which `sample_li` of that light chooses `wi` [1/sr].
void pdf_li(const Scene& scene, const PdfLiQuery& query, float* pdf_per_sr, int* status,
            std::stop_token stop);

/// Power of light `light` [lm].
Power light_power(const Scene& scene, std::uint32_t light);

/// The books' formula for it, with how far it is off as its error [lm].
Power light_power_approximate(const Scene& scene, std::uint32_t light);

/// Reflections after the first surface that the scene file asks for: a path of length 1 (pbrt's
/// maxdepth) is direct light.  Nothing where it does not say.
std::optional<std::uint32_t> hinted_bounces(const Scene& scene);

}  // namespace lucerna
