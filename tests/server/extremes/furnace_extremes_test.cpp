// Row 26: shading normals that differ from geometric ones.  A surface is diffuse about its shading
// normal, on the viewer's side.  That normal alone decides how light is chosen, weighted and
// counted.  The geometric normal only decides to which side of the surface a ray leaves.  So a
// sheet of reflectance 1 in an environment of radiance 1 has radiance 1, whatever its shading
// normals.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "server/estimate/path.h"
#include "server/estimate/render.h"
#include "tests/extremes_sweep.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

constexpr double kTilts_deg[] = {0, 10, 30, 60, 80, 89, 89.9};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// A square at z = 0 of 8 x 8 cells.  The normals of its corners are tilted by `tilt_deg`, in
/// directions all around or all towards +x.
SceneDescription sheet(double tilt_deg, bool all_to_x) {
  constexpr int kCells = 8;
  TriangleMeshData mesh;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      mesh.positions.push_back({2.0 * i / kCells - 1, 2.0 * j / kCells - 1, 0});
      const double turn = all_to_x ? 0 : 2.4 * (i + 9 * j), t = radians(tilt_deg);
      mesh.normals.push_back(
          Vec3f(Vec3{std::sin(t) * std::cos(turn), std::sin(t) * std::sin(turn), std::cos(t)}));
    }
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = i + j * (kCells + 1), b = a + kCells + 1;
      for (const std::uint32_t k : {a, a + 1, b, a + 1, b + 1, b}) mesh.indices.push_back(k);
    }
  SceneDescription d = description(1);
  d.shapes.push_back({std::move(mesh)});
  return d;
}

/// The result of a renderer that draws directions about the geometric normal but takes their
/// density about the shading normal.  It is the share of one hemisphere that lies in the other.
float share_above(double tilt_deg) {
  return (1 + std::cos(static_cast<float>(radians(tilt_deg)))) / 2;
}

TEST(FurnaceExtremes, ASheetInAUniformEnvironment) {
  Sweep sweep(26, "sheet of reflectance 1 in a uniform environment, shading normals tilted by",
              "0 ... 89.9 deg, from above and below", "radiance");
  for (const double tilt : kTilts_deg)
    for (const double height : {1.5, -1.5}) {
      SceneDescription d = sheet(tilt, false);
      d.lights.push_back({UniformInfiniteLightParams{Rgb(1)}, {"test.pbrt", 1, 1}});
      d.camera.world_from_camera = *Transform::look_at({0.3, -0.4, height}, {0, 0, 0}, {0, 1, 0});
      d.camera.screen_min = {-0.5, -0.5}, d.camera.screen_max = {0.5, 0.5};
      const auto scene = build(std::move(d));
      const TileResult tile = render_tile(
          *scene, {.rect = {0, 0, 16, 12}, .seed = 1, .samples_per_block = 1024, .bounces = 3}, {});
      double sum = 0, squares = 0;
      for (const BlockStatistics& c : tile.channels) sum += c.sum, squares += c.sum * c.sum;
      const double n = double(tile.channels.size()), mean = sum / n;
      // The three channels of a pixel count as one number.
      const double standard_error = std::sqrt((squares / n - mean * mean) / (n / 3));
      EXPECT_NEAR(mean, 1, 6 * standard_error + 1e-7) << tilt;
      sweep.compare(mean, 1, std::to_string(tilt) + " from " + std::to_string(height));
      sweep.compare_textbook(share_above(tilt), 1);
    }
  // Six standard errors of 2e5 independent samples with a standard deviation of 0.3.  Sobol' points
  // are more accurate.
  sweep.expect_within(4e-3);
}

/// Radiance of a diffuse surface of reflectance 1 with normal `n` at `p`, lit by a polygon of
/// radiance 1 above its horizon.  The polygon is counter-clockwise as seen from `p`.  Lambert's
/// formula.
double lambert(const Vec3& p, const Vec3& n, const std::vector<Vec3>& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 a = normalized(polygon[i] - p),
               b = normalized(polygon[(i + 1) % polygon.size()] - p), c = cross(a, b);
    sum += std::atan2(length(c), dot(a, b)) * dot(normalized(c), n);
  }
  return std::fabs(sum) / (2 * std::numbers::pi);
}

struct Estimates {
  double both = 0, by_light = 0, by_direction = 0;
};

Estimates estimates(const Scene& scene, const SurfaceHit& hit, const Vec3f& wo) {
  constexpr std::uint32_t kSamples = 1 << 15;
  const PathTracer tracer(scene, 0, {});
  const SampleSequence sequence(Sampler::kSobol, 7, 0, 0);
  Estimates sum;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const PathSample s{sequence, i};
    WorkCounts work;
    sum.both += double(tracer.reflected(hit, wo, 0, s, work).value.g);
    const auto n = dot(hit.ns, Vec3(wo)) < 0 ? -hit.ns : hit.ns;
    const auto add_by_light = [&](const Light& light) {
      const auto u = s.at(0, PathSample::kLightPoint);
      const auto sample = light.sample_li(hit.position, {u.x, u.y});
      const double cosine = dot(Vec3(n), Vec3(sample.wi));
      if (sample.reason != NoLight::kNone || cosine <= 0) return;
      if (scene.geometry().occluded(shadow_ray(hit, sample))) return;
      sum.by_light += double(sample.value.g) * cosine / std::numbers::pi / sample.pdf.per_sr;
    };
    add_by_light(*scene.lights()[0].light);
    const auto wi =
        PathTracer::cosine_direction(Vec3f(hit.ns), wo, s.at(0, PathSample::kDirection));
    const Ray ray = spawn_ray(hit, wi);
    for_each_emitter(scene, ray, scene.closest_hit(ray),
                     [&](std::uint32_t, const auto& le) { sum.by_direction += double(le.g); });
  }
  return {sum.both / kSamples, sum.by_light / kSamples, sum.by_direction / kSamples};
}

// A lamp half above and half below the surface, but all above the horizon of the shading normal.
TEST(FurnaceExtremes, LightsAndDirectionsAgree) {
  Sweep sweep(26, "lamp cut by the surface's plane, shading normals tilted towards it by",
              "30 ... 89.9 deg", "radiance, from samples of lights, of directions, and of both");
  for (const double tilt : kTilts_deg) {
    if (tilt < 30) continue;
    SceneDescription d = sheet(tilt, true);
    const std::vector<Vec3> lamp{
        {1.2, -0.8, -0.3}, {1.2, 0.8, -0.3}, {1.2, 0.8, 0.3}, {1.2, -0.8, 0.3}};
    d.shapes.push_back(emissive(patch(lamp[0], lamp[1], lamp[3], lamp[2]), 1, true));
    const auto scene = build(std::move(d));
    const Vec3 o = scene->origin();
    const Vec3 eye{0.6, 0, 2}, at{0.53, 0.07, 0};
    const auto hit = scene->closest_hit({Vec3f(eye - o), Vec3f(normalized(at - eye))});
    ASSERT_TRUE(hit);
    const Vec3 ns{std::sin(radians(tilt)), 0, std::cos(radians(tilt))};
    const double truth = lambert(Vec3(hit->position) + o, ns, lamp);
    const Estimates e = estimates(*scene, *hit, Vec3f(normalized(eye - at)));
    const std::string where = " at " + std::to_string(tilt);
    sweep.compare(e.by_light, truth, "lights" + where);
    sweep.compare(e.by_direction, truth, "directions" + where);
    sweep.compare(e.both, truth, "both" + where);
    // Only the part of the lamp above the horizon of the geometric normal, about which directions
    // are drawn.
    std::vector<Vec3> upper = lamp;
    upper[0].z = upper[1].z = 0;
    sweep.compare_textbook(lambert(Vec3(hit->position) + o, ns, upper), truth);
  }
  sweep.expect_within(3e-3);
}

}  // namespace
}  // namespace lucerna::testing
