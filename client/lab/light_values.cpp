#include "client/lab/light_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucerna::verify {
namespace {

constexpr Double3 kHidden = {kNaN, kNaN, kNaN};
// Samples on the light for each receiver.  On a sphere the nearest of them is then within a tenth
// of the radius, and its tangent plane within 1% of the surface.
constexpr std::uint32_t kNearSamples = 64;

Double3 rgb(const v1::Rgb& c) { return {c.r(), c.g(), c.b()}; }

}  // namespace

std::optional<Double3> LightValues::constant() const {
  switch (light_.kind_case()) {
    case v1::Light::kUniformInfinite:
      return rgb(light_.uniform_infinite().radiance_cd_m2());
    case v1::Light::kDiffuseArea:
      if (light_.diffuse_area().has_image() || light_.diffuse_area().has_profile()) return {};
      return rgb(light_.diffuse_area().radiance_cd_m2());
    case v1::Light::kImageInfinite:
      if (light_.image_infinite().has_map()) return {};
      return rgb(light_.image_infinite().radiance_cd_m2());
    case v1::Light::kSun:
      if (!sun_) {
        const Double3 center = double3(truth_.scene().center_m());
        sun_ = truth_.samples(light_.id(), {center}, {}, 1, 1, v1::AREA_SAMPLING_UNSPECIFIED)
                   .value.front();
      }
      return sun_;
    default:
      return {};
  }
}

std::vector<Double3> LightValues::of_sky(const std::vector<Double3>& directions,
                                         const Variation& variation) const {
  // Rays start beyond the scene, so nothing hides the sky.
  const Double3 center = double3(truth_.scene().center_m());
  const double far = 2 * truth_.scene().radius_m() + 1;
  const std::vector<Double3> turned = variation.vectors(directions);
  std::vector<Double3> starts;
  for (const Double3& w : turned) starts.push_back(center + far * w);
  return truth_.radiances(light_.id(), starts, turned);
}

std::vector<Double3> LightValues::at(const std::vector<Double3>& points,
                                     const std::vector<Double3>& directions,
                                     const std::vector<double>& distances,
                                     const Variation& variation) const {
  if (points.empty()) return {};
  if (light_.delta())
    return truth_.samples(light_.id(), points, {}, 1, 1, v1::AREA_SAMPLING_UNSPECIFIED, variation)
        .value;
  const std::vector<double> q = truth_.densities(light_.id(), points, {}, directions,
                                                 v1::AREA_SAMPLING_UNSPECIFIED, variation);
  std::vector<Double3> result(points.size());
  if (std::optional<Double3> level = constant()) {
    if (!variation.scene_id.empty()) {
      // The sun of another size has another radiance for the same illuminance.
      level = truth_
                  .samples(light_.id(), {points.front()}, {}, 1, 1, v1::AREA_SAMPLING_UNSPECIFIED,
                           variation)
                  .value.front();
    }
    for (std::size_t i = 0; i < points.size(); ++i)
      if (q[i] > 0) result[i] = *level;
    return result;
  }
  if (light_.kind_case() == v1::Light::kImageInfinite &&
      light_.image_infinite().portal_m_size() == 0)
    return of_sky(directions, variation);
  std::vector<Double3> starts;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool known = i < distances.size() && std::isfinite(distances[i]);
    const Double3 start =
        known ? points[i] + kAlmostThere * distances[i] * directions[i] : points[i];
    starts.push_back(variation.point(start));
  }
  result = truth_.radiances(light_.id(), starts, variation.vectors(directions));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (result[i] == Double3{} && q[i] > 0) result[i] = kHidden;
  return result;
}

std::vector<bool> on_back(const v1::Light& light, const Records& rows) {
  std::vector<bool> back(rows.rows, false);
  if (light.kind_case() != v1::Light::kDiffuseArea || light.diffuse_area().two_sided() ||
      rows.value.empty())
    return back;
  const v1::DiffuseAreaLight& area = light.diffuse_area();
  const bool flat = frame_of(light).flat && area.primitives() <= 1;
  // A light that is dark everywhere is wrong.
  if (flat || std::ranges::none_of(rows.value, [](double v) { return v > 0; })) return back;
  for (std::size_t i = 0; i < rows.rows; ++i) back[i] = rows.value[i] == 0;
  return back;
}

bool is_plane(const v1::DiffuseAreaLight& area) {
  if (area.shape() == v1::AREA_SHAPE_DISK) return true;
  if (area.primitives() > 1 || area.corners_m_size() < 3) return false;
  if (area.corners_m_size() == 3) return true;
  const Double3 origin = double3(area.corners_m(0));
  const Double3 n = cross(double3(area.corners_m(1)) - origin, double3(area.corners_m(2)) - origin);
  const Double3 last = double3(area.corners_m(3)) - origin;
  return std::fabs(dot(n, last)) <= 1e-6 * length(n) * length(last);
}

Hits hits(Truth& truth, const v1::Light& light, const std::vector<Double3>& points,
          const std::vector<Double3>& directions) {
  Hits h;
  h.distance.assign(points.size(), kNaN);
  h.cos_light.assign(points.size(), kNaN);
  h.normals.assign(points.size(), kHidden);
  if (!light.has_bounds()) return h;
  const bool delta = light.delta();
  const std::uint32_t count = delta ? 1 : kNearSamples;
  const LightSamples s =
      truth.samples(light.id(), points, {}, count, 1, v1::AREA_SAMPLING_UNSPECIFIED);
  for (std::size_t i = 0; i < points.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = i * count; k < (i + 1) * count; ++k) {
      h.behind |= s.behind[k];
      // A delta light has a distance even where it is dark.
      if (delta && s.distance[k] > 0) h.distance[i] = s.distance[k];
      if (delta || !s.ok[k]) continue;
      // Where the ray meets the tangent plane of this sample.
      const Double3 n = s.light_normals[k];
      const double along = dot(n, directions[i]);
      const double cosine = light.diffuse_area().two_sided() ? std::fabs(along) : -along;
      if (!(cosine > 1e-6)) continue;
      const Double3 place = s.distance[k] * s.directions[k];
      const double t = dot(n, place) / along;
      const double away = length(t * directions[i] - place);
      if (away >= least) continue;
      least = away;
      h.distance[i] = t;
      h.cos_light[i] = cosine;
      h.normals[i] = n;
    }
  }
  return h;
}

}  // namespace lucerna::verify
