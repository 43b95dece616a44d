#include "server/visibility/light_outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/maths/stop_poll.h"
#include "lights/shapes/all_shapes.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

/// The convex hull of points in a plane of unit normal `n`, in order.  A rectangle around it if the
/// hull has too many corners.  [Andrew79]
std::vector<Vec3> hull(const std::vector<Vec3>& points, const Vec3& n) {
  const auto frame = Frame::around(n);
  struct Point {
    double x, y;
    std::size_t number;
  };
  std::vector<Point> sorted;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 v = frame.local_from_world(points[i] - points[0]);
    sorted.push_back({v.x, v.y, i});
  }
  std::ranges::sort(
      sorted, [](const Point& a, const Point& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<Point> chain;
  const auto turns_left = [](const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0;
  };
  // The lower chain from left to right, then the upper chain back.
  for (const bool is_upper : {false, true}) {
    const std::size_t begin = chain.size();
    for (const Point& p : sorted) {
      while (chain.size() >= begin + 2 && !turns_left(chain.end()[-2], chain.back(), p))
        chain.pop_back();
      chain.push_back(p);
    }
    chain.pop_back();
    if (!is_upper) std::ranges::reverse(sorted);
  }
  std::vector<Vec3> corners;
  if (chain.size() <= kOutlineCorners) {
    for (const Point& p : chain) corners.push_back(points[p.number]);
    return corners;
  }
  double low = chain[0].y, high = low;
  for (const Point& p : chain) low = std::min(low, p.y), high = std::max(high, p.y);
  const double left = sorted.back().x, right = sorted.front().x;
  for (const Vec2& c : {Vec2{left, low}, {right, low}, {right, high}, {left, high}})
    corners.push_back(points[0] + frame.s * c.x + frame.t * c.y);
  return corners;
}

template <typename Mesh>
LightOutline flat_mesh(const Mesh& mesh) {
  std::vector<Vec3> points;
  std::size_t largest = 0;
  StopPoll poll;
  for (std::size_t i = 0; i < mesh.size(); ++i, poll()) {
    const auto& p = mesh.primitive(i);
    if constexpr (requires { p.p11; })
      points.insert(points.end(), {p.p00, p.p10, p.p01, p.p11});
    else
      points.insert(points.end(), {p.a, p.b, p.c});
    if (mesh.share(i) > mesh.share(largest)) largest = i;
  }
  const auto& p = mesh.primitive(largest);
  LightOutline outline{LightOutline::Kind::kFlat};
  if constexpr (requires { p.p11; })
    outline.axis = p.normal({0.5, 0.5});
  else
    outline.axis = p.normal();
  outline.corners = hull(points, outline.axis);
  return outline;
}

LightOutline of_shape(const TriangleMesh& mesh) { return flat_mesh(mesh); }
LightOutline of_shape(const PatchMesh& mesh) { return flat_mesh(mesh); }
LightOutline of_shape(const Disk& disk) {
  const DiskParams& params = disk.params();
  const Transform& t = disk.world_from_object();
  LightOutline outline{LightOutline::Kind::kFlat};
  outline.axis = normalized(t.normal({0, 0, 1}));
  const auto corners =
      polygon_around(t.point({0, 0, params.height_m}), t.vector({params.radius_m, 0, 0}),
                     t.vector({0, params.radius_m, 0}));
  outline.corners.assign(corners.begin(), corners.end());
  return outline;
}
LightOutline of_shape(const Sphere& sphere) {
  const SphereParams& params = sphere.params();
  const Transform& t = sphere.world_from_object();
  LightOutline outline{LightOutline::Kind::kSphere};
  outline.center = t.point({0, 0, 0});
  outline.radius = params.radius_m * params.world_from_object.uniform_scale().value_or(0);
  return outline;
}
/// Shapes without a closed form.
LightOutline of_shape(const Shape&) { return {}; }
LightOutline of_light(const SunLight& l) {
  LightOutline outline{LightOutline::Kind::kSun};
  outline.axis = normalized(l.params().to_light);
  outline.half_angle_rad = l.params().angular_diameter_rad / 2;
  return outline;
}
LightOutline of_light(const PortalLight& l) {
  LightOutline outline{LightOutline::Kind::kPortal};
  const auto corners = l.corners_m();
  outline.corners.assign(corners.begin(), corners.end());
  outline.axis = l.to_sky();
  return outline;
}

LightOutline of_kind(const Light& light) {
  if (const auto* sun = dynamic_cast<const SunLight*>(&light)) return of_light(*sun);
  if (const auto* portal = dynamic_cast<const PortalLight*>(&light)) return of_light(*portal);
  if (const auto* area = dynamic_cast<const AreaLight*>(&light)) {
    LightOutline outline;
    visit_shape(area->shape(), [&](const auto& shape) { outline = of_shape(shape); });
    return outline;
  }
  if (dynamic_cast<const UniformInfiniteLight*>(&light)) return {LightOutline::Kind::kSky};
  return {};
}

}  // namespace

LightOutline outline_of(const SceneLight& light) {
  if (light.moving != nullptr || !light.light->has_irradiance()) return {};
  // A light without a closed form at one place has none at any place.
  Receiver anywhere(0x1p40, 0x1p41, 0x1p42);
  anywhere.normal = {0, 0, 1};
  if (light.light->hides_itself() || !light.light->irradiance(anywhere)) return {};
  return of_kind(*light.light);
}

std::array<Vec3, kOutlineCorners> polygon_around(const Vec3& center, const Vec3& x, const Vec3& y) {
  static const auto kUnit = [] {
    constexpr double kStep = 2 * std::numbers::pi / kOutlineCorners;
    const double outside = 1 / std::cos(kStep / 2);
    std::array<Vec2, kOutlineCorners> corners;
    for (int i = 0; i < kOutlineCorners; ++i)
      corners[i] = {outside * std::cos(i * kStep), outside * std::sin(i * kStep)};
    return corners;
  }();
  std::array<Vec3, kOutlineCorners> corners;
  for (int i = 0; i < kOutlineCorners; ++i) corners[i] = center + x * kUnit[i].x + y * kUnit[i].y;
  return corners;
}

}  // namespace lucerna
