#include "server/pbrt/surfaces/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <type_traits>
#include <utility>

#include "server/formats/ply.h"

namespace lucerna::pbrt {
namespace {

/// Vertices and primitives of a file, with `corners` indices for each primitive.
struct RawMesh {
  std::vector<Vec3<double>> positions;
  std::vector<Vec3<double>> normals;
  std::vector<std::uint32_t> indices;
  std::vector<Vec2<float>> uv;  ///< per vertex; empty: the default (u, v) of each primitive
};

std::vector<Vec3<double>> world_positions(const ShapeDirective& shape,
                                          std::vector<Vec3<double>> positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = shape.world_from_object.point(positions[i]);
    if (!is_finite(positions[i]))
      fail(shape.place,
           fmt::format("vertex {} of \"{}\" is not finite after its transform", i, shape.type));
  }
  return positions;
}

/// Unit normals in world space, on the outside; empty if one has no direction.
std::vector<Vec3<float>> world_normals(Context& context, const ShapeDirective& shape,
                                       const std::vector<Vec3<double>>& normals) {
  std::vector<Vec3<float>> result;
  result.reserve(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vec3<double> n = normalized(shape.world_from_object.normal(normals[i]));
    if (!is_finite(n) || max_abs(n) == 0) {
      context.remark(shape.place, fmt::format("the normal of vertex {} has no direction", i),
                     "the mesh has no vertex normals");
      return {};
    }
    result.emplace_back(shape.reverse_orientation ? -n : n);
  }
  return result;
}

/// Orients each primitive so that its winding gives the outside.  Vertex normals point to the
/// outside.  Without them, either a mirror or ReverseOrientation (not both) turns the primitive.
/// `geometric_normal(corners)` has any length.
template <std::size_t kCorners, typename Mesh, typename F>
void resolve_winding(Mesh& mesh, bool turned, F&& geometric_normal) {
  for (std::size_t i = 0; i + kCorners <= mesh.indices.size(); i += kCorners) {
    std::uint32_t* corner = &mesh.indices[i];
    std::array<Vec3<double>, kCorners> p;
    Vec3<double> n{};
    for (std::size_t k = 0; k < kCorners; ++k) {
      p[k] = mesh.positions[corner[k]];
      if (!mesh.normals.empty()) n += Vec3<double>(mesh.normals[corner[k]]);
    }
    const Vec3<double> outside = geometric_normal(p);
    if (mesh.normals.empty() ? turned : dot(normalized(outside), n) < 0) {
      std::swap(corner[1], corner[2]);
      if (!mesh.corner_uv.empty()) std::swap(mesh.corner_uv[i + 1], mesh.corner_uv[i + 2]);
    }
  }
}

/// Numbers of primitives that get a remark.
struct Census {
  std::size_t without_area = 0;
  std::size_t crossed = 0;  ///< flat patches whose edges cross
};

Census census_of(const TriangleMeshData& mesh) {
  Census census;
  for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3) {
    const auto p = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
    if (max_abs(cross(p(1) - p(0), p(2) - p(0))) == 0) ++census.without_area;
  }
  return census;
}

/// dp/du x dp/dv of a patch is linear in u and in v, so a patch has no area if it is 0 at all four
/// corners.  On a flat patch it gives the turns of the outline.  The outline crosses itself if two
/// corners turn one way and two the other.  With one different turn it is an arrowhead.
Census census_of(const PatchMeshData& mesh) {
  Census census;
  for (std::size_t i = 0; i + 4 <= mesh.indices.size(); i += 4) {
    const auto p = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
    const std::array<Vec3<double>, 4> turns{
        cross(p(1) - p(0), p(2) - p(0)), cross(p(1) - p(0), p(3) - p(1)),
        cross(p(3) - p(2), p(2) - p(0)), cross(p(3) - p(2), p(3) - p(1))};
    Vec3<double> largest{};
    for (const Vec3<double>& turn : turns)
      if (max_abs(turn) > max_abs(largest)) largest = turn;
    if (max_abs(largest) == 0) {
      ++census.without_area;
      continue;
    }
    constexpr double kRounded = 1e-6;  // relative to the largest, from rounding of corners
    const Vec3<double> axis = normalized(largest);
    const double unit = length(largest);
    int left = 0, right = 0;
    for (const Vec3<double>& turn : turns) {
      const Vec3<double> t = turn / unit;
      if (max_abs(cross(axis, t)) > kRounded) break;
      left += dot(axis, t) > kRounded;
      right += dot(axis, t) < -kRounded;
    }
    if (left == 2 && right == 2) ++census.crossed;
  }
  return census;
}

void check_raw(const ShapeDirective& shape, RawMesh& raw, std::size_t corners) {
  if (raw.positions.empty())
    fail(shape.place, fmt::format("Shape \"{}\" lacks \"point3 P\"", shape.type));
  if (raw.indices.empty()) {
    if (raw.positions.size() != corners)
      fail(shape.place,
           fmt::format("Shape \"{}\" lacks \"integer indices\", optional only for {} vertices",
                       shape.type, corners));
    for (std::uint32_t k = 0; k < corners; ++k) raw.indices.push_back(k);
  }
  if (raw.indices.size() % corners != 0)
    fail(shape.place, fmt::format("Shape \"{}\" has {} indices, expected a multiple of {}",
                                  shape.type, raw.indices.size(), corners));
  for (std::size_t i = 0; i < raw.indices.size(); ++i)
    if (raw.indices[i] >= raw.positions.size())
      fail(shape.place,
           fmt::format("Shape \"{}\": index {} names vertex {}, but there are {} vertices",
                       shape.type, i, raw.indices[i], raw.positions.size()));
  if (!raw.normals.empty() && raw.normals.size() != raw.positions.size())
    fail(shape.place, fmt::format("Shape \"{}\" has {} normals for {} vertices", shape.type,
                                  raw.normals.size(), raw.positions.size()));
  if (!raw.uv.empty() && raw.uv.size() != raw.positions.size())
    fail(shape.place, fmt::format("Shape \"{}\" has {} \"uv\" for {} vertices", shape.type,
                                  raw.uv.size(), raw.positions.size()));
}

/// The (u, v) of every corner, as in pbrt-v4: those of the vertices, or the defaults of each
/// primitive.
template <std::size_t kCorners>
std::vector<Vec2<float>> corner_uvs(const RawMesh& raw) {
  static constexpr std::array<Vec2<float>, 4> kTriangle{{{0, 0}, {1, 0}, {1, 1}}};
  static constexpr std::array<Vec2<float>, 4> kPatch{{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};
  std::vector<Vec2<float>> uv;
  uv.reserve(raw.indices.size());
  for (std::size_t i = 0; i < raw.indices.size(); ++i)
    uv.push_back(raw.uv.empty() ? (kCorners == 3 ? kTriangle : kPatch)[i % kCorners]
                                : raw.uv[raw.indices[i]]);
  return uv;
}

/// Whether each patch shows the whole image, without a flip.
bool shows_all_on_each(const std::vector<Vec2<float>>& corner_uv) {
  for (std::size_t i = 0; i < corner_uv.size(); ++i)
    if (!(corner_uv[i] == Vec2<float>{float(i & 1), float(i >> 1 & 1)})) return false;
  return true;
}

template <typename Mesh>
Mesh make_mesh(Context& context, const ShapeDirective& shape, RawMesh raw) {
  constexpr bool kPatches = std::is_same_v<Mesh, PatchMeshData>;
  check_raw(shape, raw, kPatches ? 4 : 3);
  Mesh mesh;
  mesh.positions = world_positions(shape, std::move(raw.positions));
  mesh.normals = world_normals(context, shape, raw.normals);
  if (shape.needs_uv) mesh.corner_uv = corner_uvs < kPatches ? 4 : 3 > (raw);
  mesh.indices = std::move(raw.indices);
  const bool turned = shape.reverse_orientation != shape.world_from_object.swaps_handedness();
  if constexpr (kPatches) {
    // cross(dp/du, dp/dv) in the middle; the corners are (0,0), (1,0), (0,1), (1,1).
    resolve_winding<4>(mesh, turned, [](const auto& p) {
      return cross((p[1] - p[0]) + (p[3] - p[2]), (p[2] - p[0]) + (p[3] - p[1]));
    });
    if (shows_all_on_each(mesh.corner_uv)) mesh.corner_uv = {};
  } else {
    resolve_winding<3>(mesh, turned, [](const auto& p) { return cross(p[1] - p[0], p[2] - p[0]); });
  }
  const Census census = census_of(mesh);
  const std::size_t primitives = mesh.indices.size() / (kPatches ? 4 : 3);
  if (census.without_area > 0)
    context.remark(shape.place,
                   fmt::format("{} of {} {} of this mesh have no area", census.without_area,
                               primitives, kPatches ? "patches" : "triangles"),
                   "kept, but invisible and without light");
  if (census.crossed > 0)
    context.remark(
        shape.place,
        fmt::format(
            "the edges of {} of {} patches of this mesh cross, which suggests corners in ring "
            "order; \"point3 P\" of a bilinearmesh needs rows: (u, v) = (0, 0), (1, 0), (0, 1), "
            "(1, 1)",
            census.crossed, primitives),
        "taken as rows: a bow tie, whose halves face opposite ways");
  return mesh;
}

RawMesh raw_mesh(const ShapeDirective& shape) {
  shape.params.ignore({"uv", "st", "S", "faceIndices", "emissionfilename"});
  RawMesh raw{shape.params.vectors("P", "point3"),
              shape.params.vectors("N", "normal"),
              shape.params.indices("indices"),
              {}};
  if (const Parameter* uv = shape.needs_uv ? shape.params.find("uv", {"point2"}) : nullptr)
    for (std::size_t i = 0; i + 1 < uv->numbers.size(); i += 2)
      raw.uv.push_back({float(uv->numbers[i]), float(uv->numbers[i + 1])});
  return raw;
}

TriangleMeshData ply_mesh(Context& context, const ShapeDirective& shape) {
  const Parameter* file = shape.params.find("filename", {"string"});
  if (file == nullptr) fail(shape.place, "Shape \"plymesh\" lacks \"string filename\"");
  if (const Parameter* map = shape.params.find("displacement", {"texture", "float"}))
    context.remark(map->place, "\"displacement\" is not modelled", "the mesh without it");
  shape.params.ignore({"displacement.edgelength", "edgelength", "displacement.uvscale"});
  const AssetContent content = context.read(*file);
  auto ply = parse_ply(content.bytes, context.stop);
  if (absl::IsCancelled(ply.status())) throw Failure{ply.status()};
  if (!ply.ok()) {
    const std::string message(ply.status().message().data(), ply.status().message().size());
    fail(file->place, fmt::format("file \"{}\": {}", content.name, message));
  }
  RawMesh raw;
  raw.positions = std::move(ply->positions);
  raw.indices = std::move(ply->indices);
  if (shape.needs_uv) raw.uv = std::move(ply->uv);
  raw.normals.reserve(ply->normals.size());
  for (const Vec3<float>& n : ply->normals) raw.normals.emplace_back(n);
  if (raw.positions.empty() || raw.indices.empty()) {
    context.remark(file->place, fmt::format("mesh \"{}\" is empty", content.name), "left out");
    return {};
  }
  return make_mesh<TriangleMeshData>(context, shape, std::move(raw));
}

/// Radius [m].
double radius(const ShapeDirective& shape) {
  const double radius = shape.params.number("radius", 1);
  if (!(radius > 0))
    fail(shape.params.place_of({"radius"}, shape.place),
         fmt::format("\"float radius\" = {} m, allowed: positive", radius));
  return radius;
}

/// Swept angle [rad].
double swept_angle(const ShapeDirective& shape) {
  const double degrees = shape.params.number("phimax", 360);
  const double angle = degrees >= 360 ? 2 * std::numbers::pi : degrees * kRadPerDegree;
  if (!(angle > 0))
    fail(shape.params.place_of({"phimax"}, shape.place),
         fmt::format(
             "\"float phimax\" = {} degrees, allowed: positive; 360 and more is the whole turn",
             degrees));
  return angle;
}

[[noreturn]] void refuse_heights(const ShapeDirective& shape, double z0, double z1,
                                 const std::string& allowed) {
  fail(shape.params.place_of({"zmin", "zmax", "radius"}, shape.place),
       fmt::format("\"float zmin\" = {} m and \"float zmax\" = {} m, allowed: two heights that {}",
                   z0, z1, allowed));
}

SphereParams sphere(const ShapeDirective& shape) {
  SphereParams sphere;
  sphere.radius_m = radius(shape);
  const double z0 = shape.params.number("zmin", -sphere.radius_m);
  const double z1 = shape.params.number("zmax", sphere.radius_m);
  sphere.z_min_m = std::min(z0, z1);
  sphere.z_max_m = std::max(z0, z1);
  const double r = sphere.radius_m;
  if (!(sphere.z_min_m < r && sphere.z_max_m > -r && sphere.z_max_m > sphere.z_min_m))
    refuse_heights(shape, z0, z1, fmt::format("have a part of [{}, {}] between them", -r, r));
  sphere.phi_max_rad = swept_angle(shape);
  sphere.reverse_orientation = shape.reverse_orientation;
  sphere.world_from_object = shape.world_from_object;
  if (const auto made = Sphere<double>::create(sphere); !made.ok())
    fail(shape.place, made.status());
  return sphere;
}

DiskParams disk(const ShapeDirective& shape) {
  DiskParams disk;
  disk.height_m = shape.params.number("height", 0);
  disk.radius_m = radius(shape);
  disk.inner_radius_m = shape.params.number("innerradius", 0);
  if (!(disk.inner_radius_m >= 0 && disk.inner_radius_m < disk.radius_m))
    fail(shape.params.place_of({"innerradius"}, shape.place),
         fmt::format(
             "\"float innerradius\" = {} m, allowed: at least 0 and less than the radius, {} m",
             disk.inner_radius_m, disk.radius_m));
  disk.phi_max_rad = swept_angle(shape);
  disk.reverse_orientation = shape.reverse_orientation;
  disk.world_from_object = shape.world_from_object;
  if (const auto made = Disk<double>::create(disk); !made.ok()) fail(shape.place, made.status());
  return disk;
}

CylinderParams cylinder(const ShapeDirective& shape) {
  CylinderParams cylinder;
  cylinder.radius_m = radius(shape);
  const double z0 = shape.params.number("zmin", -1);
  const double z1 = shape.params.number("zmax", 1);
  cylinder.z_min_m = std::min(z0, z1);
  cylinder.z_max_m = std::max(z0, z1);
  if (!(cylinder.z_max_m > cylinder.z_min_m)) refuse_heights(shape, z0, z1, "differ");
  cylinder.phi_max_rad = swept_angle(shape);
  cylinder.reverse_orientation = shape.reverse_orientation;
  cylinder.world_from_object = shape.world_from_object;
  if (const auto made = Cylinder<double>::create(cylinder); !made.ok())
    fail(shape.place, made.status());
  return cylinder;
}

std::optional<Geometry> geometry_of(Context& context, const ShapeDirective& shape) {
  if (shape.type == "sphere") return sphere(shape);
  if (shape.type == "disk") return disk(shape);
  if (shape.type == "cylinder") return cylinder(shape);
  if (shape.type == "trianglemesh")
    return make_mesh<TriangleMeshData>(context, shape, raw_mesh(shape));
  if (shape.type == "bilinearmesh") {
    RawMesh raw = raw_mesh(shape);
    return make_mesh<PatchMeshData>(context, shape, std::move(raw));
  }
  if (shape.type == "plymesh") {
    TriangleMeshData mesh = ply_mesh(context, shape);
    if (mesh.indices.empty()) return std::nullopt;
    return mesh;
  }
  for (const char* known : {"curve", "loopsubdiv"})
    if (shape.type == known) {
      context.remark(shape.place, fmt::format("Shape \"{}\" is not modelled", known), "left out");
      return std::nullopt;
    }
  fail(shape.place, fmt::format("unknown shape \"{}\", expected one of sphere disk trianglemesh "
                                "plymesh bilinearmesh cylinder curve loopsubdiv",
                                printable(shape.type)));
}

}  // namespace

std::optional<Geometry> make_geometry(Context& context, const ShapeDirective& shape) {
  auto geometry = geometry_of(context, shape);
  if (!geometry) return geometry;
  if (const Parameter* alpha = shape.params.find("alpha", {"float", "texture"});
      alpha != nullptr && (alpha->type == "texture" || alpha->numbers.front() != 1))
    context.remark(alpha->place, "\"alpha\" is not modelled", "opaque");
  shape.params.remark_unused(context, fmt::format("Shape \"{}\"", shape.type));
  return geometry;
}

}  // namespace lucerna::pbrt
