#include "server/pbrt/context.h"

#include <fmt/format.h>

#include <utility>

namespace lucerna::pbrt {

void Context::remark(const Place& place, std::string what, std::string instead) {
  constexpr std::size_t kMaxRemarks = 1000;
  if (scene.remarks.size() >= kMaxRemarks) {
    ++uncounted_;
    return;
  }
  if (!said_.insert(to_string(place) + what + instead).second) return;
  scene.remarks.push_back({location(place), std::move(what), std::move(instead)});
}

void Context::finish_remarks() {
  if (uncounted_ == 0) return;
  Remark& rest = scene.remarks.emplace_back();
  rest.where.file = scene_file;
  rest.what = fmt::format("{} more things are not modelled", uncounted_);
  rest.instead = "as the remarks before this one say of their like";
}

AssetContent Context::read(const Place& place, const std::string& name) {
  if (!is_printable(name)) fail(place, "a file name must be UTF-8 without control characters");
  auto content = assets.read_unpacked(name, scene_file);
  if (absl::IsNotFound(content.status()) && place.file != nullptr && *place.file != scene_file) {
    if (auto nearby = assets.read_unpacked(name, *place.file); !absl::IsNotFound(nearby.status()))
      content = std::move(nearby);
  }
  if (!content.ok()) fail(place, content.status());
  return *std::move(content);
}

void Context::poll() const {
  if (stop.stop_requested()) throw Failure{absl::CancelledError("loading was cancelled")};
}

}  // namespace lucerna::pbrt
