#include "server/scene/portal_remarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "proto/common/status_macros.h"
#include "server/scene/scene_frame.h"

namespace lucerna {
namespace {

/// Illuminance of a surface in the open, the mean over all its directions [lx].
double mean_lx(const PortalLightParams& light) {
  // The mean of the cosine, 0 on the other side, is a quarter.
  const Rgb sr = light.map ? light.map->integral() : Rgb(4 * std::numbers::pi);
  return luminance(light.radiance_cd_m2 * sr) / 4;
}

/// Whether a part of the box is on the side that the light of the portal comes from.
bool is_outdoors(const PortalLightParams& portal, const Bounds& box,
                 const Transform& world_from_box) {
  const auto& c = portal.corners_m;
  const Vec3 outwards = normalized(cross(c[3] - c[0], c[1] - c[0]));
  // A pane or a frame in the opening is no surface outdoors.
  const double beyond_m = std::fmin(length(c[3] - c[0]), length(c[1] - c[0])) / 2;
  if (box.empty()) return false;
  return std::ranges::any_of(box.corners(), [&](const Vec3& corner) {
    return dot(outwards, world_from_box.point(corner) - c[0]) > beyond_m;
  });
}

}  // namespace

absl::Status remark_on_portals(SceneDescription& scene, const std::stop_token& stop) {
  for (const LightDescription& light : scene.lights) {
    const auto* portal = std::get_if<PortalLightParams>(&light.params);
    if (portal == nullptr) continue;
    std::size_t shapes = 0, outdoors = 0;
    const auto count = [&](const ShapeList& list, const Transform& to_world) -> absl::Status {
      shapes += list.size();
      for (const ShapeDescription& shape : list) {
        LUCERNA_RETURN_IF_ERROR(check_stop(stop));
        outdoors += is_outdoors(*portal, shape_bounds(shape).value_or(Bounds{}), to_world) ? 1 : 0;
      }
      return absl::OkStatus();
    };
    LUCERNA_RETURN_IF_ERROR(count(scene.shapes, Transform()));
    for (const InstanceDescription& i : scene.instances)
      LUCERNA_RETURN_IF_ERROR(count(scene.objects[i.object].shapes, i.world_from_object));
    if (outdoors == 0) continue;
    Remark& remark = scene.remarks.emplace_back();
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
