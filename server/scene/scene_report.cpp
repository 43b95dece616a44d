#include "server/scene/scene_report.h"

#include <fmt/format.h>

#include "lights/maths/stop_poll.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/rays/surface_table.h"

namespace lucerna {

std::string scene_id(const std::vector<Asset>& assets, const std::vector<HalvedPicture>& halved,
                     const LevelFactors& factors) {
  std::string text;
  for (const Asset& a : assets) {
    // Lengths come first, so that different lists of assets give different bytes.
    text += fmt::format("{}:{}{}:", a.name.size(), a.name, a.sha256.size());
    text += a.sha256;
  }
  for (const HalvedPicture& h : halved)
    text += fmt::format("halved:{}:{}{}x{}:", h.name.size(), h.name, h.kept_width, h.kept_height);
  // Shortest decimal numbers: different factors give different texts.
  if (factors != LevelFactors())
    text += fmt::format("levels:{}:{}:{}:", factors.lamps, factors.suns, factors.emission);
  return hexadecimal(sha256(text));
}

void remark_on_halved_pictures(const std::vector<HalvedPicture>& halved, SceneDescription& scene) {
  for (const HalvedPicture& h : halved) {
    Remark& remark = scene.remarks.emplace_back();
    remark.where.file = h.name;
    remark.what = fmt::format("a picture of {} x {} texels exceeds the memory of textures", h.width,
                              h.height);
    remark.instead =
        fmt::format("{} x {}, each the mean of several texels", h.kept_width, h.kept_height);
  }
}

absl::Status check_references(const SceneDescription& scene) {
  const auto check = [&](const ShapeDescription& s) -> absl::Status {
    const auto is_medium = [&](std::int32_t medium) {
      return medium >= -1 && medium < static_cast<std::int32_t>(scene.media.size());
    };
    if (s.media && !(is_medium(s.media->inside) && is_medium(s.media->outside)))
      return located(absl::InvalidArgumentError(
                         fmt::format("media number {} and {}, allowed: -1 for none, less than {}",
                                     s.media->inside, s.media->outside, scene.media.size())),
                     s.where);
    if (s.is_interface || s.material < scene.materials.size()) return absl::OkStatus();
    return located(
        absl::InvalidArgumentError(fmt::format("material number {}, allowed: less than {}",
                                               s.material, scene.materials.size())),
        s.where);
  };
  StopPoll poll;
  for (const auto& s : scene.shapes) {
    poll();
    LUCERNA_RETURN_IF_ERROR(check(s));
  }
  for (const auto& o : scene.objects)
    for (const auto& s : o.shapes) {
      poll();
      LUCERNA_RETURN_IF_ERROR(check(s));
    }
  for (const auto& i : scene.instances) {
    poll();
    if (i.object >= scene.objects.size())
      return absl::InvalidArgumentError(
          fmt::format("object number {}, allowed: less than {}", i.object, scene.objects.size()));
  }
  return absl::OkStatus();
}

}  // namespace lucerna
