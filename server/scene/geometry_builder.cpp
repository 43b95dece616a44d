// Prepares the surfaces of a scene for rays.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"
#include "server/scene/scene_builder.h"

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

}  // namespace

/// Appends the shape and frees its arrays.  Leaves out a light that rays do not meet.
absl::Status Scene::Builder::append(ShapeDescription& shape, const Vec3& origin, std::int32_t light,
                                    GeometrySet& set, SurfaceTable& table) {
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
    LUCERNA_RETURN_IF_ERROR(append_shape(shape, origin, detail_m_, light, set, table));
  }
  // The budget counts the arrays for rays until the end of the load.
  if (budget_ != nullptr) LUCERNA_RETURN_IF_ERROR(budget_->claim(bytes() - before));
  // Edits can move a light that does not move by itself.
  if (!shape.emission || shape.motion) drop(shape);
  if (shape.is_interface) return absl::OkStatus();
  const auto of_scene = [&](std::uint32_t i) -> const Material& { return in_.materials[i]; };
  const SmoothTraits traits = smooth_traits(of_scene, shape.material);
  if (traits.is_smooth() || traits.is_glossy() || traits.is_nearly_smooth ||
      traits.has_roughness_texture)
    table.smooth.push_back({static_cast<std::uint32_t>(table.surfaces.size() - 1), shape.where});
  // A pane that emits is met by all rays, which find its light.
  const Material& material = in_.materials[shape.material];
  const auto* pane = std::get_if<ThinDielectricParams>(&material.params);
  if (pane != nullptr && material.normal_map < 0 && light < 0) {
    table.surfaces.back().pane_eta = pane->eta;
    scene_->has_panes_ = true;
  }
  scene_->has_panes_ |= table.surfaces.back().is_sheet();
  return absl::OkStatus();
}

void Scene::Builder::drop(ShapeDescription& shape) {
  const std::uint64_t held = std::min(listed_bytes(shape), in_.held_bytes);
  if (auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry)) *mesh = {};
  if (auto* mesh = std::get_if<PatchMeshData>(&shape.geometry)) *mesh = {};
  if (auto* curves = std::get_if<CurveData>(&shape.geometry)) *curves = {};
  in_.held_bytes -= held;
  if (budget_ != nullptr) budget_->release(held);
}

absl::Status Scene::Builder::build_geometry(const std::string& isa) {
  Stopwatch watch;
  GeometrySet set;
  std::vector<GeometrySet> objects(in_.objects.size() + moving_origins_.size());
  std::vector<GeometryInstance> instances;
  scene_->object_surfaces_.resize(objects.size());
  auto light = static_cast<std::int32_t>(in_.lights.size());
  std::size_t moving_shape = 0;
  reserve(in_.shapes, false, set);
  // A list that grows would copy the arrays of its shapes.
  scene_->movable_.reserve(static_cast<std::size_t>(std::ranges::count_if(
      in_.shapes, [](const ShapeDescription& s) { return s.emission.has_value(); })));
  for (; !in_.shapes.empty(); in_.shapes.pop_front()) {
    ShapeDescription& s = in_.shapes.front();
    LUCERNA_RETURN_IF_ERROR(check_stop());
    const std::int32_t emitter = s.emission ? light++ : -1;
    if (!s.motion) {
      LUCERNA_RETURN_IF_ERROR(append(s, scene_->origin_, emitter, set, placed_->surfaces));
      if (s.emission) scene_->movable_.add(std::move(s));
      continue;
    }
    // A moving shape is an object about its own origin with one instance.
    const Vec3& origin = moving_origins_[moving_shape];
    const std::size_t object = in_.objects.size() + moving_shape++;
    LUCERNA_RETURN_IF_ERROR(
        append(s, origin, emitter, objects[object], scene_->object_surfaces_[object]));
    if (!objects[object].empty())
      instances.push_back(
          {static_cast<std::uint32_t>(object), Transform(), about_scene(*s.motion, origin)});
    if (s.emission) scene_->movable_.add(std::move(s));
  }
  std::vector<bool> is_placed(in_.objects.size());
  StopPoll poll;
  for (const auto& i : in_.instances) poll(), is_placed[i.object] = true;
  for (std::size_t i = 0; i < in_.objects.size(); ++i) {
    if (!is_placed[i]) continue;
    reserve(in_.objects[i].shapes, true, objects[i]);
    for (ShapeList& of_object = in_.objects[i].shapes; !of_object.empty(); of_object.pop_front()) {
      LUCERNA_RETURN_IF_ERROR(check_stop());
      LUCERNA_RETURN_IF_ERROR(append(of_object.front(), object_origins_[i], -1, objects[i],
                                     scene_->object_surfaces_[i]));
    }
  }
  for (const auto& i : in_.instances) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    if (objects[i.object].empty()) continue;
    const Transform scene_from_object = Transform::translate(-scene_->origin_) *
                                        i.world_from_object *
                                        Transform::translate(object_origins_[i.object]);
    if (i.motion)
      instances.push_back({i.object, scene_from_object, about_scene(*i.motion, scene_->origin_)});
    else
      instances.push_back({i.object, rounded_to_float(scene_from_object)});
  }
  fit(set);
  for (GeometrySet& object : objects) fit(object);
  keep_textures(set, objects);
  report_motion(instances);
  if (!set.empty() || !instances.empty()) keep_materials();
  report_geometry(set, objects, watch);
  keep_movable(set.bytes());
  in_.objects = {};
  if (budget_ != nullptr) budget_->release(std::exchange(in_.held_bytes, 0));

  watch = Stopwatch();
  const std::size_t instance_count = instances.size();
  LUCERNA_ASSIGN_OR_RETURN(placed_->accelerator,
                           Accelerator::build(std::move(set), std::move(objects),
                                              std::move(instances), isa, stop_, budget_));
  if (placed_->accelerator->empty()) return absl::OkStatus();
  const std::uint64_t all = placed_->accelerator->bytes();
  part("bvh", all > read_by_embree_ ? all - read_by_embree_ : 0, watch,
       fmt::format("rays against {} primitives{}", scene_->primitive_count(),
                   instance_count > 0 ? fmt::format(", {} instances", instance_count) : ""));
  return absl::OkStatus();
}

/// Keeps the shapes of lights, so that edits can move them, unless they take much of the memory.
void Scene::Builder::keep_movable(std::uint64_t geometry_bytes) {
  MovableSurfaces& movable = scene_->movable_;
  const std::uint64_t bytes = movable.bytes();
  movable.is_complete = bytes <= std::max(MovableSurfaces::kLeastBytes, geometry_bytes / 100);
  if (!movable.is_complete) movable.clear();
  if (!movable.empty())
    part("movable surfaces", bytes, Stopwatch(), "shapes of lights, which edits can move");
}

/// Diffuse materials without textures keep only their reflectance, unless the scene has others.
void Scene::Builder::keep_materials() {
  auto materials = std::make_shared<SurfaceMaterials>();
  for (const Material& m : in_.materials) {
    const Rgb* reflectance = m.plain_diffuse();
    materials->plain.push_back(reflectance != nullptr);
    materials->reflectances.push_back(reflectance != nullptr ? *reflectance : Rgb());
  }
  if (std::ranges::find(materials->plain, false) != materials->plain.end()) {
    materials->all.assign(std::make_move_iterator(in_.materials.begin()),
                          std::make_move_iterator(in_.materials.end()));
    if (scene_->textures_.empty()) scene_->textures_ = std::move(in_.textures);
  }
  placed_->materials = std::move(materials);
}

/// Textures of sheer surfaces are needed even if all materials are plain.
void Scene::Builder::keep_textures(GeometrySet& set, std::vector<GeometrySet>& objects) {
  const auto connect = [&](GeometrySet& of, SurfaceTable& table, const Vec3& origin) {
    if (!table.has_sheer()) return;
    if (scene_->textures_.empty()) scene_->textures_ = std::move(in_.textures);
    table.textures = &scene_->textures_;
    table.origin_m = origin;
    of.sheer = &table;
  };
  connect(set, placed_->surfaces, scene_->origin_);
  for (std::size_t i = 0; i < objects.size(); ++i)
    connect(objects[i], scene_->object_surfaces_[i],
            i < object_origins_.size() ? object_origins_[i]
                                       : moving_origins_[i - object_origins_.size()]);
}

void Scene::Builder::report_motion(const std::vector<GeometryInstance>& instances) {
  std::uint64_t lights = 0, surfaces = 0, bytes = 0;
  for (const SceneLight& l : scene_->lights_) {
    if (l.moving == nullptr) continue;
    ++lights;
    bytes += sizeof(LightMotion) + l.moving->motion.bytes();
  }
  StopPoll poll;
  for (const GeometryInstance& i : instances) {
    poll();
    if (!i.motion) continue;
    ++surfaces;
    bytes += sizeof(Motion) + i.motion->bytes();
  }
  if (in_.camera.motion) bytes += sizeof(Motion) + in_.camera.motion->bytes();
  if (lights + surfaces == 0 && !in_.camera.motion) return;
  scene_->moves_ = true;
  scene_->others_move_ = surfaces > 0 || in_.camera.motion;
  part("motion", bytes, Stopwatch(),
       fmt::format("{} lights, {} shapes and instances{} move", lights, surfaces,
                   in_.camera.motion ? " and the camera" : ""));
}

void Scene::Builder::report_geometry(const GeometrySet& set,
                                     const std::vector<GeometrySet>& objects,
                                     const Stopwatch& watch) {
  // Vertices, then primitives by HitKind.
  std::array<std::uint64_t, 1 + kHitKinds> counts{}, bytes{};
  std::uint64_t surface_bytes = placed_->surfaces.bytes(), wide = 0, wide_bytes = 0;
  const auto count = [&](const GeometrySet& s) {
    std::size_t next = 0;
    const auto add = [&](const auto& v, std::size_t per = 1) {
      counts[next] += v.size() / per;
      bytes[next++] += v.capacity() * sizeof v[0];
    };
    add(s.vertices), add(s.triangles, 3);
    s.for_each_kind_of_surface([&](const auto& surfaces) { add(surfaces); });
    wide += s.wide.size(), wide_bytes += s.wide.capacity() * sizeof(WideTriangle);
  };
  count(set);
  for (const auto& o : objects) count(o);
  for (const auto& t : scene_->object_surfaces_) surface_bytes += t.bytes();
  struct Name {
    std::string one, many;
  };
#define LUCERNA_NAME(Shape) \
  , Name { std::string(Shape::kName), fmt::format("{}s", Shape::kName) }
  const std::array names{
      Name{"vertex", "vertices"}, Name{"triangle", "triangles"}, Name{"patch", "patches"},
      Name{"piece of a curve", "pieces of curves"} LUCERNA_QUADRICS(LUCERNA_NAME)};
#undef LUCERNA_NAME
  for (std::size_t i = 0; i < names.size(); ++i)
    if (counts[i] > 0) {
      part(names[i].many, bytes[i], watch,
           fmt::format("{} {}", counts[i], counts[i] == 1 ? names[i].one : names[i].many));
      read_by_embree_ += bytes[i];
    }
  if (wide > 0) {
    part("wide triangles", wide_bytes, watch,
         fmt::format("{} triangles that rays meet in double precision", wide));
    read_by_embree_ += wide_bytes;
  }
  if (surface_bytes > 0)
    part("surfaces", surface_bytes, watch, "materials, shading normals and lights of surfaces");
  if (const SurfaceMaterials& materials = *placed_->materials; !materials.reflectances.empty())
    part("materials",
         materials.reflectances.capacity() * sizeof(Rgb) + materials.plain.capacity() / 8 +
             materials.all.capacity() * sizeof(Material),
         watch,
         materials.all.empty()
             ? fmt::format("{} diffuse reflectances", materials.reflectances.size())
             : fmt::format("{} materials", materials.all.size()));
  if (!scene_->textures_.empty())
    part("textures", scene_->textures_.bytes(), watch,
         fmt::format(
             "{} textures of surfaces{}", scene_->textures_.size(),
             scene_->textures_.limit_bytes() < std::numeric_limits<std::size_t>::max()
                 ? fmt::format("; pictures at most {} bytes", scene_->textures_.limit_bytes())
                 : ""));
}

}  // namespace lucerna
