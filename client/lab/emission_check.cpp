#include "client/lab/emission_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/lab/comparison.h"
#include "client/lab/explain.h"
#include "client/lab/light_values.h"
#include "client/lab/verify_statistics.h"

namespace lucerna::verify {
namespace {

// A ray that comes back to an area light starts this far from it, relative to its size.
constexpr double kBack = 1e-3;

bool is_at_point(const v1::Light& light) {
  return light.delta() && light.has_bounds() && !light.has_beam();
}

/// Cosines at the light; empty if nothing tells the normals.
std::vector<double> cosines(const v1::Light& light, const Records& rows) {
  std::vector<double> result;
  if (is_at_point(light)) return std::vector<double>(rows.rows, 1);
  const LightFrame frame = frame_of(light);
  for (std::size_t i = 0; i < rows.rows; ++i) {
    if (!rows.normals.empty()) {
      result.push_back(std::fabs(dot(rows.normals[i], rows.directions[i])));
    } else if (frame.flat && frame.has_axes) {
      result.push_back(std::fabs(dot(frame.axes[2], rows.directions[i])));
    }
  }
  return result;
}

/// Luminous intensities [cd] or radiances [cd/m2] of rays.  NaN for lights at infinity and beams.
std::vector<double> values_of(Truth& truth, const v1::Light& light, const Records& rows) {
  std::vector<double> result(rows.rows, kNaN);
  std::vector<Double3> back;
  for (const Double3& d : rows.directions) back.push_back(-1.0 * d);
  if (is_at_point(light)) {
    // The illuminance at 1 m is the intensity.
    std::vector<Double3> receivers;
    const Double3 center = frame_of(light).center;
    for (const Double3& d : rows.directions) receivers.push_back(center + d);
    const std::vector<Double3> rgb = LightValues(truth, light).at(receivers, back, {});
    for (std::size_t i = 0; i < rgb.size(); ++i) result[i] = luminance(rgb[i]);
  } else if (light.kind_case() == v1::Light::kDiffuseArea) {
    const Double3 size = double3(light.bounds().upper_m()) - double3(light.bounds().lower_m());
    std::vector<Double3> receivers;
    std::vector<double> distances(rows.rows, kBack * length(size));
    for (std::size_t i = 0; i < rows.rows; ++i)
      receivers.push_back(rows.points[i] + distances[i] * rows.directions[i]);
    // The whole way back is short, so it starts where it is.
    const std::vector<Double3> rgb = LightValues(truth, light).at(receivers, back, {});
    for (std::size_t i = 0; i < rgb.size(); ++i) result[i] = luminance(rgb[i]);
  }
  return result;
}

/// A value that is the same everywhere, whichever side of the light emits.
void add_sides(const v1::Light& light, const std::vector<double>& ours,
               std::vector<Hypothesis>* all) {
  if (!light.has_diffuse_area() || light.diffuse_area().two_sided() ||
      light.diffuse_area().has_image() || light.diffuse_area().has_profile())
    return;
  const double level = *std::ranges::max_element(ours);
  all->push_back({"two_sides", "the light shines from both sides, but only one side emits",
                  std::vector<double>(ours.size(), level), 1});
}

Finding compared(const v1::Light& light, const char* quantity, const Records& rows,
                 const std::vector<double>& theirs, const std::vector<double>& ours,
                 const std::vector<double>& cosine, std::size_t lights,
                 const Strictness& strictness) {
  Finding f;
  f.quantity = quantity;
  f.light = light.id();
  compare(theirs, ours, {}, rows.place, strictness, &f);
  f.explain = [&light, theirs, ours, cosine, lights, selection = rows.selection,
               is_value = std::string(quantity) == "emission"](Finding& finding) {
    std::vector<Hypothesis> all;
    if (is_value) {
      add_colours(light, ours, &all);
      add_sides(light, ours, &all);
    }
    add_factors(ours, lights, &all);
    add_product(ours, cosine, 1, "cosine_light", "a cosine at the light is a factor too many",
                &all);
    add_product(ours, cosine, -1, "cosine_light", "a cosine at the light is missing", &all);
    add_product(ours, selection, 1, "selection",
                "the numbers are multiplied by the probability of choosing the light", &all);
    add_product(ours, selection, -1, "selection",
                "the numbers are divided by the probability of choosing the light", &all);
    name_mistake(likely_mistake(theirs, ours, {}, all), &finding);
  };
  return f;
}

}  // namespace

std::vector<Finding> check_emission(Truth& truth, const v1::Light& light, const Records& rows,
                                    const Strictness& strictness) {
  std::vector<Finding> all;
  const std::size_t lights = truth.lights().size();
  const std::vector<double> cosine = cosines(light, rows);
  std::vector<double> position, direction;
  truth.emission_densities(light.id(), rows.points, rows.directions, &position, &direction);
  const auto density = [&](const char* quantity, std::vector<double> theirs,
                           const std::vector<double>& ours) {
    if (theirs.empty()) return;
    // Renderers write 0, 1 or nothing for a density that does not exist.
    for (std::size_t i = 0; i < theirs.size(); ++i)
      if (ours[i] == 0 && (std::isnan(theirs[i]) || theirs[i] == 1)) theirs[i] = 0;
    all.push_back(compared(light, quantity, rows, theirs, ours, cosine, lights, strictness));
    all.back().own_way_allowed = !strictness.same_density;
    all.back().tests = {"emitted power"};
    all.back().needs_tests = true;
  };
  density("position density", rows.pdf_position, position);
  density("direction density", rows.pdf_direction, direction);
  if (rows.value.empty()) return all;
  all.push_back(compared(light, "emission", rows, rows.value, values_of(truth, light, rows), cosine,
                         lights, strictness));
  if (all.back().rows == 0) all.back().sentence = "Lucerna compares values of local lights only";

  Finding power;
  power.quantity = "emitted power";
  power.light = light.id();
  if (cosine.empty()) {
    power.sentence = "needs the normals of the light, nx,ny,nz";
  } else if (rows.pdf_direction.empty() && !(light.delta() && !light.has_bounds())) {
    power.sentence = "needs the densities";
  } else {
    std::vector<double> weights;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      double density_of_ray = 1;
      for (const auto* p : {&rows.pdf_position, &rows.pdf_direction}) {
        const bool certain = (p == &rows.pdf_position ? position[i] : direction[i]) == 0;
        if (!p->empty() && !certain && (*p)[i] > 0) density_of_ray *= (*p)[i];
      }
      weights.push_back(rows.value[i] * cosine[i] / density_of_ray);
    }
    const double exact = truth.powers({light.id()}).value.front();
    const MeanResult mean = mean_is(weights, exact, strictness.tolerance * exact);
    power.rows = rows.rows;
    power.p = mean.p;
    power.where = fmt::format("{:.6g} lm, Lucerna: {:.6g} lm", mean.mean, exact);
    if (!mean.p) power.sentence = "too few rows";
    power.explain = [&light, mean, exact, lights](Finding& finding) {
      std::vector<Hypothesis> hypotheses;
      add_colours(light, {exact}, &hypotheses);
      add_factors({exact}, lights, &hypotheses);
      name_mistake(
          likely_mistake({mean.mean}, {exact}, {mean.standard_error / mean.mean}, hypotheses),
          &finding);
    };
  }
  all.push_back(std::move(power));
  return all;
}

}  // namespace lucerna::verify
