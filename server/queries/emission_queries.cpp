#include "server/queries/emission_queries.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lights/sampling/sobol.h"
#include "server/estimate/path.h"
#include "server/estimate/spectral_values.h"
#include "server/estimate/wire_direction.h"
#include "server/queries/visibility.h"
#include "server/runtime/parallel.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrain = 512;

/// The sample values of one ray.
struct RayValues {
  Vec2f position, direction;
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

/// Whether a density is 0 (the choice is certain) or a normal float.
bool fits_float(double density) {
  const auto rounded = static_cast<float>(density);
  return density == 0 || (rounded >= std::numeric_limits<float>::min() && std::isfinite(rounded));
}

/// Rounds origin and direction of a sampled ray to the floats of the answer.  Sets value and
/// densities to those of the rounded ray, so that PdfLe returns the same densities for it.
void set_wire_ray(const Light& light, const SceneSphere& scene, EmissionSample& s) {
  if (s.reason != NoLight::kNone) return;
  const Vec3 origin(as_floats(s.origin));
  const EmissionSample sampled = s;
  const auto direction = wire_direction(sampled.direction, [&](const Vec3& w) {
    if (light.leaves_freely()) {
      const EmissionPdf pdf = light.pdf_le(origin, w, scene);
      s.value = light.le_leaving(origin, w);
      s.pdf_position = pdf.position;
      s.pdf_direction = pdf.direction;
    } else if (light.has_surface()) {
      s = light.ray_from({origin, sampled.normal, sampled.primitive}, w);
    }
    // A density of 0 means that position or direction is certain.
    return s.reason == NoLight::kNone && !s.value.is_black() &&
           (s.pdf_position.per_m2 > 0) == (sampled.pdf_position.per_m2 > 0) &&
           (s.pdf_direction.per_sr > 0) == (sampled.pdf_direction.per_sr > 0);
  });
  if (direction)
    s.direction = Vec3(*direction);
  else
    s = sampled;
}

ItemResult put(const EmissionSample& s, std::uint32_t light, SpectralValues& spectral,
               std::size_t i, const SampleLeAnswer& a) {
  if (s.reason != NoLight::kNone) return item_result(s.reason);
  const Vec3f value(Vec3(s.value.r, s.value.g, s.value.b));
  const Vec3f origin(s.origin);
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
  store(a.directions, i, Vec3f(s.direction));
  store(a.light_normals, i, Vec3f(s.normal));
  store(a.value, i, value);
  a.pdf_position_per_m2[i] = static_cast<float>(s.pdf_position.per_m2);
  a.pdf_direction_per_sr[i] = static_cast<float>(s.pdf_direction.per_sr);
  return ItemResult::kOk;
}

/// One ray of the named light or of a chosen one.
ItemResult sample_ray(const Scene& scene, const SampleLeQuery& q, SpectralValues& spectral,
                      std::size_t i, const SampleLeAnswer& a) {
  const RayValues u = values_of(q, i);
  std::uint32_t light = q.light.value_or(0);
  if (!q.light) {
    std::optional<LightChoice> choice;
    if (!scene.lights().empty()) choice = scene.lights().choose_emitter(u.light);
    put_choice(scene, choice, i, a.light_ids, a.selection_probability);
    if (!choice) return u.valid ? ItemResult::kBlack : ItemResult::kInvalidInput;
    light = choice->light;
  }
  if (!u.valid) return ItemResult::kInvalidInput;
  const LightAtTime l(scene.lights()[light], q.time_s);
  EmissionSample s =
      l->sample_le({u.position.x, u.position.y}, {u.direction.x, u.direction.y}, scene.sphere());
  set_wire_ray(*l, scene.sphere(), s);
  return put(s, light, spectral, i, a);
}

/// The rays of one chunk of a LeQuery.
class LeChunk {
 public:
  LeChunk(const Scene& scene, const LeQuery& query, const LeAnswer& answer, WorkCounts& work)
      : scene_(scene),
        query_(query),
        answer_(answer),
        transmittance_(scene, query.thin_glass),
        to_scene_(scene, query.points, std::nullopt),
        spectral_(scene, query.wavelengths_nm),
        at_wavelengths_(spectral_.size()),
        work_(work) {}

  /// Fills the entries of ray `i` except its status, and returns the status.
  ItemResult ray(std::size_t i) {
    const ScenePoint p = to_scene_(i);
    const Vec3f direction = triple(query_.directions, i);
    if (!is_direction(direction)) return ItemResult::kInvalidInput;
    if (p.result != ItemResult::kOk) return p.result;
    Ray ray{Vec3f(p.position), normalized(direction), kStartWithoutNormal * p.error};
    ray.time_s = query_.time_s;
    const auto hit =
        first_other_surface(scene_, ray, {{p.position, p.error}, {}}, transmittance_.blocking());
    ++work_.indirect_rays;
    Rgb arriving(1);
    if (transmittance_.is_partial()) {
      if (hit) ray.t_max = hit->t;
      arriving = transmittance_.along(ray, work_);
    }
    return put(i, {p.position, direction_of(direction), query_.time_s}, hit, arriving);
  }

 private:
  /// Adds the radiance of all lights at the end of the ray.  `arriving`: the share of it.
  ItemResult put(std::size_t i, const Sight& sight, const std::optional<SurfaceHit>& hit,
                 const Rgb& arriving) {
    Rgb sum;
    std::uint64_t first_id = 0;
    std::ranges::fill(at_wavelengths_, 0);
    for_each_emitter(scene_, sight, hit, [&](std::uint32_t light, const Rgb& le) {
      if (query_.light && light != *query_.light) return;
      const Rgb radiance = le * arriving;
      if (first_id == 0) first_id = scene_.lights()[light].id;
      sum += radiance;
      spectral_.add(light, radiance, at_wavelengths_);
    });
    const Vec3f total(Vec3(sum.r, sum.g, sum.b));
    if (!is_finite(total) ||
        !store_spectral(at_wavelengths_, answer_.spectral_radiance + i * at_wavelengths_.size()))
      return ItemResult::kOutOfRange;
    answer_.light_ids[i] = first_id;
    store(answer_.radiance_cd_m2, i, total);
    return ItemResult::kOk;
  }

  const Scene& scene_;
  const LeQuery& query_;
  const LeAnswer& answer_;
  Transmittance transmittance_;
  ToScene to_scene_;
  SpectralValues spectral_;
  std::vector<double> at_wavelengths_;
  WorkCounts& work_;
};

}  // namespace

WorkCounts le(const Scene& scene, const LeQuery& query, const LeAnswer& answer,
              std::stop_token stop) {
  const auto rays = [&](std::size_t begin, std::size_t end, WorkCounts& work) {
    LeChunk chunk(scene, query, answer, work);
    for (std::size_t i = begin; i < end; ++i) answer.status[i] = static_cast<int>(chunk.ray(i));
  };
  WorkCounts work = parallel_work(query.points.size(), kGrain, stop, rays);
  work.samples = query.points.size();
  return work;
}

WorkCounts sample_le(const Scene& scene, const SampleLeQuery& query, const SampleLeAnswer& answer,
                     std::stop_token stop) {
  parallel_chunks(query.rays, kGrain, stop, [&](std::size_t begin, std::size_t end) {
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
  const LightAtTime l(scene.lights()[light], time_s);
  const auto ray = [&](std::size_t i) {
    const ScenePoint p = to_scene(i);
    const Vec3f w = triple(directions, i);
    if (!is_direction(w)) return ItemResult::kInvalidInput;
    if (p.result != ItemResult::kOk) return p.result;
    const EmissionPdf pdf = l->pdf_le(p.position, direction_of(w), scene.sphere());
    if (!fits_float(pdf.position.per_m2) || !fits_float(pdf.direction.per_sr))
      return ItemResult::kOutOfRange;
    pdf_position_per_m2[i] = static_cast<float>(pdf.position.per_m2);
    pdf_direction_per_sr[i] = static_cast<float>(pdf.direction.per_sr);
    return ItemResult::kOk;
  };
  parallel_chunks(points.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) status[i] = static_cast<int>(ray(i));
  });
}

}  // namespace lucerna
