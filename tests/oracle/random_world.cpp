#include <algorithm>

#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/random_lights.h"

namespace lucerna::oracle {
namespace {

/// Makes one scene.  Everything stands on or over a ground, whose size may be anything.
class Maker {
 public:
  explicit Maker(std::uint64_t number) : random_(number) {}

  World make() {
    stage_.scale = random_.power(-9, 9);
    if (random_.chance(0.25)) stage_.axis = random_.direction();
    stage_.across = across(stage_.axis);
    stage_.along = cross(stage_.axis, stage_.across);
    if (random_.chance(0.2)) stage_.origin = far_away();
    const bool moving = random_.chance(0.2);
    if (moving) world_.time = random_.below(9) / 8.0;
    if (random_.chance(0.7)) add_ground();
    const int shapes = 1 + random_.below(4);
    for (int i = 0; i < shapes; ++i) add_shape(moving);
    const int lights = 1 + random_.below(2);
    for (int i = 0; i < lights; ++i) {
      world_.lights.push_back(random_light(random_, stage_));
      if (moving && random_.chance(0.3)) world_.lights.back().moves = motion();
    }
    for (int i = 0; i < 4; ++i) world_.receivers.push_back(place(true));
    for (int i = 0; i < 8; ++i) world_.segments.push_back(segment());
    return world_;
  }

 private:
  Vec far_away() { return doubles(random_.direction() * (stage_.scale * random_.power(0, 6))); }
  Vec motion() { return doubles(random_.direction() * (stage_.scale * random_.power(-3, 0))); }

  void add_ground() {
    // The corners of a tilted ground, and the middle of a triangle, are rounded by their distance.
    const bool upright = stage_.axis.z == 1;
    constexpr double kMostDecades = 9;
    const bool triangle = !upright || random_.chance(0.3);
    const double half = random_.power(0, upright && !triangle ? kMostDecades : 2) * 1.5;
    Shape ground;
    ground.kind = triangle ? ShapeKind::kTriangle : ShapeKind::kParallelogram;
    const double far = half * (triangle ? 5 : 1);
    ground.at = {stage_.over(-half, -half, 0), stage_.over(far, -half, 0),
                 stage_.over(-half, far, 0)};
    ground_ = static_cast<int>(world_.shapes.size());
    world_.shapes.push_back(ground);
    is_sliver_.push_back(false);
  }

  void add_shape(bool moving) {
    Shape shape;
    shape.kind = static_cast<ShapeKind>(random_.below(static_cast<int>(kShapeNames.size())));
    const bool sliver = shape.kind <= ShapeKind::kPatch && random_.chance(0.12);
    const double size = sliver ? random_.power(-0.5, 0.5) : random_.power(-2, 0);
    // Some hang a hair over the ground, some lie in it.
    const bool low = random_.chance(0.25);
    const double height = random_.chance(0.03) ? 0
                          : low                ? size * random_.power(-4, -1)
                                               : size + random_.between(0.01, 1);
    const double x = random_.between(-1, 1), y = random_.between(-1, 1);
    Vec u = stage_.across, v = stage_.along;
    if (!low) {
      const Vec w = random_.direction();
      u = across(w);
      v = cross(w, u);
    }
    const Real wide = size * stage_.scale;
    const Real slim = sliver                ? random_.power(-3, -1.7)
                      : random_.chance(0.2) ? random_.power(-3, 0)
                                            : 1;
    const Vec middle = stage_.over(x, y, height);
    shape.at[0] = middle;
    switch (shape.kind) {
      case ShapeKind::kTriangle:
      case ShapeKind::kParallelogram:
      case ShapeKind::kPatch: {
        if (random_.chance(0.5)) std::swap(u, v);  // the other side
        const Vec side = v * slim + u * random_.between(-0.5, 0.5);
        shape.at[1] = doubles(middle + u * wide);
        shape.at[2] = doubles(middle + side * wide);
        const Vec bend = u * random_.between(-0.5, 0.5) + v * random_.between(-0.5, 0.5) +
                         cross(u, v) * random_.between(-1, 1);
        if (shape.kind == ShapeKind::kPatch)
          shape.at[3] = doubles(middle + (u + side + bend * slim) * wide);
        break;
      }
      case ShapeKind::kDisk:
      case ShapeKind::kCylinder:
        shape.at[1] = doubles(cross(u, v) * (random_.chance(0.5) ? 1 : -1));
        shape.radius = static_cast<double>(wide);
        shape.half_height = static_cast<double>(wide * random_.power(-2, 0.5));
        if (low && shape.kind == ShapeKind::kCylinder)
          shape.at[0] =
              stage_.over(x, y, height + static_cast<double>(shape.half_height / stage_.scale));
        break;
      case ShapeKind::kSphere:
        if (low) shape.at[0] = stage_.over(x, y, height + size);
        shape.radius = static_cast<double>(wide);
        break;
    }
    if (random_.chance(0.3)) {
      shape.radiance = random_.power(-2, 2);
      shape.two_sided = random_.chance(0.3);
      if (shape.kind == ShapeKind::kParallelogram && random_.chance(0.5))
        shape.picture = random_texels(random_, 1 + random_.below(4), 1 + random_.below(4));
    }
    if (moving && random_.chance(0.5)) shape.moves = motion();
    world_.shapes.push_back(shape);
    is_sliver_.push_back(sliver);
  }

  Place place(bool with_normal) {
    Place p;
    const int number = random_.below(static_cast<int>(world_.shapes.size()));
    const Shape shape = at_time(world_.shapes[static_cast<std::size_t>(number)], world_.time);
    if (ground_ >= 0 && random_.chance(0.5)) {
      // Near what stands there, in the plane's own coordinates.
      p.at = stage_.over(random_.between(-1.5, 1.5), random_.between(-1.5, 1.5), 0);
      p.on = ground_;
      p.normal = floats(stage_.axis);
    } else if (random_.chance(0.5) && shape.radiance == 0 && number != ground_ &&
               !is_sliver_[static_cast<std::size_t>(number)]) {
      p.s = random_.uniform(), p.t = random_.uniform();
      const auto [at, n] = point_of(shape, p.s, p.t);
      const bool front = random_.chance(0.5);
      p.normal = floats(front ? n : -n);
      // Some are beside the surface.
      const bool on = random_.chance(0.85);
      if (on) p.on = number;
      const Real off = on ? 0 : stage_.scale * random_.power(-4, -1);
      p.at = doubles(at + (front ? n : -n) * off);
    } else {
      p.at = stage_.over(random_.between(-1, 1), random_.between(-1, 1), random_.power(-2, 0.5));
      p.normal = floats(random_.direction());
      if (const Shape* emitter = an_emitter();
          emitter != nullptr && number != ground_ && random_.chance(0.3))
        put_behind(shape, *emitter, p);
    }
    if (!with_normal) p.normal = {};
    p.asked = true;
    return p;
  }

  const Shape* an_emitter() {
    const std::vector<int> emitters = emitting_shapes(world_);
    if (emitters.empty()) return nullptr;
    const int number =
        emitters[static_cast<std::size_t>(random_.below(static_cast<int>(emitters.size())))];
    return &world_.shapes[static_cast<std::size_t>(number)];
  }

  /// Moves the place to where the shape hides a point of the emitter.
  void put_behind(const Shape& shape, const Shape& emitter, Place& p) {
    const Vec lit =
        point_of(at_time(emitter, world_.time), random_.uniform(), random_.uniform()).at;
    const Vec dark = point_of(shape, random_.uniform(), random_.uniform()).at;
    const Vec way = dark - lit;
    if (!(length(way) > 0)) return;
    p.at = doubles(dark + way * (random_.power(-1.5, 0) * stage_.scale / length(way)));
    p.normal = floats(random_.direction() - unit(way) * 1.5L);
  }

  /// Not within one flat surface.
  World::Segment segment() {
    World::Segment s{place(random_.chance(0.5)), place(false)};
    while (s.from.on >= 0 && s.to.on == s.from.on) s.to = place(false);
    return s;
  }

  Numbers random_;
  World world_;
  Stage stage_;
  int ground_ = -1;
  std::vector<bool> is_sliver_;  ///< of each shape; rounding decides most queries on slivers
};

}  // namespace

World random_world(std::uint64_t number) { return Maker(number).make(); }

}  // namespace lucerna::oracle
