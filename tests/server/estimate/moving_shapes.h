// Shapes of every kind under one motion, and their place by the definition.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "tests/server/scene/scenes.h"

namespace lucerna::testing {

inline std::vector<KeyTransform> keys() {
  return {{0, Transform::translate({1, 0.5, 0.2}) * *Transform::rotate(0.3, {1, 0, 2})},
          {2, Transform::translate({3, -0.5, 1}) * *Transform::rotate(1.6, {1, 2, -1})}};
}

// World from object at `t` in [0, 2], from the definition.  The origin moves on a line.  The shape
// turns about one axis at constant speed from one key frame to the other.  The angle comes from the
// trace, the axis from the antisymmetric part.
inline Transform placed_at(double t) {
  const std::vector<KeyTransform> k = keys();
  const Transform step = k[1].world_from_light * k[0].world_from_light.inverse();
  const auto& m = step.matrix();
  const double angle = std::acos((m[0][0] + m[1][1] + m[2][2] - 1) / 2);
  const Vec3 axis{m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
  const Vec3 a = k[0].world_from_light.point({}), b = k[1].world_from_light.point({});
  return Transform::translate(a + (b - a) * (t / 2)) * *Transform::rotate(angle * t / 2, axis) *
         Transform::translate(-a) * k[0].world_from_light;
}

inline std::shared_ptr<const Motion> moving(const std::vector<KeyTransform>& k = keys()) {
  return std::make_shared<const Motion>(*Motion::create(k));
}

/// Slides by `shift` from 0 s to `end_s`.
inline std::shared_ptr<const Motion> sliding(const Vec3& shift, double end_s) {
  return moving({{0, {}}, {end_s, Transform::translate(shift)}});
}

/// A kind of shape, about a metre in size; `make` takes the map from object to world.
struct Kind {
  const char* name;
  std::function<ShapeDescription(const Transform&)> make;
};

inline ShapeDescription patch_of(const Transform& w, double twist) {
  return patch(w.point({-1, -0.5, 0}), w.point({1, -0.5, 0}), w.point({-1, 0.5, 0}),
               w.point({1, 0.5, twist}));
}

inline const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {"mesh",
       [](const Transform& w) {
         return shape(ball(2, [&](const Vec3& p) { return w.point(p); }));
       }},
      {"flat patch", [](const Transform& w) { return patch_of(w, 0); }},
      {"twisted patch", [](const Transform& w) { return patch_of(w, 0.5); }},
      {"sphere",
       [](const Transform& w) {
         return shape(SphereParams{.radius_m = 0.8,
                                   .z_min_m = -0.8,
                                   .z_max_m = 0.5,
                                   .phi_max_rad = 5,
                                   .world_from_object = w});
       }},
      {"disk",
       [](const Transform& w) {
         return shape(DiskParams{
             .height_m = 0.25, .radius_m = 1, .inner_radius_m = 0.25, .world_from_object = w});
       }},
      {"cylinder", [](const Transform& w) {
         return shape(CylinderParams{
             .radius_m = 0.5, .z_min_m = -0.75, .z_max_m = 0.5, .world_from_object = w});
       }}};
  return all;
}

inline ShapeDescription moved(const Kind& kind) {
  ShapeDescription s = kind.make(placed_at(0));
  s.motion = moving();
  return s;
}

inline std::shared_ptr<const Scene> scene_of(ShapeDescription s) {
  SceneDescription d = description();
  d.shapes.push_back(std::move(s));
  return build(std::move(d));
}

}  // namespace lucerna::testing
