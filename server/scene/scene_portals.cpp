// Remarks about surfaces that an infinite light with a portal leaves dark.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "server/scene/scene_builder.h"

namespace lucerna {
namespace {

/// Illuminance of a surface in the open, the mean over all its directions [lx].
double mean_lx(const PortalLightParams& light) {
  // The mean of the cosine, 0 on the other side, is a quarter.
  const Rgb<double> sr = light.map ? light.map->integral() : Rgb<double>(4 * std::numbers::pi);
  return luminance(light.radiance_cd_m2 * sr) / 4;
}

}  // namespace

void Scene::Builder::report_portals() {
  for (const LightDescription& light : in_.lights) {
    const auto* portal = std::get_if<PortalLightParams>(&light.params);
    if (portal == nullptr) continue;
    const auto& c = portal->corners_m;
    const Vec3<double> outwards = normalized(cross(c[3] - c[0], c[1] - c[0]));
    // A pane or a frame in the opening is no surface outdoors.
    const double beyond_m = std::fmin(length(c[3] - c[0]), length(c[1] - c[0])) / 2;
    const auto is_outdoors = [&](const Bounds& box, const Transform& world_from_box) {
      for (int corner = 0; corner < 8 && !box.empty(); ++corner) {
        const Vec3<double> p = world_from_box.point({corner & 1 ? box.upper.x : box.lower.x,
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
    for (const ShapeDescription& shape : in_.shapes)
      outdoors += is_outdoors(box_of(shape), Transform()) ? 1 : 0;
    for (const InstanceDescription& instance : in_.instances) {
      const ShapeList& own = in_.objects[instance.object].shapes;
      shapes += own.size();
      for (const ShapeDescription& shape : own)
        outdoors += is_outdoors(box_of(shape), instance.world_from_object) ? 1 : 0;
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
}

}  // namespace lucerna
