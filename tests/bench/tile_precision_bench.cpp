// Measures the cost of light mathematics in double for the time of a tile.  Not a test; `make
// precision` writes its output to docs/precision.md.
//
// The server's renderer renders a tile in double on one thread.  The benchmark then walks the paths
// of the same tile again and records their queries to lights.  Lights of both types answer the same
// queries in alternation.  The cost is the extra time of double, relative to the tile's time
// without it.
#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "lights/models/light.h"
#include "server/assets/asset_reader.h"
#include "server/estimate/paths/path.h"
#include "server/estimate/paths/render.h"
#include "server/pbrt/load.h"
#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"
#include "server/scene/light_choice.h"
#include "server/scene/scene.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

template <typename T>
T value_of(absl::StatusOr<T> made) {
  if (!made.ok()) throw std::runtime_error(made.status().ToString());
  return *std::move(made);
}

// Lights of a scene in float, from the parameters of those in double.

template <template <std::floating_point> typename L>
requires requires(const L<double>& l) { l.params(); }
Light<float> in_float(const L<double>& light, const Vec3<double>& origin) {
  return value_of(L<float>::create(light.params(), origin));
}

template <template <typename> typename Profile>
Light<float> in_float(const IntensityLight<double, Profile>& light, const Vec3<double>& origin) {
  return value_of(IntensityLight<float, Profile>::create(light.params(), origin));
}

Vec3<float> rounded(const Vec3<double>& v) { return Vec3<float>(v); }
Triangle<float> rounded(const Triangle<double>& t) {
  return {rounded(t.a), rounded(t.b), rounded(t.c)};
}
BilinearPatch<float> rounded(const BilinearPatch<double>& p) {
  return {rounded(p.p00), rounded(p.p10), rounded(p.p01), rounded(p.p11)};
}

template <template <typename> typename Shape>
Light<float> in_float(const AreaLight<double, Shape>& light, const Vec3<double>& origin) {
  const Shape<double>& shape = light.shape();
  if constexpr (requires { shape.params(); }) {
    return value_of(AreaLight<float, Shape>::create(
        light.emission(), value_of(Shape<float>::create(shape.params(), origin))));
  } else if constexpr (requires { shape.primitive(0); }) {
    std::vector<decltype(rounded(shape.primitive(0)))> primitives;
    for (std::size_t i = 0; i < shape.size(); ++i)
      primitives.push_back(rounded(shape.primitive(i)));
    return value_of(AreaLight<float, Shape>::create(
        light.emission(), value_of(Shape<float>::create(std::move(primitives)))));
  } else {
    throw std::runtime_error("a light with a picture or photometry on its surface");
  }
}

/// A query along a path about a light.
template <std::floating_point Real>
struct Question {
  enum Kind { kSample, kFound, kFoundDensity, kEscaped, kEscapedDensity } kind;
  std::uint32_t light;
  Receiver<Real> receiver;
  Vec2<Real> u;              // kSample
  SurfacePoint<Real> point;  // kFound, kFoundDensity
  Vec3<Real> w;              // kFound: away from the light; kEscaped...: towards it

  explicit Question(Kind kind, std::uint32_t light) : kind(kind), light(light) {}
  template <typename Other>
  explicit Question(const Question<Other>& q)
      : kind(static_cast<Kind>(q.kind)),
        light(q.light),
        receiver(Vec3<Real>(q.receiver.position)),
        u{Real(q.u.x), Real(q.u.y)},
        point{Vec3<Real>(q.point.position), Vec3<Real>(q.point.normal), q.point.primitive},
        w(q.w) {
    receiver.normal = Vec3<Real>(q.receiver.normal);
    receiver.area_sampling = q.receiver.area_sampling;
    receiver.incomplete = q.receiver.incomplete;
  }
};

template <std::floating_point Real>
double answer(const std::vector<Light<Real>>& lights, const Question<Real>& q) {
  return visit(
      [&]<typename L>(const L& light) -> double {
        switch (q.kind) {
          case Question<Real>::kSample:
            return light.sample_li(q.receiver, q.u).value.g;
          case Question<Real>::kFound:
            if constexpr (SeenOnSurface<L>) return light.le(q.point, q.w).g;
            break;
          case Question<Real>::kFoundDensity:
            if constexpr (SeenOnSurface<L>) return light.pdf_li(q.receiver, q.point).per_sr;
            break;
          case Question<Real>::kEscaped:
            if constexpr (SeenBeyond<L>) return light.le_escaped(q.receiver.position, q.w).g;
            break;
          case Question<Real>::kEscapedDensity:
            return light.pdf_li(q.receiver, q.w).per_sr;
        }
        return 0;
      },
      lights[q.light]);
}

/// Repeats the paths of PathTracer, for a scene without motion and with a limit of bounces.
class Walker {
 public:
  Walker(const Scene& scene, const TileSettings& settings)
      : scene_(scene), settings_(settings), tracer_(scene, settings.bounces, settings.methods) {}

  /// Walks all paths of a pixel and appends their queries to `questions`.
  void walk(int x, int y, std::vector<Question<double>>& questions) {
    const auto item = static_cast<std::uint64_t>(y * scene_.camera().width() + x);
    for (std::uint64_t b = 0; b < settings_.block_count; ++b) {
      const SampleSequence sequence(settings_.methods.sampler, settings_.seed, item,
                                    settings_.first_block + b);
      for (std::uint32_t i = 0; i < settings_.samples_per_block; ++i) {
        const PathSample sample{sequence, i};
        const Vec2<float> film = sample.pair(PathSample::kFilm);
        walk(scene_.camera().ray(static_cast<float>(x) + film.x, static_cast<float>(y) + film.y),
             sample, questions);
      }
    }
  }

  const WorkCounts& work() const { return work_; }

 private:
  using Questions = std::vector<Question<double>>;
  using Record = Question<double>;

  void walk(const Ray& from_camera, const PathSample& sample, Questions& questions) {
    ++work_.camera_rays;
    std::optional<SurfaceHit> hit = scene_.closest_hit(from_camera);
    found(from_camera, hit, nullptr, questions);
    Vec3<float> wo = -from_camera.direction;
    for (std::uint32_t depth = 0; hit; ++depth) {
      const Rgb<double>* reflectance = scene_.plain_diffuse(hit->material);
      if (reflectance != nullptr && reflectance->is_black()) return;
      Receiver<double> receiver(hit->position);
      receiver.normal = dot(hit->ns, Vec3<double>(wo)) < 0 ? -hit->ns : hit->ns;
      receiver.area_sampling = settings_.methods.area_sampling;
      receiver.incomplete = true;
      sample_lights(receiver, depth, sample, questions);
      const bool last = depth >= *settings_.bounces;
      if (last && !scene_.has_visible_lights()) return;
      const Vec3<float> wi = PathTracer::cosine_direction(Vec3<float>(hit->ns), wo,
                                                          sample.at(depth, PathSample::kDirection));
      const Ray ray = spawn_ray(*hit, wi);
      ++work_.indirect_rays;
      hit = scene_.closest_hit(ray);
      found(ray, hit, &receiver, questions);
      if (last) return;
      wo = -wi;
    }
  }

  void sample_lights(const Receiver<double>& receiver, std::uint32_t depth,
                     const PathSample& sample, Questions& questions) const {
    const auto record = [&](std::uint32_t light, Vec2<float> u) {
      Record& q = questions.emplace_back(Record::kSample, light);
      q.receiver = receiver;
      q.u = {u.x, u.y};
    };
    const Spending spending = tracer_.direct().spending(depth);
    if (spending != Spending::kDrawn) {
      const Vec2<float> u = sample.at(depth, PathSample::kLightPoint);
      const bool draws = spending == Spending::kOneArea;
      for (std::uint32_t l = 0; l < scene_.lights().size(); ++l)
        if (!draws || is_delta(scene_.lights()[l])) record(l, u);
      if (!draws) return;
      const auto choice = scene_.area_selector().choose(
          LightSelection::kBvh, receiver, choosing_value(sample.at(depth, PathSample::kLight)));
      if (choice) record(choice->light, u);
      return;
    }
    for (std::uint32_t j = 0; j < DirectLight::kCandidates; ++j) {
      const PathSample s = sample.part(j, DirectLight::kCandidates);
      const auto choice = scene_.light_selector().choose(
          LightSelection::kAutomatic, receiver, choosing_value(s.at(depth, PathSample::kLight)));
      if (choice) record(choice->light, s.at(depth, PathSample::kLightPoint));
    }
  }

  /// Records what `ray` hits, and the density of sampling that direction at the surface where it
  /// started.
  void found(const Ray& ray, const std::optional<SurfaceHit>& hit, const Receiver<double>* from,
             Questions& questions) const {
    const Vec3<double> w(ray.direction);
    if (hit && hit->light >= 0) {
      const auto light = static_cast<std::uint32_t>(hit->light);
      Record& le = questions.emplace_back(Record::kFound, light);
      le.point = hit->on_light();
      le.w = -w;
    }
    if (!hit)
      for (const std::uint32_t light : scene_.infinite_lights()) {
        Record& le = questions.emplace_back(Record::kEscaped, light);
        le.receiver = Receiver<double>(Vec3<double>(ray.origin));
        le.w = w;
      }
    tracer_.for_each_emitter(ray, hit, [&](std::uint32_t light, const Rgb<double>&) {
      if (from == nullptr) return;
      Record& pdf =
          questions.emplace_back(hit ? Record::kFoundDensity : Record::kEscapedDensity, light);
      pdf.receiver = *from;
      pdf.w = w;
      if (hit) pdf.point = hit->on_light();
    });
  }

  const Scene& scene_;
  const TileSettings& settings_;
  PathTracer tracer_;
  WorkCounts work_;
};

/// Processor time: other programs change it less than the wall time.
template <typename F>
double seconds(F&& f) {
  const std::int64_t begin = thread_cpu_ns();
  f();
  return 1e-9 * static_cast<double>(thread_cpu_ns() - begin);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Time of the queries of one tile [s].
struct Answered {
  double in_float = 0, in_double = 0;
  double questions = 0;
  WorkCounts work;
};

class Tile {
 public:
  Tile(const std::string& root, const std::string& name) {
    auto assets = value_of(AssetReader::open(root));
    scene_ = value_of(Scene::build(value_of(load_pbrt(assets, name, {}))));
    for (const SceneLight& l : scene_->lights()) {
      in_double_.push_back(l.light);
      in_float_.push_back(
          visit([&](const auto& light) { return in_float(light, scene_->origin()); }, l.light));
    }
    settings_.rect = {48, 28, 112, 92};
    settings_.samples_per_block = 4;
    settings_.block_count = 1;
    settings_.bounces = static_cast<std::uint32_t>(scene_->hints().max_depth.value_or(1) - 1);
  }

  std::size_t lights() const { return in_double_.size(); }
  double samples() const {
    return double(settings_.rect.x1 - settings_.rect.x0) *
           double(settings_.rect.y1 - settings_.rect.y0) * settings_.samples_per_block;
  }

  /// Time of the server's renderer [s].
  double render(WorkCounts& work) const {
    return seconds([&] { work = render_tile(*scene_, settings_, {}).work; });
  }

  /// A few pixels at a time, so that queries stay in the cache.  The types alternate, so that other
  /// load on the machine affects both equally.
  Answered measure() const {
    const DenormalsAreZero denormals;
    constexpr std::size_t kAtOnce = 1024;
    Answered all;
    Walker walker(*scene_, settings_);
    std::vector<Question<double>> questions;
    const auto answer_in_turns = [&] {
      const std::vector<Question<float>> roundings(questions.begin(), questions.end());
      answer_all(in_float_, roundings), answer_all(in_double_, questions);
      for (int turn = 0; turn < 2; ++turn) {
        all.in_double += answer_all(in_double_, questions) / 4;
        all.in_float += answer_all(in_float_, roundings) / 2;
        all.in_double += answer_all(in_double_, questions) / 4;
      }
      all.questions += static_cast<double>(questions.size());
      questions.clear();
    };
    for (int y = settings_.rect.y0; y < settings_.rect.y1; ++y)
      for (int x = settings_.rect.x0; x < settings_.rect.x1; ++x) {
        walker.walk(x, y, questions);
        if (questions.size() >= kAtOnce) answer_in_turns();
      }
    answer_in_turns();
    all.work = walker.work();
    return all;
  }

 private:
  template <typename Real>
  static double answer_all(const std::vector<Light<Real>>& lights,
                           const std::vector<Question<Real>>& questions) {
    return seconds([&] {
      double sum = 0;
      for (const auto& q : questions) sum += answer(lights, q);
      volatile double kept = sum;  // keeps the compiler from removing the work
      static_cast<void>(kept);
    });
  }

  std::shared_ptr<const Scene> scene_;
  TileSettings settings_;
  std::vector<Light<double>> in_double_;
  std::vector<Light<float>> in_float_;
};

/// Cost of double as a share of the tile's time.
double compare(const std::string& root, const std::string& name) {
  constexpr int kRepeats = 9;
  const Tile tile(root, name + ".pbrt");
  std::vector<double> tile_s, float_s, double_s, shares, costs;
  Answered a;
  for (int k = 0; k < kRepeats; ++k) {
    WorkCounts work;
    tile_s.push_back(tile.render(work));
    a = tile.measure();
    if (a.work.camera_rays != work.camera_rays || a.work.indirect_rays != work.indirect_rays)
      throw std::runtime_error("the paths of " + name + " are not those of the renderer");
    float_s.push_back(a.in_float), double_s.push_back(a.in_double);
    shares.push_back(a.in_double / tile_s.back());
    costs.push_back((a.in_double - a.in_float) / (tile_s.back() - a.in_double + a.in_float));
  }
  const double each = 1e9 / a.questions;
  fmt::print("| {} | {} | {:.1f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} % | {:+.1f} % |\n", name,
             tile.lights(), a.questions / tile.samples(), 1e9 * median(tile_s) / tile.samples(),
             each * median(float_s), each * median(double_s), 100 * median(shares),
             100 * median(costs));
  return median(costs);
}

int run() {
  fmt::print(
      "| scene | lights | light evaluations a sample | ns a sample of the tile | ns an evaluation, "
      "float | double | share of the tile's time | cost of double |\n"
      "|---|---|---|---|---|---|---|---|\n");
  const std::string reference = test_data("reference");
  double most = -1;
  std::string where;
  const auto measure = [&](const std::string& root, const std::string& name) {
    const double cost = compare(root, name);
    if (cost > most) most = cost, where = name;
  };
  for (const char* name : {"point", "spot", "triangle", "rectangle", "sphere", "disk", "cylinder",
                           "environment", "many_points", "many_triangles", "bounces"})
    measure(reference, name);
  measure(source_path("scenes"), "demo");
  fmt::print(
      "\nAt most double costs {:.1f} % of a tile's time ({}), {} than a tenth: by the rule "
      "**lights compute in {}**.\n",
      100 * most, where, most < 0.1 ? "less" : "not less", most < 0.1 ? "double" : "float");
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace lucerna

int main() {
  try {
    // One thread: the tile's time is then processor time, like that of the queries.
    return tbb::task_arena(1).execute([] { return lucerna::run(); });
  } catch (const std::exception& error) {
    fmt::print(stderr, "tile_precision_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
