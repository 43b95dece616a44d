#include "server/pbrt/pbrt_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/description/loop_subdivision.h"
#include "server/description/mesh_census.h"
#include "server/description/raw_mesh.h"
#include "server/files/ply.h"
#include "server/pbrt/curve_shapes.h"
#include "server/pbrt/older_pbrt.h"

namespace lucerna::pbrt {

std::vector<Vec3> world_positions(const ShapeDirective& shape, std::vector<Vec3> positions) {
  StopPoll poll;
  for (std::size_t i = 0; i < positions.size(); ++i, poll()) {
    positions[i] = shape.world_from_object.point(positions[i]);
    if (!is_finite(positions[i]))
      fail(shape.place(),
           fmt::format("vertex {} of \"{}\" is not finite after its transform", i, shape.type()));
  }
  return positions;
}

namespace {

/// Unit normals in world space, on the outside; 0 where one has no direction.
std::vector<Vec3f> world_normals(const ShapeDirective& shape, const std::vector<Vec3>& normals) {
  std::vector<Vec3f> result;
  result.reserve(normals.size());
  StopPoll poll;
  for (const Vec3& normal : normals) {
    poll();
    const Vec3 n = normalized(shape.world_from_object.normal(normal));
    result.emplace_back(!is_finite(n) ? Vec3{} : shape.reverse_orientation ? -n : n);
  }
  return result;
}

/// Mends vertex normals, with a remark, and sets the winding of faces.
template <std::size_t kCorners, typename Mesh, typename F>
void orient(LoadState& context, const ShapeDirective& shape, Mesh& mesh, F&& geometric_normal) {
  const bool turned = shape.reverse_orientation != shape.world_from_object.swaps_handedness();
  const std::size_t all = mesh.normals.size();
  if (const std::size_t mended = mend_normals<kCorners>(mesh, turned, geometric_normal); mended > 0)
    context.remark(
        shape.place(),
        fmt::format("{} of {} vertex normals of this mesh have no direction", mended, all),
        mended == all ? "the mesh has no vertex normals" : "the mean of the faces around each");
  resolve_winding<kCorners>(mesh, turned, geometric_normal);
}

void check_raw(const ShapeDirective& shape, RawMesh& raw, std::size_t corners) {
  if (raw.positions.empty())
    fail(shape.place(), fmt::format("Shape \"{}\" lacks \"point3 P\"", shape.type()));
  if (raw.indices.empty()) {
    if (raw.positions.size() != corners)
      fail(shape.place(),
           fmt::format("Shape \"{}\" lacks \"integer indices\", optional only for {} vertices",
                       shape.type(), corners));
    for (std::uint32_t k = 0; k < corners; ++k) raw.indices.push_back(k);
  }
  if (raw.indices.size() % corners != 0)
    fail(shape.place(), fmt::format("Shape \"{}\" has {} indices, expected a multiple of {}",
                                    shape.type(), raw.indices.size(), corners));
  StopPoll poll;
  for (std::size_t i = 0; i < raw.indices.size(); ++i, poll())
    if (raw.indices[i] >= raw.positions.size())
      fail(shape.place(),
           fmt::format("Shape \"{}\": index {} names vertex {}, but there are {} vertices",
                       shape.type(), i, raw.indices[i], raw.positions.size()));
  if (!raw.normals.empty() && raw.normals.size() != raw.positions.size())
    fail(shape.place(), fmt::format("Shape \"{}\" has {} normals for {} vertices", shape.type(),
                                    raw.normals.size(), raw.positions.size()));
  if (!raw.uv.empty() && raw.uv.size() != raw.positions.size())
    fail(shape.place(), fmt::format("Shape \"{}\" has {} \"uv\" for {} vertices", shape.type(),
                                    raw.uv.size(), raw.positions.size()));
}

template <typename Mesh>
Mesh make_mesh(LoadState& context, const ShapeDirective& shape, RawMesh raw) {
  constexpr bool kPatches = std::is_same_v<Mesh, PatchMeshData>;
  check_raw(shape, raw, kPatches ? 4 : 3);
  Mesh mesh;
  mesh.positions = world_positions(shape, std::move(raw.positions));
  mesh.normals = world_normals(shape, raw.normals);
  if (shape.needs_uv) mesh.corner_uv = corner_uvs < kPatches ? 4 : 3 > (raw);
  mesh.indices = std::move(raw.indices);
  if constexpr (kPatches) {
    // cross(dp/du, dp/dv) in the middle; the corners are (0,0), (1,0), (0,1), (1,1).
    orient<4>(context, shape, mesh, [](const auto& p) {
      return cross((p[1] - p[0]) + (p[3] - p[2]), (p[2] - p[0]) + (p[3] - p[1]));
    });
    if (shows_all_on_each(mesh.corner_uv)) mesh.corner_uv = {};
  } else {
    orient<3>(context, shape, mesh, [](const auto& p) { return cross(p[1] - p[0], p[2] - p[0]); });
  }
  if constexpr (kPatches) {
    if (const std::size_t crossed = census_of(mesh).crossed; crossed > 0)
      context.remark(
          shape.place(),
          fmt::format(
              "the edges of {} of {} patches of this mesh cross, which suggests corners in ring "
              "order; \"point3 P\" of a bilinearmesh needs rows: (u, v) = (0, 0), (1, 0), (0, 1), "
              "(1, 1)",
              crossed, mesh.indices.size() / 4),
          "taken as rows: a bow tie, whose halves face opposite ways");
  }
  return mesh;
}

RawMesh raw_mesh(const ShapeDirective& shape) {
  shape.params.ignore({"uv", "st", "S", "faceIndices", "emissionfilename"});
  RawMesh raw{shape.params.take_vectors("P", "point3"),
              shape.params.take_vectors("N", "normal"),
              shape.params.take_indices("indices"),
              {}};
  StopPoll poll;
  if (const Parameter* uv = shape.needs_uv ? shape.params.find("uv", {"point2"}) : nullptr)
    for (std::size_t i = 0; i + 1 < uv->numbers().size(); i += 2, poll())
      raw.uv.push_back({float(uv->numbers()[i]), float(uv->numbers()[i + 1])});
  return raw;
}

/// Reports what a PLY file holds and the mesh does not.
void remark_left_out(LoadState& context, const FilePosition& place, const std::string& name,
                     const PlyMesh& ply) {
  if (ply.short_faces > 0)
    context.remark(
        place,
        fmt::format("{} faces of mesh \"{}\" have fewer than 3 corners", ply.short_faces, name),
        "left out, as in pbrt-v4");
  if (ply.long_faces > 0)
    context.remark(
        place,
        fmt::format("{} faces of mesh \"{}\" have more than 4 corners", ply.long_faces, name),
        "left out, as in pbrt-v4; triangles keep them");
  if (ply.mended_uv > 0)
    context.remark(
        place,
        fmt::format("the (u, v) of {} vertices of mesh \"{}\" are not finite", ply.mended_uv, name),
        "(u, v) 0, 0");
}

/// Quadrilaterals whose two triangles do not have one normal.
std::size_t bent_quads(const PlyMesh& ply) {
  return static_cast<std::size_t>(std::ranges::count_if(ply.quads, [&](std::size_t triangle) {
    const auto normal = [&](std::size_t first) {
      const auto p = [&](std::size_t k) { return ply.positions[ply.indices[first + k]]; };
      return normalized(cross(p(1) - p(0), p(2) - p(0)));
    };
    constexpr double kRounded = 1e-4;  // floats of a flat quadrilateral
    return length(normal(3 * triangle) - normal(3 * triangle + 3)) > kRounded;
  }));
}

TriangleMeshData ply_mesh(LoadState& context, const ShapeDirective& shape) {
  const Parameter* file = shape.params.find("filename", {"string"});
  if (file == nullptr) fail(shape.place(), "Shape \"plymesh\" lacks \"string filename\"");
  if (const Parameter* map = shape.params.find("displacement", {"texture", "float"}))
    context.remark(map->place, "\"displacement\" is not modelled", "the mesh without it");
  shape.params.ignore({"displacement.edgelength", "edgelength", "displacement.uvscale"});
  AssetContent content = context.read(*file);
  auto ply = parse_ply(content.bytes, context.stop, context.meter.budget());
  if (absl::IsCancelled(ply.status()) || absl::IsResourceExhausted(ply.status()))
    throw StatusError(ply.status());
  if (!ply.ok()) {
    const std::string message(ply.status().message().data(), ply.status().message().size());
    fail(file->place, fmt::format("file \"{}\": {}", content.name, message));
  }
  content.bytes = std::string();
  content.share.reset();
  // Normals in double and in float, and the (u, v) of each corner.
  LoadBudget::Share work(context.meter.budget());
  LoadState::require(work.resize(ply->normals.size() * (sizeof(Vec3) + sizeof(Vec3f)) +
                                 (shape.needs_uv ? ply->indices.size() * sizeof(Vec2f) : 0)));
  RawMesh raw;
  remark_left_out(context, file->place, content.name, *ply);
  if (const std::size_t bent = bent_quads(*ply); bent > 0)
    context.remark(file->place,
                   fmt::format("{} of {} quadrilaterals of mesh \"{}\" are not flat and convex; "
                               "pbrt-v4 makes bilinear patches of them",
                               bent, ply->quads.size(), content.name),
                   "two triangles each");
  raw.positions = std::move(ply->positions);
  raw.indices = std::move(ply->indices);
  if (shape.needs_uv) raw.uv = std::move(ply->uv);
  raw.normals.reserve(ply->normals.size());
  StopPoll poll;
  for (const Vec3f& n : ply->normals) poll(), raw.normals.emplace_back(n);
  if (raw.positions.empty() || raw.indices.empty()) {
    context.remark(file->place, fmt::format("mesh \"{}\" is empty", content.name), "left out");
    return {};
  }
  return make_mesh<TriangleMeshData>(context, shape, std::move(raw));
}

/// The control mesh of a limit surface, refined.
TriangleMeshData loop_surface(LoadState& context, const ShapeDirective& shape) {
  shape.params.ignore({"scheme"});  // "loop" is the only one of pbrt-v4
  const int levels = shape.params.integer("levels", 3);
  const FilePosition at = shape.params.place_of({"levels"});
  if (levels < 0) fail(at, fmt::format("\"integer levels\" = {}, allowed: 0 and more", levels));
  RawMesh raw = raw_mesh(shape);
  check_raw(shape, raw, 3);
  // Measured: the last step takes about 100 bytes for each triangle.
  constexpr std::uint64_t kTriangleBytes = 100;
  LoadBudget::Share work(context.meter.budget());
  LoadState::require(work.resize(
      std::min(kMostLimitTriangles, (raw.indices.size() / 3) << (2 * std::min(levels, 12))) *
      kTriangleBytes));
  auto limit =
      loop_subdivide({std::move(raw.positions), std::move(raw.indices)}, levels, context.stop);
  if (!limit.ok())
    fail(absl::IsResourceExhausted(limit.status()) ? at : shape.place(), limit.status());
  return make_mesh<TriangleMeshData>(
      context, shape,
      {std::move(limit->positions), std::move(limit->normals), std::move(limit->indices), {}});
}

/// Radius [m].
double radius(const ShapeDirective& shape) {
  return shape.params.number(
      "radius", 1, [](double r) { return r > 0; }, " m, allowed: positive");
}

/// Swept angle [rad].
double swept_angle(const ShapeDirective& shape) {
  const double degrees = shape.params.number(
      "phimax", 360, [](double d) { return d >= 360 || d * kRadPerDegree > 0; },
      " degrees, allowed: positive; 360 and more is the whole turn");
  return degrees >= 360 ? 2 * std::numbers::pi : degrees * kRadPerDegree;
}

[[noreturn]] void refuse_heights(const ShapeDirective& shape, double z0, double z1,
                                 const std::string& allowed) {
  fail(shape.params.place_of({"zmin", "zmax", "radius"}),
       fmt::format("\"float zmin\" = {} m and \"float zmax\" = {} m, allowed: two heights that {}",
                   z0, z1, allowed));
}

/// What all quadrics have.  Fails if `Quadric` refuses its parameters.
template <typename Quadric, typename Params>
Params completed(const ShapeDirective& shape, Params params) {
  params.phi_max_rad = swept_angle(shape);
  params.reverse_orientation = shape.reverse_orientation;
  params.world_from_object = shape.world_from_object;
  if (const auto made = Quadric::create(params); !made.ok()) fail(shape.place(), made.status());
  return params;
}

SphereParams sphere(const ShapeDirective& shape) {
  SphereParams sphere;
  const double r = sphere.radius_m = radius(shape);
  const double z0 = shape.params.number("zmin", -r), z1 = shape.params.number("zmax", r);
  sphere.z_min_m = std::min(z0, z1);
  sphere.z_max_m = std::max(z0, z1);
  if (!(sphere.z_min_m < r && sphere.z_max_m > -r && sphere.z_max_m > sphere.z_min_m))
    refuse_heights(shape, z0, z1, fmt::format("have a part of [{}, {}] between them", -r, r));
  return completed<Sphere>(shape, sphere);
}

DiskParams disk(const ShapeDirective& shape) {
  DiskParams disk;
  disk.height_m = shape.params.number("height", 0);
  disk.radius_m = radius(shape);
  disk.inner_radius_m = shape.params.number(
      "innerradius", 0, [&](double r) { return r >= 0 && r < disk.radius_m; },
      fmt::format(" m, allowed: at least 0 and less than the radius, {} m", disk.radius_m));
  return completed<Disk>(shape, disk);
}

CylinderParams cylinder(const ShapeDirective& shape) {
  CylinderParams cylinder;
  cylinder.radius_m = radius(shape);
  const double z0 = shape.params.number("zmin", -1), z1 = shape.params.number("zmax", 1);
  cylinder.z_min_m = std::min(z0, z1);
  cylinder.z_max_m = std::max(z0, z1);
  if (!(cylinder.z_max_m > cylinder.z_min_m)) refuse_heights(shape, z0, z1, "differ");
  return completed<Cylinder>(shape, cylinder);
}

std::optional<Geometry> geometry_of(LoadState& context, const ShapeDirective& shape) {
  if (shape.type() == "sphere") return sphere(shape);
  if (shape.type() == "disk") return disk(shape);
  if (shape.type() == "cylinder") return cylinder(shape);
  if (shape.type() == "trianglemesh")
    return make_mesh<TriangleMeshData>(context, shape, raw_mesh(shape));
  if (shape.type() == "bilinearmesh") {
    RawMesh raw = raw_mesh(shape);
    return make_mesh<PatchMeshData>(context, shape, std::move(raw));
  }
  if (shape.type() == "plymesh") {
    TriangleMeshData mesh = ply_mesh(context, shape);
    if (mesh.indices.empty()) return std::nullopt;
    return mesh;
  }
  if (shape.type() == "loopsubdiv") return loop_surface(context, shape);
  if (shape.type() == "curve") return make_curve(context, shape);
  fail(shape.place(),
       fmt::format("unknown shape \"{}\", expected one of sphere disk trianglemesh "
                   "plymesh bilinearmesh cylinder curve loopsubdiv{}",
                   printable(shape.type()), hint_of_older_pbrt("Shape", shape.type())));
}

}  // namespace

std::optional<Geometry> make_geometry(LoadState& context, const ShapeDirective& shape) {
  // The arrays of a mesh take at most twice the memory of its parameters.
  LoadBudget::Share work(context.meter.budget());
  LoadState::require(work.resize(2 * shape.params.long_bytes()));
  auto geometry = geometry_of(context, shape);
  if (!geometry) return geometry;
  shape.params.ignore({"alpha"});  // the caller reads it
  shape.params.remark_unused(context, fmt::format("Shape \"{}\"", shape.type()));
  return geometry;
}

}  // namespace lucerna::pbrt
