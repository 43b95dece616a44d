#include "server/scene/moved_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"
#include "server/runtime/denormals.h"
#include "server/scene/create_light.h"
#include "server/scene/scene_frame.h"

namespace lucerna {
namespace {

/// Where the primitives of a shape begin in each kind, and how many there are.
struct Extent {
  std::array<std::uint32_t, kHitKinds> first{}, count{};
};

/// The primitives of a surface.
Extent extent_of(const SurfaceTable& table, const GeometrySet& set, std::uint32_t surface) {
  const auto all = set.counts();
  Extent extent;
  for (std::size_t kind = 0; kind < kHitKinds; ++kind) {
    const auto& runs = table.runs[kind];
    const auto from = std::ranges::find(runs, surface, &PrimitiveRun::surface);
    if (from == runs.end()) continue;
    const auto to =
        std::find_if(from, runs.end(), [&](const PrimitiveRun& r) { return r.surface != surface; });
    extent.first[kind] = from->first;
    extent.count[kind] =
        (to == runs.end() ? static_cast<std::uint32_t>(all[kind]) : to->first) - from->first;
  }
  return extent;
}

/// Whether the runs of a surface are those of a table with this surface alone.
bool has_same_runs(const SurfaceTable& table, std::uint32_t surface, const Extent& at,
                   const SurfaceTable& alone) {
  for (std::size_t kind = 0; kind < kHitKinds; ++kind) {
    auto run = std::ranges::find(table.runs[kind], surface, &PrimitiveRun::surface);
    for (const PrimitiveRun& other : alone.runs[kind]) {
      if (run == table.runs[kind].end() || run->surface != surface ||
          run->first - at.first[kind] != other.first ||
          run->first_light_primitive != other.first_light_primitive ||
          run->per_light_primitive != other.per_light_primitive)
        return false;
      ++run;
    }
    if (run != table.runs[kind].end() && run->surface == surface) return false;
  }
  return true;
}

/// Replaces values from `first` on.  Without values to put, there may be none to replace.
template <typename T>
void replace(std::vector<T>& values, std::size_t first, const std::vector<T>& by) {
  if (by.empty()) return;
  std::ranges::copy(by, values.begin() + static_cast<std::ptrdiff_t>(first));
}

GeometrySet copy_of(const GeometrySet& set) {
  GeometrySet copy = set;
  copy.non_opaque = nullptr;
  copy.vertices.reserve(copy.vertices.size() + 1);  // Embree reads beyond the last vertex
  return copy;
}

/// A copy of the scene's own geometry with other shapes of lights.
class EditedSet {
 public:
  explicit EditedSet(const SceneGeometry& from)
      : from_set_(from.accelerator().scene()),
        set_(copy_of(from_set_)),
        table_(std::make_shared<SurfaceTable>(from.surfaces())) {}

  /// Puts a moved shape in its own place.  False if it has other primitives now.
  absl::StatusOr<bool> put(const ShapeDescription& shape, const Vec3& origin, double detail_m,
                           std::int32_t light) {
    GeometrySet piece;
    SurfaceTable alone;
    LUCERNA_RETURN_IF_ERROR(append_shape(shape, origin, detail_m, light, piece, alone));
    SurfaceTable& table = *table_;
    const auto found = std::ranges::find(table.surfaces, light, &Surface::light);
    if (found == table.surfaces.end()) return absl::InternalError("a light without a surface");
    const auto surface = static_cast<std::uint32_t>(found - table.surfaces.begin());
    const Extent at = extent_of(table, from_set_, surface);
    const auto counts = piece.counts();
    if (!std::ranges::equal(at.count, counts) || !has_same_runs(table, surface, at, alone))
      return false;
    for (std::size_t kind = 0; kind < kHitKinds; ++kind)
      if (counts[kind] > 0)
        moved_.push_back({static_cast<HitKind>(kind), at.first[kind], at.count[kind]});
    if (!piece.triangles.empty()) put_triangles(piece, alone, at.first[0]);
    put_surfaces(piece, alone, at);
    return true;
  }

  /// Adds a shape after all others.
  absl::Status add(const ShapeDescription& shape, const Vec3& origin, double detail_m,
                   std::int32_t light) {
    const auto before = set_.counts();
    const std::size_t vertices = set_.vertices.size();
    LUCERNA_RETURN_IF_ERROR(append_shape(shape, origin, detail_m, light, set_, *table_));
    if (set_.unit_m != 1)
      for (std::size_t i = vertices; i < set_.vertices.size(); ++i)
        set_.vertices[i] = Vec3f(Vec3(set_.vertices[i]) / set_.unit_m);
    const auto after = set_.counts();
    for (std::size_t kind = 0; kind < kHitKinds; ++kind)
      if (after[kind] > before[kind])
        moved_.push_back({static_cast<HitKind>(kind), static_cast<std::uint32_t>(before[kind]),
                          static_cast<std::uint32_t>(after[kind] - before[kind])});
    return absl::OkStatus();
  }

  const GeometrySet& set() const { return set_; }
  const std::shared_ptr<SurfaceTable>& table() const { return table_; }
  GeometrySet take_set() { return std::move(set_); }
  std::vector<PrimitiveRange> take_moved() { return std::move(moved_); }

 private:
  void put_triangles(const GeometrySet& piece, const SurfaceTable& alone, std::uint32_t first) {
    // The vertices of a shape follow each other.
    const std::size_t vertex = set_.triangles[3 * std::size_t{first}] - piece.triangles[0];
    for (std::size_t i = 0; i < piece.vertices.size(); ++i)
      set_.vertices[vertex + i] =
          set_.unit_m == 1 ? piece.vertices[i] : Vec3f(Vec3(piece.vertices[i]) / set_.unit_m);
    replace(table_->vertex_normals, vertex, alone.vertex_normals);
    replace(table_->vertex_tangents, vertex, alone.vertex_tangents);
    const auto count = static_cast<std::uint32_t>(piece.triangles.size() / 3);
    std::erase_if(set_.large, [&](const LargeTriangle& w) { return w.triangle - first < count; });
    const auto after = std::ranges::lower_bound(set_.large, first, {}, &LargeTriangle::triangle);
    const auto put = set_.large.insert(after, piece.large.begin(), piece.large.end());
    for (std::size_t i = 0; i < piece.large.size(); ++i) put[i].triangle += first;
    set_.other_error_m = std::fmax(set_.other_error_m, piece.other_error_m);
  }

  void put_surfaces(const GeometrySet& piece, const SurfaceTable& alone, const Extent& at) {
    constexpr auto kPatches = static_cast<std::size_t>(HitKind::kPatch);
    replace(set_.patches, at.first[kPatches], piece.patches);
    replace(table_->patch_normals, at.first[kPatches], alone.patch_normals);
    std::size_t kind = static_cast<std::size_t>(HitKind::kCurve) + 1;
    const auto put = [&](auto& into, const auto& by) { replace(into, at.first[kind++], by); };
    std::apply(
        [&](auto&... into) {
          std::apply([&](const auto&... by) { (put(into, by), ...); }, piece.quadrics);
        },
        set_.quadrics);
  }

  const GeometrySet& from_set_;
  GeometrySet set_;
  std::shared_ptr<SurfaceTable> table_;
  std::vector<PrimitiveRange> moved_;
};

/// Whether other triangles than the set's large ones would be large.
bool changes_wide(const GeometrySet& set, double detail_m, double new_detail_m) {
  if (set.large.size() >= kMostLargeTriangles) return true;
  if (new_detail_m < detail_m) return set.other_error_m > kLargeShare * new_detail_m;
  return new_detail_m > detail_m && std::ranges::any_of(set.large, [&](const LargeTriangle& w) {
           return ray_error_of(w.corners) <= kLargeShare * new_detail_m;
         });
}

/// A shape of a light at its new place.
struct EditedShape {
  std::uint64_t id;
  ShapeDescription shape;
  std::int32_t number;  ///< Surface::light
  bool is_new;
};

/// The materials of a scene, and those of new surfaces.  Sets the number of each new one's.
std::shared_ptr<const SurfaceMaterials> with_materials(
    const std::shared_ptr<const SurfaceMaterials>& from, const SurfaceEdits& edits,
    std::vector<EditedShape>& shapes) {
  if (edits.added.empty()) return from;
  auto materials = std::make_shared<SurfaceMaterials>(*from);
  for (EditedShape& edited : shapes) {
    if (!edited.is_new) continue;
    const Rgb& reflectance = edits.added.at(edited.id).surface->reflectance;
    edited.shape.material = static_cast<std::uint32_t>(materials->plain.size());
    if (!materials->all.empty()) materials->all.push_back(diffuse_material(reflectance));
    materials->plain.push_back(true);
    materials->reflectances.push_back(reflectance);
  }
  return materials;
}

/// The shapes of lights that edits move and add, and the extents of all shapes with them.
struct EditedShapes {
  std::vector<EditedShape> shapes;
  Bounds world_m;
  double detail_m, old_detail_m;
};

absl::Status check_edit(const std::stop_token& stop) {
  return stop.stop_requested() ? absl::CancelledError("the edit was cancelled") : absl::OkStatus();
}

/// `moved`: the moves of lights of the file.
absl::Status add_moved(const MovableSurfaces& movable, const SceneLights& loaded,
                       const MovedSurfaces& moved, const std::stop_token& stop, EditedShapes& all) {
  const std::uint64_t first_id = loaded.size() - movable.size() + 1;
  for (std::size_t i = 0; i < movable.size(); ++i) {
    LUCERNA_RETURN_IF_ERROR(check_edit(stop));
    const std::uint64_t id = first_id + i;
    const auto change = moved.find(id);
    const bool is_moved = change != moved.end();
    if (is_moved) {
      all.shapes.push_back(
          {id, movable.shape(i, loaded, loaded[id - 1]), static_cast<std::int32_t>(id - 1), false});
      LUCERNA_RETURN_IF_ERROR(move_surface(id, change->second, all.shapes.back().shape));
    }
    LUCERNA_ASSIGN_OR_RETURN(const std::optional<Bounds> before, movable.still_bounds(i));
    if (!before) continue;
    Bounds unused;
    add_shape(*before, unused, all.old_detail_m);
    if (!is_moved) add_shape(*before, all.world_m, all.detail_m);
  }
  if (all.shapes.size() == moved.size()) return absl::OkStatus();
  return absl::InternalError("a surface to move that the scene does not have");
}

absl::StatusOr<EditedShapes> edited_shapes(const MovableSurfaces& movable,
                                           const SceneLights& loaded, const MovedSurfaces& moved,
                                           const SurfaceEdits& edits, const std::stop_token& stop) {
  EditedShapes all{.shapes = {},
                   .world_m = movable.others_m,
                   .detail_m = movable.others_detail_m,
                   .old_detail_m = movable.others_detail_m};
  LUCERNA_RETURN_IF_ERROR(add_moved(movable, loaded, moved, stop, all));
  auto number = static_cast<std::int32_t>(loaded.size());
  for (const auto& [id, added] : edits.added) {
    LUCERNA_RETURN_IF_ERROR(check_edit(stop));
    all.shapes.push_back({id, added.surface->shape, number++, true});
    if (const auto change = edits.moved.find(id); change != edits.moved.end())
      LUCERNA_RETURN_IF_ERROR(move_surface(id, change->second, all.shapes.back().shape));
  }
  for (const EditedShape& edited : all.shapes) {
    LUCERNA_RETURN_IF_ERROR(check_edit(stop));
    LUCERNA_ASSIGN_OR_RETURN(const Bounds after, shape_bounds(edited.shape));
    add_shape(after, all.world_m, all.detail_m);
  }
  return all;
}

/// Whether the geometry keeps its origin and its large triangles.
bool fits(const SceneGeometry& from, const EditedShapes& edited) {
  const auto changes = [&](const GeometrySet& set) {
    return changes_wide(set, edited.old_detail_m, edited.detail_m);
  };
  if (from.empty() || origin_for(edited.world_m) != from.origin() ||
      changes(from.accelerator().scene()))
    return false;
  for (std::uint32_t i = 0; i < from.accelerator().object_count(); ++i)
    if (changes(from.accelerator().object(i))) return false;
  return true;
}

/// False if a shape has other primitives now.
absl::StatusOr<bool> put(const EditedShapes& all, const Vec3& origin, const std::stop_token& stop,
                         EditedSet& set, GeometryData& to) {
  for (const EditedShape& edited : all.shapes) {
    LUCERNA_RETURN_IF_ERROR(check_edit(stop));
    if (edited.shape.emission->is_unseen) {
      // Rays do not meet it.
    } else if (edited.is_new) {
      LUCERNA_RETURN_IF_ERROR(set.add(edited.shape, origin, all.detail_m, edited.number));
    } else {
      LUCERNA_ASSIGN_OR_RETURN(const bool is_same,
                               set.put(edited.shape, origin, all.detail_m, edited.number));
      if (!is_same) return false;
    }
    absl::StatusOr<LightPointer> light = create_area_light(edited.shape, origin);
    if (!light.ok()) return located(light.status(), edited.shape.emission->where);
    to.edited_lights.emplace(edited.id,
                             GeometryData::EditedLight{*std::move(light), edited.number});
  }
  return set.set().large.size() <= kMostLargeTriangles;
}

std::uint64_t bytes_of(const GeometryData& to) {
  std::uint64_t bytes = to.accelerator->bytes() + to.surfaces->bytes();
  for (const auto& [id, edited] : to.edited_lights) {
    const LightBytes own = edited.light->own_bytes();
    bytes += kLightHeapBytes + own.object + own.data;
  }
  bytes += bytes_of(to.edits.added);
  for (const auto& [id, added] : to.edits.added)
    bytes += sizeof(AddedSurface) + array_bytes(added.surface->shape);
  return bytes;
}

}  // namespace

SurfaceEdits surface_edits(const SceneLights& loaded, const LightEdits& edits) {
  SurfaceEdits of;
  StopPoll poll;
  for (const auto& [id, light] : edits.added) {
    poll();
    if (light.surface != nullptr) of.added.emplace(id, light);
  }
  for (const auto& [id, change] : edits.changes) {
    poll();
    if (!change.has_place() || change.is_removed) continue;
    const bool is_of_file =
        id <= loaded.size() && !edits.added.contains(id) && loaded[id - 1].light->has_surface();
    if (is_of_file || of.added.contains(id)) of.moved[id] = place_only(change);
  }
  return of;
}

absl::StatusOr<std::shared_ptr<const SceneGeometry>> moved_geometry(const SceneGeometry& from,
                                                                    const SceneLights& loaded,
                                                                    const SurfaceEdits& edits,
                                                                    const std::stop_token& stop) {
  const DenormalsAreZero denormals;
  const Stopwatch watch;
  const std::shared_ptr<const SceneGeometry> none;
  const MovableSurfaces& movable = from.data().fixed->movable;
  if (!movable.is_complete) return none;
  // Those that `from` was built with are where they should be.
  MovedSurfaces moved = edits.moved;
  std::erase_if(moved, [&](const auto& m) { return edits.added.contains(m.first); });
  if (!from.edits().moved.empty()) {
    if (moved != from.edits().moved) return none;
    moved.clear();
  }
  LUCERNA_ASSIGN_OR_RETURN(EditedShapes all, edited_shapes(movable, loaded, moved, edits, stop));
  if (!fits(from, all)) return none;
  GeometryData to{.origin = from.origin(),
                  .world_m = all.world_m,
                  .edits = edits,
                  .fixed = from.data().fixed,
                  .materials = with_materials(from.data().materials, edits, all.shapes)};
  EditedSet edited(from);
  LUCERNA_ASSIGN_OR_RETURN(const bool is_same, put(all, from.origin(), stop, edited, to));
  if (!is_same) return none;
  to.surfaces = edited.table();
  GeometrySet set = edited.take_set();
  if (from.accelerator().scene().non_opaque != nullptr) set.non_opaque = to.surfaces.get();
  LUCERNA_ASSIGN_OR_RETURN(
      to.accelerator,
      Accelerator::with_moved(from.data().accelerator, std::move(set), edited.take_moved()));
  if (to.accelerator == nullptr) return none;
  to.parts.push_back({"edited surfaces", bytes_of(to), 1e3 * watch.seconds(),
                      fmt::format("{} {} of lights that edits moved or added", all.shapes.size(),
                                  all.shapes.size() == 1 ? "surface" : "surfaces")});
  return std::make_shared<const SceneGeometry>(std::move(to));
}

}  // namespace lucerna
