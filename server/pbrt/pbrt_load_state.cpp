#include "server/pbrt/pbrt_load_state.h"

#include <fmt/format.h>

#include <utility>

#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

void LoadState::remark(const FilePosition& place, std::string what, std::string instead) {
  remarks_.add(location(place), std::move(what), std::move(instead));
}

void LoadState::finish_remarks() { scene.remarks = remarks_.take(scene_file); }

absl::StatusOr<AssetContent> LoadState::find(const FilePosition& place, const std::string& name) {
  if (!is_printable(name))
    return absl::InvalidArgumentError("a file name must be UTF-8 without control characters");
  auto content = assets.read_unpacked(name, scene_file);
  if (absl::IsNotFound(content.status()) && place.file != nullptr &&
      place.file->str() != scene_file) {
    if (auto nearby = assets.read_unpacked(name, *place.file); !absl::IsNotFound(nearby.status()))
      content = std::move(nearby);
  }
  return content;
}

AssetContent LoadState::read(const FilePosition& place, const std::string& name) {
  auto content = find(place, name);
  if (!content.ok()) fail(place, content.status());
  return *std::move(content);
}

AssetContent LoadState::read(const Parameter& parameter) {
  const std::string& name = parameter.strings().front();
  auto content = find(parameter.place, name);
  if (content.ok()) return *std::move(content);
  const absl::Status& status = content.status();
  const bool missing = absl::IsNotFound(status);
  // Other errors do not depend on the parameter's value: the file may still arrive, is too large,
  // or the load was stopped.
  if (!missing && !absl::IsInvalidArgument(status)) fail(parameter.place, status);
  fail(parameter.place,
       absl::Status(
           status.code(),
           fmt::format("\"{} {}\" = \"{}\": {}{}", parameter.type, printable(parameter.name),
                       printable(name), std::string(status.message()),
                       missing ? ", allowed: a file inside the scene root" : "")));
}

void LoadState::poll() {
  if (stop.stop_requested()) throw StatusError(absl::CancelledError("loading was cancelled"));
  require(meter.count_lists());
}

}  // namespace lucerna::pbrt
