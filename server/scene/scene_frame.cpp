#include "server/scene/scene_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <variant>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/scene/create_light.h"

namespace lucerna {
namespace {

// Floats near a place differ by at least 1.2e-38 m (kLeastError).  Answers about smaller shapes
// would be wrong by more than a millionth.
absl::Status check_extent(const Bounds& bounds, const SourceLocation& where) {
  constexpr double kLeastExtent = 1e-32;
  if (bounds.empty()) return absl::OkStatus();
  const double extent = max_abs(bounds.upper - bounds.lower);
  if (extent == 0 || extent >= kLeastExtent) return absl::OkStatus();
  return located(absl::InvalidArgumentError(fmt::format(
                     "all shapes together reach over {:g} m, allowed: 0, or at least {:g}", extent,
                     kLeastExtent)),
                 where);
}

// Of spheres, disks and cylinders.  Floats of coordinates about their own place must be normal.
absl::Status check_size(const ShapeDescription& shape) {
  static constexpr double kLeastShape = 1e-36;
  const auto check = []<typename Params>(const Params& params) -> absl::Status {
    if constexpr (requires { params.world_from_object; }) {
      // About its own place, whose rounding would hide its size.
      LUCERNA_ASSIGN_OR_RETURN(
          const auto own,
          QuadricOf<Params>::create(params, params.world_from_object.point({0, 0, 0})));
      const auto [lower, upper] = own.bounds();
      if (const double extent = max_abs(upper - lower); extent < kLeastShape)
        return absl::InvalidArgumentError(
            fmt::format("a shape of {:g} m, allowed: at least {:g}", extent, kLeastShape));
    }
    return absl::OkStatus();
  };
  return located(std::visit(check, shape.geometry), shape.where);
}

/// Adds the space that `motion` sweeps, which must be within the range of rays.
absl::Status sweep(const Bounds& still, const Motion& motion, const SourceLocation& where,
                   Bounds& swept) {
  if (still.empty()) return absl::OkStatus();
  const auto [lower, upper] = motion.bounds(still.lower, still.upper);
  const double reach = std::fmax(max_abs(lower), max_abs(upper));
  if (!(reach <= Accelerator::kMaxCoordinate))
    return located(absl::InvalidArgumentError(fmt::format(
                       "motion reaching to {} m, allowed: coordinates up to 1e30", reach)),
                   where);
  swept.add(lower), swept.add(upper);
  return absl::OkStatus();
}

}  // namespace

Vec3 origin_for(const Bounds& bounds) {
  if (bounds.empty()) return {};
  const double extent = max_abs(bounds.upper - bounds.lower);
  if (!std::isfinite(extent)) return {};
  const Vec3 centre = bounds.lower * 0.5 + bounds.upper * 0.5;
  // A single point has no extent; its coordinate is rounded to a metre.
  const double step = extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 1;
  const auto snap = [&](double c) { return std::nearbyint(c / step) * step + 0.0; };
  return {snap(centre.x), snap(centre.y), snap(centre.z)};
}

void add_shape(const Bounds& shape, Bounds& all, double& detail_m) {
  if (shape.empty()) return;
  all.add(shape.lower), all.add(shape.upper);
  if (const double extent = max_abs(shape.upper - shape.lower); extent > 0)
    detail_m = std::fmin(detail_m, extent);
}

namespace {

/// The smallest box around a box after `world_from_box`; empty for an empty one.
Bounds transformed(const Transform& world_from_box, const Bounds& box) {
  Bounds world;
  if (box.empty()) return world;
  for (const Vec3& corner : box.corners()) world.add(world_from_box.point(corner));
  return world;
}

absl::Status grow(Bounds& bounds, const ShapeDescription& shape, double& detail_m) {
  LUCERNA_ASSIGN_OR_RETURN(const Bounds b, shape_bounds(shape));
  add_shape(b, bounds, detail_m);
  return absl::OkStatus();
}

void add(const Bounds& bounds, Bounds& all) {
  if (!bounds.empty()) all.add(bounds.lower), all.add(bounds.upper);
}

/// The scene's own shapes.
absl::Status add_shapes(const ShapeList& shapes, const std::stop_token& stop, ShapeExtents& all) {
  Bounds of_lights;
  double lights_detail_m = Bounds::kInfinity;
  for (const auto& s : shapes) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop));
    Bounds still;
    const bool can_be_moved = s.emission && !s.motion;
    LUCERNA_RETURN_IF_ERROR(grow(s.motion       ? still
                                 : can_be_moved ? of_lights
                                                : all.others_m,
                                 s, can_be_moved ? lights_detail_m : all.others_detail_m));
    if (!s.motion) continue;
    LUCERNA_RETURN_IF_ERROR(sweep(still, *s.motion, s.where, all.others_m));
    all.moving_origins.push_back(origin_for(still));
  }
  all.world_m = of_lights;
  all.detail_m = lights_detail_m;
  return absl::OkStatus();
}

absl::Status add_objects(const SceneDescription& scene, const std::stop_token& stop,
                         ShapeExtents& all) {
  std::vector<Bounds> object_bounds(scene.objects.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ShapeList& shapes = scene.objects[i].shapes;
    for (const auto& s : shapes) {
      LUCERNA_RETURN_IF_ERROR(check_stop(stop));
      LUCERNA_RETURN_IF_ERROR(grow(object_bounds[i], s, all.others_detail_m));
    }
    all.object_origins.push_back(origin_for(object_bounds[i]));
    if (shapes.empty()) continue;
    LUCERNA_RETURN_IF_ERROR(check_extent(object_bounds[i], shapes.front().where));
  }
  for (const auto& instance : scene.instances) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop));
    const Bounds placed = transformed(instance.world_from_object, object_bounds[instance.object]);
    if (instance.motion)
      LUCERNA_RETURN_IF_ERROR(sweep(placed, *instance.motion, instance.where, all.others_m));
    else
      add(placed, all.others_m);
  }
  return absl::OkStatus();
}

absl::Status check_sizes(const ShapeList& shapes) {
  StopPoll poll;
  for (const auto& s : shapes) {
    poll();
    LUCERNA_RETURN_IF_ERROR(check_size(s));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ShapeExtents> shape_extents(const SceneDescription& scene,
                                           const std::stop_token& stop) {
  ShapeExtents all;
  LUCERNA_RETURN_IF_ERROR(add_shapes(scene.shapes, stop, all));
  LUCERNA_RETURN_IF_ERROR(add_objects(scene, stop, all));
  add(all.others_m, all.world_m);
  all.detail_m = std::fmin(all.others_detail_m, all.detail_m);
  if (!scene.shapes.empty() || !scene.instances.empty())
    LUCERNA_RETURN_IF_ERROR(check_extent(all.world_m, scene.shapes.empty()
                                                          ? scene.instances.front().where
                                                          : scene.shapes.front().where));
  LUCERNA_RETURN_IF_ERROR(check_sizes(scene.shapes));
  for (const auto& object : scene.objects) LUCERNA_RETURN_IF_ERROR(check_sizes(object.shapes));
  return all;
}

absl::StatusOr<SceneFrame> scene_frame(const Bounds& shapes_m,
                                       const LongList<LightDescription>& lights,
                                       const std::stop_token& stop) {
  // A distant light must not make the geometry less exact, so the origin is that of the geometry if
  // there is any.
  Bounds with_lights = shapes_m, portals;
  const auto hold = [&](const LightDescription& light, const std::optional<Bounds>& box,
                        Bounds& bounds) -> absl::Status {
    if (!box || !is_finite(box->lower) || !is_finite(box->upper)) return absl::OkStatus();
    Bounds still;
    still.add(box->lower), still.add(box->upper);
    if (light.motion) return sweep(still, *light.motion, light.where, bounds);
    bounds.add(box->lower), bounds.add(box->upper);
    return absl::OkStatus();
  };
  for (const auto& light : lights) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop));
    const LightPlace place = place_of(light);
    if (absl::Status s = hold(light, place.box_m, with_lights); !s.ok()) return s;
    if (absl::Status s = hold(light, place.portal_m, portals); !s.ok()) return s;
  }
  SceneFrame frame;
  const Bounds& of_lights = with_lights.empty() ? portals : with_lights;
  frame.origin = origin_for(shapes_m.empty() ? of_lights : shapes_m);
  if (!with_lights.empty()) {
    const Vec3 centre = with_lights.lower * 0.5 + with_lights.upper * 0.5;
    frame.sphere = {centre - frame.origin, length(with_lights.upper - centre)};
  }
  return frame;
}

}  // namespace lucerna
