#include "server/estimate/queries/emission_queries.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lights/sampling/sobol.h"
#include "server/estimate/lights/told_direction.h"
#include "server/estimate/paths/path.h"
#include "server/estimate/queries/spectral_values.h"
#include "server/estimate/queries/visibility.h"
#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrain = 512;

/// The sample values of one ray.
struct RayValues {
  Vec2<float> position, direction;
  double light = 0;
  bool valid = true;
};

RayValues values_of(const SampleLeQuery& q, std::size_t i) {
  RayValues v;
  if (q.seed) {
    const std::uint64_t number = q.seed->first_item + i;
    const SobolSequence points(q.seed->seed, number >> 32);
    const auto index = static_cast<std::uint32_t>(number);
    v.position = points.pair(index, 0);
    v.direction = points.pair(index, 1);
    if (!q.light) v.light = choosing_value(points.pair(index, 2));
    return v;
  }
  v.position = {q.u[4 * i], q.u[4 * i + 1]};
  v.direction = {q.u[4 * i + 2], q.u[4 * i + 3]};
  if (!q.light) v.light = q.u_light[i];
  v.valid = std::isfinite(v.position.x) && std::isfinite(v.position.y) &&
            std::isfinite(v.direction.x) && std::isfinite(v.direction.y) && std::isfinite(v.light);
  if (!v.valid) v.light = 0;
  return v;
}

/// Whether a density is 0, of what is certain, or has all of its digits in a float.
bool fits_float(double density) {
  const auto rounded = static_cast<float>(density);
  return density == 0 || (rounded >= std::numeric_limits<float>::min() && std::isfinite(rounded));
}

/// Makes of a sampled ray the one that the answer tells: PdfLe of that is what the sample says.
template <typename L>
void tell_ray(const L& light, const SceneSphere& scene, EmissionSample<double>& s) {
  if (s.reason != NoLight::kNone) return;
  const Vec3<double> origin(as_floats(s.origin));
  const EmissionSample<double> sampled = s;
  const auto told = told_direction(sampled.direction, [&](const Vec3<double>& w) {
    if constexpr (LeavesFreely<L>) {
      const EmissionPdf<double> pdf = light.pdf_le(origin, w, scene);
      s.value = light.le_leaving(origin, w);
      s.pdf_position = pdf.position;
      s.pdf_direction = pdf.direction;
    } else if constexpr (SeenOnSurface<L>) {
      s = light.ray_from({origin, sampled.normal, sampled.primitive}, w);
    }
    // A density of 0 is one of what is certain.
    return s.reason == NoLight::kNone && !s.value.is_black() &&
           (s.pdf_position.per_m2 > 0) == (sampled.pdf_position.per_m2 > 0) &&
           (s.pdf_direction.per_sr > 0) == (sampled.pdf_direction.per_sr > 0);
  });
  if (told)
    s.direction = Vec3<double>(*told);
  else
    s = sampled;
}

ItemResult put(const EmissionSample<double>& s, std::uint32_t light, SpectralValues& spectral,
               std::size_t i, const SampleLeAnswer& a) {
  if (s.reason != NoLight::kNone) return item_result(s.reason);
  const Vec3<float> value(Vec3<double>(s.value.r, s.value.g, s.value.b));
  const Vec3<float> origin(s.origin);
  if (!is_finite(value) || !is_finite(origin) || !fits_float(s.pdf_position.per_m2) ||
      !fits_float(s.pdf_direction.per_sr)) {
    return ItemResult::kOutOfRange;
  }
  if (spectral.size() > 0) {
    std::vector<double> at(spectral.size());
    spectral.add(light, s.value, at);
    if (!store_spectral(at, a.spectral_value + i * at.size())) return ItemResult::kOutOfRange;
  }
  store(a.offsets_m, i, origin);
  store(a.directions, i, Vec3<float>(s.direction));
  store(a.light_normals, i, Vec3<float>(s.normal));
  store(a.value, i, value);
  a.pdf_position_per_m2[i] = static_cast<float>(s.pdf_position.per_m2);
  a.pdf_direction_per_sr[i] = static_cast<float>(s.pdf_direction.per_sr);
  return ItemResult::kOk;
}

/// One ray of a light that is named or chosen here.
ItemResult sample_ray(const Scene& scene, const SampleLeQuery& q, SpectralValues& spectral,
                      std::size_t i, const SampleLeAnswer& a) {
  const RayValues u = values_of(q, i);
  std::uint32_t light = q.light.value_or(0);
  if (!q.light) {
    std::optional<LightChoice> choice;
    if (!scene.lights().empty()) choice = choose_emitter(scene, u.light);
    put_choice(scene, choice, i, a.light_ids, a.selection_probability);
    if (!choice) return u.valid ? ItemResult::kBlack : ItemResult::kInvalidInput;
    light = choice->light;
  }
  if (!u.valid) return ItemResult::kInvalidInput;
  return visit_light(scene.lights()[light], q.time_s, [&]<typename L>(const L& l) {
    EmissionSample<double> s =
        l.sample_le({u.position.x, u.position.y}, {u.direction.x, u.direction.y}, scene.sphere());
    tell_ray(l, scene.sphere(), s);
    return put(s, light, spectral, i, a);
  });
}

}  // namespace

WorkCounts le(const Scene& scene, const LeQuery& query, const LeAnswer& answer,
              std::stop_token stop) {
  const ToScene to_scene(scene, query.points, std::nullopt);
  const PathTracer tracer(scene, 0, {});
  std::atomic<std::uint64_t> rays = 0;
  parallel_chunks(query.points.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    std::uint64_t chunk_rays = 0;
    SpectralValues spectral(scene, query.wavelengths_nm);
    std::vector<double> at(spectral.size());
    for (std::size_t i = begin; i < end; ++i) {
      const ScenePoint p = to_scene(i);
      const Vec3<float> direction = triple(query.directions, i);
      ItemResult result = p.result;
      if (!is_direction(direction)) result = ItemResult::kInvalidInput;
      if (result == ItemResult::kOk) {
        Ray ray{Vec3<float>(p.position), normalized(direction), kStartWithoutNormal * p.error};
        ray.time_s = query.time_s;
        const auto hit = first_other_surface(scene, ray, {{p.position, p.error}, {}});
        ++chunk_rays;
        Rgb<double> sum;
        std::uint64_t met = 0;
        std::ranges::fill(at, 0);
        const Sight sight{p.position, direction_of(direction), query.time_s};
        tracer.for_each_emitter(sight, hit, [&](std::uint32_t light, const Rgb<double>& radiance) {
          if (query.light && light != *query.light) return;
          if (met == 0) met = scene.lights()[light].id;
          sum += radiance;
          spectral.add(light, radiance, at);
        });
        const Vec3<float> total(Vec3<double>(sum.r, sum.g, sum.b));
        if (is_finite(total) && store_spectral(at, answer.spectral_radiance + i * at.size())) {
          answer.light_ids[i] = met;
          store(answer.radiance_cd_m2, i, total);
        } else {
          result = ItemResult::kOutOfRange;
        }
      }
      answer.status[i] = static_cast<int>(result);
    }
    rays += chunk_rays;
  });
  WorkCounts work;
  work.samples = query.points.size();
  work.indirect_rays = rays;
  return work;
}

WorkCounts sample_le(const Scene& scene, const SampleLeQuery& query, const SampleLeAnswer& answer,
                     std::stop_token stop) {
  parallel_chunks(query.rays, kGrain, stop, [&](std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    SpectralValues spectral(scene, query.wavelengths_nm);
    for (std::size_t i = begin; i < end; ++i) {
      answer.status[i] = static_cast<int>(sample_ray(scene, query, spectral, i, answer));
    }
  });
  WorkCounts work;
  work.samples = query.rays;
  return work;
}

void pdf_le(const Scene& scene, std::uint32_t light, const PointArray& points,
            std::span<const float> directions, double time_s, float* pdf_position_per_m2,
            float* pdf_direction_per_sr, int* status, std::stop_token stop) {
  const ToScene to_scene(scene, points, 0.0F);
  visit_light(scene.lights()[light], time_s, [&](const auto& l) {
    parallel_chunks(points.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
      const DenormalsAreZero denormals;
      for (std::size_t i = begin; i < end; ++i) {
        const ScenePoint p = to_scene(i);
        const Vec3<float> w = triple(directions, i);
        ItemResult result = p.result;
        if (!is_direction(w)) result = ItemResult::kInvalidInput;
        if (result == ItemResult::kOk) {
          const EmissionPdf<double> pdf = l.pdf_le(p.position, direction_of(w), scene.sphere());
          if (fits_float(pdf.position.per_m2) && fits_float(pdf.direction.per_sr)) {
            pdf_position_per_m2[i] = static_cast<float>(pdf.position.per_m2);
            pdf_direction_per_sr[i] = static_cast<float>(pdf.direction.per_sr);
          } else {
            result = ItemResult::kOutOfRange;
          }
        }
        status[i] = static_cast<int>(result);
      }
    });
  });
}

}  // namespace lucerna
