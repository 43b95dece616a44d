#include "server/queries.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <vector>

#include "server/denormals.h"
#include "server/light_visibility.h"
#include "server/parallel.h"
#include "server/path_sample.h"
#include "server/spectral_values.h"
#include "server/told_direction.h"
#include "server/visibility.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrain = 512;  // a multiple of 8, as chunks write bits
constexpr double kDefaultUlps = 4;

void set_bit(std::uint8_t* bits, std::size_t i) {
  bits[i / 8] |= static_cast<std::uint8_t>(1u << (i % 8));
}

/// What a light is told; `normal`: unit or zero.
Receiver<double> receiver_of(const ScenePoint& p, const Vec3<double>& normal, AreaSampling way) {
  Receiver<double> r(p.position);
  r.normal = normal;
  r.area_sampling = way;
  return r;
}

/// Whether a density has all of its digits in a float: one that underflows would divide by 0.
bool is_normal_float(double density) {
  const auto rounded = static_cast<float>(density);
  return rounded >= std::numeric_limits<float>::min() && std::isfinite(rounded);
}

/// Makes of a sample of a light that has directions alone one of the direction that the answer
/// tells: PdfLi and Le of that are what the sample says.
template <SeenBeyond L>
void tell_direction(const L& light, const Receiver<double>& receiver, LightSample<double>& sample) {
  if (sample.reason != NoLight::kNone || sample.delta) return;
  const auto told = told_direction(sample.wi, [&](const Vec3<double>& wi) {
    const Rgb<double> value = light.le_escaped(receiver.position, wi);
    const SolidAnglePdf<double> pdf = light.pdf_li(receiver, wi);
    if (value.is_black() || !(pdf.per_sr > 0)) return false;
    sample.value = value;
    sample.pdf = pdf;
    return true;
  });
  if (told) sample.wi = Vec3<double>(*told);
}

/// One sample of a chunk on its way.
struct Pending {
  ScenePoint receiver;
  Vec3<double> normal;
  Vec2<double> u;
  std::optional<std::uint32_t> light{};  // none: none can be chosen
  bool sampled = false;
  LightSample<double> sample;
};

class LiSampler {
 public:
  LiSampler(const Scene& scene, const SampleLiQuery& query, const SampleLiAnswer& answer)
      : scene_(scene),
        q_(query),
        a_(answer),
        visibility_(scene,
                    query.test_visibility ? query.methods.visibility : VisibilityMethod::kRays),
        // Rays alone ask how far off receivers may be.
        to_scene_(scene, query.receivers, query.test_visibility ? query.position_error_m : 0.0F),
        light_shift_(scene.origin() - query.receivers.origin_m) {}

  /// Returns the shadow rays and look-ups that it took.
  WorkCounts run(std::size_t begin, std::size_t end) const {
    if (q_.light && !q_.test_visibility && q_.wavelengths_nm.empty()) {
      sample_alone(begin, end);
      return {};
    }
    std::vector<Pending> chunk(end - begin);
    for (std::size_t i = begin; i < end; ++i) prepare(i, chunk[i - begin]);
    sample(chunk);
    for (std::size_t i = begin; i < end; ++i) put(i, chunk[i - begin]);
    if (!q_.wavelengths_nm.empty()) put_spectral(begin, chunk);
    return q_.test_visibility ? test(begin, chunk) : WorkCounts{};
  }

 private:
  void prepare(std::size_t i, Pending& p) const {
    const std::size_t receiver = i / q_.samples;
    p.receiver = to_scene_(receiver);
    if (!q_.normals.empty()) {
      const Vec3<float> n = triple(q_.normals, receiver);
      if (!is_direction(n)) p.receiver.result = ItemResult::kInvalidInput;
      p.normal = normalized(Vec3<double>(n));
      if (q_.test_visibility && !q_.position_error_m && p.receiver.result == ItemResult::kOk) {
        p.receiver = on_surface(scene_, p.receiver, Vec3<float>(p.normal), q_.time_s);
      }
    }
    double u_light = 0;
    if (q_.seed) {
      const SampleSequence points(q_.methods.sampler, q_.seed->seed, q_.seed->first_item + receiver,
                                  0);
      const auto index = static_cast<std::uint32_t>(i % q_.samples);
      const Vec2<float> u = points.pair(index, 0);
      p.u = {u.x, u.y};
      if (!q_.light) u_light = choosing_value(points.pair(index, 1));
    } else {
      p.u = {q_.u[2 * i], q_.u[2 * i + 1]};
      if (!q_.light) u_light = q_.u_light[i];
      if (!std::isfinite(p.u.x) || !std::isfinite(p.u.y) || !std::isfinite(u_light)) {
        p.receiver.result = ItemResult::kInvalidInput;
        u_light = 0;
      }
    }
    p.light = q_.light;
    if (q_.light) return;
    std::optional<LightChoice> choice;
    if (!scene_.lights().empty() && p.receiver.result == ItemResult::kOk)
      choice = choose_light(scene_, q_.methods.light_selection,
                            receiver_of(p.receiver, p.normal, q_.methods.area_sampling), u_light);
    put_choice(scene_, choice, i, a_.light_ids, a_.selection_probability);
    if (choice) p.light = choice->light;
  }

  /// Samples of one light of which nothing else is asked: one by one, without a chunk of them in
  /// between, which takes more time than a point light does.
  void sample_alone(std::size_t begin, std::size_t end) const {
    visit_light(scene_.lights()[*q_.light], q_.time_s, [&](const auto& l) {
      for (std::size_t i = begin; i < end; ++i) {
        Pending p;
        prepare(i, p);
        if (p.receiver.result == ItemResult::kOk) sample(l, p);
        put(i, p);
      }
    });
  }

  template <typename L>
  void sample(const L& l, Pending& p) const {
    const Receiver<double> receiver = receiver_of(p.receiver, p.normal, q_.methods.area_sampling);
    p.sample = l.sample_li(receiver, p.u);
    if constexpr (SeenBeyond<L>) tell_direction(l, receiver, p.sample);
    p.sampled = true;
  }

  /// Visits each light once for all samples of the chunk that chose it.
  void sample(std::vector<Pending>& chunk) const {
    std::vector<std::uint32_t> order;
    order.reserve(chunk.size());
    for (std::uint32_t k = 0; k < chunk.size(); ++k) {
      if (chunk[k].receiver.result == ItemResult::kOk && chunk[k].light) order.push_back(k);
    }
    if (!q_.light) {
      std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return chunk[a].light != chunk[b].light ? chunk[a].light < chunk[b].light : a < b;
      });
    }
    for (std::size_t k = 0; k < order.size();) {
      const std::uint32_t light = *chunk[order[k]].light;
      visit_light(scene_.lights()[light], q_.time_s, [&](const auto& l) {
        for (; k < order.size() && chunk[order[k]].light == light; ++k) sample(l, chunk[order[k]]);
      });
    }
  }

  void put(std::size_t i, Pending& p) const {
    if (!p.sampled) {
      if (p.receiver.result == ItemResult::kOk) p.receiver.result = ItemResult::kBlack;
      a_.status[i] = static_cast<int>(p.receiver.result);
      a_.pdf_per_sr[i] = 1;
      return;
    }
    const LightSample<double>& s = p.sample;
    if (s.delta) set_bit(a_.delta, i);
    // Where there is no light there may be no direction, and no density either.
    if (const Vec3<float> wi(s.wi); is_finite(wi)) store(a_.wi, i, wi);
    if (!s.delta)
      a_.pdf_per_sr[i] = is_normal_float(s.pdf.per_sr) ? static_cast<float>(s.pdf.per_sr) : 1.0F;
    if (const Vec3<float> normal(s.normal); is_finite(normal)) store(a_.light_normals, i, normal);
    const Vec3<float> point(s.point + light_shift_);
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
    p.receiver.result = item_result(reason);
    a_.status[i] = static_cast<int>(p.receiver.result);
  }

  void put_spectral(std::size_t begin, std::vector<Pending>& chunk) const {
    SpectralValues values(scene_, q_.wavelengths_nm);
    std::vector<double> at(values.size());
    for (std::size_t k = 0; k < chunk.size(); ++k) {
      Pending& p = chunk[k];
      if (p.receiver.result != ItemResult::kOk) continue;
      std::ranges::fill(at, 0);
      values.add(*p.light, Rgb<double>(p.sample.value), at);
      const std::size_t i = begin + k;
      if (store_spectral(at, a_.spectral_value + i * values.size())) continue;
      store(a_.value, i, {});
      p.receiver.result = ItemResult::kOutOfRange;
      a_.status[i] = static_cast<int>(p.receiver.result);
    }
  }

  WorkCounts test(std::size_t begin, const std::vector<Pending>& chunk) const {
    WorkCounts work;
    std::vector<Ray> rays;
    std::vector<LooseEnds> ends;
    std::vector<std::uint32_t> items;
    const bool loose = q_.normals.empty() && !q_.position_error_m;
    rays.reserve(chunk.size());
    ends.reserve(chunk.size());
    items.reserve(chunk.size());
    for (std::size_t k = 0; k < chunk.size(); ++k) {
      if (chunk[k].receiver.result != ItemResult::kOk) continue;
      const float reach_m = chunk[k].sampled ? scene_.lights()[*chunk[k].light].reach_m : 0;
      const Ray ray = light_ray(chunk[k].receiver, Vec3<float>(chunk[k].normal), chunk[k].sample,
                                q_.time_s, reach_m);
      std::optional<bool> told;
      if (chunk[k].light)
        told = visibility_.by_map(*chunk[k].light, chunk[k].receiver.position, chunk[k].normal);
      if (told) {
        ++work.map_lookups;
        if (!*told) set_bit(a_.visible, begin + k);
        if (LightVisibility::is_compared(ray)) {
          const bool occluded =
              scene_.occluded(ray) &&
              (!loose || first_other_surface(scene_, ray, {start_of(chunk[k]), {}}));
          ++work.shadow_rays;
          LightVisibility::compare(*told, occluded, work);
        }
        continue;
      }
      rays.push_back(ray);
      LooseEnds& e = ends.emplace_back();
      if (loose) e.start = start_of(chunk[k]);
      items.push_back(static_cast<std::uint32_t>(begin + k));
    }
    mark_visible(scene_, rays, ends, items, a_.visible);
    work.shadow_rays += rays.size();
    return work;
  }

  static LooseEnd start_of(const Pending& p) { return {p.receiver.position, p.receiver.error}; }

  const Scene& scene_;
  const SampleLiQuery& q_;
  const SampleLiAnswer& a_;
  LightVisibility visibility_;
  ToScene to_scene_;
  Vec3<double> light_shift_;  // the scene's origin about the receivers'
};

}  // namespace

ItemResult item_result(NoLight reason) {
  switch (reason) {
    case NoLight::kNone:
      return ItemResult::kOk;
    case NoLight::kBehind:
      return ItemResult::kBehind;
    case NoLight::kOutsideCone:
      return ItemResult::kOutsideCone;
    case NoLight::kDegenerate:
      return ItemResult::kDegenerate;
    case NoLight::kBlack:
      return ItemResult::kBlack;
    case NoLight::kOutOfRange:
      return ItemResult::kOutOfRange;
  }
  return ItemResult::kOutOfRange;
}

ToScene::ToScene(const Scene& scene, const PointArray& points,
                 std::optional<float> position_error_m)
    : offsets_m_(points.offsets_m),
      shift_m_(points.origin_m - scene.origin()),
      origin_error_m_(kDefaultUlps * std::numeric_limits<double>::epsilon() *
                      max_abs(points.origin_m)),
      position_error_m_(position_error_m) {}

ScenePoint ToScene::operator()(std::size_t i) const {
  ScenePoint p;
  const Vec3<float> offset = triple(offsets_m_, i);
  if (!is_finite(offset)) {
    p.result = ItemResult::kInvalidInput;
    return p;
  }
  p.position = shift_m_ + Vec3<double>(offset);
  if (!is_finite(Vec3<float>(p.position))) {
    p.position = {};
    p.result = ItemResult::kOutOfRange;
    return p;
  }
  constexpr float kRelative =
      static_cast<float>(kDefaultUlps) * std::numeric_limits<float>::epsilon();
  p.error = position_error_m_
                ? *position_error_m_
                : kRelative * std::fmax(max_abs(offset), static_cast<float>(max_abs(p.position))) +
                      static_cast<float>(origin_error_m_);
  return p;
}

void put_choice(const Scene& scene, const std::optional<LightChoice>& choice, std::size_t i,
                std::uint64_t* light_ids, double* selection_probability) {
  selection_probability[i] = choice ? choice->probability : 1;
  if (choice) light_ids[i] = scene.lights()[choice->light].id;
}

WorkCounts sample_li(const Scene& scene, const SampleLiQuery& query, const SampleLiAnswer& answer,
                     std::stop_token stop) {
  const LiSampler sampler(scene, query, answer);
  const std::size_t n = query.receivers.size() * query.samples;
  std::mutex mutex;
  WorkCounts work;
  parallel_chunks(n, kGrain, stop, [&](std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    const WorkCounts spent = sampler.run(begin, end);
    const std::lock_guard lock(mutex);
    work += spent;
  });
  work.samples = n;
  return work;
}

void pdf_li(const Scene& scene, const PdfLiQuery& q, float* pdf_per_sr, int* status,
            std::stop_token stop) {
  const ToScene to_scene(scene, q.receivers, 0.0F);
  visit_light(scene.lights()[q.light], q.time_s, [&](const auto& l) {
    parallel_chunks(q.receivers.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
      const DenormalsAreZero denormals;
      for (std::size_t i = begin; i < end; ++i) {
        const ScenePoint p = to_scene(i);
        const Vec3<float> w = triple(q.wi, i);
        ItemResult result = p.result;
        if (!is_direction(w)) result = ItemResult::kInvalidInput;
        Vec3<double> n;
        if (!q.normals.empty()) {
          const Vec3<float> given = triple(q.normals, i);
          if (!is_direction(given)) result = ItemResult::kInvalidInput;
          n = normalized(Vec3<double>(given));
        }
        if (result == ItemResult::kOk) {
          const auto pdf = static_cast<float>(
              l.pdf_li(receiver_of(p, n, q.area_sampling), direction_of(w)).per_sr);
          if (std::isfinite(pdf)) {
            pdf_per_sr[i] = pdf;
          } else {
            result = ItemResult::kOutOfRange;
          }
        }
        status[i] = static_cast<int>(result);
      }
    });
  });
}

Power light_power(const Scene& scene, std::uint32_t light) {
  // The same at any time, but for what the scene's sphere is to portals: at the first key frame.
  return visit_light(scene.lights()[light], -std::numeric_limits<double>::infinity(),
                     [&](const auto& l) { return l.power(scene.sphere()); });
}

Power light_power_approximate(const Scene& scene, std::uint32_t light) {
  return visit_light(scene.lights()[light], -std::numeric_limits<double>::infinity(),
                     [&](const auto& l) { return l.power_approximate(scene.sphere()); });
}

std::optional<std::uint32_t> hinted_bounces(const Scene& scene) {
  if (!scene.hints().max_depth) return std::nullopt;
  return static_cast<std::uint32_t>(std::max(*scene.hints().max_depth - 1, 0));
}

}  // namespace lucerna
