#include "server/rpc/handlers/light_edits.h"

#include <fmt/core.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <cmath>
#include <memory>
#include <utility>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/files/printable.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/scene_manifest.h"
#include "server/scene/create_light.h"

namespace lucerna::rpc {
namespace {

constexpr double kMostFactor = 1e9;
// Lights that requests add have no place in a file.
constexpr const char* kAddedSource = "(added)";

absl::Status check_factor(const std::string& field, double value) {
  if (value >= 0 && value <= kMostFactor) return absl::OkStatus();
  return bad_field(field, value, "[0, {}]", kMostFactor);
}

absl::Status check_finite(const std::string& field, double value) {
  if (std::isfinite(value)) return absl::OkStatus();
  return bad_field(field, value, "a finite number");
}

absl::Status check_finite(const std::string& field, const v1::Vector3& v) {
  LUCERNA_RETURN_IF_ERROR(check_finite(field + ".x", v.x()));
  LUCERNA_RETURN_IF_ERROR(check_finite(field + ".y", v.y()));
  return check_finite(field + ".z", v.z());
}

absl::Status check_change(const std::string& field, const v1::LightChange& change) {
  if (change.has_scale()) LUCERNA_RETURN_IF_ERROR(check_factor(field + ".scale", change.scale()));
  if (change.has_tint()) {
    LUCERNA_RETURN_IF_ERROR(check_factor(field + ".tint.r", change.tint().r()));
    LUCERNA_RETURN_IF_ERROR(check_factor(field + ".tint.g", change.tint().g()));
    LUCERNA_RETURN_IF_ERROR(check_factor(field + ".tint.b", change.tint().b()));
  }
  if (!change.has_placement()) return absl::OkStatus();
  const v1::LightPlacement& place = change.placement();
  LUCERNA_RETURN_IF_ERROR(check_finite(field + ".placement.shift_m", place.shift_m()));
  LUCERNA_RETURN_IF_ERROR(check_finite(field + ".placement.turn_axis", place.turn_axis()));
  LUCERNA_RETURN_IF_ERROR(check_finite(field + ".placement.turn_rad", place.turn_rad()));
  const v1::Vector3& axis = place.turn_axis();
  if (place.turn_rad() != 0 && axis.x() == 0 && axis.y() == 0 && axis.z() == 0)
    return bad_field(field + ".placement.turn_axis", "(0, 0, 0)", "an axis for the turn");
  return absl::OkStatus();
}

absl::StatusOr<SpotProfile> spot_profile(const std::string& field, v1::SpotProfile profile) {
  switch (profile) {
    case v1::SPOT_PROFILE_UNSPECIFIED:
    case v1::SPOT_PROFILE_SMOOTHSTEP:
      return SpotProfile::kSmoothstep;
    case v1::SPOT_PROFILE_QUARTIC:
      return SpotProfile::kQuartic;
    case v1::SPOT_PROFILE_QUADRATIC:
      return SpotProfile::kQuadratic;
    default:
      return bad_field(field, static_cast<int>(profile), "[0, {}], the numbers of SpotProfile",
                       static_cast<int>(v1::SpotProfile_MAX));
  }
}

Vec3 vector(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }
Rgb colour(const v1::Rgb& c) { return {c.r(), c.g(), c.b()}; }

/// The parameters of a light; its model checks their values.
absl::StatusOr<LightParams> params_of(const std::string& field, const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return PointLightParams{vector(light.point().position_m()),
                              colour(light.point().intensity_cd())};
    case v1::Light::kSpot: {
      LUCERNA_ASSIGN_OR_RETURN(const SpotProfile profile,
                               spot_profile(field + ".spot.profile", light.spot().profile()));
      return SpotLightParams{.position_m = vector(light.spot().position_m()),
                             .axis = vector(light.spot().axis()),
                             .intensity_cd = colour(light.spot().intensity_cd()),
                             .cone_half_angle_rad = light.spot().cone_half_angle_rad(),
                             .falloff_start_rad = light.spot().falloff_start_rad(),
                             .profile = profile};
    }
    case v1::Light::kDistant:
      return DistantLightParams{vector(light.distant().to_light()),
                                colour(light.distant().illuminance_lx())};
    case v1::Light::kSun:
      return SunLightParams{vector(light.sun().to_light()), light.sun().angular_diameter_rad(),
                            colour(light.sun().illuminance_lx())};
    case v1::Light::kUniformInfinite:
      return UniformInfiniteLightParams{colour(light.uniform_infinite().radiance_cd_m2())};
    default:
      return bad_field(field + ".kind",
                       light.kind_case() == v1::Light::KIND_NOT_SET ? "none" : "another",
                       "point, spot, distant, sun, uniform_infinite");
  }
}

absl::StatusOr<LightDescription> put_light(const std::string& field, const v1::Light& light) {
  if (!light.name().empty() && !is_light_name(light.name()))
    return bad_field(field + ".name", fmt::format("\"{}\"", printable(light.name())),
                     "at most 256 bytes of UTF-8 without control characters");
  if (light.has_spectrum())
    return bad_field(field + ".spectrum", "set", "unset; the kind has the RGB values");
  if (light.has_motion()) return bad_field(field + ".motion", "set", "unset");
  LUCERNA_ASSIGN_OR_RETURN(LightParams params, params_of(field, light));
  LightDescription described{.params = std::move(params), .where = {.file = kAddedSource}};
  if (light.samples_per_light() > kMostSamplesPerLight)
    return bad_field(field + ".samples_per_light", light.samples_per_light(), "[0, {}]",
                     kMostSamplesPerLight);
  described.samples = std::max(light.samples_per_light(), 1U);
  described.name = light.name();
  // Reports bad values with the field of the request.
  if (absl::Status s = create_light(described, {}).status(); !s.ok())
    return absl::InvalidArgumentError(fmt::format("{}: {}", field, std::string(s.message())));
  return described;
}

/// The bytes of a light that determine its answers.
std::string content_of(const v1::Light& light) {
  v1::Light kept = light;
  kept.clear_id();
  kept.clear_source();
  kept.clear_bounds();
  kept.clear_power_lm();
  kept.clear_power_error_lm();
  kept.clear_power_unit();
  kept.clear_directions();
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream out(&stream);
    out.SetSerializationDeterministic(true);
    kept.SerializeToCodedStream(&out);
  }
  return "put:" + bytes;
}

/// Errors: a surface that cannot be added.
absl::Status check_surface(const ShapeDescription& shape, const std::deque<Material>& materials) {
  const auto refused = [&](const char* what, const char* allowed) {
    return located(absl::InvalidArgumentError(fmt::format(
                       "{} in a file whose lights are added, allowed: {}", what, allowed)),
                   shape.where);
  };
  if (!shape.emission) return refused("a shape that does not emit", "shapes that emit");
  if (shape.motion) return refused("a shape that moves", "shapes that do not move");
  if (!shape.alpha.is_constant() || shape.alpha.constant < 1)
    return refused("a cut-out shape", "an \"alpha\" of 1");
  if (shape.media) return refused("a shape between media", "shapes without media");
  if (materials[shape.material].plain_diffuse() == nullptr)
    return refused("a shape of another material", "diffuse without textures");
  return absl::OkStatus();
}

/// The error of a file that does not fit beside those before it.
absl::Status too_large(const std::string& field, const absl::Status& status) {
  absl::Status named(status.code(), fmt::format("{}: {}", field, std::string(status.message())));
  status.ForEachPayload(
      [&](absl::string_view type, const absl::Cord& payload) { named.SetPayload(type, payload); });
  return load_error(std::move(named));
}

struct EditedLights {
  LightEdits edits;                   ///< all of the scene's, not only the new ones
  std::vector<MissingAsset> missing;  ///< of added files; if any, `edits` is incomplete
  std::vector<std::uint64_t> new_ids;
  std::shared_ptr<SceneStore::LoadMemory> memory;  ///< of added files
};

/// Applies edits one after another.
class Editor {
 public:
  Editor(const CallContext& context, const Scene& scene, const std::stop_token& stop)
      : context_(context), stop_(stop), ids_(scene.edits().added) {
    result_.edits = scene.edits();
    result_.memory = context.scenes.start_counting();
    loaded_ids_ = scene.without_edits().lights().size();
  }

  absl::Status apply(const std::string& field, const v1::LightEdit& edit) {
    switch (edit.edit_case()) {
      case v1::LightEdit::kPut:
        return put(field + ".put", edit.put());
      case v1::LightEdit::kRemove:
        return remove(edit.remove());
      case v1::LightEdit::kChange:
        return change(edit.change());
      case v1::LightEdit::kAdd:
        return add(field + ".add", edit.add());
      default:
        return absl::InternalError("an edit without a kind");
    }
  }
  EditedLights take() && { return std::move(result_); }

 private:
  bool exists(std::uint64_t id) const {
    const LightEdits& edits = result_.edits;
    if (edits.added.contains(id)) return true;
    if (id < 1 || id > loaded_ids_) return false;
    const auto change = edits.changes.find(id);
    return change == edits.changes.end() || !change->second.is_removed;
  }

  absl::Status remove(std::uint64_t id) {
    if (!exists(id)) return unknown_light(id);
    result_.edits.added.erase(id);
    ids_.free(id);
    result_.edits.changes.erase(id);
    if (id <= loaded_ids_) result_.edits.changes[id].is_removed = true;
    return absl::OkStatus();
  }

  absl::Status change(const v1::LightChange& given) {
    const std::uint64_t id = given.light_id();
    if (!exists(id)) return unknown_light(id);
    LightChange& c = result_.edits.changes[id];
    if (given.has_scale()) c.scale = given.scale();
    if (given.has_tint()) c.tint = colour(given.tint());
    if (given.has_on()) c.is_off = !given.on();
    if (given.has_placement()) {
      const v1::LightPlacement& place = given.placement();
      const bool has_turn = place.has_turn_axis() || place.turn_rad() != 0;
      const bool is_back = !place.has_shift_m() && !has_turn;
      if (place.has_shift_m() || is_back) c.shift_m = vector(place.shift_m());
      if (has_turn || is_back) {
        c.turn_rad = place.turn_rad();
        c.turn_axis = c.turn_rad != 0 ? normalized(vector(place.turn_axis())) : Vec3();
      }
    }
    if (c == LightChange()) result_.edits.changes.erase(id);
    return absl::OkStatus();
  }

  absl::Status put(const std::string& field, const v1::Light& light) {
    if (light.id() != 0 && !exists(light.id())) return unknown_light(light.id());
    LUCERNA_ASSIGN_OR_RETURN(LightDescription described, put_light(field, light));
    insert(light.id(), {std::move(described), content_of(light)});
    return absl::OkStatus();
  }

  absl::Status add(const std::string& field, const v1::LightFile& file) {
    LUCERNA_ASSIGN_OR_RETURN(const SceneSource source,
                             check_scene_file(context_, field + ".", file));
    absl::StatusOr<SceneStore::Read> read =
        context_.scenes.read(source, {.stop = stop_}, *result_.memory);
    if (absl::IsResourceExhausted(read.status())) return too_large(field, read.status());
    LUCERNA_RETURN_IF_ERROR(read.status());
    for (MissingAsset& asset : read->missing) result_.missing.push_back(std::move(asset));
    if (!read->description) return absl::OkStatus();
    SceneDescription& scene = *read->description;
    if (!scene.instances.empty())
      return located(
          absl::InvalidArgumentError(
              "an instance in a file whose lights are added, allowed: lights and shapes that emit"),
          scene.instances.front().where);
    for (const ShapeDescription& shape : scene.shapes)
      LUCERNA_RETURN_IF_ERROR(check_surface(shape, scene.materials));
    const std::string files = scene_id(scene.assets);
    std::size_t number = 0;
    const auto content = [&] { return fmt::format("file:{}:{}", files, number++); };
    for (LightDescription& light : scene.lights) insert(0, {std::move(light), content()});
    for (ShapeDescription& shape : scene.shapes) {
      const Rgb reflectance = *scene.materials[shape.material].plain_diffuse();
      shape.has_uv = false;  // only textures of materials use them
      insert(0,
             {{}, content(), std::make_shared<const AddedSurface>(std::move(shape), reflectance)});
    }
    return absl::OkStatus();
  }

  void insert(std::uint64_t id, AddedLight light) {
    LightEdits& edits = result_.edits;
    if (id == 0) id = ids_.take(light.content);
    edits.changes.erase(id);
    edits.added[id] = std::move(light);
    result_.new_ids.push_back(id);
  }

  const CallContext& context_;
  const std::stop_token& stop_;
  AddedLightIds ids_;
  std::uint64_t loaded_ids_;
  EditedLights result_;
};

}  // namespace

absl::Status check_edits(const CallContext& context, const LightEditList& edits) {
  const auto n = static_cast<std::size_t>(edits.size());
  LUCERNA_RETURN_IF_ERROR(check_limit("edits", n, context.limits.max_batch_items));
  for (std::size_t i = 0; i < n; ++i) {
    const v1::LightEdit& edit = edits.Get(static_cast<int>(i));
    const std::string field = fmt::format("edits[{}]", i);
    switch (edit.edit_case()) {
      case v1::LightEdit::kPut:
        LUCERNA_RETURN_IF_ERROR(put_light(field + ".put", edit.put()).status());
        break;
      case v1::LightEdit::kRemove:
        break;
      case v1::LightEdit::kChange:
        LUCERNA_RETURN_IF_ERROR(check_change(field + ".change", edit.change()));
        break;
      case v1::LightEdit::kAdd:
        LUCERNA_RETURN_IF_ERROR(check_scene_file(context, field + ".add.", edit.add()).status());
        break;
      default:
        return bad_field(field + ".edit", "none", "put, remove, change, add");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<EditedScene> edited_scene(const CallContext& context, const StoredScene& scene,
                                         const LightEditList& edits, double lease_s,
                                         const std::stop_token& stop) {
  Editor editor(context, *scene.scene, stop);
  for (int i = 0; i < edits.size(); ++i) {
    if (stop.stop_requested()) return absl::CancelledError("the edit was cancelled");
    LUCERNA_RETURN_IF_ERROR(editor.apply(fmt::format("edits[{}]", i), edits.Get(i)));
  }
  EditedLights edited = std::move(editor).take();
  EditedScene result;
  if (!edited.missing.empty()) {
    result.revision.missing = std::move(edited.missing);
    return result;
  }
  absl::StatusOr<LoadedScene> revision = context.scenes.revise(
      scene, std::move(edited.edits), {lease_s, stop, {}, context.caller}, edited.memory.get());
  if (!revision.ok()) return load_error(revision.status());
  result.revision = *std::move(revision);
  result.new_ids = std::move(edited.new_ids);
  return result;
}

}  // namespace lucerna::rpc
