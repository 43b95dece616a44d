// What packets of rays could gain: Embree alone on the rays of paths, single and in packets.
//
//     packet_bench SCENE.pbrt [SAMPLES [REPEATS]]
//
// Follows the paths of some rows of the picture, as path_bench does, and records their rays.  The
// scene must have one point light and diffuse surfaces without textures.  Then it traces the same
// rays again, one way after the other, with nothing else in the loop:
//
// - path: one by one, in the order in which a path needs them;
// - single: one by one, the rays of a wave after each other;
// - 8: in packets of eight, wave by wave;
// - stream: a wave in one call.
//
// A wave has the rays of one kind and depth: of a pixel, or of a number of pixels.  `sorted` waves
// are in the order of the octants of directions, then of a Morton code of the origins.  Packets are
// prepared before, so the figures leave out the time of preparing and sorting them.
#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "lights/models/point_light.h"
#include "server/estimate/lights/path_sample.h"
#include "server/estimate/paths/path.h"
#include "server/rays/ray_limits.h"
#include "server/runtime/denormals.h"
#include "tests/bench/bench_program.h"

namespace lucerna {
namespace {

/// A ray of a path.  Wave 0 has the rays of the camera, wave 2 d + 1 the shadow rays after d
/// reflections, and wave 2 d + 2 the rays that leave there.
struct Traced {
  RTCRay ray;
  std::uint32_t pixel = 0, wave = 0;
  bool is_shadow() const { return wave % 2 == 1; }
};

/// Follows paths as PathTracer does, in one scene of plain diffuse surfaces and one point light.
class Recorder {
 public:
  Recorder(const Scene& scene, const RaySpace& space)
      : scene_(scene),
        space_(space),
        last_depth_(static_cast<std::uint32_t>(scene.report().hints.max_depth.value_or(1) - 1)) {
    if (scene.lights().size() != 1 || scene.lights()[0].moving != nullptr)
      throw std::runtime_error("the scene must have one light that does not move");
    light_ = dynamic_cast<const PointLight*>(scene.lights()[0].light.get());
    if (light_ == nullptr) throw std::runtime_error("the light must be a point light");
  }

  /// Records one path through the pixel (x, y).
  void path(int x, int y, std::uint32_t pixel, const PathSample& sample) {
    const Vec2f film = sample.pair(PathSample::kFilm);
    Ray ray = scene_.camera().ray(static_cast<float>(x) + film.x, static_cast<float>(y) + film.y, 0,
                                  {0.5F, 0.5F});
    Rgb throughput{1};
    for (std::uint32_t depth = 0;; ++depth) {
      add(ray, pixel, 2 * depth);
      const auto hit = scene_.closest_hit(ray);
      if (!hit) return;
      const Vec3f wo = -ray.direction;
      const Rgb* reflectance = scene_.geometry().plain_diffuse(hit->material);
      if (reflectance == nullptr) throw std::runtime_error("a surface is not plain and diffuse");
      throughput = throughput * *reflectance;
      if (throughput.is_black()) return;
      const LightSample to = light_->sample_li({hit->position}, {});
      if (dot(hit->ns, to.wi) * dot(hit->ns, Vec3(wo)) > 0)
        add(shadow_ray(*hit, to), pixel, 2 * depth + 1);
      if (depth >= last_depth_) return;
      ray = spawn_ray(*hit, PathTracer::cosine_direction(Vec3f(hit->ns), wo,
                                                         sample.at(depth, PathSample::kDirection)));
    }
  }

  std::vector<Traced> rays;

 private:
  void add(const Ray& ray, std::uint32_t pixel, std::uint32_t wave) {
    const auto unit = unit_ray(Vec3(ray.origin), Vec3(ray.direction), ray.t_min, ray.t_max, space_);
    if (!unit) return;
    Traced t{{}, pixel, wave};
    t.ray.org_x = unit->origin.x, t.ray.org_y = unit->origin.y, t.ray.org_z = unit->origin.z;
    t.ray.dir_x = unit->direction.x, t.ray.dir_y = unit->direction.y;
    t.ray.dir_z = unit->direction.z;
    t.ray.tnear = unit->t_min, t.ray.tfar = unit->t_max;
    t.ray.mask = ~0U;
    rays.push_back(t);
  }

  const Scene& scene_;
  RaySpace space_;
  std::uint32_t last_depth_;
  const PointLight* light_ = nullptr;
};

/// As the filter of the server's triangles: looks at the cosine of each hit.
void check_hits(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const Vec3f n{RTCHitN_Ng_x(args->hit, args->N, i), RTCHitN_Ng_y(args->hit, args->N, i),
                  RTCHitN_Ng_z(args->hit, args->N, i)};
    const Vec3f d{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                  RTCRayN_dir_z(args->ray, args->N, i)};
    const float cosine = dot(n, d);
    if (cosine * cosine < 0x1p-24F * dot(n, n) * dot(d, d)) args->valid[i] = 0;
  }
}

/// The triangles of a scene in Embree.
class Triangles {
 public:
  Triangles(const GeometrySet& set, bool robust)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    if (robust) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    const RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* v = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                      sizeof(Vec3f), set.vertices.size());
    std::ranges::copy(set.vertices, static_cast<Vec3f*>(v));
    void* t = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                      3 * sizeof(std::uint32_t), set.triangles.size() / 3);
    std::ranges::copy(set.triangles, static_cast<std::uint32_t*>(t));
    rtcSetGeometryIntersectFilterFunction(g, check_hits);
    rtcSetGeometryOccludedFilterFunction(g, check_hits);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene_, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene_);
  }
  ~Triangles() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Triangles(const Triangles&) = delete;
  Triangles& operator=(const Triangles&) = delete;

  RTCScene scene() const { return scene_; }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

/// Consecutive rays of one kind.
struct Wave {
  std::size_t first, count;
  bool is_shadow;
};

/// Rays in the order in which they are traced, with the waves that they form.
struct Order {
  std::vector<RTCRayHit> rays;
  std::vector<Wave> waves;
};

std::uint64_t spread_bits(std::uint32_t v) {
  std::uint64_t out = 0;
  for (int i = 0; i < 10; ++i) out |= std::uint64_t{v >> i & 1} << 3 * i;
  return out;
}

/// Octant of the direction, then Morton code of the origin.
std::uint64_t place(const RTCRay& r, double reach) {
  const auto cell = [&](float x) {
    return static_cast<std::uint32_t>(std::clamp((x / reach + 1) * 512, 0.0, 1023.0));
  };
  const std::uint64_t octant =
      (r.dir_x < 0 ? 1 : 0) | (r.dir_y < 0 ? 2 : 0) | (r.dir_z < 0 ? 4 : 0);
  return octant << 30 | spread_bits(cell(r.org_x)) << 2 | spread_bits(cell(r.org_y)) << 1 |
         spread_bits(cell(r.org_z));
}

/// Waves of `pixels` pixels each; of single paths' rays as recorded if 0.
Order in_waves(const std::vector<Traced>& traced, std::uint32_t pixels, bool sorted, double reach) {
  std::vector<std::pair<std::array<std::uint64_t, 3>, const Traced*>> keyed;
  for (const Traced& t : traced)
    keyed.push_back({pixels == 0 ? std::array<std::uint64_t, 3>{}
                                 : std::array<std::uint64_t, 3>{t.pixel / pixels, t.wave,
                                                                sorted ? place(t.ray, reach) : 0},
                     &t});
  std::ranges::stable_sort(keyed, {}, [](const auto& k) { return k.first; });
  Order order;
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    const auto& [key, t] = keyed[i];
    const bool starts =
        i == 0 || pixels == 0 || key[0] != keyed[i - 1].first[0] || key[1] != keyed[i - 1].first[1];
    if (starts) order.waves.push_back({i, 0, t->is_shadow()});
    ++order.waves.back().count;
    RTCRayHit& ray = order.rays.emplace_back();
    ray.ray = t->ray;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  }
  return order;
}

enum class Call { kSingle, kEight, kStream };

/// The rays of a wave in packets.  Places without a ray are not valid.
struct Eights {
  std::vector<RTCRayHit8> packets;
  std::vector<std::array<int, 8>> valid;
  std::vector<bool> is_shadow;
};

Eights in_eights(const Order& order) {
  Eights out;
  for (const Wave& wave : order.waves)
    for (std::size_t i = 0; i < wave.count; i += 8) {
      auto& p = out.packets.emplace_back();
      auto& valid = out.valid.emplace_back();
      out.is_shadow.push_back(wave.is_shadow);
      for (std::size_t k = 0; k < 8; ++k) {
        const RTCRay& r = order.rays[wave.first + std::min(i + k, wave.count - 1)].ray;
        valid.at(k) = i + k < wave.count ? -1 : 0;
        p.ray.org_x[k] = r.org_x, p.ray.org_y[k] = r.org_y, p.ray.org_z[k] = r.org_z;
        p.ray.dir_x[k] = r.dir_x, p.ray.dir_y[k] = r.dir_y, p.ray.dir_z[k] = r.dir_z;
        p.ray.tnear[k] = r.tnear, p.ray.tfar[k] = r.tfar, p.ray.mask[k] = r.mask;
        p.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      }
    }
  return out;
}

/// Nanoseconds of a ray, and how many rays hit something.
struct Figure {
  double ns = 0;
  std::size_t hits = 0;
};

// Rays are copied before each pass, because Embree writes into them.  The copy is not timed: a
// renderer prepares each ray once, whichever way it is traced.
Figure trace(RTCScene scene, const Order& order, Call call, RTCIntersectContextFlags flags) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  Figure figure;
  if (call == Call::kEight) {
    Eights eights = in_eights(order);
    const double begin = processor_s();
    for (std::size_t i = 0; i < eights.packets.size(); ++i) {
      if (eights.is_shadow[i])
        rtcOccluded8(eights.valid[i].data(), scene, &context, &eights.packets[i].ray);
      else
        rtcIntersect8(eights.valid[i].data(), scene, &context, &eights.packets[i]);
    }
    figure.ns = (processor_s() - begin) * 1e9 / static_cast<double>(order.rays.size());
    for (std::size_t i = 0; i < eights.packets.size(); ++i)
      for (std::size_t k = 0; k < 8; ++k)
        if (eights.valid[i].at(k) != 0)
          figure.hits += eights.is_shadow[i]
                             ? eights.packets[i].ray.tfar[k] < 0
                             : eights.packets[i].hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
    return figure;
  }
  std::vector<RTCRayHit> rays = order.rays;
  const double begin = processor_s();
  for (const Wave& wave : order.waves) {
    RTCRayHit* const first = &rays[wave.first];
    const auto count = static_cast<unsigned>(wave.count);
    if (call == Call::kStream) {
      if (wave.is_shadow)
        rtcOccluded1M(scene, &context, &first->ray, count, sizeof(RTCRayHit));
      else
        rtcIntersect1M(scene, &context, first, count, sizeof(RTCRayHit));
      continue;
    }
    for (unsigned i = 0; i < count; ++i) {
      if (wave.is_shadow)
        rtcOccluded1(scene, &context, &first[i].ray);
      else
        rtcIntersect1(scene, &context, &first[i]);
    }
  }
  figure.ns = (processor_s() - begin) * 1e9 / static_cast<double>(order.rays.size());
  for (const Wave& wave : order.waves)
    for (std::size_t i = wave.first; i < wave.first + wave.count; ++i)
      figure.hits +=
          wave.is_shadow ? rays[i].ray.tfar < 0 : rays[i].hit.geomID != RTC_INVALID_GEOMETRY_ID;
  return figure;
}

/// One way to trace all rays.
struct Way {
  std::string name;
  const Order* order;
  Call call;
  RTCIntersectContextFlags flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  std::vector<double> ns{};
  std::size_t hits = 0;
};

int run(const std::filesystem::path& file, std::uint32_t samples, int repeats) {
  const DenormalsAreZero denormals;
  const auto scene = load_scene(file);
  const GeometrySet& set = scene->geometry().accelerator().scene();
  double reach = 0;
  for (const Vec3f& v : set.vertices) reach = std::max(reach, double{max_abs(v)});
  const RaySpace space(reach * set.unit_m);
  Recorder recorder(*scene, space);
  constexpr int kRowsApart = 16;
  std::uint32_t pixel = 0, paths = 0;
  for (int y = 0; y < scene->camera().height(); y += kRowsApart)
    for (int x = 0; x < scene->camera().width(); ++x, ++pixel) {
      const SampleSequence sequence(Sampler::kSobol, 0,
                                    static_cast<std::uint64_t>(y) * scene->camera().width() + x, 0);
      for (std::uint32_t i = 0; i < samples; ++i, ++paths)
        recorder.path(x, y, pixel, {sequence, i});
    }
  fmt::print("{} paths, {:.3f} rays each\n", paths,
             static_cast<double>(recorder.rays.size()) / paths);
  // The rays of a path one by one: each is a wave of its own.
  Order as_traced = in_waves(recorder.rays, 0, false, reach);
  as_traced.waves.clear();
  for (std::size_t i = 0; i < recorder.rays.size(); ++i)
    as_traced.waves.push_back({i, 1, recorder.rays[i].is_shadow()});
  const Order by_pixel = in_waves(recorder.rays, 1, false, reach);
  const Order by_64 = in_waves(recorder.rays, 64, false, reach);
  const Order sorted = in_waves(recorder.rays, 64, true, reach);
  const auto coherent = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  std::vector<Way> ways{{"path", &as_traced, Call::kSingle},
                        {"single, waves of a pixel", &by_pixel, Call::kSingle},
                        {"8, waves of a pixel", &by_pixel, Call::kEight},
                        {"8, waves of a pixel, coherent", &by_pixel, Call::kEight, coherent},
                        {"stream, waves of a pixel", &by_pixel, Call::kStream},
                        {"stream, waves of a pixel, coherent", &by_pixel, Call::kStream, coherent},
                        {"single, waves of 64 pixels, sorted", &sorted, Call::kSingle},
                        {"8, waves of 64 pixels", &by_64, Call::kEight},
                        {"8, waves of 64 pixels, sorted", &sorted, Call::kEight},
                        {"8, the same, coherent", &sorted, Call::kEight, coherent},
                        {"stream, waves of 64 pixels, sorted", &sorted, Call::kStream},
                        {"stream, the same, coherent", &sorted, Call::kStream, coherent}};
  for (const bool robust : {true, false}) {
    const Triangles triangles(set, robust);
    for (Way& way : ways) way.ns.clear();
    for (int i = 0; i < repeats; ++i)
      for (Way& way : ways) {
        const Figure figure = trace(triangles.scene(), *way.order, way.call, way.flags);
        way.ns.push_back(figure.ns);
        way.hits = figure.hits;
      }
    fmt::print("{:38} {:>8} {:>8} {:>10}\n", robust ? "robust" : "not robust", "ns a ray", "ratio",
               "hits");
    double first = 0;
    for (Way& way : ways) {
      std::ranges::sort(way.ns);
      const double median = way.ns[way.ns.size() / 2];
      if (first == 0) first = median;
      fmt::print("{:38} {:8.1f} {:8.2f} {:10}\n", way.name, median, median / first, way.hits);
    }
  }
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  return lucerna::run_on_scene("packet_bench", argc, argv, 1 << 10, 5, lucerna::run);
}
