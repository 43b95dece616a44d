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

/// Moves the geometry of a shape.
struct ShapeMover {
  const LightMover& move;

  void operator()(TriangleMeshData& mesh) const { vertices(mesh); }
  void operator()(PatchMeshData& mesh) const { vertices(mesh); }
  void operator()(CurveData&) const {}  // does not emit
  template <typename Params>
  requires requires { typename QuadricOf<Params>; }
  void operator()(Params& p) const { move.transform(p.world_from_object); }

 private:
  template <typename Mesh>
  void vertices(Mesh& mesh) const {
    StopPoll poll;
    for (Vec3& p : mesh.positions) poll(), move.point(p);
    if (!move.turns()) return;
    const auto turn = [this](Vec3f& v) {
      Vec3 w(v);
      move.direction(w);
      v = Vec3f(w);
    };
    for (Vec3f& n : mesh.normals) poll(), turn(n);
    if constexpr (requires { mesh.tangents; })
      for (VertexTangent& t : mesh.tangents) poll(), turn(t.along_u);
  }
};

LightMover mover(const LightChange& change, const Vec3& anchor_m) {
  return {anchor_m, change.shift_m, change.turn_axis, change.turn_rad};
}

void append(std::string& out, double value) { out += fmt::format("{}:", value); }
void append(std::string& out, const Vec3& v) {
  append(out, v.x), append(out, v.y), append(out, v.z);
}

}  // namespace

Rgb changed_level(const LightChange& change, const Rgb& level) {
  return change.is_off ? Rgb() : level * change.scale * change.tint;
}

Rgb& level_of(LightParams& params) {
  return std::visit([](auto& p) -> Rgb& { return p.level(); }, params);
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
  const LightMover move = mover(change, place.anchor_m.value_or(Vec3()));
  std::visit([&](auto& p) { p.apply(move); }, light.params);
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
  const LightMover move = mover(change, bounds.lower * 0.5 + bounds.upper * 0.5);
  std::visit(ShapeMover{move}, shape.geometry);
  if (shape.emission->panel) move.direction(shape.emission->panel->tangent);
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
