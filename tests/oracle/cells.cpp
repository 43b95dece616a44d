#include "tests/oracle/cells.h"

#include <algorithm>

#include "tests/oracle/oracle_lights.h"
#include "tests/oracle/oracle_shapes.h"

namespace lucerna::oracle {
namespace {

using Kind = Emitter::Kind;

Vec around(const Emitter& e, Real angle) {
  // Extended functions of large angles are slow, so quarters of a turn are taken off first.
  const Real quarters = std::rint(4 * angle), rest = kPi / 2 * (4 * angle - quarters);
  const Real c = std::cos(rest), s = std::sin(rest);
  switch (static_cast<int>(quarters) & 3) {
    case 0:
      return e.u * c + e.v * s;
    case 1:
      return e.v * c - e.u * s;
    case 2:
      return -(e.u * c + e.v * s);
    default:
      return e.u * s - e.v * c;
  }
}

/// A direction from the centre of a sphere.
Vec on_sphere(const Emitter& e, Real s, Real t) {
  const Real sine = std::sqrt(std::max<Real>(0, s * (2 - s)));
  return e.w * (1 - s) + around(e, t) * sine;
}

/// Around the cap that holds the cell: squares in its tangent plane and in the plane of its rim.
Cell::Hull cap_hull(const Cell& c) {
  const Emitter& e = *c.emitter;
  const Vec m = on_sphere(e, (c.s0 + c.s1) / 2, (c.t0 + c.t1) / 2);
  Real angle = 0;
  for (const Real s : {c.s0, c.s1}) {
    for (const Real t : {c.t0, c.t1}) {
      const Vec w = on_sphere(e, s, t);
      angle = std::max<Real>(angle, std::atan2(length(cross(w, m)), dot(w, m)));
    }
  }
  angle = std::min<Real>(1.02L * angle, 1.5L);
  const Real r = e.surface->radius;
  const Vec x = across(m), y = cross(m, x);
  Cell::Hull h{{}, 8};
  for (std::size_t i = 0; i < 8; ++i) {
    const bool rim = i >= 4;
    const Real side = rim ? r * std::sin(angle) : r * std::tan(angle);
    h.points.at(i) = e.corner + m * (rim ? r * std::cos(angle) : r) +
                     x * ((i & 1) != 0 ? side : -side) + y * ((i & 2) != 0 ? side : -side);
  }
  return h;
}

/// A square at the distance of the sky around the cone of the cell's directions.
Cell::Hull cone_hull(const Cell& c) {
  const Emitter& e = *c.emitter;
  const auto direction = [&](Real s, Real t) { return unit(c.point(s, t) - e.eye); };
  const Real sm = (c.s0 + c.s1) / 2, tm = (c.t0 + c.t1) / 2;
  const Vec m = direction(sm, tm);
  Real angle = 0;
  for (const Real s : {c.s0, sm, c.s1}) {
    for (const Real t : {c.t0, tm, c.t1}) {
      const Vec w = direction(s, t);
      angle = std::max<Real>(angle, std::atan2(length(cross(w, m)), dot(w, m)));
    }
  }
  const Vec x = across(m) * (e.reach * std::tan(1.05L * angle)), y = cross(m, x);
  const Vec middle = e.eye + m * e.reach;
  return {{middle + x + y, middle + x - y, middle - x + y, middle - x - y}, 4};
}

}  // namespace

Vec Cell::point(Real s, Real t) const {
  const Emitter& e = *emitter;
  switch (e.kind) {
    case Kind::kFlat:
      return e.corner + e.u * s + e.v * t;
    case Kind::kTriangle:
      return e.corner + e.u * s + e.v * (t * (1 - s));
    case Kind::kDisk:
      return e.corner + around(e, t) * s;
    case Kind::kPatch:
      return point_of(*e.surface, s, t).at;
    case Kind::kSphere:
      return e.corner + on_sphere(e, s, t) * e.surface->radius;
    case Kind::kCylinder:
      return e.corner + around(e, s) + e.w * t;
    case Kind::kSky:
      return e.eye + (around(e, t) * s + e.w * std::sqrt(std::max<Real>(0, 1 - s * s))) * e.reach;
    case Kind::kMap: {
      const Vec d = direction_of(s, t);
      return e.eye + (e.u * d.x + e.v * d.y + e.w * d.z) * e.reach;
    }
  }
  return {};
}

Cell::Hull Cell::hull() const {
  const Emitter& e = *emitter;
  if (e.kind == Kind::kSky || e.kind == Kind::kMap) return cone_hull(*this);
  if (e.kind == Kind::kSphere) return cap_hull(*this);
  if (e.kind == Kind::kCylinder) {
    // The chord, and where the tangents at its ends meet.
    const Real wider = 1 / std::cos(kPi * (s1 - s0));
    const Vec middle = around(e, (s0 + s1) / 2) * wider;
    return {{point(s0, t0), point(s1, t0), point(s0, t1), point(s1, t1),
             e.corner + middle + e.w * t0, e.corner + middle + e.w * t1},
            6};
  }
  const Real wider = e.kind == Kind::kDisk ? 1 / std::cos(kPi * (t1 - t0)) : 1;
  Hull h{{point(s0, t0), point(s1 * wider, t0), point(s0, t1), point(s1 * wider, t1)}, 4};
  if (e.far) {
    for (Vec& p : h.points) p = e.eye + (p - e.eye) * (e.reach / length(p - e.eye));
  }
  return h;
}

Cell::Element Cell::element(Real s, Real t) const {
  const Emitter& e = *emitter;
  switch (e.kind) {
    case Kind::kSky:
      return {point(s, t), {}, 2 * kPi * s / std::sqrt(1 - s * s)};
    case Kind::kMap:
      return {point(s, t), {}, 4 * kPi};
    case Kind::kFlat:
      return {point(s, t), cross(e.u, e.v)};
    case Kind::kTriangle:
      return {point(s, t), cross(e.u, e.v) * (1 - s)};
    case Kind::kDisk:
      return {point(s, t), cross(e.u, e.v) * (2 * kPi * s)};
    case Kind::kPatch: {
      const auto& [a, b, c, d] = e.surface->at;
      return {point(s, t), cross((b - a) * (1 - t) + (d - c) * t, (c - a) * (1 - s) + (d - b) * s)};
    }
    case Kind::kSphere: {
      const Real radius = e.surface->radius;
      const Vec out = on_sphere(e, s, t);
      return {e.corner + out * radius, out * (2 * kPi * radius * radius)};
    }
    case Kind::kCylinder: {
      const Vec out = around(e, s);
      return {e.corner + out + e.w * t, out * (2 * kPi * length(e.w))};
    }
  }
  return {};
}

Real Cell::solid_angle(const Element& element, const Vec& d) const {
  if (element.angle > 0) return element.angle;
  const Real squared = dot(d, d);
  if (!(squared > 0)) return 0;
  Real leaving = -dot(d, element.area);
  if (emitter->two_sided) leaving = std::fabs(leaving);
  return std::max(Real{0}, leaving) / (squared * std::sqrt(squared));
}

bool Cell::faces_away() const {
  const Kind kind = emitter->kind;
  if (emitter->two_sided || kind == Kind::kSky || kind == Kind::kMap || kind == Kind::kCylinder ||
      kind == Kind::kSphere)
    return false;
  // The triple product that decides is linear in s and in t.
  const Real sm = kind == Kind::kPatch ? s1 : (s0 + s1) / 2;
  const auto dark = [&](Real s, Real t) {
    const Element e = element(s, t);
    return !(solid_angle(e, e.at - emitter->eye) > 0);
  };
  return dark(sm, t0) && dark(sm, t1) && (kind != Kind::kPatch || (dark(s0, t0) && dark(s0, t1)));
}

std::vector<Cell> cells_of(const Emitter& emitter, Real radiance, const Texels& picture) {
  std::vector<Cell> cells;
  const auto add = [&](int across_s, int across_t, Real s0, Real s1) {
    for (int j = 0; j < across_t; ++j) {
      for (int i = 0; i < across_s; ++i) {
        Cell c{&emitter,
               radiance,
               s0 + (s1 - s0) * i / across_s,
               s0 + (s1 - s0) * (i + 1) / across_s,
               static_cast<Real>(j) / across_t,
               static_cast<Real>(j + 1) / across_t};
        if (!picture.empty())
          c.radiance *= picture.at(i * picture.width / across_s, j * picture.height / across_t);
        if (c.radiance > 0) cells.push_back(c);
      }
    }
  };
  switch (emitter.kind) {
    case Kind::kDisk:
      add(1, 8, 0, 1);
      break;
    case Kind::kSky:
      add(4, 8, 0, 1);
      break;
    case Kind::kMap: {
      // The axes of the map divide the texels of odd numbers.
      const int texels = picture.empty() ? 1 : picture.width;
      int across = texels;
      while (across < 8 || across % 2 != 0) across += texels;
      add(across, across, 0, 1);
      break;
    }
    case Kind::kSphere: {
      // From outside the cap within the tangents is seen, from inside everything.
      const Real ratio = emitter.surface->radius / length(emitter.eye - emitter.corner);
      add(1, 8, 0, ratio < 1 ? 1 - ratio : 1);
      if (ratio >= 1) add(1, 8, 1, 2);
      break;
    }
    case Kind::kCylinder: {
      // The outer side is seen over a part of the turn, the inner side over the rest.
      const Real distance = length(cross(emitter.eye - emitter.corner, unit(emitter.w)));
      const Real ratio = length(emitter.u) / distance;
      const Real seen = ratio < 1 ? std::acos(ratio) / (2 * kPi) : 0;
      if (seen > 0) add(8, 1, -seen, seen);
      if (emitter.two_sided) add(8, 1, seen, 1 - seen);
      break;
    }
    default:
      if (picture.empty())
        add(1, 1, 0, 1);
      else
        add(picture.width, picture.height, 0, 1);
  }
  return cells;
}

}  // namespace lucerna::oracle
