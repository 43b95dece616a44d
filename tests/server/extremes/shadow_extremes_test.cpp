// Rows 22 and 23: surfaces that shadow themselves and walls that let light through, in scenes of
// any size at any place.  Errors are counted against intersections in double.  A ray that passes an
// edge or an end within the stated error bounds has no right answer in floats and is left out.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "server/queries/visibility.h"
#include "tests/server/extremes/ray_counts.h"

namespace lucerna::testing {
namespace {

class ShadowExtremes : public RayCounts {};

/// Half of them are spheres, disks, cylinders and patches; half are triangles.
int some_primitive(const Everything& e, Random& random) {
  if (uniform(random) < 0.5F) return e.round()[random() % e.round().size()];
  for (;;) {
    const auto i = static_cast<int>(random() % e.exact().size());
    if (e.exact().is_triangle(i)) return i;
  }
}

/// A point of a random primitive.  Every twentieth is on the border, every hundredth is a corner.
Point target(const Everything& e, Random& random) {
  Vec2 u{uniform(random), uniform(random)};
  const float kind = uniform(random);
  if (kind < 0.05F) u.x = 0;
  if (kind < 0.01F) u.y = 0;
  return e.exact().point(some_primitive(e, random), u).position;
}

/// A direction about `n`.  Every tenth is nearly within the surface.
// Not inlined: GCC 12 would leave out the rounding to floats where it makes doubles from them.
[[gnu::noinline]] Vec3f leaving(const Vec3f& n, Random& random) {
  const float c = uniform(random) < 0.9F ? uniform(random) : std::pow(10.0F, -7 * uniform(random));
  const float phi = 2 * std::numbers::pi_v<float> * uniform(random), r = std::sqrt(1 - c * c);
  return normalized(Framef::around(n).world_from_local({r * std::cos(phi), r * std::sin(phi), c}));
}

/// Hits as the first editions of pbrt kept them: floats about the world's zero.
Vec3f world_float(const Everything& e, const Point& p) {
  const Point o = e.scene().origin();
  return Vec3f(Point(Vec3f(p + o)) - o);
}

/// The primitive that a hit lies on, or nothing where this is unsure.
int primitive_of(const ExactAnswer& truth, double t) {
  int found = -1;
  for (const ExactCrossing& c : truth.crossings) {
    if (std::fabs(c.t - t) > 2 * c.slack_t + 4e-7 * t) continue;
    if (!c.sure || c.on_edge || found >= 0) return -1;
    found = c.primitive;
  }
  return found;
}

/// Compares a hit with the reference.  Returns the primitive that it lies on, or -1 where that is
/// unsure.
int check_hit(const ExactAnswer& truth, const std::optional<SurfaceHit>& hit, Count& count) {
  ++count.rays;
  if (!hit) {
    if (truth.sure())
      ++count.leaks;
    else
      count.left_out += !truth.crossings.empty();
    return -1;
  }
  bool there = false, sure = false;
  for (const ExactCrossing& c : truth.crossings) {
    const double tolerance = 2 * c.slack_t + 4e-7 * hit->t;
    const bool this_one = std::fabs(c.t - hit->t) <= tolerance;
    there |= this_one;
    sure |= this_one && c.sure;
    if (c.sure && c.t < hit->t - tolerance) {
      ++count.leaks;  // through something nearer
      return -1;
    }
  }
  if (!there) ++count.shadows;
  count.left_out += there && !sure;
  return primitive_of(truth, hit->t);
}

/// Three rays: one to a surface, one that leaves it, one to a lamp.
void bounce(const Everything& e, Random& random, Count& count) {
  const Scene& scene = e.scene();
  const ExactGeometry& exact = e.exact();
  const auto around = [&] { return 3.0 * uniform(random) - 1.5; };
  const Vec3f origin(e.local({around(), around(), around() + 0.5}));
  Ray ray{origin, Vec3f(target(e, random) - Point(origin))};
  const ExactAnswer seen =
      exact.along({.origin = Point(origin), .direction = Point(ray.direction)});
  const std::optional<SurfaceHit> hit = scene.closest_hit(ray);
  const int from = check_hit(seen, hit, count);
  if (from < 0) return;

  const Point p(hit->position);
  const double start_error = max_abs(hit->position_error);
  const Point n = dot(hit->ng, Point(ray.direction)) < 0 ? hit->ng : -hit->ng;
  const Vec3f w = leaving(Vec3f(n), random);
  ExactRay leaves{.origin = p,
                  .direction = Point(w),
                  .start_error = start_error,
                  .from = from,
                  // Where `w` lies within the surface to a rounding, it may lead to the other side.
                  .from_normal = dot(n, Point(w)) < 0 ? -n : n};
  // On a round surface the ray is then a chord, from anywhere within the error of its start.
  if (dot(n, Point(w)) < 0 && !exact.is_triangle(from)) {
    ++count.rays, ++count.left_out;
    return;
  }
  count.add(exact.along(leaves), scene.geometry().occluded(spawn_ray(*hit, w)),
            scene.geometry().occluded({world_float(e, p), w, kEpsilon}));

  // The lamp just above the floor is taken less often: near its floor most rays have no right
  // answer.
  const std::uint64_t which = random();
  const std::uint32_t light = which % 8 == 0 ? 0 : 1 + (which >> 8) % 2;
  const auto shoot_at = [&](const Light& model) {
    const float u = uniform(random), v = uniform(random);
    const auto sample = model.sample_li(hit->position, {u, v});
    if (sample.reason != NoLight::kNone) return;
    const Point q(sample.point);
    const int to = e.light_begin(light) + static_cast<int>(sample.primitive);
    if (to == from) return;
    ExactRay shadow{.origin = p,
                    .direction = q - p,
                    .t_max = 1,
                    .start_error = start_error,
                    .end_error = kTraversalBound * (max_abs(q) + sample.distance),
                    .from = from,
                    .to = to,
                    .from_normal = dot(hit->ng, q - p) < 0 ? -hit->ng : hit->ng};
    const Vec3f start = world_float(e, p), way = world_float(e, q) - start;
    count.add(exact.along(shadow),
              scene.geometry().occluded(shadow_ray(*hit, sample, scene.lights()[light].reach_m())),
              scene.geometry().occluded({start, way, kEpsilon / length(way), 1 - kEpsilon}));
  };
  shoot_at(*scene.lights()[light].light);
}

/// A segment between two points on surfaces, as a user would type them: floats about a place.
struct TypedSegments {
  std::vector<float> from, to, normals;
  std::vector<ExactRay> exact;
};

TypedSegments typed_segments(const Everything& e, std::size_t n) {
  const ExactGeometry& exact = e.exact();
  TypedSegments s;
  Random random(7);
  const auto put = [](std::vector<float>& to, const Vec3f& v) {
    to.insert(to.end(), {v.x, v.y, v.z});
  };
  const Point shift = e.scene().origin() - e.place().offset;
  while (s.exact.size() < n) {
    const int from = some_primitive(e, random), to = some_primitive(e, random);
    if (from == to) continue;
    auto [p, normal] = exact.point(from, {uniform(random), uniform(random)});
    const Point q = exact.point(to, {uniform(random), uniform(random)}).position;
    if (dot(normal, q - p) < 0) normal = -normal;
    put(s.from, Vec3f(p + shift)), put(s.to, Vec3f(q + shift));
    put(s.normals, Vec3f(normal));
    s.exact.push_back({.origin = p,
                       .direction = q - p,
                       .t_max = 1,
                       .from = from,
                       .to = to,
                       .from_normal = normal});
  }
  return s;
}

/// TestVisibility of the segments, with or without normals.
Count typed(const Everything& e, TypedSegments s, bool with_normals) {
  const Scene& scene = e.scene();
  const std::size_t n = s.exact.size();
  std::vector<std::uint8_t> visible((n + 7) / 8);
  std::vector<int> status(n);
  const VisibilityQuery query{
      .from = {e.place().offset, s.from},
      .to = PointArray{e.place().offset, s.to},
      .normals = with_normals ? std::span<const float>(s.normals) : std::span<const float>{}};
  test_visibility(scene, query, {visible.data(), nullptr, status.data()}, {});
  const ToScene from(scene, query.from, {}), to(scene, *query.to, {});
  tbb::enumerable_thread_specific<Count> counts;
  parallel_chunks(n, 1024, {}, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      // Segments begin and end this far from their points, and from surfaces that the points are
      // not on.
      const auto error = [&](const ScenePoint& p) {
        return kStartWithoutNormal * (p.error + kTraversalBound * e.largest());
      };
      s.exact[i].start_error = error(from(i)), s.exact[i].end_error = error(to(i));
      const Vec3f start = world_float(e, s.exact[i].origin),
                  way = world_float(e, s.exact[i].origin + s.exact[i].direction) - start;
      EXPECT_EQ(status[i], 1);
      counts.local().add(
          e.exact().along(s.exact[i]), (visible[i / 8] >> (i % 8) & 1) == 0,
          scene.geometry().occluded({start, way, kEpsilon / length(way), 1 - kEpsilon}));
    }
  });
  Count sum;
  for (const Count& c : counts) sum += c;
  return sum;
}

/// Points of the floor beneath a lamp just above it, and beside that lamp.
void beneath(const Everything& e, Random& random, Count& count) {
  const Scene& scene = e.scene();
  const bool under = uniform(random) < 0.5F;
  const double x = under ? -0.8 + 0.3 * uniform(random) : -0.95 + 0.6 * uniform(random);
  const double y = under ? -0.8 + 0.3 * uniform(random) : -0.95 + 0.6 * uniform(random);
  const Vec3f above(e.local({x, y, 0.5 * Everything::kHair}));
  const auto hit = scene.closest_hit({above, {0, 0, -1}});
  // The lamp must not hide the floor from a point between the two.
  ++count.rays;
  const double height = Everything::kHair * e.place().size;
  if (!hit || std::fabs(hit->t - 0.5 * height) > 0.1 * height) {
    ++count.leaks;
    return;
  }
  const auto shoot_at = [&](const Light& lamp) {
    const float u = uniform(random), v = uniform(random);
    const auto sample = lamp.sample_li(hit->position, {u, v});
    ++count.rays;
    if (sample.reason != NoLight::kNone) {
      ++count.shadows;
      return;
    }
    const Point p(hit->position), q(sample.point);
    count.shadows += scene.geometry().occluded(shadow_ray(*hit, sample));
    const Vec3f start = world_float(e, p), way = world_float(e, q) - start;
    count.textbook += scene.geometry().occluded({start, way, kEpsilon / length(way), 1 - kEpsilon});
    // A ray from the floor past the sample must not pass through the lamp.
    if (sample.normal.z < -0.5F || !under) return;
    ++count.rays;
    count.leaks += !scene.geometry().occluded(spawn_ray(*hit, Vec3f{0, 0, 1}));
    count.textbook += !scene.geometry().occluded({start, {0, 0, 1}, kEpsilon});
  };
  shoot_at(*scene.lights()[0].light);
}

TEST_F(ShadowExtremes, LeaksAndSelfShadowingAtAnySize) {
  Sweep sweep(22, "rays to, from and between objects of every kind and lamps", "1e-4 ... 1e7 m",
              "leaks and self-shadowing");
  for (const Place& place : sizes()) {
    const Everything e(place);
    expect(counted(360000, [&](Random& r, Count& k) { bounce(e, r, k); }), place, 0.03);
  }
  finish(sweep);
}

TEST_F(ShadowExtremes, LeaksAndSelfShadowingFarFromZero) {
  Sweep sweep(23, "the rays of row 22 in a scene of size 1, moved",
              "1e7 m along x, y, z and all three", "leaks and self-shadowing");
  for (const Place& place : moved()) {
    const Everything e(place);
    const std::size_t n = place.offset.x * place.offset.y != 0 ? 360000 : 60000;
    expect(counted(n, [&](Random& r, Count& k) { bounce(e, r, k); }), place, 0.03);
  }
  finish(sweep);
}

TEST_F(ShadowExtremes, TypedPoints) {
  Sweep sweep(
      22, "segments between points on surfaces with coordinates as typed, with or without normals",
      "1e-4 ... 1e7 m; moved by 1e7", "leaks and self-shadowing");
  std::vector<Place> all = sizes();
  all.push_back(moved()[0]);
  for (const Place& place : all) {
    const Everything e(place);
    const TypedSegments segments = typed_segments(e, 60000);
    expect(typed(e, segments, false), place, 0.03);
    expect(typed(e, segments, true), place, 0.03);
  }
  finish(sweep);
}

TEST_F(ShadowExtremes, LampJustAboveAFloor) {
  Sweep sweep(22, "lamp above a floor, at 1e-5 of the scene's size, and points on the floor",
              "1e-4 ... 1e7 m; moved by 1e7", "lamp hidden, or seen through the floor");
  std::vector<Place> all = sizes();
  all.push_back(moved()[0]);
  for (const Place& place : all) {
    const Everything e(place);
    expect(counted(100000, [&](Random& r, Count& k) { beneath(e, r, k); }), place, 1e-9);
  }
  finish(sweep);
}

}  // namespace
}  // namespace lucerna::testing
