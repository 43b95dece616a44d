// Samples of the light that arrives at receivers, some hundreds at a time.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/direct_light.h"
#include "server/light_visibility.h"
#include "server/queries.h"

namespace lucerna {

/// Which sample an entry of an answer is: point `index` of that replicate of the receiver's points.
struct LiPlace {
  std::size_t receiver;
  std::uint64_t replicate;
  std::uint32_t index;
};

/// Which samples an answer holds: those of each receiver one behind the other.
class LiLayout {
 public:
  /// As many of each receiver, of one replicate.
  LiLayout(std::size_t receivers, std::uint32_t samples)
      : replicates_(1), each_(samples), size_(receivers * samples) {}
  /// `replicates` of samples_per_replicate[r] samples of receiver r; where that is 0, one sample.
  LiLayout(std::span<const std::uint32_t> samples_per_replicate, std::uint32_t replicates);

  std::size_t size() const { return size_; }
  LiPlace place(std::size_t i) const {
    if (!begins_.empty()) return own_place(i);
    if (each_ == 1) return {i, 0, 0};  // a division takes longer than a point light
    return {i / each_, 0, static_cast<std::uint32_t>(i % each_)};
  }
  /// The samples of receiver `r` are [begin(r), begin(r + 1)).
  std::size_t begin(std::size_t r) const { return begins_.empty() ? r * each_ : begins_[r]; }

 private:
  LiPlace own_place(std::size_t i) const;

  std::uint32_t replicates_;
  std::size_t each_ = 0;               // where all receivers have as many
  std::vector<std::size_t> begins_{};  // of each receiver, and the end; where they do not
  std::size_t size_ = 0;
};

/// What one sample says of the light at its receiver.
struct LiShare {
  /// cosine / (pdf p), for delta lights cosine / p; without a cosine where there is no normal; 0
  /// where the light is not visible.
  double weight = 0;
  /// Irradiance, or without a normal spherical irradiance [lx].
  LightEstimate lx{};
};

/// Immutable; one may serve any number of threads.
class LiSampler {
 public:
  LiSampler(const Scene& scene, const SampleLiQuery& query);

  /// Fills entries [begin, end) of an answer; `begin` is a multiple of 8, as it writes bits.
  /// `shares`: null, or one for each entry.  Returns the shadow rays and look-ups that it took.
  WorkCounts fill(const LiLayout& layout, std::size_t begin, std::size_t end,
                  const SampleLiAnswer& answer, LiShare* shares) const;
  /// What samples say that no answer holds.
  WorkCounts take(std::span<const LiPlace> places, std::span<LiShare> shares) const;

  /// one_sample_says_all() of what is asked.
  bool says_all_at_once() const;
  /// What is wrong with a receiver, before any sample.
  ItemResult receiver_result(std::size_t receiver) const;

 private:
  struct At {
    ScenePoint point;
    Vec3<double> normal{};  // unit or zero
  };
  struct Pending;

  inline At at(std::size_t receiver) const;
  Receiver<double> receiver_of(const ScenePoint& point, const Vec3<double>& normal) const;
  SampleSequence sequence_of(const LiPlace& place) const;
  inline std::optional<Vec2<double>> point_of(const LiPlace& place, std::size_t i) const;
  void prepare(const LiPlace& place, const At& at, std::size_t i, Pending& p) const;
  template <typename L>
  inline LightSample<double> sample(const L& light, const Receiver<double>& receiver,
                                    Vec2<double> u) const;
  template <typename L>
  void fill_from(const L& light, const LiLayout& layout, std::size_t begin, std::size_t end,
                 const SampleLiAnswer& answer, LiShare* shares) const;
  void sample(std::vector<Pending>& chunk) const;
  LiShare share(const Pending& sampled, bool visible) const;
  inline LiShare share(const Vec3<double>& normal, double probability, const LightSample<double>& s,
                       bool visible) const;
  inline ItemResult put(std::size_t i, const LightSample<double>& s,
                        const SampleLiAnswer& answer) const;
  ItemResult put_none(std::size_t i, ItemResult of_receiver, const SampleLiAnswer& answer) const;
  void put_spectral(std::size_t begin, std::vector<Pending>& chunk,
                    const SampleLiAnswer& answer) const;
  WorkCounts test(std::size_t first_bit, const std::vector<Pending>& chunk,
                  std::uint8_t* visible) const;

  const Scene& scene_;
  const SampleLiQuery& q_;
  LightVisibility visibility_;
  ToScene to_scene_;
  Vec3<double> light_shift_;  // the scene's origin about the receivers'
};

/// Whether all samples of a receiver are the same: those of a scene without lights, and of a delta
/// light that is named or alone.  `light`: as in SampleLiQuery.
bool one_sample_says_all(const Scene& scene, std::optional<std::uint32_t> light);

/// Fills an answer of `layout`.  `shares`: none, or one for each sample.  Runs in the oneTBB arena
/// of the caller; stops early where `stop` is asked for.
WorkCounts fill_samples(const LiSampler& sampler, const LiLayout& layout,
                        const SampleLiAnswer& answer, std::span<LiShare> shares,
                        const std::stop_token& stop);

}  // namespace lucerna
