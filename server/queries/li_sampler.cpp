#include "server/queries/li_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/estimate/path_sample.h"
#include "server/estimate/spectral_values.h"
#include "server/estimate/wire_direction.h"
#include "server/queries/visibility.h"
#include "server/runtime/bits.h"
#include "server/runtime/parallel.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

/// Rounds the direction of a sample of an infinite light to the floats of the answer.  Sets value
/// and density to those of the rounded direction, so that PdfLi and Le return the same for it.
void set_wire_wi(const Light& light, const Receiver& receiver, LightSample& sample) {
  if (sample.reason != NoLight::kNone || sample.delta) return;
  const auto wi_in_answer = wire_direction(sample.wi, [&](const Vec3& wi) {
    const Rgb value = light.le_escaped(receiver.position, wi);
    const SolidAnglePdf pdf = light.pdf_li(receiver, wi);
    if (value.is_black() || !(pdf.per_sr > 0)) return false;
    sample.value = value;
    sample.pdf = pdf;
    return true;
  });
  if (wi_in_answer) sample.wi = Vec3(*wi_in_answer);
}

}  // namespace

LiLayout::LiLayout(std::span<const std::uint32_t> samples_per_block, std::uint32_t blocks)
    : blocks_(blocks) {
  begins_.reserve(samples_per_block.size() + 1);
  for (const std::uint32_t each : samples_per_block) {
    begins_.push_back(size_);
    size_ += each > 0 ? std::size_t{each} * blocks : 1;
  }
  begins_.push_back(size_);
}

LiPlace LiLayout::own_place(std::size_t i) const {
  const auto receiver =
      static_cast<std::size_t>(std::ranges::upper_bound(begins_, i) - begins_.begin() - 1);
  const std::size_t each =
      std::max<std::size_t>(1, (begins_[receiver + 1] - begins_[receiver]) / blocks_);
  const std::size_t of_receiver = i - begins_[receiver];
  return {receiver, of_receiver / each, static_cast<std::uint32_t>(of_receiver % each)};
}

/// One sample of a chunk, from its receiver to its light.
struct LiSampler::UnwrittenSample {
  ScenePoint receiver;
  Vec3 normal;
  Vec2 u;
  std::optional<LightChoice> choice{};   // nothing: the light is named, or no light can be chosen
  std::optional<std::uint32_t> light{};  // nothing: no light can be chosen
  bool sampled = false;
  LightSample sample;
  Rgb visible{1};  ///< the share of its light that arrives

  EndTolerance start() const { return {receiver.position, receiver.error}; }
};

LiSampler::LiSampler(const Scene& scene, const SampleLiQuery& query)
    : scene_(scene),
      q_(query),
      visibility_(scene, query.test_visibility ? query.methods : Methods{}),
      // Only rays use the position error.
      to_scene_(scene, query.receivers, query.test_visibility ? query.position_error_m : 0.0F),
      light_shift_m_(scene.origin() - query.receivers.origin_m) {}

bool LiSampler::needs_one_sample() const { return one_sample_is_enough(scene_, q_.light); }

std::optional<std::uint32_t> LiSampler::plain_light() const {
  if (q_.test_visibility || !q_.wavelengths_nm.empty()) return std::nullopt;
  if (q_.light) return q_.light;
  // The only light is certain.  Sample values of the caller may be wrong, so they are checked
  // below.
  const bool is_certain = scene_.lights().size() == 1 && q_.seed;
  return is_certain ? std::optional<std::uint32_t>(0) : std::nullopt;
}

std::size_t LiSampler::grain() const {
  // A chunk takes 0.1 to 5 ms: a sample takes 0.01 to 0.6 us, or 0.2 to 5 us with a chunk in
  // memory.
  return plain_light() ? 8192 : 512;
}

WorkCounts LiSampler::fill(const LiLayout& layout, std::size_t begin, std::size_t end,
                           const SampleLiAnswer& answer, LiShare* shares) const {
  const LiAnswerWriter writer(answer, light_shift_m_);
  if (const std::optional<std::uint32_t> plain = plain_light()) {
    fill_from(scene_.lights()[*plain], layout, begin, end, writer, shares);
    if (!q_.light) put_only_choice(layout, begin, end, answer);
    return {};
  }
  std::vector<UnwrittenSample> chunk(end - begin);
  prepare_all(layout, begin, chunk);
  sample(chunk);
  for (std::size_t i = begin; i < end; ++i) {
    UnwrittenSample& p = chunk[i - begin];
    if (!q_.light) put_choice(scene_, p.choice, i, answer.light_ids, answer.selection_probability);
    if (p.sampled)
      p.receiver.result = writer.put(i, p.sample);
    else
      p.receiver.result = writer.put_none(i, p.receiver.result);
  }
  if (!q_.wavelengths_nm.empty()) put_spectral(begin, chunk, answer);
  WorkCounts work;
  if (q_.test_visibility) work = test(begin, chunk, answer.visible);
  for (std::size_t i = begin; answer.transmittance != nullptr && i < end; ++i) {
    const UnwrittenSample& p = chunk[i - begin];
    if (p.receiver.result != ItemResult::kOk) continue;
    store(answer.transmittance, i, Vec3f(Vec3(p.visible.r, p.visible.g, p.visible.b)));
  }
  for (std::size_t i = begin; shares != nullptr && i < end; ++i)
    shares[i] = share(chunk[i - begin]);
  return work;
}

/// Writes the choice of the only light, which only receivers without a place lack.
void LiSampler::put_only_choice(const LiLayout& layout, std::size_t begin, std::size_t end,
                                const SampleLiAnswer& answer) const {
  const std::uint64_t id = scene_.lights()[0].id;
  for (std::size_t i = begin; i < end; ++i) {
    answer.selection_probability[i] = 1;
    if (answer.status[i] == static_cast<int>(ItemResult::kOk) ||
        receiver_result(layout.place(i).receiver) == ItemResult::kOk)
      answer.light_ids[i] = id;
  }
}

WorkCounts LiSampler::take(std::span<const LiPlace> places, std::span<LiShare> shares) const {
  std::vector<UnwrittenSample> chunk(places.size());
  LiReceiver at_receiver;
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    if (k == 0 || places[k].receiver != places[k - 1].receiver)
      at_receiver = at(places[k].receiver);
    prepare(places[k], at_receiver, k, chunk[k]);
  }
  sample(chunk);
  WorkCounts work;
  std::vector<std::uint8_t> visible((chunk.size() + 7) / 8);
  for (UnwrittenSample& p : chunk)
    if (p.receiver.result == ItemResult::kOk)
      p.receiver.result = p.sampled ? item_result(p.sample.reason) : ItemResult::kBlack;
  if (q_.test_visibility) work = test(0, chunk, visible.data());
  for (std::size_t k = 0; k < chunk.size(); ++k) shares[k] = share(chunk[k]);
  return work;
}

// Functions that are always inlined here are part of the loop over samples of one light.  A call
// takes longer than a point light.
[[gnu::always_inline]] inline LiSampler::LiReceiver LiSampler::at(std::size_t receiver) const {
  LiReceiver at{.point = to_scene_(receiver)};
  if (q_.normals.empty()) return at;
  const Vec3f n = triple(q_.normals, receiver);
  if (!is_direction(n)) at.point.result = ItemResult::kInvalidInput;
  at.normal = normalized(Vec3(n));
  if (q_.test_visibility && !q_.position_error_m && at.point.result == ItemResult::kOk)
    at.point = on_surface(scene_, at.point, Vec3f(at.normal), q_.time_s);
  return at;
}

ItemResult LiSampler::receiver_result(std::size_t receiver) const {
  return at(receiver).point.result;
}

MostIrradiance LiSampler::most(std::size_t receiver) const {
  const LiReceiver here = at(receiver);
  const Receiver r = receiver_of(here.point, here.normal);
  const auto of_light = [&](std::uint32_t light, double probability) {
    return most_of(LightAtTime(scene_.lights()[light], q_.time_s), r, probability);
  };
  if (q_.light) return of_light(*q_.light, 1);
  MostIrradiance sum;
  for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
    const MostIrradiance one =
        of_light(l, scene_.lights().probability(q_.methods.light_selection, r, l));
    sum.lx += one.lx, sum.sample_lx += one.sample_lx;
  }
  return sum;
}

/// The receiver in the form that lights use.
Receiver LiSampler::receiver_of(const ScenePoint& point, const Vec3& normal) const {
  Receiver r(point.position);
  r.normal = normal;
  r.area_sampling = q_.methods.area_sampling;
  return r;
}

SampleSequence LiSampler::sequence_of(const LiPlace& place) const {
  return {q_.methods.sampler, q_.seed->seed, q_.seed->first_item + place.receiver, place.block};
}

/// The random numbers that place sample `i` on its light.  Nothing if those of the query are not
/// finite.
[[gnu::always_inline]] inline std::optional<Vec2> LiSampler::point_of(const LiPlace& place,
                                                                      std::size_t i) const {
  if (q_.seed) {
    const Vec2f u = sequence_of(place).pair(place.index, 0);
    return Vec2{u.x, u.y};
  }
  const float x = q_.u[2 * i], y = q_.u[2 * i + 1];
  if (!std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
  return Vec2{x, y};
}

void LiSampler::prepare(const LiPlace& place, const LiReceiver& at, std::size_t i,
                        UnwrittenSample& p) const {
  p.receiver = at.point;
  p.normal = at.normal;
  if (const auto u = point_of(place, i))
    p.u = *u;
  else
    p.receiver.result = ItemResult::kInvalidInput;
  p.light = q_.light;
  if (q_.light) return;
  double u_light = 0;
  if (q_.seed) {
    u_light = choosing_value(sequence_of(place).pair(place.index, 1));
  } else if (std::isfinite(q_.u_light[i])) {
    u_light = q_.u_light[i];
  } else {
    p.receiver.result = ItemResult::kInvalidInput;
  }
  if (!scene_.lights().empty() && p.receiver.result == ItemResult::kOk)
    p.choice = scene_.lights().choose(q_.methods.light_selection, receiver_of(p.receiver, p.normal),
                                      u_light);
  if (!p.choice) return;
  p.light = p.choice->light;
  // Fetched while the next samples choose their lights.
  const auto* light = reinterpret_cast<const char*>(&scene_.lights()[*p.light]);
  __builtin_prefetch(light);
  __builtin_prefetch(light + 64);
}

/// Prepares the entries from `begin` on.
void LiSampler::prepare_all(const LiLayout& layout, std::size_t begin,
                            std::vector<UnwrittenSample>& chunk) const {
  LiReceiver at_receiver;
  std::optional<std::size_t> receiver;
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    const LiPlace place = layout.place(begin + k);
    if (place.receiver != receiver) {
      at_receiver = at(place.receiver);
      receiver = place.receiver;
    }
    prepare(place, at_receiver, begin + k, chunk[k]);
  }
}

/// A sample with the precision of the answer.
LightSample LiSampler::sample(const Light& light, const Receiver& receiver, Vec2 u) {
  LightSample s = light.sample_li(receiver, u);
  if (light.is_seen_beyond()) set_wire_wi(light, receiver, s);
  return s;
}

/// Writes a plain sample of a receiver.  Returns false, with nothing written, in all other
/// cases.
[[gnu::always_inline]] inline bool LiSampler::put_point_light(const PointLight& light,
                                                              std::size_t receiver, std::size_t i,
                                                              const LiAnswerWriter& writer) const {
  if (!q_.seed && !std::isfinite(q_.u[2 * i] + q_.u[2 * i + 1])) return false;
  if (!q_.normals.empty() && !is_direction(triple(q_.normals, receiver))) return false;
  const ScenePoint at = to_scene_(receiver);
  if (at.result != ItemResult::kOk) return false;
  const auto s = light.plain_sample_li(at.position);
  return s && writer.put_plain(i, s->wi, s->distance, s->value, light.position());
}

/// Fills the answer from one light, without visibility and spectra.  Writes samples one by one,
/// because a chunk of them takes longer than a point light.
void LiSampler::fill_from(const SceneLight& light, const LiLayout& layout, std::size_t begin,
                          std::size_t end, const LiAnswerWriter& writer, LiShare* shares) const {
  const LightAtTime at_time(light, q_.time_s);
  const PointLight* const point = resting_point_light(light);
  if (point == nullptr || shares != nullptr)
    return fill_each(*at_time, layout, begin, end, writer, shares);
  // The wire takes about as long as a LightAtTime: docs/decisions/016-one-point-light.md.
  for (std::size_t i = begin; i < end; ++i)
    if (!put_point_light(*point, layout.place(i).receiver, i, writer))
      fill_each(*at_time, layout, i, i + 1, writer, nullptr);
}

void LiSampler::fill_each(const Light& light, const LiLayout& layout, std::size_t begin,
                          std::size_t end, const LiAnswerWriter& writer, LiShare* shares) const {
  // Random numbers are computed ahead of the samples.  The hashes of one wait for each other, but
  // the processor computes those of several at a time.
  constexpr std::size_t kAhead = 32;
  std::array<std::optional<Vec2>, kAhead> ahead;
  LiReceiver at_receiver;
  Receiver of_light;
  std::optional<std::size_t> receiver;
  for (std::size_t i = begin; i < end; ++i) {
    if ((i - begin) % kAhead == 0)
      for (std::size_t k = 0; k < std::min(kAhead, end - i); ++k)
        ahead[k] = point_of(layout.place(i + k), i + k);
    const LiPlace place = layout.place(i);
    if (place.receiver != receiver) {
      receiver = place.receiver;
      at_receiver = at(*receiver);
      of_light = receiver_of(at_receiver.point, at_receiver.normal);
    }
    const std::optional<Vec2>& u = ahead[(i - begin) % kAhead];
    const ItemResult before = u ? at_receiver.point.result : ItemResult::kInvalidInput;
    if (shares != nullptr) shares[i] = {};
    if (before != ItemResult::kOk) {
      writer.put_none(i, before);
      continue;
    }
    const LightSample s = sample(light, of_light, *u);
    if (writer.put(i, s) == ItemResult::kOk && shares != nullptr)
      shares[i] = share(at_receiver.normal, 1, s, Rgb(1));
  }
}

/// Visits each light once for all samples of the chunk that chose it.
void LiSampler::sample(std::vector<UnwrittenSample>& chunk) const {
  // The light above the number in the chunk: comparing such keys reads nothing else.
  std::vector<std::uint64_t> order;
  order.reserve(chunk.size());
  for (std::uint32_t k = 0; k < chunk.size(); ++k) {
    if (chunk[k].receiver.result == ItemResult::kOk && chunk[k].light)
      order.push_back(std::uint64_t{*chunk[k].light} << 32 | k);
  }
  if (!q_.light) std::ranges::sort(order);
  const auto at = [&](std::size_t i) -> UnwrittenSample& {
    return chunk[static_cast<std::uint32_t>(order[i])];
  };
  for (std::size_t i = 0; i < order.size();) {
    const std::uint32_t light = *at(i).light;
    const LightAtTime at_time(scene_.lights()[light], q_.time_s);
    for (; i < order.size() && at(i).light == light; ++i) {
      UnwrittenSample& p = at(i);
      p.sample = sample(*at_time, receiver_of(p.receiver, p.normal), p.u);
      p.sampled = true;
    }
  }
}

LiShare LiSampler::share(const UnwrittenSample& p) const {
  if (p.receiver.result != ItemResult::kOk) return {};
  return share(p.normal, p.choice ? p.choice->probability : 1, p.sample, p.visible);
}

[[gnu::always_inline]] inline LiShare LiSampler::share(const Vec3& normal, double probability,
                                                       const LightSample& s,
                                                       const Rgb& visible) const {
  LiShare result;
  result.weight = 1 / probability;
  if (!s.delta) result.weight /= s.pdf.per_sr;
  if (!q_.normals.empty()) result.weight *= std::fmax(0, dot(normal, s.wi));
  result.lx.unshadowed = Rgb(s.value) * result.weight;
  result.lx.value = result.lx.unshadowed * visible;
  result.weight *= visible.max_component();
  return result;
}

void LiSampler::put_spectral(std::size_t begin, std::vector<UnwrittenSample>& chunk,
                             const SampleLiAnswer& a) const {
  SpectralValues values(scene_, q_.wavelengths_nm);
  std::vector<double> at(values.size());
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    UnwrittenSample& p = chunk[k];
    if (p.receiver.result != ItemResult::kOk) continue;
    std::ranges::fill(at, 0);
    values.add(*p.light, Rgb(p.sample.value), at);
    const std::size_t i = begin + k;
    if (store_spectral(at, a.spectral_value + i * values.size())) continue;
    store(a.value, i, {});
    p.receiver.result = ItemResult::kOutOfRange;
    a.status[i] = static_cast<int>(p.receiver.result);
  }
}

WorkCounts LiSampler::test(std::size_t begin, std::vector<UnwrittenSample>& chunk,
                           std::uint8_t* visible) const {
  WorkCounts work;
  const Transmittance& transmittance = visibility_.transmittance();
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    UnwrittenSample& p = chunk[k];
    if (p.receiver.result != ItemResult::kOk) continue;
    p.visible = {};
    const float reach_m = p.sampled ? scene_.lights()[*p.light].reach_m() : 0;
    const Ray ray = light_ray(p.receiver, Vec3f(p.normal), p.sample, q_.time_s, reach_m);
    if (const std::optional<bool> occluded = by_map(p, ray, work)) {
      if (!*occluded) set_bit(visible, begin + k), p.visible = Rgb(1);
      continue;
    }
    ++work.shadow_rays;
    if (is_hidden(p, ray)) continue;
    set_bit(visible, begin + k);
    p.visible = !transmittance.is_partial() ? Rgb(1)
                : !p.light                  ? transmittance.along(ray, work)
                           : visibility_.passed(*p.light, p.receiver.position, ray, work,
                                                start_is_rounded() ? p.start().error : -1);
  }
  return work;
}

bool LiSampler::is_hidden(const UnwrittenSample& p, const Ray& ray) const {
  const RayFilter blocking = visibility_.transmittance().blocking();
  EndTolerances ends;
  if (start_is_rounded()) ends.start = p.start();
  if (p.light && visibility_.contacts().touches(*p.light)) [[unlikely]]
    return visibility_.contacts().is_hidden(*p.light, p.receiver.position, ray, blocking,
                                            ends.start.error);
  return is_blocked(scene_, ray, ends, blocking);
}

/// Whether rays may start on surfaces of unknown normal.
bool LiSampler::start_is_rounded() const { return q_.normals.empty() && !q_.position_error_m; }

/// The result of the light's shadow map; nothing if a ray is needed.
std::optional<bool> LiSampler::by_map(const UnwrittenSample& p, const Ray& ray,
                                      WorkCounts& work) const {
  if (!p.light) return std::nullopt;
  const auto occluded = visibility_.by_map(*p.light, p.receiver.position, p.normal);
  if (!occluded) return std::nullopt;
  ++work.map_lookups;
  if (LightVisibility::is_compared(ray)) {
    const bool by_ray = scene_.geometry().occluded(ray) &&
                        (!start_is_rounded() || first_other_surface(scene_, ray, {p.start(), {}}));
    ++work.shadow_rays;
    LightVisibility::compare(*occluded, by_ray, work);
  }
  return occluded;
}

bool one_sample_is_enough(const Scene& scene, std::optional<std::uint32_t> light) {
  const auto& lights = scene.lights();
  if (lights.empty()) return true;
  if (!light && lights.size() > 1) return false;
  return is_delta(lights[light.value_or(0)]);
}

WorkCounts fill_samples(const LiSampler& sampler, const LiLayout& layout,
                        const SampleLiAnswer& answer, std::span<LiShare> shares,
                        const std::stop_token& stop) {
  const auto fill = [&](std::size_t begin, std::size_t end, WorkCounts& work) {
    work = sampler.fill(layout, begin, end, answer, shares.empty() ? nullptr : shares.data());
  };
  WorkCounts work = parallel_work(layout.size(), sampler.grain(), stop, fill);
  work.samples = layout.size();
  return work;
}

}  // namespace lucerna
