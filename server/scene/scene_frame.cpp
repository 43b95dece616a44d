// Chooses the zero of the scene's coordinates, and computes the scene's sphere.  Finds the shapes
// that portals leave dark.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <variant>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/scene/scene_builder.h"
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

/// Illuminance of a surface in the open, the mean over all its directions [lx].
double mean_lx(const PortalLightParams& light) {
  // The mean of the cosine, 0 on the other side, is a quarter.
  const Rgb sr = light.map ? light.map->integral() : Rgb(4 * std::numbers::pi);
  return luminance(light.radiance_cd_m2 * sr) / 4;
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

absl::Status Scene::Builder::place() {
  std::vector<Bounds> object_bounds(in_.objects.size());
  // Of all shapes but those of lights, and of those of lights.
  Bounds others, of_lights;
  double others_detail_m = Bounds::kInfinity, lights_detail_m = Bounds::kInfinity;
  const auto grow = [](Bounds& bounds, const ShapeDescription& shape,
                       double& detail_m) -> absl::Status {
    LUCERNA_ASSIGN_OR_RETURN(const Bounds b, shape_bounds(shape));
    add_shape(b, bounds, detail_m);
    return absl::OkStatus();
  };
  for (const auto& s : in_.shapes) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    Bounds still;
    const bool can_be_moved = s.emission && !s.motion;
    LUCERNA_RETURN_IF_ERROR(grow(s.motion       ? still
                                 : can_be_moved ? of_lights
                                                : others,
                                 s, can_be_moved ? lights_detail_m : others_detail_m));
    if (!s.motion) continue;
    LUCERNA_RETURN_IF_ERROR(sweep(still, *s.motion, s.where, others));
    moving_origins_.push_back(origin_for(still));
  }
  for (std::size_t i = 0; i < in_.objects.size(); ++i) {
    for (const auto& s : in_.objects[i].shapes) {
      LUCERNA_RETURN_IF_ERROR(check_stop());
      LUCERNA_RETURN_IF_ERROR(grow(object_bounds[i], s, others_detail_m));
    }
    object_origins_.push_back(origin_for(object_bounds[i]));
    if (in_.objects[i].shapes.empty()) continue;
    LUCERNA_RETURN_IF_ERROR(check_extent(object_bounds[i], in_.objects[i].shapes.front().where));
  }
  for (const auto& instance : in_.instances) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    const Bounds& b = object_bounds[instance.object];
    Bounds placed;
    for (int corner = 0; corner < 8 && !b.empty(); ++corner)
      placed.add(instance.world_from_object.point({corner & 1 ? b.upper.x : b.lower.x,
                                                   corner & 2 ? b.upper.y : b.lower.y,
                                                   corner & 4 ? b.upper.z : b.lower.z}));
    if (instance.motion) {
      LUCERNA_RETURN_IF_ERROR(sweep(placed, *instance.motion, instance.where, others));
    } else if (!placed.empty()) {
      others.add(placed.lower), others.add(placed.upper);
    }
  }
  Bounds world = others;
  if (!of_lights.empty()) world.add(of_lights.lower), world.add(of_lights.upper);
  detail_m_ = std::fmin(others_detail_m, lights_detail_m);
  scene_->movable_.others_m = others;
  scene_->movable_.others_detail_m = others_detail_m;
  if (!in_.shapes.empty() || !in_.instances.empty()) {
    const SourceLocation& first =
        in_.shapes.empty() ? in_.instances.front().where : in_.shapes.front().where;
    LUCERNA_RETURN_IF_ERROR(check_extent(world, first));
  }
  StopPoll poll;
  for (const auto& s : in_.shapes) {
    poll();
    LUCERNA_RETURN_IF_ERROR(check_size(s));
  }
  for (const auto& object : in_.objects)
    for (const auto& s : object.shapes) {
      poll();
      LUCERNA_RETURN_IF_ERROR(check_size(s));
    }
  placed_->world_m = world;
  return place_lights();
}

absl::Status Scene::Builder::place_lights() {
  // A distant light must not make the geometry less exact, so the origin is that of the geometry if
  // there is any.
  Bounds with_lights = scene_->placed_->world_m, portals;
  const auto hold = [&](const LightDescription& light, const std::optional<Box>& box,
                        Bounds& bounds) -> absl::Status {
    if (!box || !is_finite(box->first) || !is_finite(box->second)) return absl::OkStatus();
    Bounds still;
    still.add(box->first), still.add(box->second);
    if (light.motion) return sweep(still, *light.motion, light.where, bounds);
    bounds.add(box->first), bounds.add(box->second);
    return absl::OkStatus();
  };
  for (const auto& light : in_.lights) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    const LightPlace place = place_of(light);
    if (absl::Status s = hold(light, place.box_m, with_lights); !s.ok()) return s;
    if (absl::Status s = hold(light, place.portal_m, portals); !s.ok()) return s;
  }
  const Bounds& of_lights = with_lights.empty() ? portals : with_lights;
  const Bounds& world = scene_->placed_->world_m;
  scene_->origin_ = origin_for(world.empty() ? of_lights : world);
  if (!with_lights.empty()) {
    const Vec3 centre = with_lights.lower * 0.5 + with_lights.upper * 0.5;
    scene_->sphere_ = {centre - scene_->origin_, length(with_lights.upper - centre)};
  }
  return absl::OkStatus();
}

absl::Status Scene::Builder::report_portals() {
  for (const LightDescription& light : in_.lights) {
    const auto* portal = std::get_if<PortalLightParams>(&light.params);
    if (portal == nullptr) continue;
    const auto& c = portal->corners_m;
    const Vec3 outwards = normalized(cross(c[3] - c[0], c[1] - c[0]));
    // A pane or a frame in the opening is no surface outdoors.
    const double beyond_m = std::fmin(length(c[3] - c[0]), length(c[1] - c[0])) / 2;
    const auto is_outdoors = [&](const Bounds& box, const Transform& world_from_box) {
      for (int corner = 0; corner < 8 && !box.empty(); ++corner) {
        const Vec3 p = world_from_box.point({corner & 1 ? box.upper.x : box.lower.x,
                                             corner & 2 ? box.upper.y : box.lower.y,
                                             corner & 4 ? box.upper.z : box.lower.z});
        if (dot(outwards, p - c[0]) > beyond_m) return true;
      }
      return false;
    };
    const auto box_of = [](const ShapeDescription& shape) {
      return shape_bounds(shape).value_or(Bounds{});
    };
    std::size_t shapes = in_.shapes.size(), outdoors = 0;
    for (const ShapeDescription& shape : in_.shapes) {
      LUCERNA_RETURN_IF_ERROR(check_stop());
      outdoors += is_outdoors(box_of(shape), Transform()) ? 1 : 0;
    }
    for (const InstanceDescription& instance : in_.instances) {
      const ShapeList& own = in_.objects[instance.object].shapes;
      shapes += own.size();
      for (const ShapeDescription& shape : own) {
        LUCERNA_RETURN_IF_ERROR(check_stop());
        outdoors += is_outdoors(box_of(shape), instance.world_from_object) ? 1 : 0;
      }
    }
    if (outdoors == 0) continue;
    Remark& remark = in_.remarks.emplace_back();
    remark.where = light.where;
    remark.what = fmt::format(
        "an infinite light with a portal, and {} of {} shapes reach outdoors: onto the side that "
        "its light comes from",
        outdoors, shapes);
    remark.instead = fmt::format(
        "it lights nothing outdoors, as in pbrt-v4; without the portal it would give {:.4g} lx in "
        "the open, the mean over all directions of a surface",
        mean_lx(*portal));
  }
  return absl::OkStatus();
}

}  // namespace lucerna
