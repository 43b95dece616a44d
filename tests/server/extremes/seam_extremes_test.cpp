// Row 23: rays at the seams of a closed mesh, and rays within the planes of flat shapes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/server/extremes/ray_counts.h"

namespace lucerna::testing {
namespace {

class SeamExtremes : public RayCounts {};

/// A closed mesh at a place: its corners, and rays from within towards its edges.
struct Closed {
  std::shared_ptr<const Scene> scene;
  std::vector<std::array<Vec3f, 3>> triangles;  // about the origin of the scene
  Point centre;
};

Closed closed(const Place& place, bool as_instance) {
  const Transform t = Transform::translate(place.offset) * *Transform::rotate(0.4, {3, 1, 2}) *
                      *Transform::scale({place.size, place.size, place.size});
  SceneDescription d = description();
  TriangleMeshData mesh = ball(3, [&](const Point& p) { return as_instance ? p : t.point(p); });
  const TriangleMeshData kept = mesh;
  if (as_instance) {
    d.objects = {{"ball", {{std::move(mesh)}}}};
    d.instances = {{0, t}};
  } else {
    d.shapes.push_back({std::move(mesh)});
  }
  Closed c{build(std::move(d)), {}, {}};
  const auto local = [&](std::uint32_t i) {
    const Point p = kept.positions[kept.indices[i]];
    return Vec3f((as_instance ? t.point(p) : p) - c.scene->origin());
  };
  for (std::uint32_t i = 0; i < kept.indices.size(); i += 3)
    c.triangles.push_back({local(i), local(i + 1), local(i + 2)});
  c.centre = t.point({}) - c.scene->origin();
  return c;
}

/// Whether a ray meets a triangle, by the formula of Moeller and Trumbore in floats.
bool moeller_trumbore(const Ray& ray, const std::array<Vec3f, 3>& v) {
  const Vec3f e1 = v[1] - v[0], e2 = v[2] - v[0], p = cross(ray.direction, e2);
  const float determinant = dot(e1, p);
  if (std::fabs(determinant) < 1e-6F) return false;
  const float inverse = 1 / determinant;
  const Vec3f s = ray.origin - v[0], q = cross(s, e1);
  const float a = dot(s, p) * inverse, b = dot(ray.direction, q) * inverse;
  return a >= 0 && b >= 0 && a + b <= 1 && dot(e2, q) * inverse > 0;
}

/// A ray from within the mesh towards an edge.  None may get out.  (At corners, one ray in 1e4
/// does: to within rounding, no triangle around the corner contains it.)
void at_seam(const Closed& c, double size, Random& random, Count& count) {
  const auto& v = c.triangles[random() % c.triangles.size()];
  const float along = uniform(random);
  const Vec3f seam = v[0] + (v[1] - v[0]) * along;
  const auto around = [&] { return (uniform(random) - 0.5) * size; };
  Ray ray{Vec3f(c.centre + Point{around(), around(), around()}), {}};
  ray.direction = seam - ray.origin;
  ++count.rays;
  count.leaks += !c.scene->geometry().occluded(ray);
  // One ray in 16 also goes through the textbook's formula: all of them would take as long again.
  if (random() % 16 != 0) return;
  count.textbook += 16 * std::ranges::none_of(
                             c.triangles, [&](const auto& t) { return moeller_trumbore(ray, t); });
}

/// A ray onto a square across `axis`, and one from there within its plane.
void within_plane(const Scene& scene, int axis, double size, Random& random, Count& count) {
  const auto coordinate = [&] { return (2 * uniform(random) - 1) * 0.9 * size; };
  const auto pick = [&](double a, double b, double c) {
    const std::array<double, 3> v{a, b, c};
    return Vec3f(Point{v[(3 - axis) % 3], v[(4 - axis) % 3], v[(5 - axis) % 3]});
  };
  const auto hit =
      scene.closest_hit({pick(0.5 * size, coordinate(), coordinate()), pick(-1, 0, 0)});
  ++count.rays;
  if (!hit) {
    ++count.leaks;
    return;
  }
  const double turn = 2 * std::numbers::pi * uniform(random);
  const bool straight = uniform(random) < 0.3F;
  const Vec3f w =
      straight ? pick(0, random() % 2 ? 1 : -1, 0) : pick(0, std::cos(turn), std::sin(turn));
  ++count.rays;
  count.shadows += scene.geometry().occluded(spawn_ray(*hit, w));
  const Vec3f p(hit->position);
  count.textbook += scene.geometry().occluded({p, w, kEpsilon});
}

TEST_F(SeamExtremes, NothingLeavesAClosedMesh) {
  Sweep sweep(23, "rays from inside a closed mesh or its instance, towards the edges",
              "1e-4 ... 1e7 m; moved by 1e7", "leaks");
  std::vector<Place> all = sizes();
  all.push_back(moved()[0]);
  for (const Place& place : all)
    for (const bool as_instance : {false, true}) {
      const Closed c = closed(place, as_instance);
      expect(counted(200000, [&](Random& r, Count& k) { at_seam(c, place.size, r, k); }), place,
             1e-9);
    }
  finish(sweep);
}

TEST_F(SeamExtremes, RaysWithinAxisAlignedPlanes) {
  Sweep sweep(23, "flat squares in axis-aligned planes, rays in these planes", "1e-4 ... 1e7 m",
              "leaks and self-shadowing");
  for (const Place& place : sizes())
    for (int axis = 0; axis < 3; ++axis) {
      SceneDescription d = description();
      TriangleMeshData mesh;
      for (int i = 0; i < 4; ++i) {
        const std::array<double, 3> v{0, i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0};
        mesh.positions.push_back(Point{v[(3 - axis) % 3], v[(4 - axis) % 3], v[(5 - axis) % 3]} *
                                 place.size);
      }
      mesh.indices = {0, 1, 2, 1, 3, 2};
      d.shapes.push_back({mesh});
      const auto scene = build(std::move(d));
      expect(counted(50000,
                     [&](Random& r, Count& k) { within_plane(*scene, axis, place.size, r, k); }),
             place, 1e-9);
    }
  finish(sweep);
}

}  // namespace
}  // namespace lucerna::testing
