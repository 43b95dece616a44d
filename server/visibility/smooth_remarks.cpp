#include "server/visibility/smooth_remarks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "server/scene/light_at_time.h"
#include "server/visibility/smooth_surfaces.h"

namespace lucerna {
namespace {

using Kind = UnsolvedSurface::Kind;

/// Without any, nothing is collected, and no part of the scene is built.
bool has_smooth_surfaces(const Scene& scene) {
  bool any = !scene.geometry().surfaces().smooth.empty();
  for (std::uint32_t i = 0; !any && i < scene.geometry().accelerator().instance_count(); ++i)
    any = !scene.geometry()
               .surfaces_of(scene.geometry().accelerator().instance(i).object)
               .smooth.empty();
  return any;
}

bool is_unsized(const SceneLight& light) { return is_delta(light) || light.is_unseen; }

}  // namespace

bool may_miss_light(const Scene& scene) {
  if (scene.lights().empty() || !has_smooth_surfaces(scene)) return false;
  const auto has = [&](Kind kind) {
    return std::ranges::any_of(smooth_surfaces(scene).unsolved(),
                               [&](const UnsolvedSurface& s) { return s.kind == kind; });
  };
  return has(Kind::kSmooth) || has(Kind::kCrowd) ||
         ((has(Kind::kNearlySmooth) || has(Kind::kNearlySmoothChain)) &&
          std::ranges::any_of(scene.lights(), is_unsized));
}

std::optional<Remark> remark_on_smooth_surfaces(const Scene& scene) {
  constexpr std::size_t kMostNamed = 4;
  if (!may_miss_light(scene)) return std::nullopt;
  std::vector<std::uint64_t> deltas;
  for (const SceneLight& light : scene.lights())
    if (is_unsized(light)) deltas.push_back(light.id);
  Remark remark;
  remark.count = 0;
  for (const UnsolvedSurface& s : smooth_surfaces(scene).unsolved()) {
    if (s.kind != Kind::kSmooth && s.kind != Kind::kCrowd && deltas.empty()) continue;
    if (remark.count++ == 0)
      remark.where = s.where;
    else if (remark.more.size() < kMostNamed)
      remark.more.push_back(s.where);
  }
  remark.what =
      "a smooth surface that is curved, moves, has a normal map, is nearly smooth or has a lamp on "
      "it, or the first of many";
  remark.instead = "by way of it, light may be missed";
  if (!deltas.empty()) {
    const std::size_t more = deltas.size() - std::min(deltas.size(), kMostNamed);
    deltas.resize(deltas.size() - more);
    remark.instead +=
        fmt::format(", and pictures leave out light of lights without a size (light {}{})",
                    fmt::join(deltas, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
  }
  remark.instead += "; answers that it may change have the status MAY_MISS_LIGHT";
  return remark;
}

}  // namespace lucerna
