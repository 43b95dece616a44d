// Surface coordinates at hits, for textures.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "server/scene/scene_geometry.h"

namespace lucerna {
namespace {

/// (u, v), and how the point moves as they grow, in the space of the GeometrySet.
struct Coordinates {
  Vec2 uv;
  Vec3 dpdu, dpdv;
  Rgb colour{};
};

/// The value at barycentric coordinates (b, c); nothing if the mesh has no values.
template <typename Value, typename Of>
auto at_vertices(const std::vector<Value>& values, const std::uint32_t* v, double b, double c,
                 const Of& of) -> std::optional<decltype(of(values[0]))> {
  if (std::max({v[0], v[1], v[2]}) >= values.size()) return std::nullopt;
  return of(values[v[0]]) * (1 - b - c) + of(values[v[1]]) * b + of(values[v[2]]) * c;
}

Coordinates on_triangle(const GeometrySet& set, const SurfaceTable& table, const SurfaceHit& hit) {
  const auto& uv = table.uv_of_triangle(hit.primitive);
  const std::uint32_t* v = &set.triangles[3 * std::size_t{hit.primitive}];
  const auto vertex = [&](int k) { return Vec3(set.vertices[v[k]]) * set.unit_m; };
  const Vec3 ab = vertex(1) - vertex(0), ac = vertex(2) - vertex(0);
  const double b = hit.uv.x, c = hit.uv.y, ub = double{uv[1].x} - uv[0].x,
               uc = double{uv[2].x} - uv[0].x, vb = double{uv[1].y} - uv[0].y,
               vc = double{uv[2].y} - uv[0].y;
  // Where (u, v) do not span the triangle, they have no directions.
  const double determinant = ub * vc - uc * vb, scale = determinant != 0 ? 1 / determinant : 0;
  Coordinates r{table.triangle_uv_at(hit.primitive, b, c), (ab * vc - ac * vb) * scale,
                (ac * ub - ab * uc) * scale};
  if (const auto colour =
          at_vertices(table.vertex_colours, v, b, c, [](const Rgbf& x) { return Rgb(x); }))
    r.colour = *colour;
  const auto along = [](const VertexTangent& t) { return Vec3(t.along_u); };
  if (const auto u = at_vertices(table.vertex_tangents, v, b, c, along); u && *u != Vec3{}) {
    // The normal of the corners tells the outside, also where a mirror turned it.
    const Vec3 outside = cross(ab, ac);
    r.dpdu = *u;
    r.dpdv = cross(outside, *u) * table.vertex_tangents[v[0]].turn;
  }
  return r;
}

Coordinates on_patch(const GeometrySet& set, const SurfaceTable& table, const SurfaceHit& hit) {
  const auto& uv = table.uv_of_patch(hit.primitive);
  const BilinearPatch& p = set.patches[hit.primitive];
  const double s = hit.uv.x, t = hit.uv.y;
  const Vec3 dpds = (p.p10 - p.p00) * (1 - t) + (p.p11 - p.p01) * t,
             dpdt = (p.p01 - p.p00) * (1 - s) + (p.p11 - p.p10) * s;
  const auto along_s = [&](auto member) {
    return (double{uv[1].*member} - uv[0].*member) * (1 - t) +
           (double{uv[3].*member} - uv[2].*member) * t;
  };
  const auto along_t = [&](auto member) {
    return (double{uv[2].*member} - uv[0].*member) * (1 - s) +
           (double{uv[3].*member} - uv[1].*member) * s;
  };
  constexpr auto kU = &Vec2f::x, kV = &Vec2f::y;
  const double us = along_s(kU), ut = along_t(kU), vs = along_s(kV), vt = along_t(kV);
  const double determinant = us * vt - ut * vs, scale = determinant != 0 ? 1 / determinant : 0;
  return {table.patch_uv_at(hit.primitive, s, t), (dpds * vt - dpdt * vs) * scale,
          (dpdt * us - dpds * ut) * scale};
}

/// `position`: in the space of the set.
template <typename Quadric>
Coordinates on_quadric(const Quadric& quadric, const Vec3& position, const Vec3& normal) {
  // u turns about the z axis of the quadric's own space.
  const Transform& to_set = quadric.world_from_object();
  const Vec3 q = to_set.inverse().point(position);
  const Vec3 turn = to_set.vector({-q.y, q.x, 0});
  Coordinates c{quadric.uv({position}), turn, {}};
  // (u, v) of near points give their derivatives along the surface.
  const Vec3 along = normalized(turn);
  if (!is_finite(along)) return c;
  const Vec3 across = normalized(cross(normal, along));
  const double step = 1e-4 * length(turn);
  const auto change = [&](const Vec3& w) {
    const Vec2 a = quadric.uv({position - w * step}), b = quadric.uv({position + w * step});
    const auto per_m = [&](double x) { return (x - std::round(x)) / (2 * step); };  // past the seam
    return Vec2{per_m(b.x - a.x), per_m(b.y - a.y)};
  };
  const Vec2 s = change(along), t = change(across);
  const double determinant = s.x * t.y - t.x * s.y;
  if (!(determinant != 0)) return c;
  c.dpdu = (along * t.y - across * s.y) * (1 / determinant);
  c.dpdv = (across * s.x - along * t.x) * (1 / determinant);
  return c;
}

}  // namespace

SceneGeometry::ShadingPoint SceneGeometry::shading_point(const SurfaceHit& hit) const {
  const auto number = static_cast<std::int32_t>(hit.shape >> 32) - 1;
  const auto& [instance, set, table] = primitives_of(number);
  Coordinates c;
  const auto pose = [&] { return instance->motion->at(hit.time_s); };
  switch (hit.kind) {
    case HitKind::kTriangle:
      c = on_triangle(set, table, hit);
      break;
    case HitKind::kPatch:
      c = on_patch(set, table, hit);
      break;
    default: {
      Vec3 position = hit.position, normal = hit.ng;
      if (instance != nullptr) {
        if (instance->motion) {
          position = pose().inverse_point(position);
          normal = pose().inverse_vector(normal);
        }
        const Transform to_object = instance->scene_from_object.inverse();
        position = to_object.point(position);
        normal = to_object.normal(normal);
      }
      c = set.visit_surface(hit.kind, hit.primitive, [&](const auto& surface) -> Coordinates {
        if constexpr (QuadricShape<std::decay_t<decltype(surface)>>)
          return on_quadric(surface, position, normal);
        else
          return {};
      });
    }
  }
  if (instance != nullptr) {
    for (Vec3* const v : {&c.dpdu, &c.dpdv}) {
      *v = instance->scene_from_object.vector(*v);
      if (instance->motion) *v = pose().vector(*v);
    }
  }
  return {{c.uv, hit.position + origin(), hit.ns, c.colour}, c.dpdu, c.dpdv};
}

}  // namespace lucerna
