// Compares Embree's robust traversal with its default one in one run.  Not a test: its output is
// the last table of docs/precision.md.
//
// Rays start inside of a closed mesh, so every ray has a hit.  A third of the rays has any
// direction, a third goes through vertices, and a third through middles of edges, where
// watertightness matters.  A ray is `lost` if it hits nothing (counted for each third).  `off` is
// the distance of its t from that of the hit triangle's plane in double precision, in float
// roundings of the largest coordinate.
#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "lights/maths/vec.h"
#include "proto/common/quantile.h"

namespace lucerna {
namespace {

struct MeshOfBall {
  std::vector<Vec3f> vertices;
  std::vector<std::uint32_t> indices;
};

/// An octahedron whose triangles are split in four `times` times, on a ball of radius 1 about
/// `centre`.
MeshOfBall ball(int times, const Vec3& centre) {
  std::vector<Vec3> v{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::uint32_t> t{0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                               2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  for (int k = 0; k < times; ++k) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(v.size()));
      if (is_new) v.push_back(normalized(v[a] + v[b]));
      return at->second;
    };
    std::vector<std::uint32_t> cut;
    for (std::size_t i = 0; i < t.size(); i += 3) {
      const std::uint32_t a = t[i], b = t[i + 1], c = t[i + 2];
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      cut.insert(cut.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
    }
    t = std::move(cut);
  }
  MeshOfBall mesh{{}, std::move(t)};
  for (const auto& p : v) mesh.vertices.emplace_back(p + centre);
  mesh.vertices.reserve(mesh.vertices.size() + 1);  // Embree reads 16 bytes of the last 12
  return mesh;
}

struct Aim {
  Vec3f origin, direction;
};

std::vector<Aim> aims(const MeshOfBall& mesh, const Vec3& centre, std::size_t count) {
  std::mt19937_64 random(5);
  const auto u = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<Aim> all;
  all.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 2 * u() - 1, phi = 2 * std::numbers::pi * u(), r = std::sqrt(1 - z * z);
    const Vec3f origin(centre + Vec3{u() - 0.5, u() - 0.5, u() - 0.5} * 0.8);
    Vec3 target = centre + Vec3{r * std::cos(phi), r * std::sin(phi), z};
    const std::size_t t = 3 * (random() % (mesh.indices.size() / 3));
    const Vec3 a(mesh.vertices[mesh.indices[t]]), b(mesh.vertices[mesh.indices[t + 1]]);
    if (i % 3 == 1) target = a;
    if (i % 3 == 2) target = (a + b) * 0.5;
    all.push_back({origin, Vec3f(target - Vec3(origin))});
  }
  return all;
}

/// t of a triangle's plane, in double.
double t_of(const MeshOfBall& mesh, std::uint32_t triangle, const Aim& aim) {
  const auto corner = [&](int k) {
    return Vec3(mesh.vertices[mesh.indices[3 * std::size_t{triangle} + k]]);
  };
  const Vec3 n = cross(corner(1) - corner(0), corner(2) - corner(0));
  return dot(n, corner(0) - Vec3(aim.origin)) / dot(n, Vec3(aim.direction));
}

struct Found {
  double ns = 0;
  std::size_t lost[3] = {};  // any direction, vertices, edges
  double off = 0;
};

class Traversal {
 public:
  Traversal(RTCDevice device, const MeshOfBall& mesh, RTCSceneFlags flags)
      : scene_(rtcNewScene(device)) {
    rtcSetSceneFlags(scene_, flags);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh.vertices.data(), 0, sizeof(Vec3f), mesh.vertices.size());
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(),
                               0, 3 * sizeof(std::uint32_t), mesh.indices.size() / 3);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene_, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene_);
  }
  ~Traversal() { rtcReleaseScene(scene_); }
  Traversal(const Traversal&) = delete;
  Traversal& operator=(const Traversal&) = delete;

  /// Nanoseconds of processor time per ray.
  double run(const std::vector<Aim>& aims, std::vector<RTCRayHit>& hits) const {
    hits.resize(aims.size());
    const std::clock_t begin = std::clock();
    for (std::size_t i = 0; i < aims.size(); ++i) {
      RTCRayHit& h = hits[i];
      h = {};
      h.ray.org_x = aims[i].origin.x, h.ray.org_y = aims[i].origin.y,
      h.ray.org_z = aims[i].origin.z;
      h.ray.dir_x = aims[i].direction.x, h.ray.dir_y = aims[i].direction.y;
      h.ray.dir_z = aims[i].direction.z;
      h.ray.tfar = INFINITY;
      h.ray.mask = ~0U;
      h.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcIntersect1(scene_, &context, &h);
    }
    const double took_ns = 1e9 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return took_ns / static_cast<double>(aims.size());
  }

 private:
  RTCScene scene_;
};

Found judge(const MeshOfBall& mesh, const Vec3& centre, const std::vector<Aim>& aims,
            const std::vector<RTCRayHit>& hits) {
  Found found;
  const double rounding = 0x1p-24 * (max_abs(centre) + 1);
  for (std::size_t i = 0; i < aims.size(); ++i) {
    if (hits[i].hit.geomID == RTC_INVALID_GEOMETRY_ID) {
      ++found.lost[i % 3];
      continue;
    }
    const double t = t_of(mesh, hits[i].hit.primID, aims[i]);
    const double off_m = std::fabs(hits[i].ray.tfar - t) * length(Vec3(aims[i].direction));
    found.off = std::max(found.off, off_m / rounding);
  }
  return found;
}

std::string lost_of(const Found& f) {
  return fmt::format("{}, {}, {}", f.lost[0], f.lost[1], f.lost[2]);
}

/// The sum over all balls.
struct Summary {
  std::size_t rays = 0, lost_fast = 0, lost_robust = 0;
  double least_ratio = INFINITY, most_ratio = 0;
};

void compare(RTCDevice device, int times, const Vec3& centre, const std::string& where,
             Summary& all) {
  constexpr std::size_t kRays = 600000;
  constexpr int kRepeats = 9;
  const MeshOfBall mesh = ball(times, centre);
  const std::vector<Aim> rays = aims(mesh, centre, kRays);
  const Traversal fast(device, mesh, RTC_SCENE_FLAG_NONE),
      robust(device, mesh, RTC_SCENE_FLAG_ROBUST);
  std::vector<RTCRayHit> hits;
  std::vector<double> fast_ns, robust_ns, ratios;
  Found fast_found, robust_found;
  for (int k = 0; k < kRepeats; ++k) {
    fast_ns.push_back(fast.run(rays, hits));
    if (k == 0) fast_found = judge(mesh, centre, rays, hits);
    robust_ns.push_back(robust.run(rays, hits));
    if (k == 0) robust_found = judge(mesh, centre, rays, hits);
    ratios.push_back(robust_ns.back() / fast_ns.back());
  }
  fmt::print("| {} | {} | {} | {} | {:.1f} | {:.1f} | {:.0f} | {:.0f} | {:.2f} |\n",
             mesh.indices.size() / 3, where, lost_of(fast_found), lost_of(robust_found),
             fast_found.off, robust_found.off, median(fast_ns), median(robust_ns), median(ratios));
  all.rays += kRays;
  for (const std::size_t lost : fast_found.lost) all.lost_fast += lost;
  for (const std::size_t lost : robust_found.lost) all.lost_robust += lost;
  all.least_ratio = std::min(all.least_ratio, median(ratios));
  all.most_ratio = std::max(all.most_ratio, median(ratios));
}

int run() {
  fmt::print(
      "| triangles | centre | lost, default | lost, robust | off, default | off, robust | "
      "ns a ray, default | robust | ratio |\n|---|---|---|---|---|---|---|---|---|\n");
  RTCDevice device = rtcNewDevice(nullptr);
  Summary all;
  for (const int times : {4, 6, 8}) {
    compare(device, times, {}, "0", all);
    compare(device, times, {1000, -2000, 3000}, "(1000, -2000, 3000)", all);
  }
  rtcReleaseDevice(device);
  fmt::print(
      "\nOf {} rays default traversal loses {}, robust traversal {}, in {:.2f} to {:.2f} times the "
      "time.\n",
      all.rays, all.lost_fast, all.lost_robust, all.least_ratio, all.most_ratio);
  return 0;
}

}  // namespace
}  // namespace lucerna

int main() { return lucerna::run(); }
