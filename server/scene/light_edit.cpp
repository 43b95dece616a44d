#include "server/scene/light_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <variant>

#include "lights/maths/stop_poll.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/rays/surface_table.h"
#include "server/scene/create_light.h"

namespace lucerna {
namespace {

constexpr std::uint64_t kFirstAddedId = std::uint64_t{1} << 32U;
// What a map takes for each entry beside it: three pointers, a colour, and the allocator's
// rounding.
constexpr std::uint64_t kNodeBytes = 48;

/// The level of a light.  There is one overload for each kind, so a new kind does not compile until
/// it can be dimmed.
Rgb& level_of(PointLightParams& p) { return p.intensity_cd; }
Rgb& level_of(SpotLightParams& p) { return p.intensity_cd; }
Rgb& level_of(DistantLightParams& p) { return p.illuminance_lx; }
Rgb& level_of(SunLightParams& p) { return p.illuminance_lx; }
Rgb& level_of(UniformInfiniteLightParams& p) { return p.radiance_cd_m2; }
Rgb& level_of(ImageInfiniteLightParams& p) { return p.radiance_cd_m2; }
Rgb& level_of(GoniometricLightParams& p) { return p.intensity; }
Rgb& level_of(ProjectionLightParams& p) { return p.intensity_cd; }
Rgb& level_of(BeamLightParams& p) { return p.illuminance_lx; }
Rgb& level_of(PortalLightParams& p) { return p.radiance_cd_m2; }

/// Turns directions of a light, and moves points about the one that does not turn.
class Mover {
 public:
  Mover(const LightChange& change, const Vec3& anchor) : anchor_(anchor), shift_(change.shift_m) {
    if (change.turn_rad != 0)
      turn_ = Transform::rotate(change.turn_rad, change.turn_axis).value_or(Transform());
  }

  void operator()(TriangleMeshData& mesh) const { vertices(mesh); }
  void operator()(PatchMeshData& mesh) const { vertices(mesh); }
  void operator()(CurveData&) const {}  // does not emit
  template <typename Params>
  requires requires { typename QuadricOf<Params>; }
  void operator()(Params& p) const { p.world_from_object = map() * p.world_from_object; }
  void direction(Vec3& w) const {
    if (turn_) w = turn_->vector(w);
  }

  void operator()(PointLightParams& p) const { point(p.position_m); }
  void operator()(SpotLightParams& p) const {
    point(p.position_m), direction(p.axis), space(p.own_space);
  }
  void operator()(DistantLightParams& p) const { direction(p.to_light); }
  void operator()(SunLightParams& p) const { direction(p.to_light); }
  void operator()(UniformInfiniteLightParams&) const {}
  void operator()(ImageInfiniteLightParams& p) const { turn_map(p.world_from_map); }
  void operator()(GoniometricLightParams& p) const {
    point(p.position_m), frame(p.axes), space(p.own_space);
  }
  void operator()(ProjectionLightParams& p) const {
    point(p.position_m), frame(p.axes), space(p.own_space);
  }
  void operator()(BeamLightParams& p) const { point(p.position_m), frame(p.axes); }
  void operator()(PortalLightParams& p) const {
    for (Vec3& corner : p.corners_m) point(corner);
    turn_map(p.world_from_map);
  }

 private:
  template <typename Mesh>
  void vertices(Mesh& mesh) const {
    StopPoll poll;
    for (Vec3& p : mesh.positions) poll(), point(p);
    if (!turn_) return;
    const auto turn = [this](Vec3f& v) { v = Vec3f(turn_->vector(Vec3(v))); };
    for (Vec3f& n : mesh.normals) poll(), turn(n);
    if constexpr (requires { mesh.tangents; })
      for (VertexTangent& t : mesh.tangents) poll(), turn(t.along_u);
  }
  Transform map() const {
    const Transform shift = Transform::translate(shift_);
    if (!turn_) return shift;
    return Transform::translate(anchor_ + shift_) * *turn_ * Transform::translate(-anchor_);
  }
  void point(Vec3& p) const {
    // Exact without a turn, as a file with the new position is.
    p = (turn_ ? anchor_ + turn_->vector(p - anchor_) : p) + shift_;
  }
  void frame(Frame& axes) const { direction(axes.s), direction(axes.t), direction(axes.n); }
  void space(std::shared_ptr<const Frame>& axes) const {
    if (axes == nullptr) return;
    auto turned = std::make_shared<Frame>(*axes);
    frame(*turned);
    axes = std::move(turned);
  }
  void turn_map(Transform& world_from_map) const {
    if (turn_) world_from_map = *turn_ * world_from_map;
  }

  Vec3 anchor_, shift_;
  std::optional<Transform> turn_;
};

void append(std::string& out, double value) { out += fmt::format("{}:", value); }
void append(std::string& out, const Vec3& v) {
  append(out, v.x), append(out, v.y), append(out, v.z);
}

}  // namespace

Rgb changed_level(const LightChange& change, const Rgb& level) {
  return change.is_off ? Rgb() : level * change.scale * change.tint;
}

Rgb& level_of(LightParams& params) {
  return std::visit([](auto& p) -> Rgb& { return level_of(p); }, params);
}

absl::Status apply(const LightChange& change, LightDescription& light) {
  if (change.has_level()) {
    Rgb& level = level_of(light.params);
    level = changed_level(change, level);
    if (!change.keeps_spectrum()) light.spectrum = nullptr;
  }
  if (!change.has_place()) return absl::OkStatus();
  if (light.motion)
    return absl::InvalidArgumentError("the light moves by itself, allowed: lights without motion");
  const LightPlace place = place_of(light);
  if (!place.anchor_m && !(change.shift_m == Vec3()))
    return absl::InvalidArgumentError("the light is at infinity, allowed: turns");
  std::visit(Mover(change, place.anchor_m.value_or(Vec3())), light.params);
  return absl::OkStatus();
}

AddedLightIds::AddedLightIds(const std::map<std::uint64_t, AddedLight>& taken) {
  for (auto light = taken.lower_bound(kFirstAddedId); light != taken.end(); ++light)
    add(light->first);
}

std::uint64_t AddedLightIds::take(const std::string& content) {
  const std::string digest = sha256(content);
  std::uint64_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8U | static_cast<unsigned char>(digest[i]);
  std::uint64_t id = kFirstAddedId + number;
  const auto skip_taken = [&] {
    const auto after = runs_.upper_bound(id);
    if (after != runs_.begin()) id = std::max(id, std::prev(after)->second);
  };
  skip_taken();
  if (id == 2 * kFirstAddedId) {
    id = kFirstAddedId;
    skip_taken();
  }
  add(id);
  return id;
}

void AddedLightIds::add(std::uint64_t id) {
  std::uint64_t end = id + 1;
  auto after = runs_.upper_bound(id);
  if (after != runs_.end() && after->first == end) {
    end = after->second;
    after = runs_.erase(after);
  }
  if (after != runs_.begin() && std::prev(after)->second == id)
    std::prev(after)->second = end;
  else
    runs_.emplace(id, end);
}

void AddedLightIds::free(std::uint64_t id) {
  const auto after = runs_.upper_bound(id);
  if (after == runs_.begin()) return;
  const auto run = std::prev(after);
  const std::uint64_t end = run->second;
  if (id >= end) return;
  if (id + 1 < end) runs_.emplace(id + 1, end);
  if (run->first == id)
    runs_.erase(run);
  else
    run->second = id;
}

LightChange place_only(const LightChange& change) {
  return {.shift_m = change.shift_m, .turn_axis = change.turn_axis, .turn_rad = change.turn_rad};
}

absl::Status move_surface(std::uint64_t id, const LightChange& change, ShapeDescription& shape) {
  if (shape.motion)
    return absl::InvalidArgumentError(
        fmt::format("light {}: the light moves by itself, allowed: lights without motion", id));
  LUCERNA_ASSIGN_OR_RETURN(const Bounds bounds, shape_bounds(shape));
  const Mover mover(change, bounds.lower * 0.5 + bounds.upper * 0.5);
  std::visit(mover, shape.geometry);
  if (shape.emission->panel) mover.direction(shape.emission->panel->tangent);
  return absl::OkStatus();
}

absl::Status move_surfaces(const MovedSurfaces& moved, SceneDescription& scene) {
  std::uint64_t id = scene.lights.size();
  std::size_t found = 0;
  for (ShapeDescription& shape : scene.shapes) {
    if (!shape.emission) continue;
    const auto change = moved.find(++id);
    if (change == moved.end()) continue;
    ++found;
    LUCERNA_RETURN_IF_ERROR(move_surface(id, change->second, shape));
  }
  if (found == moved.size()) return absl::OkStatus();
  return absl::InternalError("a surface to move that the scene does not have");
}

std::uint64_t bytes_of(const std::map<std::uint64_t, AddedLight>& added) {
  std::uint64_t sum = 0;
  StopPoll poll;
  for (const auto& entry : added)
    poll(), sum += kNodeBytes + sizeof entry + entry.second.content.capacity() +
                   entry.second.light.name.capacity();
  return sum;
}

std::uint64_t LightEdits::bytes() const {
  return bytes_of(added) + changes.size() * (kNodeBytes + sizeof(decltype(changes)::value_type));
}

std::string LightEdits::canonical() const {
  std::string text;
  StopPoll poll;
  for (const auto& [id, c] : changes) {
    poll();
    text += fmt::format("light {}:", id);
    if (c.is_removed) {
      text += "removed:";
      continue;
    }
    const Rgb level = changed_level(c, Rgb(1));
    append(text, Vec3(level.r, level.g, level.b));
    append(text, c.shift_m);
    append(text, c.turn_axis * c.turn_rad);
  }
  for (const auto& [id, a] : added)
    poll(), text += fmt::format("added {}:{}:{}", id, a.content.size(), a.content);
  return text;
}

}  // namespace lucerna
