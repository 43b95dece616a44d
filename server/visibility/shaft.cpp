#include "server/visibility/shaft.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "lights/maths/stop_poll.h"
#include "server/rays/box_tree.h"
#include "server/rays/error_bounds.h"
#include "server/runtime/denormals.h"
#include "server/scene/scene.h"
#include "server/visibility/shaft_region.h"

namespace lucerna {
namespace {

/// The least sine of a ray over a horizon that floats can resolve.
constexpr double kLeastRise = 4 * kFloatRoundoff;

bool is_outside(const Boundsf& box, std::span<const HalfSpace> planes) {
  for (const HalfSpace& h : planes) {
    const auto least = [](double n, double low, double high) { return n * (n > 0 ? low : high); };
    if (least(h.n.x, box.lower.x, box.upper.x) + least(h.n.y, box.lower.y, box.upper.y) +
            least(h.n.z, box.lower.z, box.upper.z) >
        h.at)
      return true;
  }
  return false;
}

bool overlaps(const Boundsf& box, const Bounds& other) {
  return box.lower.x <= other.upper.x && box.upper.x >= other.lower.x &&
         box.lower.y <= other.upper.y && box.upper.y >= other.lower.y &&
         box.lower.z <= other.upper.z && box.upper.z >= other.lower.z;
}

/// A convex polygon.  Each plane adds one corner.  Rounding may let a plane cross the polygon
/// repeatedly, which adds half as many corners again.
struct Clipped {
  static constexpr int kMostCorners = 48;
  std::array<Vec3, kMostCorners> corner;
  int count = 0;
};

/// [Sutherland74]
void clip(Clipped& polygon, const HalfSpace& h) {
  // An uncut polygon is larger, which is safe.
  if (polygon.count > Clipped::kMostCorners * 2 / 3) return;
  std::array<double, Clipped::kMostCorners> beyond;
  bool is_cut = false;
  for (int i = 0; i < polygon.count; ++i) {
    beyond[i] = dot(h.n, polygon.corner[i]) - h.at;
    is_cut = is_cut || beyond[i] > 0;
  }
  if (!is_cut) return;
  Clipped kept;
  for (int i = 0; i < polygon.count; ++i) {
    const int next = (i + 1) % polygon.count;
    const Vec3 &a = polygon.corner[i], &b = polygon.corner[next];
    if (beyond[i] <= 0) kept.corner[kept.count++] = a;
    if ((beyond[i] <= 0) != (beyond[next] <= 0))
      kept.corner[kept.count++] = a + (b - a) * (beyond[i] / (beyond[i] - beyond[next]));
  }
  polygon = kept;
}

/// Whether the rest of the polygon is so low above the horizon, and so far away, that no ray passes
/// it.
bool is_level(const Clipped& polygon, const ShaftRegion& shaft,
              const Transform* scene_from_object) {
  double highest = 0;
  Bounds box;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 p =
        scene_from_object ? scene_from_object->point(polygon.corner[i]) : polygon.corner[i];
    highest = std::fmax(highest, dot(shaft.up, p - shaft.apex));
    box.add(p);
  }
  double nearest = 0;  // along at least one axis
  for (int axis = 0; axis < 3; ++axis)
    nearest = std::fmax(
        nearest, std::fmax(box.lower[axis] - shaft.apex[axis], shaft.apex[axis] - box.upper[axis]));
  return highest <= kLeastRise * nearest;
}

bool is_outside(const RoundEnclosure& e, std::span<const HalfSpace> planes) {
  return std::ranges::any_of(planes, [&](const HalfSpace& h) {
    const double a = dot(h.n, e.x), b = dot(h.n, e.y), c = dot(h.n, e.z);
    const double reach =
        e.is_prism ? std::sqrt(a * a + b * b) + std::fabs(c) : std::sqrt(a * a + b * b + c * c);
    return dot(h.n, e.center) - reach > h.at;
  });
}

/// Whether a patch, which lies within the hull of its corners, is beyond a plane.
bool is_outside(const BilinearPatch& p, std::span<const HalfSpace> planes) {
  return std::ranges::any_of(planes, [&](const HalfSpace& h) {
    return std::min({dot(h.n, p.p00), dot(h.n, p.p10), dot(h.n, p.p01), dot(h.n, p.p11)}) > h.at;
  });
}

/// Whether a curve, which lies within its radius of the hull of its control points, is beyond a
/// plane.
bool is_outside(const CurvePiece& c, std::span<const HalfSpace> planes) {
  const double radius = std::fmax(c.start_radius_m, c.end_radius_m);
  return std::ranges::any_of(planes, [&](const HalfSpace& h) {
    const auto at = [&](int i) { return dot(h.n, c.points[i]); };
    return std::min({at(0), at(1), at(2), at(3)}) - radius * length(h.n) > h.at;
  });
}

/// The primitives of a GeometrySet with their boxes, numbered kind after kind.
class SetBoxes {
 public:
  /// `others`: boxes of items that are not primitives, numbered from first_other() on.
  explicit SetBoxes(const GeometrySet& set, std::span<const Boundsf> others = {}) : set_(set) {
    std::vector<Boundsf> boxes;
    add_to(boxes);
    boxes.insert(boxes.end(), others.begin(), others.end());
    tree_ = BoxTree(boxes);
  }

  struct Item {
    HitKind kind;
    std::uint32_t primitive;
  };
  /// Requires number < first_other().
  Item item(std::uint32_t number) const {
    const auto counts = set_.counts();
    int kind = 0;
    while (number >= counts[kind]) number -= static_cast<std::uint32_t>(counts[kind++]);
    return {static_cast<HitKind>(kind), number};
  }
  std::size_t first_other() const { return set_.primitives(); }

  /// Whether the item may reach into the shaft.  The planes are in the set's space.
  bool may_reach(const Item& item, std::span<const HalfSpace> planes, const ShaftRegion& shaft,
                 const Transform* scene_from_object) const {
    const std::uint32_t i = item.primitive;
    if (item.kind != HitKind::kTriangle) {
      // Shapes that are not clipped are tested with single planes, and with the shaft's box, which
      // does not exist in an object's space.
      return set_.visit_surface(item.kind, i, [&](const auto& surface) {
        if (scene_from_object == nullptr && !shaft.box.empty()) {
          const auto [lower, upper] = surface.bounds();
          if (!overlaps(Boundsf::around(lower, upper), shaft.box)) return false;
        }
        if constexpr (QuadricShape<std::decay_t<decltype(surface)>>)
          return !is_outside(surface.enclosure(), planes);
        else
          return !is_outside(surface, planes);
      });
    }
    Clipped left;
    left.count = 3;
    for (int k = 0; k < 3; ++k) left.corner[k] = vertex(3 * std::size_t{i} + k);
    for (const HalfSpace& h : planes)
      if (clip(left, h); left.count == 0) return false;
    return !is_level(left, shaft, scene_from_object);
  }

  const BoxTree& tree() const { return tree_; }

 private:
  Vec3 vertex(std::size_t corner) const {
    return Vec3(set_.vertices[set_.triangles[corner]]) * set_.unit_m;
  }

  void add_to(std::vector<Boundsf>& boxes) const {
    StopPoll poll;
    for (std::size_t t = 0; t < set_.triangles.size(); t += 3, poll()) {
      Bounds box;
      for (std::size_t k = 0; k < 3; ++k) box.add(vertex(t + k));
      boxes.push_back(Boundsf::around(box.lower, box.upper));
    }
    set_.for_each_kind_of_surface([&](const auto& surfaces) {
      for (const auto& surface : surfaces) {
        poll();
        const auto [lower, upper] = surface.bounds();
        boxes.push_back(Boundsf::around(lower, upper));
      }
    });
  }

  const GeometrySet& set_;
  BoxTree tree_;
};

/// The box of an object placed by an instance, over all time.
Boundsf box_of(const GeometryInstance& instance, const Boundsf& object) {
  Bounds placed;
  for (const Vec3& corner : Bounds{Vec3(object.lower), Vec3(object.upper)}.corners())
    placed.add(instance.scene_from_object.point(corner));
  if (!instance.motion) return Boundsf::around(placed.lower, placed.upper);
  const auto [lower, upper] = instance.motion->bounds(placed.lower, placed.upper);
  return Boundsf::around(lower, upper);
}

}  // namespace

/// Boxes around all surfaces.  Revisions of a scene share them.
struct Shafts::Boxes {
  static constexpr const char* kPartName = "boxes of surfaces";
  explicit Boxes(const SceneGeometry& geometry)
      : accelerator(geometry.accelerator()), surfaces(geometry.surfaces()) {
    for (std::uint32_t i = 0; i < accelerator.object_count(); ++i)
      objects.emplace_back(accelerator.object(i));
    for (std::uint32_t i = 0; i < accelerator.instance_count(); ++i) {
      const GeometryInstance& instance = accelerator.instance(i);
      instance_boxes.push_back(box_of(instance, objects[instance.object].tree().box()));
    }
    own.emplace(accelerator.scene(), instance_boxes);
    if (!own->tree().empty()) {
      hittable.add(Vec3(own->tree().box().lower));
      hittable.add(Vec3(own->tree().box().upper));
    }
  }

  static bool may_hold(const Boundsf& box, const ShaftRegion& shaft) {
    return (shaft.box.empty() || overlaps(box, shaft.box)) && !is_outside(box, shaft.half_spaces());
  }

  bool meets_instance(std::size_t number, const ShaftRegion& shaft) const {
    if (!may_hold(instance_boxes[number], shaft)) return false;
    const GeometryInstance& instance = accelerator.instance(static_cast<std::uint32_t>(number));
    if (instance.motion) return true;
    const ShaftRegion there = in_object(shaft, instance.scene_from_object);
    const SetBoxes& object = objects[instance.object];
    return object.tree().any(
        [&](const Boundsf& box) { return !is_outside(box, there.half_spaces()); },
        [&](std::uint32_t number) {
          return object.may_reach(object.item(number), there.half_spaces(), shaft,
                                  &instance.scene_from_object);
        });
  }

  /// `light`: Surface::light.
  bool is_of_light(const SetBoxes::Item& item, std::int32_t light) const {
    const PrimitiveRun& run = surfaces.run(item.kind, item.primitive);
    return surfaces.surfaces[run.surface].light == light;
  }

  bool meets(const ShaftRegion& shaft, std::int32_t light) const {
    return own->tree().any([&](const Boundsf& box) { return may_hold(box, shaft); },
                           [&](std::uint32_t number) {
                             if (number >= own->first_other())
                               return meets_instance(number - own->first_other(), shaft);
                             const SetBoxes::Item item = own->item(number);
                             return own->may_reach(item, shaft.half_spaces(), shaft, nullptr) &&
                                    !is_of_light(item, light);
                           });
  }

  std::string why() const { return "closed forms test whether surfaces block the light"; }

  const Accelerator& accelerator;
  const SurfaceTable& surfaces;
  std::vector<SetBoxes> objects;
  std::vector<Boundsf> instance_boxes;
  std::size_t bytes() const {
    std::size_t sum = sizeof *this + own->tree().bytes() + objects.capacity() * sizeof(SetBoxes) +
                      instance_boxes.capacity() * sizeof(Boundsf);
    for (const SetBoxes& o : objects) sum += o.tree().bytes();
    return sum;
  }
  std::optional<SetBoxes> own;  ///< and the instances
  Bounds hittable;              ///< of everything that can be hit
};

struct Shafts::State {
  const Boxes* boxes = nullptr;
  std::vector<LightOutline> outlines;        ///< of each light
  std::vector<std::int32_t> light_surfaces;  ///< Surface::light of each light
};

Shafts::Shafts(const Scene& scene) : state_(std::make_unique<State>()) {
  const DenormalsAreZero denormals;
  State& state = *state_;
  state.boxes = &scene.geometry().attached<AttachedLazyPart<Boxes, SceneGeometry>>().get();
  for (const SceneLight& light : scene.lights()) {
    state.outlines.push_back(outline_of(light));
    state.light_surfaces.push_back(scene.surface_number(light));
  }
}
Shafts::~Shafts() = default;

bool Shafts::has_outline(std::uint32_t light) const {
  return state_->outlines[light].kind != LightOutline::Kind::kNone;
}

bool Shafts::is_empty(const SurfaceHit& receiver, const Vec3f& normal, std::uint32_t light) const {
  const Boxes& boxes = *state_->boxes;
  const auto region = shaft_region(state_->outlines[light], receiver, normal, boxes.hittable);
  return region && !boxes.meets(*region, state_->light_surfaces[light]);
}

std::size_t Shafts::bytes() const {
  std::size_t sum = sizeof *this + sizeof(State) +
                    state_->outlines.capacity() * sizeof(LightOutline) +
                    state_->light_surfaces.capacity() * sizeof(std::int32_t);
  for (const LightOutline& o : state_->outlines) sum += o.corners.capacity() * sizeof(Vec3);
  return sum;
}

const Shafts& shafts(const Scene& scene) {
  return scene.attached<AttachedLazyPart<Shafts, Scene>>().get();
}

}  // namespace lucerna
