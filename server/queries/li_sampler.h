// Samples the light that arrives at receivers, some hundreds of samples at a time.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/estimate/direct_light.h"
#include "server/estimate/light_visibility.h"
#include "server/queries/li_answer_writer.h"
#include "server/queries/queries.h"
#include "server/scene/light_at_time.h"

namespace lucerna {

/// The contribution of one sample to the light at its receiver.
struct LiShare {
  /// cosine / (pdf p), for delta lights cosine / p.  Without a normal there is no cosine.  Times
  /// the share of light that arrives, if that is the same in all channels.
  double weight = 0;
  /// Irradiance, or spherical irradiance without a normal [lx].
  LightEstimate lx{};
};

/// The sample of an entry: point `index` of that block of the receiver's points.
struct LiPlace {
  std::size_t receiver;
  std::uint64_t block;
  std::uint32_t index;
};

/// The samples of an answer, receiver by receiver.
class LiLayout {
 public:
  /// `samples` of each receiver, in one block.
  LiLayout(std::size_t receivers, std::uint32_t samples)
      : blocks_(1), each_(samples), size_(receivers * samples) {}
  /// `blocks` of samples_per_block[r] samples of receiver r; one sample if that is 0.
  LiLayout(std::span<const std::uint32_t> samples_per_block, std::uint32_t blocks);

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

  std::uint32_t blocks_;
  std::size_t each_ = 0;               // if all receivers have the same number
  std::vector<std::size_t> begins_{};  // of each receiver, and the end; if the numbers differ
  std::size_t size_ = 0;
};

/// Immutable; may be called from any thread.
class LiSampler {
 public:
  LiSampler(const Scene& scene, const SampleLiQuery& query);

  /// Fills entries [begin, end) of an answer.  `begin` is a multiple of 8, because bits are
  /// written. `shares`: null, or one for each entry.  Returns the number of shadow rays and
  /// look-ups.
  WorkCounts fill(const LiLayout& layout, std::size_t begin, std::size_t end,
                  const SampleLiAnswer& answer, LiShare* shares) const;
  /// Entries in a chunk; a multiple of 8.
  std::size_t grain() const;
  /// Takes samples that are not part of an answer and returns only their contributions.
  WorkCounts take(std::span<const LiPlace> places, std::span<LiShare> shares) const;

  /// Whether samples have shadows.
  bool tests_visibility() const { return q_.test_visibility && !scene_.geometry().is_clear(); }
  /// one_sample_is_enough() for the query.
  bool needs_one_sample() const;
  /// The status of a receiver before any sample.
  ItemResult receiver_result(std::size_t receiver) const;
  /// Upper bounds of the illuminance at a receiver.
  MostIrradiance most(std::size_t receiver) const;

 private:
  struct LiReceiver {
    ScenePoint point;
    Vec3 normal{};  // unit or zero
  };
  struct UnwrittenSample;

  /// The light of all samples, if no random number chooses it and the query needs no visibility and
  /// no spectra.
  std::optional<std::uint32_t> plain_light() const;
  void put_only_choice(const LiLayout& layout, std::size_t begin, std::size_t end,
                       const SampleLiAnswer& answer) const;
  inline LiReceiver at(std::size_t receiver) const;
  Receiver receiver_of(const ScenePoint& point, const Vec3& normal) const;
  SampleSequence sequence_of(const LiPlace& place) const;
  inline std::optional<Vec2> point_of(const LiPlace& place, std::size_t i) const;
  void prepare(const LiPlace& place, const LiReceiver& at, std::size_t i, UnwrittenSample& p) const;
  static LightSample sample(const Light& light, const Receiver& receiver, Vec2 u);
  inline bool put_point_light(const PointLight& light, std::size_t receiver, std::size_t i,
                              const LiAnswerWriter& writer) const;
  void fill_from(const SceneLight& light, const LiLayout& layout, std::size_t begin,
                 std::size_t end, const LiAnswerWriter& writer, LiShare* shares) const;
  void fill_each(const Light& light, const LiLayout& layout, std::size_t begin, std::size_t end,
                 const LiAnswerWriter& writer, LiShare* shares) const;
  void prepare_all(const LiLayout& layout, std::size_t begin,
                   std::vector<UnwrittenSample>& chunk) const;
  void sample(std::vector<UnwrittenSample>& chunk) const;
  LiShare share(const UnwrittenSample& sampled) const;
  inline LiShare share(const Vec3& normal, double probability, const LightSample& s,
                       const Rgb& visible) const;
  void put_spectral(std::size_t begin, std::vector<UnwrittenSample>& chunk,
                    const SampleLiAnswer& answer) const;
  WorkCounts test(std::size_t first_bit, std::vector<UnwrittenSample>& chunk,
                  std::uint8_t* visible) const;
  bool is_hidden(const UnwrittenSample& sampled, const Ray& ray) const;
  bool start_is_rounded() const;
  std::optional<bool> by_map(const UnwrittenSample& sampled, const Ray& ray,
                             WorkCounts& work) const;

  const Scene& scene_;
  const SampleLiQuery& q_;
  LightVisibility visibility_;
  ToScene to_scene_;
  Vec3 light_shift_m_;  // the scene's origin about the receivers' origin
};

/// Whether all samples of a receiver are equal.  This holds in a scene without lights, and for a
/// delta light that is named or is the only one.  `light`: as in SampleLiQuery.
bool one_sample_is_enough(const Scene& scene, std::optional<std::uint32_t> light);

/// Fills an answer of `layout`.  `shares`: empty, or one for each sample.  Runs in the caller's
/// oneTBB arena.  Stops early if `stop` is requested.
WorkCounts fill_samples(const LiSampler& sampler, const LiLayout& layout,
                        const SampleLiAnswer& answer, std::span<LiShare> shares,
                        const std::stop_token& stop);

}  // namespace lucerna
