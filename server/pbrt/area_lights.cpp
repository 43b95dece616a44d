#include "server/pbrt/area_lights.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "lights/shapes/bilinear_patch.h"
#include "lights/shapes/triangle.h"
#include "server/pbrt/image_lights.h"
#include "server/pbrt/photometric_lights.h"

namespace lucerna::pbrt {
namespace {

/// dp/du of the first primitive that has an area; without one of its own where (u, v) do not say.
/// `normal(corners)` is that of a primitive.
template <std::size_t kCorners, typename Mesh, typename F>
Vec3<double> tangent_of(const Mesh& mesh, F&& normal) {
  static constexpr std::array<Vec2<float>, 4> kPatch{{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};
  for (std::size_t i = 0; i + kCorners <= mesh.indices.size(); i += kCorners) {
    std::array<Vec3<double>, kCorners> p;
    std::array<Vec2<float>, kCorners> uv;
    for (std::size_t k = 0; k < kCorners; ++k) {
      p[k] = mesh.positions[mesh.indices[i + k]];
      uv[k] = mesh.corner_uv.empty() ? kPatch[k] : mesh.corner_uv[i + k];
    }
    if (normal(p) == Vec3<double>{}) continue;
    const Vec3<double> e = p[1] - p[0], f = p[2] - p[0];
    const double du1 = uv[1].x - uv[0].x, dv1 = uv[1].y - uv[0].y;
    const double du2 = uv[2].x - uv[0].x, dv2 = uv[2].y - uv[0].y;
    const double determinant = du1 * dv2 - dv1 * du2;
    // The sine between the edges of the chart, however small that is.
    constexpr double kParallel = 1e-9;
    if (!(std::fabs(determinant) > kParallel * std::hypot(du1, dv1) * std::hypot(du2, dv2)))
      return e;
    return (e * dv2 - f * dv1) / determinant;
  }
  return {};
}

Vec3<double> tangent_of(const Geometry& geometry, const Place& shape_place) {
  if (const auto* mesh = std::get_if<TriangleMeshData>(&geometry))
    return tangent_of<3>(*mesh, [](const auto& p) {
      return Triangle<double>{p[0], p[1], p[2]}.normal();
    });
  if (const auto* mesh = std::get_if<PatchMeshData>(&geometry))
    return tangent_of<4>(*mesh, [](const auto& p) {
      return BilinearPatch<double>{p[0], p[1], p[2], p[3]}.normal({0.5, 0.5});
    });
  if (const auto* disk = std::get_if<DiskParams>(&geometry))
    return disk->world_from_object.vector({1, 0, 0});
  fail(shape_place,
       fmt::format("a light with \"profile\" on a {}, allowed: flat shapes (bilinearmesh, "
                   "trianglemesh, plymesh, disk)",
                   std::holds_alternative<SphereParams>(geometry) ? "sphere" : "cylinder"));
}

/// How the shape refuses the profile; OK where it takes it.
absl::Status check_panel(const Geometry& geometry, const PanelProfile& profile) {
  const auto made = [&]<template <typename> typename Surface>(auto surface) -> absl::Status {
    if (!surface.ok()) return surface.status();
    return Panel<double, Surface>::create(*std::move(surface), profile).status();
  };
  if (const auto* mesh = std::get_if<TriangleMeshData>(&geometry)) {
    std::vector<Triangle<double>> triangles;
    for (std::size_t i = 0; i + 3 <= mesh->indices.size(); i += 3)
      triangles.push_back({mesh->positions[mesh->indices[i]], mesh->positions[mesh->indices[i + 1]],
                           mesh->positions[mesh->indices[i + 2]]});
    return made.template operator()<TriangleMesh>(
        TriangleMesh<double>::create(std::move(triangles)));
  }
  if (const auto* mesh = std::get_if<PatchMeshData>(&geometry)) {
    std::vector<BilinearPatch<double>> patches;
    for (std::size_t i = 0; i + 4 <= mesh->indices.size(); i += 4)
      patches.push_back({mesh->positions[mesh->indices[i]], mesh->positions[mesh->indices[i + 1]],
                         mesh->positions[mesh->indices[i + 2]],
                         mesh->positions[mesh->indices[i + 3]]});
    return made.template operator()<PatchMesh>(PatchMesh<double>::create(std::move(patches)));
  }
  return made.template operator()<Disk>(Disk<double>::create(std::get<DiskParams>(geometry)));
}

}  // namespace

std::optional<Picture> area_picture(Context& context, const ParameterSet& params) {
  const Parameter* filename = params.find("filename", {"string"});
  if (filename == nullptr) {
    check_without_picture(context, params, {"filter"});
    return std::nullopt;
  }
  if (const Parameter* l = params.find("L", {"rgb", "spectrum", "blackbody"}))
    fail(l->place, "\"L\" beside \"filename\", allowed: one of them, and \"scale\"");
  NamedImage named = read_image(context, *filename);
  return Picture{std::move(named.image), image_filter(params, "bilinear"), std::move(named.name)};
}

std::optional<PanelProfile> area_profile(Context& context, const ParameterSet& params,
                                         const Geometry& geometry, const Place& shape_place,
                                         bool mirrored) {
  const Parameter* file = params.find("profile", {"string"});
  if (file == nullptr) return std::nullopt;
  if (params.find("filename", {"string"}) != nullptr)
    fail(file->place, "\"profile\" beside \"filename\", allowed: one of them");
  if (file->strings.size() != 1 || !names_photometric_file(file->strings.front()))
    fail(file->place,
         fmt::format("\"string profile\" = \"{}\", allowed: the name of an .ies or .ldt file",
                     file->strings.empty() ? "" : printable(file->strings.front())));
  NamedPhotometricFile named = read_photometric_file(context, *file);
  PanelProfile profile{.web = std::move(named.file.web),
                       .tangent = tangent_of(geometry, shape_place),
                       .mirrored = mirrored,
                       .file = std::move(named.name),
                       .format = std::move(named.file.format)};
  if (const absl::Status status = check_panel(geometry, profile); !status.ok())
    fail(shape_place, status);
  return profile;
}

bool shows_texels_alike(const Geometry& geometry) {
  if (std::holds_alternative<CylinderParams>(geometry)) return true;
  const auto* mesh = std::get_if<PatchMeshData>(&geometry);
  if (mesh == nullptr || !mesh->corner_uv.empty()) return false;
  for (std::size_t i = 0; i + 4 <= mesh->indices.size(); i += 4) {
    const auto corner = [&](std::size_t k) { return mesh->positions[mesh->indices[i + k]]; };
    const Vec3<double> along = corner(1) - corner(0), across = corner(2) - corner(0);
    const Vec3<double> opposite = corner(3) - corner(2);
    if (length(opposite - along) > 1e-6 * (length(along) + length(across))) return false;
  }
  return true;
}

}  // namespace lucerna::pbrt
