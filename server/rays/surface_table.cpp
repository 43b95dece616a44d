#include "server/rays/surface_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lights/maths/stop_poll.h"
#include "lights/sampling/hash_number.h"
#include "proto/common/status_macros.h"
#include "server/rays/error_bounds.h"

namespace lucerna {
namespace {

absl::Status not_finite(std::size_t i, const Vec3& p) {
  return absl::InvalidArgumentError(fmt::format(
      "vertex {} at ({}, {}, {}) m, allowed: coordinates up to 1e30", i, p.x, p.y, p.z));
}

/// Makes room for `more` elements: no more than that in an empty vector.  Else the capacity at
/// least doubles, so that many small additions take linear time.
template <typename T>
void make_room(std::vector<T>& values, std::size_t more) {
  const std::size_t size = values.size() + more;
  if (size > values.capacity()) values.reserve(std::max(size, 2 * values.capacity()));
}

absl::Status append_mesh(const std::vector<Vec3>& positions,
                         const std::vector<std::uint32_t>& indices, const Vec3& origin,
                         GeometrySet& set) {
  constexpr std::size_t kMaximum = std::numeric_limits<std::uint32_t>::max();
  if (set.vertices.size() + positions.size() > kMaximum ||
      set.triangles.size() / 3 + indices.size() > kMaximum)
    return absl::ResourceExhaustedError("more than 2^32 - 1 vertices or triangles");
  StopPoll poll;
  for (const std::uint32_t i : indices) {
    poll();
    if (i >= positions.size())
      return absl::InvalidArgumentError(
          fmt::format("vertex number {}, allowed: less than {}", i, positions.size()));
  }
  make_room(set.vertices, positions.size() + 1);  // Embree reads beyond the last vertex
  for (std::size_t i = 0; i < positions.size(); ++i, poll()) {
    const Vec3f p = about(positions[i], origin);
    if (!is_finite(p) || max_abs(p) > Accelerator::kMaxCoordinate)
      return not_finite(i, positions[i]);
    set.vertices.push_back(p);
  }
  return absl::OkStatus();
}

void append_normals(const std::vector<Vec3f>& normals, std::size_t base, std::size_t count,
                    std::vector<Vec3f>& out) {
  if (normals.empty() && out.empty()) return;
  out.resize(base);  // earlier meshes have no normals
  if (normals.empty())
    out.resize(base + count);
  else
    out.insert(out.end(), normals.begin(), normals.end());
}

/// Values of the vertices from `base` on, if a mesh has them.
template <typename Value>
absl::Status append_values(const char* name, const std::vector<Value>& values, std::size_t base,
                           std::size_t count, std::vector<Value>& out) {
  if (values.empty()) return absl::OkStatus();
  if (values.size() != count)
    return absl::InvalidArgumentError(
        fmt::format("{} {}, allowed: 0 or one for each vertex ({})", values.size(), name, count));
  out.resize(base);
  out.insert(out.end(), values.begin(), values.end());
  return absl::OkStatus();
}

class Appender {
 public:
  Appender(const Vec3& origin, double detail_m, std::uint32_t surface, GeometrySet& set,
           bool has_uv, SurfaceTable& table)
      : origin_(origin),
        detail_m_(detail_m),
        surface_(surface),
        set_(set),
        has_uv_(has_uv),
        table_(table) {}

  absl::Status operator()(const TriangleMeshData& mesh) {
    const std::size_t base = set_.vertices.size();
    if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size())
      return absl::InvalidArgumentError(
          fmt::format("{} normals, allowed: 0 or one for each vertex ({})", mesh.normals.size(),
                      mesh.positions.size()));
    LUCERNA_RETURN_IF_ERROR(append_mesh(mesh.positions, mesh.indices, origin_, set_));
    append_normals(mesh.normals, base, mesh.positions.size(), table_.vertex_normals);
    LUCERNA_RETURN_IF_ERROR(
        append_values("colours", mesh.colours, base, mesh.positions.size(), table_.vertex_colours));
    LUCERNA_RETURN_IF_ERROR(append_values("tangents", mesh.tangents, base, mesh.positions.size(),
                                          table_.vertex_tangents));
    begin_run(HitKind::kTriangle, set_.triangles.size() / 3, 0, 1);
    make_room(set_.triangles, mesh.indices.size());
    if (has_uv_) make_room(table_.triangle_uv, mesh.indices.size() / 3);
    StopPoll poll;
    for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3, poll()) {
      append_triangle(mesh.positions, static_cast<std::uint32_t>(base),
                      {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
      auto uv = kTriangleUv;
      if (!mesh.corner_uv.empty()) std::copy_n(&mesh.corner_uv[i], 3, uv.begin());
      keep_uv(uv, table_.triangle_uv);
    }
    return absl::OkStatus();
  }

  absl::Status operator()(const PatchMeshData& mesh) {
    const auto base = static_cast<std::uint32_t>(set_.vertices.size());
    if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size())
      return absl::InvalidArgumentError(
          fmt::format("{} normals, allowed: 0 or one for each vertex ({})", mesh.normals.size(),
                      mesh.positions.size()));
    LUCERNA_RETURN_IF_ERROR(append_mesh(mesh.positions, mesh.indices, origin_, set_));
    HitKind kind = HitKind::kTriangle;
    bool any_flat = false;
    StopPoll poll;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 4, poll()) {
      const std::uint32_t* v = &mesh.indices[i];
      std::array<Vec3, 4> c;
      for (int k = 0; k < 4; ++k) c[k] = Vec3(set_.vertices[base + v[k]]);
      const bool flat = mesh.normals.empty() && is_flat_and_convex(c);
      any_flat |= flat;
      const HitKind this_kind = flat ? HitKind::kTriangle : HitKind::kPatch;
      if (i == 0 || this_kind != kind)
        begin_run(this_kind, flat ? set_.triangles.size() / 3 : set_.patches.size(), i / 4,
                  flat ? 2 : 1);
      kind = this_kind;
      auto uv = kPatchUv;
      if (!mesh.corner_uv.empty()) std::copy_n(&mesh.corner_uv[i], 4, uv.begin());
      if (flat) {
        append_triangle(mesh.positions, base, {v[0], v[1], v[2]});
        keep_uv<3>({uv[0], uv[1], uv[2]}, table_.triangle_uv);
        append_triangle(mesh.positions, base, {v[1], v[3], v[2]});
        keep_uv<3>({uv[1], uv[3], uv[2]}, table_.triangle_uv);
      } else {
        append_patch(mesh, v, c);
        keep_uv(uv, table_.patch_uv);
      }
    }
    if (any_flat)
      append_normals({}, base, mesh.positions.size(), table_.vertex_normals);
    else
      set_.vertices.resize(base);  // nothing refers to these vertices
    return absl::OkStatus();
  }

  absl::Status operator()(const CurveData& data) {
    constexpr std::size_t kMaximum = std::numeric_limits<std::uint32_t>::max();
    begin_run(HitKind::kCurve, set_.curves.size(), 0, 1);
    StopPoll poll;
    for (std::size_t i = 0; i < data.count(); ++i, poll()) {
      const auto pieces = pieces_of(cubic_curve(data, i), data.kind, origin_);
      if (set_.curves.size() + pieces.size() > kMaximum)
        return absl::ResourceExhaustedError("more than 2^32 - 1 pieces of curves");
      set_.curves.insert(set_.curves.end(), pieces.begin(), pieces.end());
    }
    return absl::OkStatus();
  }

  template <typename Params>
  absl::Status operator()(const Params& params) {
    using Shape = QuadricOf<Params>;
    LUCERNA_ASSIGN_OR_RETURN(Shape shape, Shape::create(params, origin_));
    begin_run(kHitKind<Shape>, set_.of<Shape>().size(), 0, 1);
    set_.of<Shape>().push_back(std::move(shape));
    return absl::OkStatus();
  }

 private:
  void begin_run(HitKind kind, std::size_t first, std::size_t light_primitive,
                 std::uint32_t per_light_primitive) {
    table_.runs[static_cast<int>(kind)].push_back({static_cast<std::uint32_t>(first), surface_,
                                                   static_cast<std::uint32_t>(light_primitive),
                                                   per_light_primitive});
    if (!has_uv_) return;
    std::uint32_t& uv = table_.runs[static_cast<int>(kind)].back().first_uv;
    if (kind == HitKind::kTriangle) uv = static_cast<std::uint32_t>(table_.triangle_uv.size());
    if (kind == HitKind::kPatch) uv = static_cast<std::uint32_t>(table_.patch_uv.size());
  }

  /// Stores the (u, v) of the next primitive of the run, if the shape needs them.
  template <std::size_t n>
  void keep_uv(const std::array<Vec2f, n>& uv, std::vector<std::array<Vec2f, n>>& out) const {
    if (has_uv_) out.push_back(uv);
  }

  void append_triangle(const std::vector<Vec3>& positions, std::uint32_t base,
                       const std::array<std::uint32_t, 3>& v) {
    const std::array corners{positions[v[0]] - origin_, positions[v[1]] - origin_,
                             positions[v[2]] - origin_};
    const double error_m = ray_error_of(corners);
    if (error_m > kLargeShare * detail_m_ && set_.large.size() < kMostLargeTriangles)
      set_.large.push_back({static_cast<std::uint32_t>(set_.triangles.size() / 3), corners});
    else
      set_.other_error_m = std::fmax(set_.other_error_m, error_m);
    for (const std::uint32_t i : v) set_.triangles.push_back(base + i);
  }

  void append_patch(const PatchMeshData& mesh, const std::uint32_t* v,
                    const std::array<Vec3, 4>& c) {
    if (!mesh.normals.empty() || !table_.patch_normals.empty()) {
      table_.patch_normals.resize(set_.patches.size() + 1);
      for (int k = 0; k < 4 && !mesh.normals.empty(); ++k)
        table_.patch_normals.back()[k] = mesh.normals[v[k]];
    }
    set_.patches.push_back({c[0], c[1], c[2], c[3]});
  }

  const Vec3& origin_;
  double detail_m_;
  std::uint32_t surface_;
  GeometrySet& set_;
  bool has_uv_;
  SurfaceTable& table_;
};

/// Adds the bounds of a shape.
class BoundsAdder {
 public:
  explicit BoundsAdder(Bounds& bounds) : bounds_(bounds) {}

  absl::Status operator()(const TriangleMeshData& mesh) { return add_vertices(mesh.positions); }
  absl::Status operator()(const PatchMeshData& mesh) { return add_vertices(mesh.positions); }
  absl::Status operator()(const CurveData& data) {
    StopPoll poll;
    for (std::size_t i = 0; i < data.count(); ++i, poll())
      for (const CurvePiece& piece : pieces_of(cubic_curve(data, i), data.kind, {})) {
        const auto [lower, upper] = piece.bounds();
        const double reach = std::max(max_abs(lower), max_abs(upper));
        if (!(reach <= Accelerator::kMaxCoordinate))
          return absl::InvalidArgumentError(
              fmt::format("a curve reaching to {} m, allowed: coordinates up to 1e30", reach));
        bounds_.add(lower), bounds_.add(upper);
      }
    return absl::OkStatus();
  }
  template <typename Params>
  absl::Status operator()(const Params& params) {
    LUCERNA_ASSIGN_OR_RETURN(const auto shape, QuadricOf<Params>::create(params));
    const auto box = shape.bounds();
    const double reach = std::max(max_abs(box.first), max_abs(box.second));
    if (!(reach <= Accelerator::kMaxCoordinate))
      return absl::InvalidArgumentError(
          fmt::format("shape reaching to {} m, allowed: coordinates up to 1e30", reach));
    bounds_.add(box.first);
    bounds_.add(box.second);
    return absl::OkStatus();
  }

 private:
  absl::Status add_vertices(const std::vector<Vec3>& positions) {
    StopPoll poll;
    for (std::size_t i = 0; i < positions.size(); ++i, poll()) {
      const Vec3& p = positions[i];
      if (!is_finite(p) || max_abs(p) > Accelerator::kMaxCoordinate) return not_finite(i, p);
      bounds_.add(p);
    }
    return absl::OkStatus();
  }

  Bounds& bounds_;
};

}  // namespace

const PrimitiveRun& SurfaceTable::run(HitKind kind, std::uint32_t primitive) const {
  // A binary search without branches: no processor could predict them.
  const auto& of_kind = runs[static_cast<int>(kind)];
  const PrimitiveRun* run = of_kind.data();
  for (std::size_t count = of_kind.size(); count > 1;) {
    const std::size_t half = count / 2;
    const std::size_t step = run[half].first <= primitive ? 1 : 0;
    run += step * half;
    count -= half;
  }
  return *run;
}

bool SurfaceTable::has_non_opaque() const {
  return std::ranges::any_of(surfaces, &Surface::is_non_opaque);
}

const std::array<Vec2f, 3>& SurfaceTable::uv_of_triangle(std::uint32_t triangle) const {
  if (triangle_uv.empty()) return kTriangleUv;
  const PrimitiveRun& r = run(HitKind::kTriangle, triangle);
  return r.first_uv == PrimitiveRun::kNoUv ? kTriangleUv
                                           : triangle_uv[r.first_uv + (triangle - r.first)];
}

const std::array<Vec2f, 4>& SurfaceTable::uv_of_patch(std::uint32_t patch) const {
  if (patch_uv.empty()) return kPatchUv;
  const PrimitiveRun& r = run(HitKind::kPatch, patch);
  return r.first_uv == PrimitiveRun::kNoUv ? kPatchUv : patch_uv[r.first_uv + (patch - r.first)];
}

Vec2 SurfaceTable::triangle_uv_at(std::uint32_t triangle, double b, double c) const {
  const auto& uv = uv_of_triangle(triangle);
  const double a = 1 - b - c;
  return {uv[0].x * a + uv[1].x * b + uv[2].x * c, uv[0].y * a + uv[1].y * b + uv[2].y * c};
}

Vec2 SurfaceTable::patch_uv_at(std::uint32_t patch, double s, double t) const {
  const auto& uv = uv_of_patch(patch);
  const auto mix = [&](auto member) {
    return (uv[0].*member * (1 - s) + uv[1].*member * s) * (1 - t) +
           (uv[2].*member * (1 - s) + uv[3].*member * s) * t;
  };
  return {mix(&Vec2f::x), mix(&Vec2f::y)};
}

bool SurfaceTable::lets_pass(HitKind kind, std::uint32_t primitive, RayFilter filter,
                             const RayAtSurface& ray) const {
  const Surface& surface = surfaces[run(kind, primitive).surface];
  // Holes of a surface do not let a medium flow out.
  if (filter == RayFilter::kBoundaries) return !surface.media;
  if (surface.is_interface ||
      (filter == RayFilter::kPanes && !surface.pane_eta && !surface.is_sheet()))
    return true;
  if (!surface.is_non_opaque()) return false;
  // Direct light passes sheets in part.
  if (surface.is_sheet() && (filter == RayFilter::kOpaque || filter == RayFilter::kPanes))
    return filter == RayFilter::kOpaque;
  const Vec3 &p = ray.at.position, &o = ray.origin, &d = ray.direction;
  double u = hash_number({o.x, o.y, o.z, d.x, d.y, d.z, p.x, p.y, p.z, double(primitive)});
  TexturePoint at = ray.at;
  at.position += origin_m;
  if (surface.is_cut_out()) {
    const double alpha = (*textures)(surface.alpha, at);
    if (!(alpha > 0) || u > alpha) return true;
    u /= alpha;  // again even in [0, 1)
  }
  if (!surface.pane_eta || filter == RayFilter::kSurfaces || filter == RayFilter::kPanes)
    return false;
  if (filter == RayFilter::kOpaque) return true;
  return u < pane_transmittance(*surface.pane_eta, *textures, at, ray.cosine);
}

std::size_t SurfaceTable::bytes() const {
  std::size_t sum =
      surfaces.capacity() * sizeof(Surface) + smooth.capacity() * sizeof(SmoothSurface) +
      vertex_normals.capacity() * sizeof(Vec3f) + vertex_colours.capacity() * sizeof(Rgbf) +
      vertex_tangents.capacity() * sizeof(VertexTangent) +
      patch_normals.capacity() * sizeof(std::array<Vec3f, 4>) +
      triangle_uv.capacity() * sizeof(std::array<Vec2f, 3>) +
      patch_uv.capacity() * sizeof(std::array<Vec2f, 4>);
  for (const auto& r : runs) sum += r.capacity() * sizeof(PrimitiveRun);
  return sum;
}

absl::StatusOr<Bounds> shape_bounds(const ShapeDescription& shape) {
  Bounds bounds;
  if (absl::Status s = std::visit(BoundsAdder(bounds), shape.geometry); !s.ok())
    return located(s, shape.where);
  return bounds;
}

bool is_flat_and_convex(const std::array<Vec3, 4>& c) {
  const std::array<Vec3, 4> around{c[0], c[1], c[3], c[2]};
  const Vec3 n = cross(c[3] - c[0], c[2] - c[1]);  // of the diagonals
  const double size = length(n);
  if (!(size > 0)) return false;
  double largest = 0;
  for (const auto& p : c) largest = std::fmax(largest, max_abs(p));
  // Both diagonals are perpendicular to n, so the distance between them is the deviation from
  // a plane.
  if (std::fabs(dot(c[1] - c[0], n)) > 2 * kFloatRoundoff * largest * size) return false;
  for (int i = 0; i < 4; ++i) {
    const Vec3 turn =
        cross(around[(i + 1) % 4] - around[i], around[(i + 2) % 4] - around[(i + 1) % 4]);
    if (!(dot(turn, n) > 1e-6 * size * size)) return false;
  }
  return true;
}

absl::Status append_shape(const ShapeDescription& shape, const Vec3& origin, double detail_m,
                          std::int32_t light, GeometrySet& set, SurfaceTable& table) {
  const auto surface = static_cast<std::uint32_t>(table.surfaces.size());
  table.surfaces.push_back({.material = shape.material,
                            .light = light,
                            .alpha = shape.alpha,
                            .media = shape.media,
                            .is_interface = shape.is_interface});
  return located(
      std::visit(Appender(origin, detail_m, surface, set, shape.has_uv, table), shape.geometry),
      shape.where);
}

}  // namespace lucerna
