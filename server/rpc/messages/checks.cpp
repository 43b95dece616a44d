#include "server/rpc/messages/checks.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/files/printable.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {

namespace {

/// The error for an id that no scene has.
absl::Status no_scene(const std::string& scene_id) {
  constexpr std::size_t kMostShown = 200;
  if (scene_id.empty()) return bad_field("scene_id", "\"\"", "the scene_id of a LoadSceneResponse");
  return error(Reason::kSceneNotLoaded, fmt::format("scene_id = \"{}\", which is not loaded",
                                                    shortened(scene_id, kMostShown)));
}

/// The ids of lights with the same name, at most ten of them.
std::string ids_of(const Scene& scene, std::span<const std::uint32_t> lights) {
  constexpr std::size_t kMost = 10;
  const auto shown = lights.first(std::min(lights.size(), kMost));
  return absl::StrJoin(shown, ", ",
                       [&](std::string* out, std::uint32_t light) {
                         absl::StrAppend(out, scene.lights()[light].id);
                       }) +
         (lights.size() > kMost ? ", ..." : "");
}

}  // namespace

absl::StatusOr<StoredScene> find_stored(const CallContext& context, const std::string& scene_id) {
  std::optional<StoredScene> stored = context.scenes.stored(scene_id);
  if (!stored) return no_scene(scene_id);
  return *std::move(stored);
}

absl::StatusOr<std::shared_ptr<const Scene>> find_scene(const CallContext& context,
                                                        const std::string& scene_id) {
  auto scene = context.scenes.find(scene_id);
  if (scene == nullptr) return no_scene(scene_id);
  return scene;
}

absl::StatusOr<std::uint32_t> find_light(const Scene& scene, std::uint64_t light_id) {
  const std::optional<std::uint32_t> light = scene.lights().find(light_id);
  if (!light) return unknown_light(light_id);
  return *light;
}

absl::StatusOr<std::uint32_t> find_named_light(const Scene& scene, const std::string& name,
                                               const std::string& field) {
  const LightNames& names = scene.lights().names();
  const std::span<const std::uint32_t> found = names.lights(name);
  if (found.size() == 1) return found[0];
  if (found.size() > 1)
    return bad_field(field, fmt::format("\"{}\"", printable(name)),
                     "the name of one light; {} lights have this name: use an id, {}", found.size(),
                     ids_of(scene, found));
  constexpr std::size_t kMostSimilar = 5;
  const std::string similar = absl::StrJoin(names.similar(name, kMostSimilar), ", ",
                                            [](std::string* out, std::string_view other) {
                                              absl::StrAppend(out, "\"", printable(other), "\"");
                                            });
  return error(
      Reason::kNoSuchLight,
      fmt::format("{} = \"{}\", which the scene does not have; {}", field, printable(name),
                  similar.empty() ? "none of its lights has a name" : "similar names: " + similar));
}

absl::StatusOr<std::uint32_t> find_light(const Scene& scene, std::optional<std::uint64_t> light_id,
                                         const std::string& light_name) {
  if (light_name.empty()) {
    if (light_id) return find_light(scene, *light_id);
    return bad_field("light_id", "0", "the id of a light, or 0 beside a light_name");
  }
  if (light_id)
    return bad_field("light_name", fmt::format("\"{}\"", printable(light_name)),
                     "empty beside light_id = {}", *light_id);
  return find_named_light(scene, light_name, "light_name");
}

absl::StatusOr<PointArray> check_points(const CallContext& context, const std::string& field,
                                        const v1::Points& points) {
  const int n = points.offsets_m_size();
  if (n % 3 != 0) {
    return bad_field(field + ".offsets_m", fmt::format("{} numbers", n), "three for each point");
  }
  const auto items = static_cast<std::uint64_t>(n / 3);
  LUCERNA_RETURN_IF_ERROR(check_limit(field + " points", items, context.limits.max_batch_items));
  const v1::Vector3& o = points.origin_m();
  const auto is_bad = [](double v) { return !std::isfinite(v); };
  if (is_bad(o.x())) return bad_field(field + ".origin_m.x", o.x(), "finite");
  if (is_bad(o.y())) return bad_field(field + ".origin_m.y", o.y(), "finite");
  if (is_bad(o.z())) return bad_field(field + ".origin_m.z", o.z(), "finite");
  return PointArray{{o.x(), o.y(), o.z()}, view(points.offsets_m())};
}

absl::StatusOr<std::span<const float>> check_triples(
    const std::string& field, const google::protobuf::RepeatedField<float>& v, std::size_t items,
    const std::string& of, bool optional) {
  const auto length = static_cast<std::size_t>(v.size());
  if (length == 3 * items || (optional && v.empty())) return view(v);
  return bad_length(
      field, length, 3 * items,
      fmt::format("three for each of the {} {}{}", items, of, optional ? ", or none" : ""));
}

absl::StatusOr<double> check_time(double time_s) {
  if (std::isfinite(time_s)) return time_s;
  return bad_field("time_s", time_s, "finite");
}

absl::Status check_lease(double lease_s) {
  if (lease_s >= 0 && std::isfinite(lease_s)) return absl::OkStatus();
  return bad_field("lease_s", lease_s, "[0, inf)");
}

absl::StatusOr<std::optional<float>> check_position_error(bool has, float position_error_m) {
  if (!has) return std::optional<float>();
  if (!std::isfinite(position_error_m) || position_error_m < 0) {
    return bad_field("position_error_m", position_error_m, "[0, inf)");
  }
  return std::optional<float>(position_error_m);
}

absl::StatusOr<std::span<const double>> check_wavelengths(
    const google::protobuf::RepeatedField<double>& wavelengths_nm) {
  const std::span<const double> nm = view(wavelengths_nm);
  if (nm.size() > kMostWavelengths) {
    return bad_field("wavelengths_nm", fmt::format("{} numbers", nm.size()),
                     "at most {} in one request", kMostWavelengths);
  }
  for (std::size_t i = 0; i < nm.size(); ++i) {
    if (!(nm[i] >= 100 && nm[i] <= 1e6)) {
      return bad_field(fmt::format("wavelengths_nm[{}]", i), nm[i], "[100, 1e6] nm");
    }
  }
  return nm;
}

absl::Status check_grey_media(const Scene& scene, std::span<const double> wavelengths_nm) {
  if (wavelengths_nm.empty() || scene.geometry().media_are_grey()) return absl::OkStatus();
  return bad_field("wavelengths_nm", fmt::format("{} numbers", wavelengths_nm.size()),
                   "none in this scene, since its media have a colour and no spectrum");
}

absl::Status check_answer_size(const CallContext& context, const std::string& field,
                               std::uint64_t items, const AnswerSize& size) {
  const std::uint64_t most = size.items_within(context.limits.max_message_bytes);
  if (items <= most) return absl::OkStatus();
  return over_limit(fmt::format("{} ({} bytes each in the answer)", field, size.per_item), items,
                    most);
}

std::uint8_t* fill_bits(std::string* bits, std::size_t n) {
  bits->assign((n + 7) / 8, '\0');
  return reinterpret_cast<std::uint8_t*>(bits->data());
}

void drop_if_all_ok(google::protobuf::RepeatedField<int>* status) {
  const auto ok = static_cast<int>(ItemResult::kOk);
  if (std::all_of(status->begin(), status->end(), [&](int s) { return s == ok; })) status->Clear();
}

void set_counts(v1::Cost* cost, const WorkCounts& work) {
  cost->set_samples(work.samples);
  cost->set_camera_rays(work.camera_rays);
  cost->set_indirect_rays(work.indirect_rays);
  cost->set_shadow_rays(work.shadow_rays);
  cost->set_shadow_map_lookups(work.map_lookups);
  cost->set_shadow_map_compared(work.map_compared);
  cost->set_shadow_map_disagreed(work.map_disagreed);
  cost->set_through_thin_glass(work.through_panes);
}

}  // namespace lucerna::rpc
