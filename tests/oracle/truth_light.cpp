// Direct light by adaptive quadrature over emitters.
#include <algorithm>

#include "tests/oracle/oracle_lights.h"
#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/oracle_truth.h"
#include "tests/oracle/quadrature.h"

namespace lucerna::oracle {
Amount Truth::from_light(const Light& light, const Place& at) const {
  const Real reach = Truth::reach(at.at);
  const Arrival a = *arrival(light, at.at, reach);
  const Vec d = a.end.at - at.at;
  const Real distance = length(d);
  if (!(distance > 0)) return {0, 0, false};
  const Real cosine = dot(unit(at.normal), d) / distance;
  const Real slant = (a.end.far ? 0 : length(rounding(at.at)) / distance) + 0x1p-22L;
  if (std::fabs(cosine) <= 64 * slant) return {0, 0, false};
  if (cosine < 0) return {};
  // What changes if the point is a little off.
  Real change = 0;
  const Vec w = d * (1 / distance), u = across(w);
  for (const Vec& side : {u, cross(w, u)}) {
    for (const Real sign : {-1, 1}) {
      const Vec moved = at.at + side * (sign * distance * slant);
      change = std::fmax(change, std::fabs(arrival(light, moved, reach)->facing - a.facing));
    }
  }
  if (a.facing == 0) return {0, 0, change == 0};
  const Way w_free = way(at, a.end);
  if (w_free == Way::kUnsure) return {0, 0, false};
  if (w_free == Way::kBlocked) return {};
  const Real value = a.facing * cosine;
  return {value, value * (4 * slant / cosine + 4 * slant) + change * cosine, true};
}

Amount Truth::from_sky(const Light& light, const Place& at) const {
  Emitter e{.eye = at.at, .far = true, .reach = reach(at.at)};
  Real radiance = light.level;
  switch (light.kind) {
    case LightKind::kSun: {
      const Real sine = std::sin(light.angle / 2);
      radiance = light.level / (kPi * sine * sine);
      const Vec& w = light.axes[2];
      const Vec u = across(w) * (e.reach * std::tan(light.angle / 2));
      e.kind = Emitter::Kind::kDisk;
      e.corner = at.at + w * e.reach;
      e.u = u;
      e.v = -cross(w, u);
      break;
    }
    case LightKind::kPortal:
      e.kind = Emitter::Kind::kFlat;
      e.corner = light.at;
      e.u = light.axes[0] * light.extent[0];
      e.v = light.axes[1] * light.extent[1];
      break;
    default:
      e.kind = light.picture.empty() ? Emitter::Kind::kSky : Emitter::Kind::kMap;
      e.w = light.picture.empty() ? unit(at.normal) : light.axes[2];
      e.u = light.picture.empty() ? across(e.w) : light.axes[0];
      e.v = light.picture.empty() ? cross(e.w, e.u) : light.axes[1];
  }
  if (light.kind == LightKind::kPortal) {
    // In the portal's plane the light has an edge.
    const Real off = dot(at.at - e.corner, light.axes[2]);
    if (std::fabs(off) <= 4 * length(rounding(at.at) + rounding(e.corner))) return {0, 0, false};
  }
  const Texels none;
  const Integral integral{at, unit(at.normal)};
  return Quadrature(*this, integral, e)
      .run(radiance, e.kind == Emitter::Kind::kMap ? light.picture : none);
}

}  // namespace lucerna::oracle
