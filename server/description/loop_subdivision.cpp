#include "server/description/loop_subdivision.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Half-edge 3 f + k of triangle f goes from its vertex k to the next.
std::uint32_t next_in_face(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
std::uint32_t previous_in_face(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// A mesh whose triangles know their neighbours.
struct Level {
  std::vector<Vec3> positions;
  std::vector<std::uint32_t> indices;
  std::vector<std::uint32_t> twins;  ///< of each half-edge, kNone on the boundary

  std::uint32_t start(std::uint32_t h) const { return indices[h]; }
  std::uint32_t end(std::uint32_t h) const { return indices[next_in_face(h)]; }
  std::uint32_t half_edges() const { return static_cast<std::uint32_t>(indices.size()); }
  /// Whether the half-edge stands for its edge: each edge has one such half-edge.
  bool leads(std::uint32_t h) const { return twins[h] == kNone || h < twins[h]; }
};

/// The neighbours of each vertex.
struct Neighbours {
  Vec3 sum;           ///< of all
  Vec3 boundary_sum;  ///< of the two on the boundary
  std::uint32_t valence = 0;
  bool on_boundary = false;
};

std::vector<Neighbours> neighbours_of(const Level& level) {
  std::vector<Neighbours> result(level.positions.size());
  StopPoll poll;
  for (std::uint32_t h = 0; h < level.half_edges(); ++h, poll()) {
    if (!level.leads(h)) continue;
    const std::uint32_t a = level.start(h), b = level.end(h);
    const bool boundary = level.twins[h] == kNone;
    for (const auto& [of, other] : {std::pair{a, b}, std::pair{b, a}}) {
      Neighbours& n = result[of];
      n.sum += level.positions[other];
      ++n.valence;
      if (!boundary) continue;
      n.boundary_sum += level.positions[other];
      n.on_boundary = true;
    }
  }
  return result;
}

/// The weight of each neighbour of a vertex inside.  [Warren95]
double beta(std::uint32_t valence) { return valence == 3 ? 3.0 / 16 : 3.0 / (8.0 * valence); }

Vec3 mixed(const Vec3& p, const Vec3& sum, std::uint32_t count, double weight) {
  return p * (1 - count * weight) + sum * weight;
}

/// The next level: each triangle becomes four.  Child 4 f + k has the corner k of triangle f, and
/// child 4 f + 3 the middles of its edges.
Level refined(const Level& level) {
  Level next;
  const std::uint32_t vertices = static_cast<std::uint32_t>(level.positions.size());
  const std::vector<Neighbours> neighbours = neighbours_of(level);
  // An edge has at least one of six half-edges about a vertex; this is close for large meshes.
  next.positions.reserve(std::size_t{vertices} + level.half_edges() / 2 + vertices / 8);
  StopPoll poll;
  for (std::uint32_t v = 0; v < vertices; ++v, poll()) {
    const Neighbours& n = neighbours[v];
    next.positions.push_back(n.on_boundary
                                 ? mixed(level.positions[v], n.boundary_sum, 2, 1.0 / 8)
                                 : mixed(level.positions[v], n.sum, n.valence, beta(n.valence)));
  }
  std::vector<std::uint32_t> middle(level.half_edges());
  for (std::uint32_t h = 0; h < level.half_edges(); ++h, poll()) {
    if (!level.leads(h)) {
      middle[h] = middle[level.twins[h]];
      continue;
    }
    middle[h] = static_cast<std::uint32_t>(next.positions.size());
    const Vec3 ends = level.positions[level.start(h)] + level.positions[level.end(h)];
    if (level.twins[h] == kNone) {
      next.positions.push_back(ends * 0.5);
      continue;
    }
    const auto opposite = [&](std::uint32_t e) {
      return level.positions[level.start(previous_in_face(e))];
    };
    next.positions.push_back(ends * (3.0 / 8) +
                             (opposite(h) + opposite(level.twins[h])) * (1.0 / 8));
  }
  next.indices.resize(4 * level.indices.size());
  next.twins.resize(next.indices.size());
  // A half-edge of a child: of the triangle of `h`, at the corner where `h` starts.
  const auto at_corner = [](std::uint32_t h, std::uint32_t k) {
    return 3 * (4 * (h / 3) + h % 3) + k;
  };
  const auto at_centre = [](std::uint32_t h) { return 3 * (4 * (h / 3) + 3) + h % 3; };
  for (std::uint32_t h = 0; h < level.half_edges(); ++h, poll()) {
    const std::uint32_t before = previous_in_face(h);
    // Corner child: the corner, the middle of its edge h, the middle of the edge before.
    next.indices[at_corner(h, 0)] = level.start(h);
    next.indices[at_corner(h, 1)] = middle[h];
    next.indices[at_corner(h, 2)] = middle[before];
    next.indices[at_centre(h)] = middle[h];
    next.twins[at_corner(h, 1)] = at_centre(before);
    next.twins[at_centre(before)] = at_corner(h, 1);
    const std::uint32_t along = level.twins[h], back = level.twins[before];
    next.twins[at_corner(h, 0)] = along == kNone ? kNone : at_corner(next_in_face(along), 2);
    next.twins[at_corner(h, 2)] = back == kNone ? kNone : at_corner(back, 0);
  }
  return next;
}

/// Two tangents of the limit surface from the ring of neighbours, counterclockwise about the
/// winding's normal.  On the boundary, the ring runs from one boundary edge to the other.
/// [Pharr16, 3.8]
std::pair<Vec3, Vec3> tangents(const Vec3& p, const std::vector<Vec3>& ring, bool on_boundary) {
  const std::size_t n = ring.size();
  Vec3 s{}, t{};
  if (!on_boundary) {
    for (std::size_t k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
      s += ring[k] * std::cos(angle);
      t += ring[k] * std::sin(angle);
    }
    return {s, t};
  }
  s = ring.front() - ring.back();
  if (n == 2) {
    t = ring[0] + ring[1] - p * 2.0;
  } else if (n == 3) {
    t = ring[1] - p;
  } else if (n == 4) {
    t = (ring[1] + ring[2]) * 2.0 - ring[0] - ring[3] - p * 2.0;
  } else {
    const double theta = std::numbers::pi / static_cast<double>(n - 1);
    t = (ring.front() + ring.back()) * -std::sin(theta);
    for (std::size_t k = 1; k + 1 < n; ++k)
      t += ring[k] * ((2 - 2 * std::cos(theta)) * std::sin(static_cast<double>(k) * theta));
  }
  return {s, t};
}

LimitMesh limit_of(Level level) {
  LimitMesh limit;
  const std::vector<Neighbours> neighbours = neighbours_of(level);
  // The half-edge where the ring of each vertex starts: on the boundary, the first one
  // counterclockwise.
  std::vector<std::uint32_t> first(level.positions.size(), kNone);
  StopPoll poll;
  for (std::uint32_t h = 0; h < level.half_edges(); ++h, poll())
    if (level.twins[h] == kNone || first[level.start(h)] == kNone) first[level.start(h)] = h;
  limit.positions.reserve(level.positions.size());
  limit.normals.reserve(level.positions.size());
  std::vector<Vec3> ring;
  for (std::size_t v = 0; v < level.positions.size(); ++v, poll()) {
    const Neighbours& n = neighbours[v];
    const Vec3& p = level.positions[v];
    ring.clear();
    for (std::uint32_t h = first[v]; h != kNone; poll()) {
      ring.push_back(level.positions[level.end(h)]);
      const std::uint32_t into = previous_in_face(h);
      h = level.twins[into];
      if (h == kNone) ring.push_back(level.positions[level.start(into)]);
      if (h == first[v]) break;
    }
    const auto [s, t] = tangents(p, ring, n.on_boundary);
    limit.normals.push_back(cross(t, s));
    limit.positions.push_back(
        n.on_boundary ? mixed(p, n.boundary_sum, 2, 1.0 / 5)
                      : mixed(p, n.sum, n.valence, 1 / (n.valence + 3 / (8 * beta(n.valence)))));
  }
  limit.indices = std::move(level.indices);
  return limit;
}

absl::Status invalid(const std::string& what) { return absl::InvalidArgumentError(what); }

/// Finds the neighbours of each triangle and checks that they make a surface.
absl::StatusOr<Level> connected(ControlMesh mesh) {
  Level level{std::move(mesh.positions), std::move(mesh.indices), {}};
  struct Edge {
    std::uint32_t low, high, half_edge;
  };
  std::vector<Edge> edges;
  edges.reserve(level.indices.size());
  StopPoll poll;
  for (std::uint32_t h = 0; h < level.half_edges(); ++h, poll()) {
    if (level.start(h) >= level.positions.size())
      return invalid(fmt::format("index {} names vertex {}, but there are {} vertices", h,
                                 level.start(h), level.positions.size()));
    if (level.start(h) == level.end(h))
      return invalid(fmt::format("triangle {} has vertex {} twice", h / 3, level.start(h)));
    edges.push_back(
        {std::min(level.start(h), level.end(h)), std::max(level.start(h), level.end(h)), h});
  }
  std::ranges::sort(edges, {}, [&](const Edge& e) {
    poll();
    return std::tuple(e.low, e.high, e.half_edge);
  });
  level.twins.assign(level.indices.size(), kNone);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i, poll()) {
    const auto joins = [&](std::size_t a, std::size_t b) {
      return b < edges.size() && edges[a].low == edges[b].low && edges[a].high == edges[b].high;
    };
    if (!joins(i, i + 1)) continue;
    const std::uint32_t a = edges[i].half_edge, b = edges[i + 1].half_edge;
    if (joins(i, i + 2))
      return invalid(
          fmt::format("the edge from vertex {} to {} has three triangles or more ({}, {}, "
                      "{}), allowed: at most two",
                      edges[i].low, edges[i].high, a / 3, b / 3, edges[i + 2].half_edge / 3));
    if (level.start(a) == level.start(b))
      return invalid(
          fmt::format("triangles {} and {} have opposite windings at the edge from vertex "
                      "{} to {}, allowed: the same winding",
                      a / 3, b / 3, edges[i].low, edges[i].high));
    level.twins[a] = b, level.twins[b] = a;
    ++i;
  }
  return level;
}

/// Checks that the triangles of each vertex form one fan, and leaves out vertices without any.
absl::Status check_fans(Level& level) {
  // Corners not yet reached from a first corner of their vertex.
  std::vector<bool> seen(level.indices.size());
  std::vector<bool> used(level.positions.size());
  StopPoll poll;
  const auto walk = [&](std::uint32_t h) {
    for (; h != kNone && !seen[h]; h = level.twins[previous_in_face(h)], poll()) seen[h] = true;
  };
  // On a boundary the walk must start there, so that it reaches all triangles.
  for (const bool boundary : {true, false})
    for (std::uint32_t h = 0; h < level.half_edges(); ++h, poll()) {
      if (seen[h] || (boundary && level.twins[h] != kNone)) continue;
      const std::uint32_t v = level.start(h);
      if (used[v])
        return invalid(fmt::format(
            "two parts of the surface touch only at vertex {}, allowed: a vertex of one part", v));
      used[v] = true;
      walk(h);
    }
  std::vector<std::uint32_t> number(level.positions.size());
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < number.size(); ++v, poll()) {
    if (!used[v]) continue;
    level.positions[count] = level.positions[v];
    number[v] = count++;
  }
  level.positions.resize(count);
  for (std::uint32_t& v : level.indices) poll(), v = number[v];
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LimitMesh> loop_subdivide(ControlMesh mesh, int levels, std::stop_token stop) {
  const std::uint64_t triangles = mesh.indices.size() / 3;
  if (triangles == 0) return LimitMesh{};
  mesh.indices.resize(3 * triangles);
  // 4^12 exceeds the limit by itself.
  if (levels > 12 || triangles > kMostLimitTriangles >> (2 * levels))
    return absl::ResourceExhaustedError(
        fmt::format("{} triangles at \"integer levels\" = {} become more than {}, the limit",
                    triangles, levels, kMostLimitTriangles));
  LUCERNA_ASSIGN_OR_RETURN(Level level, connected(std::move(mesh)));
  LUCERNA_RETURN_IF_ERROR(check_fans(level));
  for (int i = 0; i < levels; ++i) {
    if (stop.stop_requested()) return absl::CancelledError("loading was cancelled");
    level = refined(level);
  }
  return limit_of(std::move(level));
}

}  // namespace lucerna
