#include "server/scene/geometry_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"

namespace lucerna {
namespace {

// Rounds the entries to the values that Embree's float matrices hold.
Transform rounded_to_float(const Transform& t) {
  Transform::Matrix m = t.matrix();
  for (auto& row : m)
    for (double& v : row) v = static_cast<float>(v);
  return Transform::from_matrix(m).value_or(t);
}

/// Reserves the vertices and triangles of all meshes among `shapes`.  Vectors that grow would hold
/// them twice meanwhile.
void reserve(const ShapeList& shapes, bool with_moving, GeometrySet& set) {
  std::size_t vertices = 0, numbers = 0;
  StopPoll poll;
  for (const ShapeDescription& shape : shapes) {
    poll();
    if (shape.motion && !with_moving) continue;
    if (const auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry)) {
      vertices += mesh->positions.size();
      numbers += mesh->indices.size();
    } else if (const auto* patches = std::get_if<PatchMeshData>(&shape.geometry)) {
      // A flat patch becomes two triangles.
      vertices += patches->positions.size();
      if (patches->normals.empty()) numbers += patches->indices.size() / 4 * 6;
    }
  }
  // append_shape() leaves room for one more.  A scene without meshes has no array.
  if (vertices > 0) set.vertices.reserve(vertices + 1);
  set.triangles.reserve(numbers);
}

/// Frees unused room behind `spare` elements, if it is more than a sixteenth of what is used.
template <typename T>
void fit(std::vector<T>& values, std::size_t spare) {
  const std::size_t used = values.size() + spare;
  if (values.capacity() - std::min(values.capacity(), used) <= used / 16) return;
  std::vector<T> fitted;
  fitted.reserve(used);
  fitted.assign(values.begin(), values.end());
  values = std::move(fitted);
}

void fit(GeometrySet& set) {
  fit(set.vertices, set.triangles.empty() ? 0 : 1);  // Embree reads beyond the last vertex
  fit(set.triangles, 0);
}

/// Reserved and not filled yet.
std::uint64_t unused_bytes(const GeometrySet& set) {
  return (set.vertices.capacity() - set.vertices.size()) * sizeof set.vertices[0] +
         (set.triangles.capacity() - set.triangles.size()) * sizeof set.triangles[0];
}

/// Builds a geometry step by step.
class GeometryBuilder {
 public:
  GeometryBuilder(SceneDescription& scene, const ShapeExtents& extents, const Vec3& origin,
                  const std::stop_token& stop, LoadBudget* budget)
      : in_(scene), extents_(extents), origin_(origin), stop_(stop), budget_(budget) {}

  absl::StatusOr<std::shared_ptr<const SceneGeometry>> build(bool has_cut_lights,
                                                             const MovedSurfaces& moved,
                                                             const std::string& isa);

 private:
  absl::Status append(ShapeDescription& shape, const Vec3& origin, std::int32_t light,
                      GeometrySet& set, SurfaceTable& table);
  /// Notes whether rays find a mirror or a pane in the shape that was appended last.
  void note_smooth(const ShapeDescription& shape, bool emits, SurfaceTable& table);
  /// Frees the arrays of a shape that was appended.
  void drop(ShapeDescription& shape);
  absl::Status add_shapes();
  absl::Status add_objects();
  absl::Status add_instances();
  std::shared_ptr<const SurfaceMaterials> take_materials();
  void connect_textures();
  void report_movable();
  void report_primitives(const Stopwatch& watch);
  void report_surfaces(const SurfaceMaterials& materials, const Stopwatch& watch);

  std::shared_ptr<const Motion> about_scene(const Motion& motion, const Vec3& from) const {
    return std::make_shared<const Motion>(motion.about(from, origin_));
  }
  void part(std::string name, std::uint64_t bytes, const Stopwatch& watch, std::string why) {
    parts_.push_back({std::move(name), bytes, 1e3 * watch.seconds(), std::move(why)});
  }

  SceneDescription& in_;
  const ShapeExtents& extents_;
  const Vec3& origin_;
  const std::stop_token& stop_;
  LoadBudget* budget_;  // null: no limit
  std::shared_ptr<FixedGeometry> fixed_ = std::make_shared<FixedGeometry>();
  std::shared_ptr<SurfaceTable> surfaces_ = std::make_shared<SurfaceTable>();
  GeometrySet set_;
  std::vector<GeometrySet> objects_;
  std::vector<GeometryInstance> instances_;
  std::vector<ScenePart> parts_;
  std::uint64_t read_by_embree_ = 0;  // bytes of geometry that Embree reads and also counts
};

/// Appends the shape and frees its arrays.  Leaves out a light that rays do not meet.
absl::Status GeometryBuilder::append(ShapeDescription& shape, const Vec3& origin,
                                     std::int32_t light, GeometrySet& set, SurfaceTable& table) {
  if (shape.emission && shape.emission->is_unseen) {
    if (shape.motion) drop(shape);
    return absl::OkStatus();
  }
  // What is reserved takes no memory before it is filled, and meshes are freed meanwhile.
  const auto bytes = [&] { return set.bytes() - unused_bytes(set) + table.bytes(); };
  const std::uint64_t before = bytes();
  {
    // The arrays for rays take less than those of the description.
    LoadBudget::Share work(budget_);
    LUCERNA_RETURN_IF_ERROR(work.resize(array_bytes(shape)));
    LUCERNA_RETURN_IF_ERROR(append_shape(shape, origin, extents_.detail_m, light, set, table));
  }
  // The budget counts the arrays for rays until the end of the load.
  if (budget_ != nullptr) LUCERNA_RETURN_IF_ERROR(budget_->claim(bytes() - before));
  // Edits can move a light that does not move by itself.
  if (!shape.emission || shape.motion) drop(shape);
  note_smooth(shape, light >= 0, table);
  return absl::OkStatus();
}

void GeometryBuilder::note_smooth(const ShapeDescription& shape, bool emits, SurfaceTable& table) {
  if (shape.is_interface) return;
  const auto of_scene = [&](std::uint32_t i) -> const Material& { return in_.materials[i]; };
  const SmoothTraits traits = smooth_traits(of_scene, shape.material);
  if (traits.is_smooth() || traits.is_glossy() || traits.is_nearly_smooth ||
      traits.has_roughness_texture)
    table.smooth.push_back({static_cast<std::uint32_t>(table.surfaces.size() - 1), shape.where});
  // A pane that emits is met by all rays, which find its light.
  const Material& material = in_.materials[shape.material];
  const auto* pane = std::get_if<ThinDielectricParams>(&material.params);
  if (pane != nullptr && material.normal_map < 0 && !emits) {
    table.surfaces.back().pane_eta = pane->eta;
    fixed_->has_panes = true;
  }
  fixed_->has_panes |= table.surfaces.back().is_sheet();
}

void GeometryBuilder::drop(ShapeDescription& shape) {
  const std::uint64_t held = std::min(listed_bytes(shape), in_.held_bytes);
  if (auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry)) *mesh = {};
  if (auto* mesh = std::get_if<PatchMeshData>(&shape.geometry)) *mesh = {};
  if (auto* curves = std::get_if<CurveData>(&shape.geometry)) *curves = {};
  in_.held_bytes -= held;
  if (budget_ != nullptr) budget_->release(held);
}

absl::Status GeometryBuilder::add_shapes() {
  auto light = static_cast<std::int32_t>(in_.lights.size());
  std::size_t moving_shape = 0;
  reserve(in_.shapes, false, set_);
  // A list that grows would copy the arrays of its shapes.
  fixed_->movable.reserve(static_cast<std::size_t>(std::ranges::count_if(
      in_.shapes, [](const ShapeDescription& s) { return s.emission.has_value(); })));
  for (; !in_.shapes.empty(); in_.shapes.pop_front()) {
    ShapeDescription& s = in_.shapes.front();
    LUCERNA_RETURN_IF_ERROR(check_stop(stop_));
    const std::int32_t emitter = s.emission ? light++ : -1;
    if (!s.motion) {
      LUCERNA_RETURN_IF_ERROR(append(s, origin_, emitter, set_, *surfaces_));
      if (s.emission) fixed_->movable.add(std::move(s));
      continue;
    }
    // A moving shape is an object about its own origin with one instance.
    const Vec3& origin = extents_.moving_origins[moving_shape];
    const std::size_t object = in_.objects.size() + moving_shape++;
    LUCERNA_RETURN_IF_ERROR(append(s, origin, emitter, objects_[object], fixed_->objects[object]));
    if (!objects_[object].empty())
      instances_.push_back(
          {static_cast<std::uint32_t>(object), Transform(), about_scene(*s.motion, origin)});
    if (s.emission) fixed_->movable.add(std::move(s));
  }
  return absl::OkStatus();
}

absl::Status GeometryBuilder::add_objects() {
  std::vector<bool> is_placed(in_.objects.size());
  StopPoll poll;
  for (const auto& i : in_.instances) poll(), is_placed[i.object] = true;
  for (std::size_t i = 0; i < in_.objects.size(); ++i) {
    if (!is_placed[i]) continue;
    reserve(in_.objects[i].shapes, true, objects_[i]);
    for (ShapeList& of_object = in_.objects[i].shapes; !of_object.empty(); of_object.pop_front()) {
      LUCERNA_RETURN_IF_ERROR(check_stop(stop_));
      LUCERNA_RETURN_IF_ERROR(append(of_object.front(), extents_.object_origins[i], -1, objects_[i],
                                     fixed_->objects[i]));
    }
  }
  return absl::OkStatus();
}

absl::Status GeometryBuilder::add_instances() {
  for (const auto& i : in_.instances) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop_));
    if (objects_[i.object].empty()) continue;
    const Transform scene_from_object = Transform::translate(-origin_) * i.world_from_object *
                                        Transform::translate(extents_.object_origins[i.object]);
    if (i.motion)
      instances_.push_back({i.object, scene_from_object, about_scene(*i.motion, origin_)});
    else
      instances_.push_back({i.object, rounded_to_float(scene_from_object)});
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const SceneGeometry>> GeometryBuilder::build(
    bool has_cut_lights, const MovedSurfaces& moved, const std::string& isa) {
  Stopwatch watch;
  objects_.resize(in_.objects.size() + extents_.moving_origins.size());
  fixed_->objects.resize(objects_.size());
  fixed_->has_cut_lights = has_cut_lights;
  fixed_->movable.others_m = extents_.others_m;
  fixed_->movable.others_detail_m = extents_.others_detail_m;
  fixed_->media = std::move(in_.media);
  fixed_->surrounding_medium = in_.surrounding_medium;
  if (const std::vector<Medium>& media = fixed_->media; !media.empty())
    part("media", media.capacity() * sizeof(Medium), watch,
         fmt::format("{} media that absorb light", media.size()));
  LUCERNA_RETURN_IF_ERROR(add_shapes());
  LUCERNA_RETURN_IF_ERROR(add_objects());
  LUCERNA_RETURN_IF_ERROR(add_instances());
  fit(set_);
  for (GeometrySet& object : objects_) fit(object);
  connect_textures();
  const bool is_empty = set_.empty() && instances_.empty();
  auto materials = is_empty ? std::make_shared<const SurfaceMaterials>() : take_materials();
  report_primitives(watch);
  report_surfaces(*materials, watch);
  report_movable();
  in_.objects = {};
  if (budget_ != nullptr) budget_->release(std::exchange(in_.held_bytes, 0));

  watch = Stopwatch();
  std::uint64_t primitives = set_.primitives();
  for (const GeometrySet& object : objects_) primitives += object.primitives();
  const std::string with_instances =
      instances_.empty() ? "" : fmt::format(", {} instances", instances_.size());
  GeometryData data{.origin = origin_,
                    .world_m = extents_.world_m,
                    .edits = {.moved = moved, .added = {}},
                    .fixed = fixed_,
                    .surfaces = surfaces_,
                    .materials = std::move(materials)};
  LUCERNA_ASSIGN_OR_RETURN(data.accelerator,
                           Accelerator::build(std::move(set_), std::move(objects_),
                                              std::move(instances_), isa, stop_, budget_));
  const std::uint64_t bytes = data.accelerator->bytes();
  if (!data.accelerator->empty())
    part("bvh", bytes > read_by_embree_ ? bytes - read_by_embree_ : 0, watch,
         fmt::format("rays against {} primitives{}", primitives, with_instances));
  data.parts = std::move(parts_);
  return std::make_shared<const SceneGeometry>(std::move(data));
}

/// Keeps the shapes of lights, so that edits can move them, unless they take much of the memory.
void GeometryBuilder::report_movable() {
  MovableSurfaces& movable = fixed_->movable;
  const std::uint64_t bytes = movable.bytes();
  movable.is_complete =
      bytes <= std::max(MovableSurfaces::kLeastBytes, std::uint64_t{set_.bytes()} / 100);
  if (!movable.is_complete) movable.clear();
  if (!movable.empty())
    part("movable surfaces", bytes, Stopwatch(), "shapes of lights, which edits can move");
}

/// Diffuse materials without textures keep only their reflectance, unless the scene has others.
std::shared_ptr<const SurfaceMaterials> GeometryBuilder::take_materials() {
  auto materials = std::make_shared<SurfaceMaterials>();
  for (const Material& m : in_.materials) {
    const Rgb* reflectance = m.plain_diffuse();
    materials->plain.push_back(reflectance != nullptr);
    materials->reflectances.push_back(reflectance != nullptr ? *reflectance : Rgb());
  }
  if (std::ranges::find(materials->plain, false) != materials->plain.end()) {
    materials->all.assign(std::make_move_iterator(in_.materials.begin()),
                          std::make_move_iterator(in_.materials.end()));
    if (fixed_->textures.empty()) fixed_->textures = std::move(in_.textures);
  }
  return materials;
}

/// Textures of non-opaque surfaces are needed even if all materials are plain.
void GeometryBuilder::connect_textures() {
  const auto connect = [&](GeometrySet& of, SurfaceTable& table, const Vec3& origin) {
    if (!table.has_non_opaque()) return;
    if (fixed_->textures.empty()) fixed_->textures = std::move(in_.textures);
    table.textures = &fixed_->textures;
    table.origin_m = origin;
    of.non_opaque = &table;
  };
  connect(set_, *surfaces_, origin_);
  const std::size_t objects = extents_.object_origins.size();
  for (std::size_t i = 0; i < objects_.size(); ++i)
    connect(objects_[i], fixed_->objects[i],
            i < objects ? extents_.object_origins[i] : extents_.moving_origins[i - objects]);
}

void GeometryBuilder::report_primitives(const Stopwatch& watch) {
  // Vertices, then primitives by HitKind.
  std::array<std::uint64_t, 1 + kHitKinds> counts{}, bytes{};
  std::uint64_t large = 0, large_bytes = 0;
  const auto count = [&](const GeometrySet& s) {
    std::size_t next = 0;
    const auto add = [&](const auto& v, std::size_t per = 1) {
      counts[next] += v.size() / per;
      bytes[next++] += v.capacity() * sizeof v[0];
    };
    add(s.vertices), add(s.triangles, 3);
    s.for_each_kind_of_surface([&](const auto& surfaces) { add(surfaces); });
    large += s.large.size(), large_bytes += s.large.capacity() * sizeof(LargeTriangle);
  };
  count(set_);
  for (const auto& o : objects_) count(o);
  struct Name {
    std::string one, many;
  };
  std::vector<Name> names{{"vertex", "vertices"},
                          {"triangle", "triangles"},
                          {"patch", "patches"},
                          {"piece of a curve", "pieces of curves"}};
  Quadrics::for_each([&]<typename Shape>() {
    names.push_back({std::string(Shape::kName), fmt::format("{}s", Shape::kName)});
  });
  for (std::size_t i = 0; i < names.size(); ++i)
    if (counts[i] > 0) {
      part(names[i].many, bytes[i], watch,
           fmt::format("{} {}", counts[i], counts[i] == 1 ? names[i].one : names[i].many));
      read_by_embree_ += bytes[i];
    }
  if (large > 0) {
    part("large triangles", large_bytes, watch,
         fmt::format("{} triangles that rays meet in double precision", large));
    read_by_embree_ += large_bytes;
  }
}

void GeometryBuilder::report_surfaces(const SurfaceMaterials& materials, const Stopwatch& watch) {
  std::uint64_t surface_bytes = surfaces_->bytes();
  for (const auto& t : fixed_->objects) surface_bytes += t.bytes();
  if (surface_bytes > 0)
    part("surfaces", surface_bytes, watch, "materials, shading normals and lights of surfaces");
  if (!materials.reflectances.empty())
    part("materials",
         materials.reflectances.capacity() * sizeof(Rgb) + materials.plain.capacity() / 8 +
             materials.all.capacity() * sizeof(Material),
         watch,
         materials.all.empty()
             ? fmt::format("{} diffuse reflectances", materials.reflectances.size())
             : fmt::format("{} materials", materials.all.size()));
  if (const Textures& textures = fixed_->textures; !textures.empty())
    part("textures", textures.bytes(), watch,
         fmt::format("{} textures of surfaces{}", textures.size(),
                     textures.limit_bytes() < std::numeric_limits<std::size_t>::max()
                         ? fmt::format("; pictures at most {} bytes", textures.limit_bytes())
                         : ""));
}

}  // namespace

void simplify_media(SceneDescription& scene) {
  const auto kept = [&](std::int32_t medium) {
    return medium >= 0 && scene.media[static_cast<std::size_t>(medium)].absorption_per_m.is_black()
               ? -1
               : medium;
  };
  const auto simplify = [&](ShapeList& shapes) {
    StopPoll poll;
    for (ShapeDescription& s : shapes) {
      poll();
      if (!s.media) continue;
      s.media = MediumSides{kept(s.media->inside), kept(s.media->outside)};
      if (s.media->inside == s.media->outside) s.media.reset();
    }
    const auto bounds_nothing = [](const auto& s) { return s.is_interface && !s.media; };
    shapes.erase(std::remove_if(shapes.begin(), shapes.end(), bounds_nothing), shapes.end());
    return std::ranges::any_of(shapes, [](const auto& s) { return s.media.has_value(); });
  };
  bool has_media = simplify(scene.shapes);
  for (ObjectDefinition& o : scene.objects) has_media = simplify(o.shapes) || has_media;
  scene.surrounding_medium = kept(scene.surrounding_medium);
  if (!has_media && scene.surrounding_medium < 0) scene.media = {};
}

absl::StatusOr<std::shared_ptr<const SceneGeometry>> build_geometry(
    SceneDescription& scene, const ShapeExtents& extents, const Vec3& origin, bool has_cut_lights,
    const MovedSurfaces& moved, const std::string& isa, const std::stop_token& stop,
    LoadBudget* budget) {
  return GeometryBuilder(scene, extents, origin, stop, budget).build(has_cut_lights, moved, isa);
}

}  // namespace lucerna
