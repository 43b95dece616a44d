// Moves and adds surfaces of lights, without building everything else again.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"
#include "server/runtime/denormals.h"
#include "server/scene/scene_builder.h"
#include "server/scene/create_light.h"

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

/// Copies of the arrays that moves change.
GeometrySet copy_of(const GeometrySet& set) {
  GeometrySet copy;
  copy.vertices.reserve(set.vertices.size() + 1);  // Embree reads beyond the last vertex
  copy.vertices = set.vertices;
  copy.triangles = set.triangles;
  copy.patches = set.patches;
  copy.curves = set.curves;
  copy.quadrics = set.quadrics;
  copy.wide = set.wide;
  copy.unit_m = set.unit_m;
  copy.narrow_error_m = set.narrow_error_m;
  return copy;
}

/// A copy of the scene's own geometry with other shapes of lights.
class EditedSet {
 public:
  EditedSet(const PlacedSurfaces& from, PlacedSurfaces& to)
      : from_set_(from.accelerator->scene()), to_(to), set_(copy_of(from_set_)) {
    to_.surfaces = from.surfaces;
  }

  /// Puts a moved shape in its own place.  False if it has other primitives now.
  absl::StatusOr<bool> put(const ShapeDescription& shape, const Vec3& origin, double detail_m,
                           std::int32_t light) {
    GeometrySet piece;
    SurfaceTable alone;
    LUCERNA_RETURN_IF_ERROR(append_shape(shape, origin, detail_m, light, piece, alone));
    SurfaceTable& table = to_.surfaces;
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
    LUCERNA_RETURN_IF_ERROR(append_shape(shape, origin, detail_m, light, set_, to_.surfaces));
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
  GeometrySet take_set() { return std::move(set_); }
  std::vector<PrimitiveRange> take_moved() { return std::move(moved_); }

 private:
  void put_triangles(const GeometrySet& piece, const SurfaceTable& alone, std::uint32_t first) {
    // The vertices of a shape follow each other.
    const std::size_t vertex = set_.triangles[3 * std::size_t{first}] - piece.triangles[0];
    for (std::size_t i = 0; i < piece.vertices.size(); ++i)
      set_.vertices[vertex + i] =
          set_.unit_m == 1 ? piece.vertices[i] : Vec3f(Vec3(piece.vertices[i]) / set_.unit_m);
    replace(to_.surfaces.vertex_normals, vertex, alone.vertex_normals);
    replace(to_.surfaces.vertex_tangents, vertex, alone.vertex_tangents);
    const auto count = static_cast<std::uint32_t>(piece.triangles.size() / 3);
    std::erase_if(set_.wide, [&](const WideTriangle& w) { return w.triangle - first < count; });
    const auto after = std::ranges::lower_bound(set_.wide, first, {}, &WideTriangle::triangle);
    const auto put = set_.wide.insert(after, piece.wide.begin(), piece.wide.end());
    for (std::size_t i = 0; i < piece.wide.size(); ++i) put[i].triangle += first;
    set_.narrow_error_m = std::fmax(set_.narrow_error_m, piece.narrow_error_m);
  }

  void put_surfaces(const GeometrySet& piece, const SurfaceTable& alone, const Extent& at) {
    constexpr auto kPatches = static_cast<std::size_t>(HitKind::kPatch);
    replace(set_.patches, at.first[kPatches], piece.patches);
    replace(to_.surfaces.patch_normals, at.first[kPatches], alone.patch_normals);
    std::size_t kind = static_cast<std::size_t>(HitKind::kCurve) + 1;
    const auto put = [&](auto& into, const auto& by) { replace(into, at.first[kind++], by); };
    std::apply(
        [&](auto&... into) {
          std::apply([&](const auto&... by) { (put(into, by), ...); }, piece.quadrics);
        },
        set_.quadrics);
  }

  const GeometrySet& from_set_;
  PlacedSurfaces& to_;
  GeometrySet set_;
  std::vector<PrimitiveRange> moved_;
};

/// Whether other triangles than the set's wide ones would be wide.
bool changes_wide(const GeometrySet& set, double detail_m, double new_detail_m) {
  if (set.wide.size() >= kMostWideTriangles) return true;
  if (new_detail_m < detail_m) return set.narrow_error_m > kWideShare * new_detail_m;
  return new_detail_m > detail_m && std::ranges::any_of(set.wide, [&](const WideTriangle& w) {
           return ray_error_of(w.corners) <= kWideShare * new_detail_m;
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

/// The emission of a light without a picture and without a profile, as its file gives it.  Without
/// spectrum, name and number of samples, which a light keeps when it moves.
ShapeDescription::Emission emission_of(const Scene& scene, const SceneLight& light) {
  ShapeDescription::Emission emission{.radiance_cd_m2 = {}, .where = scene.source_of(light)};
  if (const auto* surface = dynamic_cast<const SurfaceLight*>(light.light.get())) {
    emission.radiance_cd_m2 = surface->emission().radiance_cd_m2;
    emission.two_sided = surface->emission().two_sided;
    emission.is_unseen = light.is_unseen;
  }
  return emission;
}

}  // namespace

bool MovableSurfaces::is_plain(const ShapeDescription& shape) {
  const auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry);
  return mesh != nullptr && mesh->normals.empty() && mesh->corner_uv.empty() &&
         mesh->colours.empty() && mesh->tangents.empty() && shape.alpha.is_constant() &&
         shape.alpha.constant >= 1 && !shape.media && !shape.is_interface && !shape.motion &&
         !shape.emission->picture && !shape.emission->panel;
}

void MovableSurfaces::add(ShapeDescription&& shape) {
  if (!is_plain(shape)) {
    kept_.emplace_back(std::make_unique<const ShapeDescription>(std::move(shape)));
    return;
  }
  auto& mesh = std::get<TriangleMeshData>(shape.geometry);
  kept_.emplace_back(PlainMesh{std::move(mesh.positions), std::move(mesh.indices)});
}

ShapeDescription MovableSurfaces::shape(std::size_t i, const Scene& loaded,
                                        const SceneLight& light) const {
  if (const auto* whole = std::get_if<std::unique_ptr<const ShapeDescription>>(&kept_[i]))
    return **whole;
  const auto& mesh = std::get<PlainMesh>(kept_[i]);
  ShapeDescription shape;
  shape.geometry = TriangleMeshData{mesh.positions, {}, mesh.indices};
  shape.emission = emission_of(loaded, light);
  return shape;
}

absl::StatusOr<std::optional<Bounds>> MovableSurfaces::still_bounds(std::size_t i) const {
  ShapeDescription plain;
  const ShapeDescription* shape = &plain;
  if (const auto* whole = std::get_if<std::unique_ptr<const ShapeDescription>>(&kept_[i])) {
    shape = whole->get();
    if (shape->motion) return std::nullopt;
  } else {
    const auto& mesh = std::get<PlainMesh>(kept_[i]);
    plain.geometry = TriangleMeshData{mesh.positions, {}, mesh.indices};
  }
  LUCERNA_ASSIGN_OR_RETURN(const Bounds bounds, shape_bounds(*shape));
  return bounds;
}

std::uint64_t MovableSurfaces::bytes() const {
  std::uint64_t sum = kept_.capacity() * sizeof(Kept);
  for (const Kept& kept : kept_) {
    if (const auto* whole = std::get_if<std::unique_ptr<const ShapeDescription>>(&kept))
      sum += sizeof(ShapeDescription) + array_bytes(**whole);
    else
      sum += std::get<PlainMesh>(kept).positions.capacity() * sizeof(Vec3) +
             std::get<PlainMesh>(kept).indices.capacity() * sizeof(std::uint32_t);
  }
  return sum;
}

absl::StatusOr<std::shared_ptr<const PlacedSurfaces>> Scene::place(const Scene& loaded,
                                                                   const SurfaceEdits& edits,
                                                                   const std::stop_token& stop) {
  const DenormalsAreZero denormals;
  const Stopwatch watch;
  const MovableSurfaces& movable = loaded.movable_;
  const PlacedSurfaces& from = *loaded.placed_;
  const auto count = static_cast<std::int32_t>(loaded.lights_.size());
  const std::uint64_t first_id = loaded.lights_.size() - movable.size() + 1;
  if (!movable.is_complete) return std::shared_ptr<const PlacedSurfaces>();
  // Those that `loaded` was built with are where they should be.
  MovedSurfaces moved = edits.moved;
  if (!from.edits.moved.empty()) {
    std::erase_if(moved, [&](const auto& m) { return edits.added.contains(m.first); });
    if (moved != from.edits.moved) return std::shared_ptr<const PlacedSurfaces>();
    moved.clear();
  }
  auto to = std::make_shared<PlacedSurfaces>();
  to->edits = edits;
  to->world_m = movable.others_m;
  double detail_m = movable.others_detail_m, old_detail_m = movable.others_detail_m;
  std::vector<EditedShape> shapes;
  const auto stopped = [&] { return stop.stop_requested(); };
  const auto cancelled = [] { return absl::CancelledError("the edit was cancelled"); };
  for (std::size_t i = 0; i < movable.size(); ++i) {
    if (stopped()) return cancelled();
    const std::uint64_t id = first_id + i;
    const auto change = moved.find(id);
    const bool is_moved = change != moved.end();
    if (is_moved) {
      shapes.push_back({id, movable.shape(i, loaded, loaded.lights_[id - 1]),
                        static_cast<std::int32_t>(id - 1), false});
      LUCERNA_RETURN_IF_ERROR(move_surface(id, change->second, shapes.back().shape));
    }
    LUCERNA_ASSIGN_OR_RETURN(const std::optional<Bounds> before, movable.still_bounds(i));
    if (!before) continue;
    Bounds unused;
    add_shape(*before, unused, old_detail_m);
    if (!is_moved) add_shape(*before, to->world_m, detail_m);
  }
  if (shapes.size() != static_cast<std::size_t>(std::ranges::count_if(
                           moved, [&](const auto& m) { return !edits.added.contains(m.first); })))
    return absl::InternalError("a surface to move that the scene does not have");
  std::int32_t number = count;
  for (const auto& [id, added] : edits.added) {
    if (stopped()) return cancelled();
    shapes.push_back({id, added.surface->shape, number++, true});
    if (const auto change = edits.moved.find(id); change != edits.moved.end())
      LUCERNA_RETURN_IF_ERROR(move_surface(id, change->second, shapes.back().shape));
  }
  for (const EditedShape& edited : shapes) {
    if (stopped()) return cancelled();
    LUCERNA_ASSIGN_OR_RETURN(const Bounds after, shape_bounds(edited.shape));
    add_shape(after, to->world_m, detail_m);
  }
  const auto changes = [&](const GeometrySet& set) {
    return changes_wide(set, old_detail_m, detail_m);
  };
  bool fits = !from.accelerator->empty() && origin_for(to->world_m) == loaded.origin_ &&
              !changes(from.accelerator->scene());
  for (std::uint32_t i = 0; fits && i < from.accelerator->object_count(); ++i)
    fits = !changes(from.accelerator->object(i));
  if (!fits) return std::shared_ptr<const PlacedSurfaces>();

  to->materials = with_materials(from.materials, edits, shapes);
  EditedSet edited_set(from, *to);
  for (const EditedShape& edited : shapes) {
    if (stopped()) return cancelled();
    if (edited.shape.emission->is_unseen) {
      // Rays do not meet it.
    } else if (edited.is_new) {
      LUCERNA_RETURN_IF_ERROR(
          edited_set.add(edited.shape, loaded.origin_, detail_m, edited.number));
    } else {
      LUCERNA_ASSIGN_OR_RETURN(const bool is_same, edited_set.put(edited.shape, loaded.origin_,
                                                                  detail_m, edited.number));
      if (!is_same) return std::shared_ptr<const PlacedSurfaces>();
    }
    absl::StatusOr<std::shared_ptr<const Light>> light =
        create_area_light(edited.shape, loaded.origin_);
    if (!light.ok()) return located(light.status(), edited.shape.emission->where);
    to->lights.emplace(edited.id, PlacedSurfaces::EditedLight{*std::move(light), edited.number});
  }
  if (edited_set.set().wide.size() > kMostWideTriangles)
    return std::shared_ptr<const PlacedSurfaces>();
  GeometrySet set = edited_set.take_set();
  if (from.accelerator->scene().sheer != nullptr) set.sheer = &to->surfaces;
  LUCERNA_ASSIGN_OR_RETURN(
      to->accelerator,
      Accelerator::with_moved(from.accelerator, std::move(set), edited_set.take_moved()));
  if (to->accelerator == nullptr) return std::shared_ptr<const PlacedSurfaces>();
  std::uint64_t bytes = to->accelerator->bytes() + to->surfaces.bytes();
  for (const auto& [id, edited] : to->lights) {
    const LightBytes own = edited.light->own_bytes();
    bytes += kLightHeapBytes + own.object + own.data;
  }
  bytes += bytes_of(to->edits.added);
  for (const auto& [id, added] : to->edits.added)
    bytes += sizeof(AddedSurface) + array_bytes(added.surface->shape);
  to->parts.push_back({"edited surfaces", bytes, 1e3 * watch.seconds(),
                       fmt::format("{} {} of lights that edits moved or added", shapes.size(),
                                   shapes.size() == 1 ? "surface" : "surfaces")});
  return to;
}

}  // namespace lucerna
