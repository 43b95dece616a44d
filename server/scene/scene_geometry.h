// The geometry of a scene: surfaces as rays meet them, with materials, textures and media.
#pragma once

#include <concepts>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/description/scene_description.h"
#include "server/materials/material.h"
#include "server/rays/accelerator.h"
#include "server/rays/ray.h"
#include "server/rays/surface_table.h"
#include "server/scene/light_edit.h"
#include "server/scene/movable_surfaces.h"
#include "server/scene/scene_part.h"

namespace lucerna {

/// The materials of surfaces.
struct SurfaceMaterials {
  std::vector<Material> all;  ///< empty if all are plain
  // By material: whether it is diffuse without textures, and then its reflectance.
  std::vector<bool> plain;
  std::vector<Rgb> reflectances;
};

/// What the geometry of a scene shares with those whose surfaces of lights edits moved.
struct FixedGeometry {
  std::vector<SurfaceTable> objects;  ///< of each object, then of each moving shape
  Textures textures;
  std::vector<Medium> media;
  std::int32_t surrounding_medium = -1;
  bool has_panes = false;       ///< smooth thin panes or sheets with a constant alpha
  bool has_cut_lights = false;  ///< surfaces that emit and have an alpha below 1
  MovableSurfaces movable;
};

/// What a geometry consists of.
struct GeometryData {
  Vec3 origin;         ///< Scene::origin()
  Bounds world_m;      ///< of all shapes over their motion, world [m]
  SurfaceEdits edits;  ///< how the surfaces differ from those of the file
  std::shared_ptr<const FixedGeometry> fixed;
  std::shared_ptr<const SurfaceTable> surfaces;  ///< of the scene's own geometry
  std::shared_ptr<const SurfaceMaterials> materials;
  std::shared_ptr<const Accelerator> accelerator;
  /// A light whose surface was moved or added.
  struct EditedLight {
    std::shared_ptr<const Light> light;  ///< with the level of the file
    std::int32_t number;                 ///< Surface::light
  };
  /// By id.  Empty if the whole scene was built with them at their places.
  std::map<std::uint64_t, EditedLight> edited_lights;
  std::vector<ScenePart> parts;  ///< without those of the geometry that it was made from
};

/// Immutable: a scene shares it with its revisions.  All members may be called from any thread.
class SceneGeometry {
 public:
  explicit SceneGeometry(GeometryData data) : data_(std::move(data)) {}

  /// World position of the zero of scene coordinates [m], if there is anything to hit.
  const Vec3& origin() const { return data_.origin; }
  const Bounds& world_m() const { return data_.world_m; }
  const SurfaceEdits& edits() const { return data_.edits; }
  const std::map<std::uint64_t, GeometryData::EditedLight>& edited_lights() const {
    return data_.edited_lights;
  }
  /// What edits of this geometry need.
  const GeometryData& data() const { return data_; }

  /// Whether there is nothing to hit.
  bool empty() const { return data_.accelerator->empty(); }
  /// Whether nothing can take light on its way: no surface and no medium.
  bool is_clear() const { return empty() && !has_media(); }
  /// Whether a shape or an instance moves.
  bool moves() const;
  const Accelerator& accelerator() const { return *data_.accelerator; }
  /// Shading data of the scene's own geometry.
  const SurfaceTable& surfaces() const { return *data_.surfaces; }
  /// The same for the geometry of an object, as Accelerator::object numbers it.
  const SurfaceTable& surfaces_of(std::uint32_t object) const {
    return data_.fixed->objects[object];
  }
  std::span<const Material> materials() const { return data_.materials->all; }
  const Textures& textures() const { return data_.fixed->textures; }
  /// The reflectance of a diffuse material without textures; null for all others.
  const Rgb* plain_diffuse(std::uint32_t material) const {
    const SurfaceMaterials& materials = *data_.materials;
    return materials.plain[material] ? &materials.reflectances[material] : nullptr;
  }
  /// Shapes in memory.  Those of an object count once, for any number of instances.
  std::uint64_t shape_count() const;
  /// Primitives in memory: triangles, patches, pieces of curves, spheres, disks, cylinders.
  std::uint64_t primitive_count() const;
  std::string isa() const { return data_.accelerator->isa(); }

  /// SurfaceHit::light is Surface::light: Scene::closest_hit returns the light of the scene.
  std::optional<SurfaceHit> closest_hit(const Ray& ray,
                                        RayFilter filter = RayFilter::kSurfaces) const;
  bool occluded(const Ray& ray, RayFilter filter = RayFilter::kSurfaces) const {
    return data_.accelerator->occluded(ray, filter);
  }
  Obstacle obstacle(const Ray& ray, const EndTolerances& ends, RayFilter filter) const {
    return data_.accelerator->obstacle(ray, ends, filter);
  }
  /// Where a surface was hit, as textures need it.
  struct ShadingPoint {
    TexturePoint texture;
    /// Scene [m]: how the point moves as u and v grow.  0 where (u, v) do not span the surface.
    Vec3 dpdu, dpdv;
  };
  ShadingPoint shading_point(const SurfaceHit& hit) const;

  /// Whether it has smooth thin panes or sheets with a constant alpha, and whether it has media.
  bool has_panes() const { return data_.fixed->has_panes; }
  bool has_media() const { return !data_.fixed->media.empty(); }
  /// Whether all media absorb each channel alike.
  bool media_are_grey() const;
  /// Whether a smooth thin pane was hit.
  bool is_pane(const SurfaceHit& hit) const {
    return has_panes() && surface_of(hit).pane_eta.has_value();
  }
  /// The share of rays that meet the surface at a hit of a light.  Light models have the radiance
  /// times this share.
  double alpha(const SurfaceHit& hit) const {
    return data_.fixed->has_cut_lights ? alpha_of(surface_of(hit), hit) : 1;
  }
  /// The share of light that the panes and sheets along the ray pass straight on.
  double through_panes(const Ray& ray) const;
  /// The share of light along `direction` that one of them passes where it was hit.
  double through_pane(const SurfaceHit& hit, const Vec3f& direction) const;
  /// The share of light that the media along the ray leave, by channel.  Surfaces that bound
  /// media define the medium on each side.  If none is ahead, the nearest one behind decides.  If
  /// there is none at all, the ray is in the surrounding medium.
  Rgb through_media(const Ray& ray) const;

  /// The part of type `T` that other code keeps with this geometry.  Made by `T(*this)` at its
  /// first use.
  template <std::derived_from<AttachedPart> T>
  const T& attached() const {
    return attached_.get<T>(*this);
  }
  /// The parts that are built, without those of the geometry that it was made from.
  std::vector<ScenePart> parts() const;
  std::uint64_t bytes() const { return bytes_of(data_.parts) + attached_.bytes(); }

 private:
  /// A surface along a ray, at `t` in double.
  struct Crossing {
    SurfaceHit hit;
    double t = 0, error_t = 0;
    bool is_front = false;  ///< whether the ray meets the side of the normal
  };
  /// The primitives of the scene or of an instance, with their shading data.
  struct Primitives {
    const GeometryInstance* instance;  ///< null: the scene's own
    const GeometrySet& set;
    const SurfaceTable& table;
  };
  Primitives primitives_of(std::int32_t instance) const {
    if (instance < 0) return {nullptr, data_.accelerator->scene(), *data_.surfaces};
    const GeometryInstance& of = data_.accelerator->instance(instance);
    return {&of, data_.accelerator->object(of.object), surfaces_of(of.object)};
  }
  /// All surfaces along the ray in their order, each once.
  std::vector<Crossing> crossings(const Ray& ray, RayFilter filter) const;
  SurfaceHit surface_hit(const RawHit& raw, const Ray& ray) const;
  const Surface& surface_of(const SurfaceHit& hit) const;
  double alpha_of(const Surface& surface, const SurfaceHit& hit) const;

  GeometryData data_;
  AttachedParts attached_;  // last: its parts refer to the other members
};

}  // namespace lucerna
