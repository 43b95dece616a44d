// One object of every kind that rays can meet, at a given place and of a given size.  It exists
// twice: as the server's scene, and as primitives in double.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/scene/scene.h"
#include "tests/server/extremes/exact_rays.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {

struct Place {
  double size;
  Point offset;
  std::string name;
};

/// Maps points about zero, within 1 of it, to a place.
class Everything {
 public:
  explicit Everything(const Place& place) : place_(place) {
    SceneDescription d = description();
    const auto mesh = [&](TriangleMeshData m) { d.shapes.push_back({std::move(m)}); };
    mesh(quad(-1, -1, 1, 1, 0));  // a floor in a coordinate plane
    TriangleMeshData wall;        // and a wall of 2 x 8 triangles that meets it
    for (int i = 0; i < 9; ++i)
      for (const double z : {0.0, 0.9}) wall.positions.push_back(at({-1, -1 + 0.25 * i, z}));
    for (std::uint32_t i = 0; i < 16; i += 2)
      for (const std::uint32_t k : {0, 2, 1, 1, 2, 3}) wall.indices.push_back(i + k);
    mesh(wall);
    mesh(box({0.3, 0.3, 0.2}, 0.2, 0));
    mesh(box({0.35, -0.5, 0.21}, 0.13, 0.6));
    mesh(ball(1, [&](const Point& p) { return at(p * 0.25 + Point{-0.4, 0.3, 0.4}); }));
    for (const double width : {3e-2, 3e-4, 3e-6}) {  // needles of 1:10 to 1:1e5
      const double y = 0.6 + 0.1 * std::log10(width);
      mesh({{at({-0.7, y, 0.6}), at({-0.4, y + 0.02, 0.65}), at({-0.7, y + width, 0.6})},
            {},
            {0, 1, 2}});
    }
    const auto unit = [&](const Point& centre, double turn) {
      return Transform::translate(at(centre)) * *Transform::rotate(turn, {1, 2, 3}) *
             *Transform::scale({place_.size, place_.size, place_.size});
    };
    d.shapes.push_back(
        {SphereParams{.radius_m = 0.2, .world_from_object = unit({0, 0.7, 0.3}, 0)}});
    d.shapes.push_back({DiskParams{.radius_m = 0.2, .world_from_object = unit({0.6, 0, 0.4}, 1)}});
    d.shapes.push_back({CylinderParams{.radius_m = 0.1,
                                       .z_min_m = -0.25,
                                       .z_max_m = 0.25,
                                       .world_from_object = unit({0.7, 0.6, 0.4}, 2)}});
    d.shapes.push_back(testing::patch(at(kPatch[0]), at(kPatch[1]), at(kPatch[2]), at(kPatch[3])));
    d.objects = {{"ball", {{ball(1, [](const Point& p) { return p * 5.0; })}}}};
    world_from_object_ = unit({-0.1, -0.3, 0.35}, 0.7) * *Transform::scale({0.05, 0.03, 0.04});
    d.instances = {{0, world_from_object_}};
    // Lamps: one just above the floor, one above everything, one sphere.
    const auto lamp = [&](ShapeDescription s) {
      d.shapes.push_back(emissive(std::move(s), 1, true));
    };
    lamp({quad(-0.8, -0.8, -0.5, -0.5, kHair)});
    lamp({quad(-0.5, -0.5, 0.5, 0.5, 1)});
    lamp({SphereParams{.radius_m = 0.1, .world_from_object = unit({0.8, -0.8, 0.5}, 0)}});
    const SceneDescription kept = d;
    scene_ = build(std::move(d));
    fill(kept);
  }

  const Scene& scene() const { return *scene_; }
  const ExactGeometry& exact() const { return *exact_; }
  const Place& place() const { return place_; }
  /// The primitives of each light.
  int light_begin(std::uint32_t light) const { return light_begin_[light]; }
  /// About the origin of the scene.
  Point local(const Point& unit) const { return at(unit) - scene_->origin(); }
  double largest() const { return largest_; }
  /// The few hundred primitives that are not triangles.
  const std::vector<int>& round() const { return round_; }

  static constexpr double kHair = 1e-5;

 private:
  static constexpr std::array<Point, 4> kPatch{Point{-0.9, -0.3, 0.2}, Point{-0.6, -0.3, 0.5},
                                               Point{-0.9, 0.1, 0.5}, Point{-0.55, 0.05, 0.2}};

  Point at(const Point& p) const { return place_.offset + p * place_.size; }

  TriangleMeshData quad(double x0, double y0, double x1, double y1, double z) const {
    return {{at({x0, y0, z}), at({x1, y0, z}), at({x0, y1, z}), at({x1, y1, z})},
            {},
            {0, 1, 2, 1, 3, 2}};
  }

  /// Twelve triangles on eight corners, turned by `turn` about the vertical.
  TriangleMeshData box(const Point& centre, double half, double turn) const {
    TriangleMeshData m;
    const Transform t = Transform::translate(centre) * *Transform::rotate(turn, {0, 0, 1});
    for (int i = 0; i < 8; ++i)
      m.positions.push_back(
          at(t.point(Point{i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half})));
    m.indices = {0, 3, 1, 0, 2, 3, 4, 7, 6, 4, 5, 7, 0, 5, 4, 0, 1, 5,
                 2, 7, 3, 2, 6, 7, 0, 6, 2, 0, 4, 6, 1, 7, 5, 1, 3, 7};
    return m;
  }

  void fill(const SceneDescription& d) {
    const Point o = scene_->origin();
    largest_ = max_abs(scene_->sphere().center_m) + scene_->sphere().radius_m;
    exact_.emplace(largest_);
    for (const ShapeDescription& s : d.shapes) {
      if (s.emission) light_begin_.push_back(exact_->size());
      if (const auto* mesh = std::get_if<TriangleMeshData>(&s.geometry))
        triangles(*mesh, [&](const Point& p) { return p - o; });
      if (const auto* sphere = std::get_if<SphereParams>(&s.geometry))
        exact_->sphere(sphere->world_from_object.point({}) - o, sphere->radius_m * place_.size);
      if (const auto* disk = std::get_if<DiskParams>(&s.geometry))
        exact_->disk(disk->world_from_object.point({}) - o,
                     normalized(disk->world_from_object.vector({0, 0, 1})),
                     disk->radius_m * place_.size);
      if (const auto* c = std::get_if<CylinderParams>(&s.geometry))
        exact_->cylinder(c->world_from_object.point({}) - o,
                         normalized(c->world_from_object.vector({0, 0, 1})),
                         c->radius_m * place_.size, c->z_max_m * place_.size);
      if (const auto* patches = std::get_if<PatchMeshData>(&s.geometry))
        exact_->patch(patches->positions[0] - o, patches->positions[1] - o,
                      patches->positions[2] - o, patches->positions[3] - o);
    }
    // Into the object's space.  Its axes are stretched relative to each other by up to 5/3.
    exact_->begin_instance(3 * 5.0 / 3 * kTraversalBound * largest_);
    triangles(std::get<TriangleMeshData>(d.objects[0].shapes[0].geometry),
              [&](const Point& p) { return world_from_object_.point(p) - o; });
    exact_->finish();
    for (int i = 0; i < exact_->size(); ++i)
      if (!exact_->is_triangle(i)) round_.push_back(i);
  }

  template <typename F>
  void triangles(const TriangleMeshData& mesh, F&& f) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
      exact_->triangle(f(mesh.positions[mesh.indices[i]]), f(mesh.positions[mesh.indices[i + 1]]),
                       f(mesh.positions[mesh.indices[i + 2]]));
  }

  Place place_;
  Transform world_from_object_;
  std::shared_ptr<const Scene> scene_;
  std::optional<ExactGeometry> exact_;
  std::vector<int> light_begin_, round_;
  double largest_ = 0;
};

inline const std::vector<Place>& sizes() {
  static const std::vector<Place> all{
      {1e-4, {}, "size 1e-4"}, {1, {}, "size 1"}, {1e4, {}, "size 1e4"}, {1e7, {}, "size 1e7"}};
  return all;
}

inline const std::vector<Place>& moved() {
  static const std::vector<Place> all{{1, {1e7, -1e7, 1e7}, "moved by 1e7 on all axes"},
                                      {1, {1e7, 0, 0}, "moved by 1e7 along x"},
                                      {1, {0, 1e7, 0}, "moved by 1e7 along y"},
                                      {1, {0, 0, 1e7}, "moved by 1e7 along z"}};
  return all;
}

}  // namespace lucerna::testing
