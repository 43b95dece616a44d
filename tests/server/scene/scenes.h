// Small scenes in code, for tests that need no file.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/scene/scene.h"

namespace lucerna::testing {

inline std::shared_ptr<const Scene> build(SceneDescription description) {
  auto scene = Scene::build(std::move(description));
  if (!scene.ok()) throw std::runtime_error(scene.status().ToString());
  return *scene;
}

inline SceneDescription description(double reflectance = 0.5) {
  SceneDescription d;
  d.materials = {diffuse_material(Rgb(reflectance))};
  d.film = {.width = 16, .height = 12};
  return d;
}

template <typename Geometry>
ShapeDescription shape(Geometry geometry) {
  ShapeDescription s;
  s.geometry = std::move(geometry);
  return s;
}

/// Corners in patch order.
inline ShapeDescription patch(const Vec3& p00, const Vec3& p10, const Vec3& p01, const Vec3& p11) {
  return shape(PatchMeshData{{p00, p10, p01, p11}, {}, {0, 1, 2, 3}});
}

/// Normal +z.
inline ShapeDescription floor(double half_side, double z = 0) {
  const double s = half_side;
  return patch({-s, -s, z}, {s, -s, z}, {-s, s, z}, {s, s, z});
}

inline ShapeDescription emissive(ShapeDescription shape, double radiance, bool two_sided = false) {
  shape.emission = ShapeDescription::Emission{
      .radiance_cd_m2 = Rgb(radiance), .two_sided = two_sided, .where = {"test.pbrt", 7, 3}};
  return shape;
}

/// A convex mesh: the octahedron, with each face split `levels` times and moved to the unit sphere;
/// then mapped by `f`.  Normals point outwards.
template <typename F>
TriangleMeshData ball(int levels, F&& f) {
  struct Face {
    Vec3 a, b, c;
  };
  std::vector<Face> faces;
  for (int i = 0; i < 8; ++i) {
    const Vec3 x{i & 1 ? -1.0 : 1.0, 0, 0}, y{0, i & 2 ? -1.0 : 1.0, 0},
        z{0, 0, i & 4 ? -1.0 : 1.0};
    const bool mirrored = ((i & 1) + (i >> 1 & 1) + (i >> 2 & 1)) % 2 == 1;
    faces.push_back(mirrored ? Face{x, z, y} : Face{x, y, z});
  }
  for (int l = 0; l < levels; ++l) {
    std::vector<Face> finer;
    for (const Face& t : faces) {
      const Vec3 ab = normalized(t.a + t.b), bc = normalized(t.b + t.c), ca = normalized(t.c + t.a);
      for (const Face& s :
           {Face{t.a, ab, ca}, Face{ab, t.b, bc}, Face{ca, bc, t.c}, Face{ab, bc, ca}})
        finer.push_back(s);
    }
    faces = std::move(finer);
  }
  TriangleMeshData mesh;
  for (const Face& t : faces)
    for (const Vec3& p : {t.a, t.b, t.c}) {
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(f(p));
    }
  return mesh;
}

/// The inside of a cube of side 2 about `centre`, normals inwards, as triangles.
inline TriangleMeshData room(const Vec3& centre = {}) {
  TriangleMeshData mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(centre +
                             Vec3{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
  mesh.indices = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                  2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
  return mesh;
}

inline LightDescription point_light(const Vec3& position, double candela) {
  return {PointLightParams{position, Rgb(candela)}, {"test.pbrt", 5, 1}};
}

inline std::vector<std::string> part_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const ScenePart& p : scene.parts()) names.push_back(p.name);
  return names;
}

}  // namespace lucerna::testing
