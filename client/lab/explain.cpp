#include "client/lab/explain.h"

#include <algorithm>
#include <cmath>

#include "client/files/srgb.h"
#include "client/lab/comparison.h"
#include "client/lab/rotation.h"

namespace lucerna::verify {
namespace {

// A mistake shows in this many rows as well as in all.
constexpr std::size_t kMostExplainedRows = 400;

std::vector<double> luminances(const std::vector<Double3>& all) {
  std::vector<double> result;
  result.reserve(all.size());
  for (const Double3& c : all) result.push_back(luminance(c));
  return result;
}

std::vector<double> ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = a[i] / b[i];
  return result;
}

std::vector<double> square(std::vector<double> a) {
  for (double& v : a) v *= v;
  return a;
}

/// Hypotheses that multiply by cosines and distances.
void add_geometry(const std::vector<double>& ours, const Geometry& g, bool density,
                  std::vector<Hypothesis>* all) {
  add_product(ours, g.cos_receiver, 1, "cosine_receiver",
              "a cosine at the receiver is a factor too many", all);
  add_product(ours, g.cos_receiver, -1, "cosine_receiver", "a cosine at the receiver is missing",
              all);
  add_product(ours, g.cos_light, 1, "cosine_light", "a cosine at the light is a factor too many",
              all);
  add_product(ours, g.cos_light, -1, "cosine_light", "a cosine at the light is a divisor too many",
              all);
  if (!g.cos_geometric.empty()) {
    add_product(ours, g.cos_geometric, 1, "cosine_receiver",
                "a cosine about the geometric normal is a factor too many", all);
    if (!g.cos_receiver.empty())
      add_product(ours, ratio(g.cos_geometric, g.cos_receiver), 1, "shading_normal",
                  "the geometric normal is used instead of the shading normal", all);
  }
  const std::vector<double> squares = square(g.distance);
  if (density) {
    add_product(ours, ratio(g.cos_light, squares), 1, "measure_area",
                "the density is with respect to area, not to solid angle (cos / r2 remains)", all);
    add_product(ours, ratio(g.cos_light, squares), -1, "measure_area",
                "the density is converted from area to solid angle twice", all);
    if (!g.cos_given_light.empty())
      add_product(ours, ratio(g.cos_light, g.cos_given_light), 1, "shading_normal",
                  "the density uses the shading normal of the light, not the geometric one", all);
  } else {
    add_product(ours, squares, 1, "inverse_square", "a division by r2 is missing", all);
    add_product(ours, squares, -1, "inverse_square", "a division by r2 is too many", all);
  }
  add_product(ours, g.distance, 1, "distance", "a factor of the distance r is too many", all);
  add_product(ours, g.distance, -1, "distance", "a division by the distance r is too many", all);
  if (density) {
    add_product(ours, squares, 1, "inverse_square", "a factor of r2 is too many", all);
    add_product(ours, squares, -1, "inverse_square", "a factor of r2 is missing", all);
  }
}

void add_selection(const std::vector<double>& ours, const std::vector<double>& selection,
                   std::vector<Hypothesis>* all) {
  add_product(ours, selection, 1, "selection",
              "the numbers are multiplied by the probability of choosing the light", all);
  add_product(ours, selection, -1, "selection",
              "the numbers are divided by the probability of choosing the light", all);
}

/// One-sided lights that shine from both sides, and the other way round.  `numbers` returns those
/// of a variation.
template <class Numbers>
void add_sides(const v1::Light& light, const std::vector<double>& ours, const Records& rows,
               Numbers&& numbers, std::vector<Hypothesis>* all) {
  if (light.kind_case() != v1::Light::kDiffuseArea) return;
  const LightFrame frame = frame_of(light);
  if (!frame.flat || !frame.has_axes) return;
  const Double3 n = frame.axes[2];
  if (!light.diffuse_area().two_sided()) {
    Variation mirror;
    mirror.center = frame.center;
    for (std::size_t column = 0; column < 3; ++column)
      mirror.turn[column] = kIdentity[column] - 2 * n[column] * n;
    std::vector<double> both = numbers(mirror);
    for (std::size_t i = 0; i < both.size(); ++i) both[i] = std::max(both[i], ours[i]);
    all->push_back({"two_sides", "the light shines from both sides, but only one side emits",
                    std::move(both), 1});
    return;
  }
  for (const double side : {1.0, -1.0}) {
    std::vector<double> one = ours;
    for (std::size_t i = 0; i < one.size(); ++i)
      if (side * dot(rows.points[i] - frame.center, n) < 0) one[i] = 0;
    all->push_back({"one_side", "the light shines from one side only, but both sides emit",
                    std::move(one), 1});
  }
}

template <class Curve>
Double3 by_channel(const Double3& rgb, const Double3& level, Curve&& curve) {
  Double3 result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = level[i] > 0 ? level[i] * curve(rgb[i] / level[i]) : rgb[i];
  return result;
}

std::vector<double> times(std::vector<double> values, double factor) {
  for (double& v : values) v *= factor;
  return values;
}

}  // namespace

Double3 not_linearised(const Double3& rgb, const Double3& level) {
  return by_channel(rgb, level, srgb_encoded);
}
Double3 linearised_twice(const Double3& rgb, const Double3& level) {
  return by_channel(rgb, level, srgb_decoded);
}

Double3 texel_level(const v1::Light& light) {
  const auto triple = [](const v1::Rgb& c) { return Double3{c.r(), c.g(), c.b()}; };
  const auto brightest = [&](const v1::Rgb& c) {
    const double most = std::max({c.r(), c.g(), c.b()});
    return Double3{most, most, most};
  };
  switch (light.kind_case()) {
    case v1::Light::kImageInfinite:
      return triple(light.image_infinite().radiance_cd_m2());
    case v1::Light::kProjection:
      return triple(light.projection().intensity_cd());
    case v1::Light::kBeam:
      return triple(light.beam().illuminance_lx());
    case v1::Light::kGoniometric:
      return triple(light.goniometric().intensity());
    case v1::Light::kDiffuseArea:
      return light.diffuse_area().has_image() ? triple(light.diffuse_area().radiance_cd_m2())
                                              : brightest(light.diffuse_area().radiance_cd_m2());
    case v1::Light::kPoint:
      return brightest(light.point().intensity_cd());
    case v1::Light::kSpot:
      return brightest(light.spot().intensity_cd());
    case v1::Light::kDistant:
      return brightest(light.distant().illuminance_lx());
    case v1::Light::kUniformInfinite:
      return brightest(light.uniform_infinite().radiance_cd_m2());
    default:
      return {};
  }
}

void add_colours(const v1::Light& light, const std::vector<double>& ours,
                 std::vector<Hypothesis>* all) {
  const Double3 level = texel_level(light);
  Double3 colour{};
  switch (light.kind_case()) {
    case v1::Light::kDiffuseArea:
      if (light.diffuse_area().has_image()) return;
      colour = {light.diffuse_area().radiance_cd_m2().r(),
                light.diffuse_area().radiance_cd_m2().g(),
                light.diffuse_area().radiance_cd_m2().b()};
      break;
    case v1::Light::kPoint:
      colour = {light.point().intensity_cd().r(), light.point().intensity_cd().g(),
                light.point().intensity_cd().b()};
      break;
    case v1::Light::kSpot:
      colour = {light.spot().intensity_cd().r(), light.spot().intensity_cd().g(),
                light.spot().intensity_cd().b()};
      break;
    default:
      return;
  }
  const double right = luminance(colour);
  if (!(right > 0)) return;
  const double once = luminance(not_linearised(colour, level)) / right;
  const double twice = luminance(linearised_twice(colour, level)) / right;
  if (once == 1) return;
  all->push_back({"srgb", "sRGB texels or colours are not linearised", times(ours, once), 1});
  all->push_back({"srgb", "linear texels or colours are decoded as sRGB", times(ours, twice), 1});
}

void name_mistake(const std::optional<Mistake>& mistake, Finding* finding) {
  if (!mistake) return;
  finding->mistake = mistake->mistake;
  finding->sentence = mistake->sentence;
}

std::vector<Variation> variations(Truth& truth, const v1::Light& light) {
  std::vector<Variation> all = turned(light);
  std::ranges::move(resized(light), std::back_inserter(all));
  for (const ChangedLight& changed : with_other_angles(light)) {
    Variation v;
    v.mistake = changed.mistake;
    v.sentence = changed.sentence;
    v.scene_id = truth.with_light(changed.light);
    if (!v.scene_id.empty()) all.push_back(std::move(v));
  }
  return all;
}

std::vector<MissingFactor> missing_factors(const v1::Light& light, const Records& rows) {
  std::vector<MissingFactor> all;
  if (!rows.normals.empty()) {
    MissingFactor cosine{"cosine_receiver", "a cosine at the receiver is missing", {}};
    for (std::size_t i = 0; i < rows.rows; ++i)
      cosine.factor.push_back(1 / std::max(0.0, dot(rows.normals[i], rows.directions[i])));
    all.push_back(std::move(cosine));
  }
  if (light.kind_case() != v1::Light::kUniformInfinite &&
      light.kind_case() != v1::Light::kImageInfinite)
    return all;
  const LightFrame frame = frame_of(light);
  constexpr const char* kNames[] = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    MissingFactor sine{"sin_theta",
                       std::string("a division by sin(theta) is missing, with theta from ") +
                           kNames[axis] + " of the light",
                       {}};
    for (const Double3& w : rows.directions)
      sine.factor.push_back(length(cross(frame.axes[axis], w)));
    all.push_back(std::move(sine));
  }
  return all;
}

Geometry geometry_of(Truth& truth, const v1::Light& light, const Records& rows) {
  Geometry g;
  Hits h = hits(truth, light, rows.points, rows.directions);
  const auto cosines = [&](const std::vector<Double3>& normals) {
    std::vector<double> result;
    for (std::size_t i = 0; i < normals.size(); ++i)
      result.push_back(dot(normals[i], rows.directions[i]));
    return result;
  };
  g.cos_receiver = cosines(rows.normals);
  g.cos_geometric = cosines(rows.geometric_normals);
  for (std::vector<double>* c : {&g.cos_receiver, &g.cos_geometric})
    for (double& v : *c) v = std::max(0.0, v);
  g.cos_given_light = cosines(rows.light_normals);
  for (double& v : g.cos_given_light) v = std::fabs(v);
  g.cos_light = std::move(h.cos_light);
  g.distance = std::move(h.distance);
  g.behind = h.behind;
  return g;
}

void explain_values(Truth& truth, const v1::Light& light, const Records& all_rows,
                    const std::vector<double>& all_ours, Finding* finding) {
  const std::vector<std::size_t> chosen = some_rows(all_rows.rows, kMostExplainedRows);
  const Records rows = rows_of(all_rows, chosen);
  const std::vector<double> ours = at_rows(all_ours, chosen);
  const LightValues values(truth, light);
  const auto numbers = [&](const Variation& v) {
    std::vector<double> result =
        luminances(values.at(rows.points, rows.directions, rows.distance, v));
    return result;
  };
  std::vector<Hypothesis> all;
  add_factors(ours, truth.lights().size(), &all);
  const Geometry geometry = geometry_of(truth, light, rows);
  add_geometry(ours, geometry, false, &all);
  add_selection(ours, rows.selection, &all);
  add_range(rows.value, ours, geometry.distance, &all);
  add_clamp(rows.value, ours, &all);
  add_sides(light, ours, rows, numbers, &all);
  for (const Variation& v : variations(truth, light))
    all.push_back({v.mistake, v.sentence, numbers(v), 1});
  add_rotation(light, rows.value, numbers, &all);
  const Double3 level = texel_level(light);
  if (level != Double3{}) {
    std::vector<double> once, twice;
    const std::vector<Double3> colours = values.at(rows.points, rows.directions, rows.distance);
    for (std::size_t i = 0; i < colours.size(); ++i) {
      // The texels of a light at a point are intensities.
      const bool at_point = light.delta() && light.has_bounds() && !light.has_beam();
      const double square = at_point ? geometry.distance[i] * geometry.distance[i] : 1;
      const Double3 texel = square * colours[i];
      once.push_back(luminance(not_linearised(texel, level)) / square);
      twice.push_back(luminance(linearised_twice(texel, level)) / square);
    }
    all.push_back({"srgb", "sRGB texels or colours are not linearised", std::move(once), 1});
    all.push_back({"srgb", "linear texels or colours are decoded as sRGB", std::move(twice), 1});
  }
  name_mistake(likely_mistake(rows.value, ours, {}, all), finding);
}

void explain_densities(Truth& truth, const v1::Light& light, const Records& all_rows,
                       const std::vector<Way>& ways, Finding* finding) {
  const Records rows = rows_of(all_rows, some_rows(all_rows.rows, kMostExplainedRows));
  if (rows.rows == 0) return;
  const Geometry geometry = geometry_of(truth, light, rows);
  const std::vector<Variation> changed = variations(truth, light);
  std::optional<Mistake> best;
  // The way in which no mistake comes closest is tried first.
  for (const Way& way : ways) {
    const auto numbers = [&](const Variation& v) {
      return truth.densities(light.id(), rows.points, rows.normals, rows.directions, way.sampling,
                             v);
    };
    const std::vector<double> ours = numbers({});
    std::vector<Hypothesis> all;
    add_factors(ours, truth.lights().size(), &all);
    add_geometry(ours, geometry, true, &all);
    add_selection(ours, rows.selection, &all);
    for (const MissingFactor& f : missing_factors(light, rows))
      add_product(ours, f.factor, 1, f.mistake, f.sentence, &all);
    add_sides(light, ours, rows, numbers, &all);
    for (const Variation& v : changed) all.push_back({v.mistake, v.sentence, numbers(v), 1});
    add_rotation(light, rows.pdf, numbers, &all);
    best = likely_mistake(rows.pdf, ours, {}, all);
    if (!best) continue;
    if (*way.name != 0) best->sentence += std::string(" (Lucerna's way: ") + way.name + ")";
    break;
  }
  name_mistake(best, finding);
}

}  // namespace lucerna::verify
