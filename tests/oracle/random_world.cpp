#include <algorithm>
#include <numbers>

#include "tests/oracle/world.h"

namespace lucerna::oracle {
namespace {

/// SplitMix64 [Steele14].
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed) { state_ = next() ^ seed << 32; }
  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double a, double b) { return a + (b - a) * uniform(); }
  /// 10^x, with x uniform.
  double power(double a, double b) { return std::pow(10.0, between(a, b)); }
  bool chance(double p) { return uniform() < p; }
  int below(int n) { return static_cast<int>(uniform() * n); }
  Vec direction() {
    const double z = between(-1, 1), angle = 2 * std::numbers::pi * uniform();
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

Vec doubles(const Vec& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
Vec floats(const Vec& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Makes one scene.  Everything stands on or over a ground about the origin, whose size may be
/// anything.
class Maker {
 public:
  explicit Maker(std::uint64_t number) : random_(number) {}

  World make() {
    scale_ = random_.power(-6, 6);
    if (random_.chance(0.25)) {
      axis_ = random_.direction();
    }
    across_ = across(axis_);
    along_ = cross(axis_, across_);
    if (random_.chance(0.8)) add_ground();
    const int shapes = 1 + random_.below(4);
    for (int i = 0; i < shapes; ++i) add_shape();
    const int lights = 1 + random_.below(2);
    for (int i = 0; i < lights; ++i) add_light();
    for (int i = 0; i < 4; ++i) world_.receivers.push_back(place(true));
    for (int i = 0; i < 8; ++i) world_.segments.push_back(segment());
    return world_;
  }

 private:
  Vec over(double x, double y, double z) const {
    return doubles((across_ * x + along_ * y + axis_ * z) * scale_);
  }

  void add_ground() {
    // The corners of a tilted ground, and the middle of a triangle, are rounded by their distance.
    const bool upright = axis_.z == 1;
    constexpr double kMostDecades = 9;
    const bool triangle = !upright || random_.chance(0.3);
    const Real half = random_.power(0, upright && !triangle ? kMostDecades : 2) * 1.5L;
    Shape ground;
    ground.kind = triangle ? ShapeKind::kTriangle : ShapeKind::kParallelogram;
    const Real reach = triangle ? 3 : 1;
    ground.at = {doubles((across_ + along_) * (-half * scale_)),
                 doubles((across_ * (2 * reach - 1) - along_) * (half * scale_)),
                 doubles((along_ * (2 * reach - 1) - across_) * (half * scale_))};
    ground_ = static_cast<int>(world_.shapes.size());
    world_.shapes.push_back(ground);
  }

  void add_shape() {
    Shape shape;
    shape.kind = static_cast<ShapeKind>(random_.below(kShapeKinds));
    const double size = random_.power(-2, 0);
    // Some hang a hair over the ground.
    const bool low = random_.chance(0.25);
    const double height = low ? size * random_.power(-4, -1) : size + random_.between(0.01, 1);
    const double x = random_.between(-1, 1), y = random_.between(-1, 1);
    Vec u = across_, v = along_;
    if (!low) {
      const Vec w = random_.direction();
      u = across(w);
      v = cross(w, u);
    }
    const Real slim = random_.chance(0.2) ? random_.power(-3, 0) : 1;
    switch (shape.kind) {
      case ShapeKind::kTriangle:
      case ShapeKind::kParallelogram: {
        if (random_.chance(0.5)) std::swap(u, v);  // the other side
        const Vec corner = over(x, y, height);
        shape.at = {
            corner, doubles(corner + u * (size * scale_)),
            doubles(corner + (v * slim + u * random_.between(-0.5, 0.5)) * (size * scale_))};
        break;
      }
      case ShapeKind::kDisk: {
        shape.at[0] = over(x, y, height);
        const Vec n = cross(u, v) * (random_.chance(0.5) ? 1 : -1);
        shape.at[1] = shape.at[0] + n;
        shape.radius = static_cast<double>(size * scale_);
        break;
      }
      case ShapeKind::kSphere:
        shape.at[0] = over(x, y, low ? height + size : height);
        shape.radius = static_cast<double>(size * scale_);
        break;
    }
    if (random_.chance(0.3)) {
      shape.radiance = random_.power(-2, 2);
      shape.two_sided = random_.chance(0.3);
    }
    world_.shapes.push_back(shape);
  }

  void add_light() {
    Light light;
    light.kind = static_cast<LightKind>(random_.below(kLightKinds));
    light.level = random_.power(-2, 2);
    if (light.kind == LightKind::kPoint) {
      light.at = over(random_.between(-1, 1), random_.between(-1, 1), random_.power(-2, 0.5));
      light.level = static_cast<double>(light.level * scale_ * scale_);
    } else {
      Vec d = random_.direction();
      if (dot(d, axis_) < 0) d = -d;
      light.at = doubles(d);
    }
    world_.lights.push_back(light);
  }

  /// A point of the shape, and its normal.
  std::pair<Vec, Vec> point_on(const Shape& shape) {
    const auto& [a, b, c] = shape.at;
    double s = random_.uniform(), t = random_.uniform();
    switch (shape.kind) {
      case ShapeKind::kTriangle:
        if (s + t > 1) s = 1 - s, t = 1 - t;
        [[fallthrough]];
      case ShapeKind::kParallelogram:
        return {a + (b - a) * s + (c - a) * t, unit(cross(b - a, c - a))};
      case ShapeKind::kDisk: {
        const Vec n = unit(b - a);
        const Vec u = across(n);
        const double angle = 2 * std::numbers::pi * t;
        return {a + (u * std::cos(angle) + cross(n, u) * std::sin(angle)) *
                        (shape.radius * std::sqrt(s)),
                n};
      }
      case ShapeKind::kSphere: {
        const Vec n = random_.direction();
        return {a + n * shape.radius, n};
      }
    }
    return {};
  }

  Place place(bool with_normal) {
    Place p;
    const bool on_ground = ground_ >= 0 && random_.chance(0.5);
    if (on_ground) {
      // Near what stands there, in the plane's own coordinates.
      p.at = over(random_.between(-1.5, 1.5), random_.between(-1.5, 1.5), 0);
      p.on = ground_;
      p.normal = floats(axis_);
    } else if (const int number = random_.below(static_cast<int>(world_.shapes.size()));
               random_.chance(0.5) &&
               world_.shapes[static_cast<std::size_t>(number)].radiance == 0) {
      const Shape& shape = world_.shapes[static_cast<std::size_t>(number)];
      const auto [at, n] =
          number == ground_ ? std::pair{over(0.3, 0.4, 0), axis_} : point_on(shape);
      p.at = doubles(at);
      p.normal = floats(random_.chance(0.5) ? n : -n);
      p.on = number;
    } else {
      p.at = over(random_.between(-1, 1), random_.between(-1, 1), random_.power(-2, 0.5));
      p.normal = floats(random_.direction());
    }
    if (!with_normal) p.normal = {};
    return p;
  }

  /// Not within one flat surface.
  World::Segment segment() {
    World::Segment s{place(random_.chance(0.5)), place(false)};
    while (s.from.on >= 0 && s.to.on == s.from.on) s.to = place(false);
    return s;
  }

  Numbers random_;
  World world_;
  Real scale_ = 1;
  Vec axis_{0, 0, 1}, across_, along_;
  int ground_ = -1;
};

}  // namespace

World random_world(std::uint64_t number) { return Maker(number).make(); }

}  // namespace lucerna::oracle
