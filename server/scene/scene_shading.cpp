// Surface coordinates at hits, for textures.
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using Vector = Vec3<double>;

/// (u, v), and the direction of growing u in the space of the GeometrySet.
struct Coordinates {
  Vec2<double> uv;
  Vector dpdu;
};

Coordinates on_triangle(const GeometrySet& set, const SurfaceTable& table, const SurfaceHit& hit) {
  const auto& uv = table.triangle_uv.empty() ? kTriangleUv : table.triangle_uv[hit.primitive];
  const std::uint32_t* v = &set.triangles[3 * std::size_t{hit.primitive}];
  const Vector a(set.vertices[v[0]]), ab = Vector(set.vertices[v[1]]) - a,
                                      ac = Vector(set.vertices[v[2]]) - a;
  const double b = hit.uv.x, c = hit.uv.y, ub = double{uv[1].x} - uv[0].x,
               uc = double{uv[2].x} - uv[0].x, vb = double{uv[1].y} - uv[0].y,
               vc = double{uv[2].y} - uv[0].y;
  // Where (u, v) do not span the triangle, there is no direction of u.
  const double determinant = ub * vc - uc * vb;
  const Vector dpdu = determinant != 0 ? (ab * vc - ac * vb) * (1 / determinant) : Vector{};
  return {table.triangle_uv_at(hit.primitive, b, c), dpdu};
}

Coordinates on_patch(const GeometrySet& set, const SurfaceTable& table, const SurfaceHit& hit) {
  const auto& uv = table.patch_uv.empty() ? kPatchUv : table.patch_uv[hit.primitive];
  const BilinearPatch<double>& p = set.patches[hit.primitive];
  const double s = hit.uv.x, t = hit.uv.y;
  const Vector dpds = (p.p10 - p.p00) * (1 - t) + (p.p11 - p.p01) * t,
               dpdt = (p.p01 - p.p00) * (1 - s) + (p.p11 - p.p10) * s;
  const auto along_s = [&](auto member) {
    return (double{uv[1].*member} - uv[0].*member) * (1 - t) +
           (double{uv[3].*member} - uv[2].*member) * t;
  };
  const auto along_t = [&](auto member) {
    return (double{uv[2].*member} - uv[0].*member) * (1 - s) +
           (double{uv[3].*member} - uv[1].*member) * s;
  };
  constexpr auto kU = &Vec2<float>::x, kV = &Vec2<float>::y;
  const double us = along_s(kU), ut = along_t(kU), vs = along_s(kV), vt = along_t(kV);
  const double determinant = us * vt - ut * vs;
  const Vector dpdu = determinant != 0 ? (dpds * vt - dpdt * vs) * (1 / determinant) : Vector{};
  return {table.patch_uv_at(hit.primitive, s, t), dpdu};
}

/// `position`: in the space of the set.
template <typename Quadric>
Coordinates on_quadric(const Quadric& quadric, const Vector& position) {
  // u turns about the z axis of the quadric's own space.
  const Vector q = quadric.world_from_object().inverse().point(position);
  return {quadric.uv(position), quadric.world_from_object().vector({-q.y, q.x, 0})};
}

}  // namespace

Scene::ShadingPoint Scene::shading_point(const SurfaceHit& hit) const {
  const auto number = static_cast<std::int32_t>(hit.shape >> 32) - 1;
  const GeometryInstance* instance = number >= 0 ? &accelerator_->instance(number) : nullptr;
  const GeometrySet& set =
      instance != nullptr ? accelerator_->object(instance->object) : accelerator_->scene();
  const SurfaceTable& table = instance != nullptr ? object_surfaces_[instance->object] : surfaces_;
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
      Vector position = hit.position;
      if (instance != nullptr) {
        if (instance->motion) position = pose().inverse_point(position);
        position = instance->scene_from_object.inverse().point(position);
      }
      c = set.visit_surface(hit.kind, hit.primitive, [&](const auto& surface) -> Coordinates {
        if constexpr (QuadricShape<std::decay_t<decltype(surface)>>)
          return on_quadric(surface, position);
        else
          return {};
      });
    }
  }
  if (instance != nullptr) {
    c.dpdu = instance->scene_from_object.vector(c.dpdu);
    if (instance->motion) c.dpdu = pose().vector(c.dpdu);
  }
  return {{c.uv, hit.position + origin_, Vector(hit.ns)}, c.dpdu};
}

}  // namespace lucerna
