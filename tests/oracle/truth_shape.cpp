// Direct light from surfaces, and their solid angles.
#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/oracle_truth.h"
#include "tests/oracle/quadrature.h"

namespace lucerna::oracle {
namespace {

const Texels kNone;

Emitter emitter_of(const Shape& shape, int number, const Vec& eye) {
  const auto& [a, b, c, d] = shape.at;
  Emitter e{.shape = number,
            .eye = eye,
            .corner = a,
            .u = b - a,
            .v = c - a,
            .surface = &shape,
            .two_sided = shape.two_sided};
  switch (shape.kind) {
    case ShapeKind::kTriangle:
      e.kind = Emitter::Kind::kTriangle;
      break;
    case ShapeKind::kPatch:
      e.kind = Emitter::Kind::kPatch;
      break;
    case ShapeKind::kDisk: {
      e.kind = Emitter::Kind::kDisk;
      const Vec n = normal_of(shape);
      e.u = across(n) * shape.radius;
      e.v = cross(n, e.u);
      break;
    }
    case ShapeKind::kCylinder: {
      e.kind = Emitter::Kind::kCylinder;
      const Vec& w = b;
      const Vec outwards = eye - a - w * dot(eye - a, w);
      const Vec u = length(outwards) > 0 ? unit(outwards) : across(w);
      e.corner = a - w * shape.half_height;
      e.w = w * (2 * shape.half_height);
      e.u = u * shape.radius;
      e.v = cross(w, e.u);
      break;
    }
    case ShapeKind::kSphere: {
      e.kind = Emitter::Kind::kSphere;
      e.w = length(eye - a) > 0 ? unit(eye - a) : Vec{0, 0, 1};
      e.u = across(e.w);
      e.v = cross(e.w, e.u);
      break;
    }
    default:
      break;
  }
  return e;
}

}  // namespace

Amount Truth::from_shape(int number, const Integral& integral) const {
  const Place& at = integral.at;
  const Shape& shape = world_.shapes[static_cast<std::size_t>(number)];
  if (at.on == number) return {0, 0, !is_curved(shape)};
  if (is_flat(shape)) {
    const Vec n = normal_of(shape);
    const Real plane = dot(absolute(n), rounding(shape) + rounding(at.at));
    if (std::fabs(dot(at.at - shape.at[0], n)) <= 4 * plane) return {0, 0, false};
  } else if (shape.kind == ShapeKind::kSphere) {
    const Real error = length(rounding(shape)) + length(rounding(at.at));
    const Real off = length(at.at - shape.at[0]) - shape.radius;
    if (std::fabs(off) <= 4 * error) return {0, 0, false};
    if (off < 0 && !shape.two_sided) return {};
  }
  const Emitter e = emitter_of(shape, number, at.at);
  const bool bare = integral.is_solid_angle();
  Amount sum =
      Quadrature(*this, integral, e).run(bare ? 1 : shape.radiance, bare ? kNone : shape.picture);
  sum.bound += 1e-6L * sum.value;
  return sum;
}

Amount Truth::illuminance(int source, const Place& at) const {
  const int lights = static_cast<int>(world_.lights.size());
  if (source < lights) {
    const Light& light = world_.lights[static_cast<std::size_t>(source)];
    const bool wide = light.kind == LightKind::kSun || light.kind == LightKind::kSky ||
                      light.kind == LightKind::kPortal;
    return wide ? from_sky(light, at) : from_light(light, at);
  }
  const int shape = emitting_shapes(world_)[static_cast<std::size_t>(source - lights)];
  return from_shape(shape, {at, unit(at.normal)});
}

Amount Truth::illuminance(const Place& at) const {
  Amount sum;
  const std::size_t sources = world_.lights.size() + emitting_shapes(world_).size();
  for (std::size_t i = 0; i < sources; ++i) sum += illuminance(static_cast<int>(i), at);
  return sum;
}

Amount Truth::solid_angle(int shape, const Place& at) const { return from_shape(shape, {at, {}}); }

}  // namespace lucerna::oracle
