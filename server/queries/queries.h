// Batches of queries about lights, over plain arrays: the computations of the services, without
// messages.  All work runs in the caller's oneTBB arena and depends only on the arguments.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>

#include "server/estimate/methods.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

/// The status of one item.  The numbers are those of ItemStatus in lucerna/v1/accuracy.proto.
enum class ItemResult : int {
  kOk = 1,
  kBehind,
  kOutsideCone,
  kDegenerate,
  kBlack,
  kOutOfRange,
  kInvalidInput,
  kInsideSolid,
  kMayMissLight,
};
inline ItemResult item_result(NoLight reason) {
  // Both enums have the same order.  This avoids a call or a table in the loop over samples of
  // a point light.
  constexpr auto kRank = [](ItemResult r) { return static_cast<int>(r) - 1; };
  static_assert(kRank(ItemResult::kOk) == static_cast<int>(NoLight::kNone) &&
                kRank(ItemResult::kBehind) == static_cast<int>(NoLight::kBehind) &&
                kRank(ItemResult::kOutsideCone) == static_cast<int>(NoLight::kOutsideCone) &&
                kRank(ItemResult::kDegenerate) == static_cast<int>(NoLight::kDegenerate) &&
                kRank(ItemResult::kBlack) == static_cast<int>(NoLight::kBlack) &&
                kRank(ItemResult::kOutOfRange) == static_cast<int>(NoLight::kOutOfRange));
  return static_cast<ItemResult>(static_cast<int>(reason) + 1);
}

/// World points as in messages: offsets x, y, z interleaved [m] from one origin [m].
struct PointArray {
  Vec3 origin_m;
  std::span<const float> offsets_m;
  std::size_t size() const { return offsets_m.size() / 3; }
};

/// Triple `i` of an interleaved array.
inline Vec3f triple(std::span<const float> v, std::size_t i) {
  return {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
}

inline void store(float* array, std::size_t i, const Vec3f& v) {
  array[3 * i] = v.x;
  array[3 * i + 1] = v.y;
  array[3 * i + 2] = v.z;
}

/// Whether a vector of a request is a direction: finite, with any length except 0.
inline bool is_direction(const Vec3f& v) { return is_finite(v) && v != Vec3f{}; }

/// A point of a batch, about the scene's origin.
struct ScenePoint {
  Vec3 position;    ///< within the range of floats
  float error = 0;  ///< error bound of each coordinate, including rounding to float [m]
  ItemResult result = ItemResult::kOk;
};

/// Converts points of one batch to scene coordinates, in double.
class ToScene {
 public:
  /// `position_error_m`: unset for the default, 4 ulps.  This is 2^-21 of the largest coordinate of
  /// offset and scene position, plus 2^-50 of that of the origin, which is a double.
  ToScene(const Scene& scene, const PointArray& points, std::optional<float> position_error_m);

  /// kInvalidInput if an offset is not finite, kOutOfRange if the result does not fit floats.
  [[gnu::always_inline]] ScenePoint operator()(std::size_t i) const {
    ScenePoint p;
    const Vec3f offset = triple(offsets_m_, i);
    p.position = shift_m_ + Vec3(offset);
    if (!is_finite(Vec3f(p.position))) [[unlikely]] {
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
  Vec3 shift_m_;  ///< the points' origin about the scene's origin
  double origin_error_m_;
  std::optional<float> position_error_m_;
};

struct SeedRange {
  std::uint64_t seed = 0;
  std::uint64_t first_item = 0;
};

/// Writes id and probability of the light chosen for item `i`.  Without a light the id stays 0
/// and the probability is 1, so that callers may divide by it.
void put_choice(const Scene& scene, const std::optional<LightChoice>& choice, std::size_t i,
                std::uint64_t* light_ids, double* selection_probability);

struct SampleLiQuery {
  PointArray receivers;
  std::uint32_t samples = 1;             ///< for each receiver
  std::optional<std::uint32_t> light{};  ///< index; unset: chosen for each sample
  std::optional<SeedRange> seed{};       ///< set: `u` and `u_light` are not read
  std::span<const float> u{};            ///< two for each sample, in [0, 1] or not finite
  std::span<const double> u_light{};     ///< one a sample, in [0, 1); only without `light`
  double time_s = 0;
  bool test_visibility = false;
  std::span<const float> normals{};  ///< three for each receiver, or empty
  std::optional<float> position_error_m{};
  Methods methods{};
  std::span<const double> wavelengths_nm{};
};

/// Arrays to fill, of receivers x samples entries (or triples), receiver by receiver.  All
/// start as zeros.  The density is 1 for a sample that is not kOk and has no density that fits
/// a float.
struct SampleLiAnswer {
  float* value;
  float* wi;
  float* distance_m;
  float* light_offsets_m;  ///< about the receivers' origin
  float* light_normals;
  float* pdf_per_sr;
  std::uint8_t* delta;              ///< bits
  std::uint8_t* visible;            ///< bits, with `test_visibility`
  std::uint64_t* light_ids;         ///< if the light is chosen
  double* selection_probability;    ///< if the light is chosen
  int* status;                      ///< ItemResult
  float* spectral_value = nullptr;  ///< one for each wavelength, sample by sample
  /// The share of light that arrives, three channels for each sample.  With `test_visibility`, if
  /// Transmittance::is_partial(); else null.
  float* transmittance = nullptr;
};

/// If no light can be chosen, a sample is kBlack, with light 0 and selection probability 1.  This
/// happens in a scene without lights, or if none of the remaining lights reaches the receiver.  A
/// sample whose value at some wavelength does not fit a float is kOutOfRange, with value 0.
/// Stops early if `stop` is requested; the answer is then incomplete.
WorkCounts sample_li(const Scene& scene, const SampleLiQuery& query, const SampleLiAnswer& answer,
                     std::stop_token stop);

struct PdfLiQuery {
  std::uint32_t light = 0;  ///< index
  PointArray receivers;
  std::span<const float> wi;         ///< three for each receiver, any length except 0
  std::span<const float> normals{};  ///< as in SampleLiQuery
  AreaSampling area_sampling = AreaSampling::kAutomatic;
  double time_s = 0;
};

/// The density with which `sample_li` of the light chooses `wi` [1/sr].
void pdf_li(const Scene& scene, const PdfLiQuery& query, float* pdf_per_sr, int* status,
            std::stop_token stop);

/// Power of light `light` [lm].
Power light_power(const Scene& scene, std::uint32_t light);

/// The textbook formula for the power, with its difference from the power as its error [lm].
Power light_power_approximate(const Scene& scene, std::uint32_t light);

/// The number of reflections after the first surface that the scene file requests.  A path of
/// length 1 (pbrt's maxdepth) is direct light.  Nothing if the file has no value.
std::optional<std::uint32_t> hinted_bounces(const Scene& scene);

}  // namespace lucerna
