#include "client/lab/light_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "client/lab/comparison.h"
#include "client/lab/direction_check.h"
#include "client/lab/distance_check.h"
#include "client/lab/explain.h"
#include "client/lab/light_values.h"
#include "client/lab/verify_statistics.h"

namespace lucerna::verify {
namespace {

Finding finding_of(const v1::Light& light, const char* quantity) {
  Finding f;
  f.quantity = quantity;
  f.light = light.id();
  return f;
}

/// The way whose densities agree with most rows.
struct BestWay {
  Way way;
  std::vector<double> q;
};

BestWay best_way(Truth& truth, const v1::Light& light, const Records& rows,
                 const Strictness& strictness) {
  BestWay best;
  double least = std::numeric_limits<double>::infinity();
  for (const Way& way : ways_of(light, !rows.normals.empty())) {
    std::vector<double> q =
        truth.densities(light.id(), rows.points, rows.normals, rows.directions, way.sampling);
    double off = 0, far = 0;
    for (std::size_t i = 0; i < q.size() && !rows.pdf.empty(); ++i) {
      if (std::isnan(rows.pdf[i])) continue;
      const double error = relative_error(rows.pdf[i], {q[i], q[i]});
      off += error > strictness.tolerance ? 1 : 0;
      far += std::min(error, 10.0);
    }
    // The number of rows decides, and their distance between equal numbers.
    const double score = off + 1e-3 * far / static_cast<double>(q.size());
    if (score >= least) continue;
    least = score;
    best = {way, std::move(q)};
  }
  return best;
}

Finding density_finding(Truth& truth, const v1::Light& light, const Records& rows,
                        const BestWay& best, const Strictness& strictness) {
  Finding f = finding_of(light, "density");
  // A sample without light, in a direction without light, may have any density.
  std::vector<double> q = best.q;
  const std::vector<bool> back = on_back(light, rows);
  for (std::size_t i = 0; i < q.size() && !rows.value.empty(); ++i)
    if (rows.value[i] == 0 && (q[i] == 0 || back[i])) q[i] = kNaN;
  compare(
      rows.pdf, q,
      [&](const std::vector<std::size_t>& which) {
        return ranges_of(at_rows(rows.directions, which), strictness.angle_rad,
                         [&](const std::vector<Double3>& moved) {
                           return truth.densities(light.id(), at_rows(rows.points, which),
                                                  at_rows(rows.normals, which), moved,
                                                  best.way.sampling);
                         });
      },
      rows.place, strictness, &f);
  std::vector<std::size_t> compared;
  for (std::size_t i = 0; i < q.size(); ++i)
    if (!std::isnan(q[i]) && !std::isnan(rows.pdf[i])) compared.push_back(i);
  f.explain = [&truth, &light, rows = rows_of(rows, compared)](Finding& finding) {
    explain_densities(truth, light, rows, ways_of(light, !rows.normals.empty()), &finding);
  };
  if (f.verdict == Verdict::kAgrees && *best.way.name != 0)
    f.sentence = fmt::format("sampled {}", best.way.name);
  return f;
}

/// A light without a density.
std::vector<Finding> check_delta(Truth& truth, const v1::Light& light, const Records& rows,
                                 const Strictness& strictness) {
  std::vector<Finding> all;
  const LightSamples s =
      truth.samples(light.id(), rows.points, {}, 1, 1, v1::AREA_SAMPLING_UNSPECIFIED);
  Finding directions = finding_of(light, "directions");
  std::vector<double> ones(rows.rows, 1), cosines(rows.rows, kNaN);
  for (std::size_t i = 0; i < rows.rows; ++i)
    if (s.directions[i] != Double3{})
      cosines[i] = 1 - 0.5 * std::pow(length(s.directions[i] - rows.directions[i]), 2);
  Strictness angles = strictness;
  angles.tolerance = 0.5 * strictness.tolerance * strictness.tolerance;
  compare(ones, cosines, {}, rows.place, angles, &directions);
  if (directions.off > 0) directions.where += " (cosine to Lucerna's direction)";
  all.push_back(std::move(directions));
  if (!rows.pdf.empty()) {
    Finding density = finding_of(light, "density");
    // Renderers write 0, 1 or nothing for a light without a density.
    std::vector<double> theirs, ours;
    for (const double pdf : rows.pdf) {
      theirs.push_back(std::isnan(pdf) ? 0 : pdf);
      ours.push_back(pdf == 1 ? 1 : 0);
    }
    compare(theirs, ours, {}, rows.place, strictness, &density);
    if (density.verdict == Verdict::kDiffers)
      density.sentence = "the light has no density; write 0, 1 or nothing";
    all.push_back(std::move(density));
  }
  return all;
}

Finding value_finding(Truth& truth, const v1::Light& light, const Records& rows,
                      const Strictness& strictness) {
  Finding f = finding_of(light, "value");
  const LightValues values(truth, light);
  const std::vector<Double3> rgb = values.at(rows.points, rows.directions, rows.distance);
  const std::vector<bool> back = on_back(light, rows);
  std::vector<double> ours;
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    // A hidden light says nothing about a row that is dark as well.
    const bool hidden = std::isnan(rgb[i][0]);
    ours.push_back(hidden && rows.value[i] == 0 ? 0 : luminance(rgb[i]));
    if (back[i]) ours.back() = kNaN;
  }
  const auto rounded = [&](const std::vector<std::size_t>& which) {
    const std::vector<Double3> points = at_rows(rows.points, which);
    const std::vector<Double3> directions = at_rows(rows.directions, which);
    const std::vector<double> distances = at_rows(rows.distance, which);
    return ranges_of(directions, strictness.angle_rad, [&](const std::vector<Double3>& moved) {
      std::vector<Double3> places = points;
      // For a delta light the place of the receiver decides.
      for (std::size_t i = 0; i < places.size() && light.delta(); ++i) {
        const double d = i < distances.size() && std::isfinite(distances[i]) ? distances[i] : 1;
        places[i] = places[i] + d * (moved[i] - directions[i]);
      }
      std::vector<double> result;
      for (const Double3& c : values.at(places, moved, distances)) result.push_back(luminance(c));
      return result;
    });
  };
  compare(rows.value, ours, rounded, rows.place, strictness, &f);
  if (f.verdict == Verdict::kAgrees && !rows.rgb.empty()) {
    // Wrong colours may have the right luminance.
    std::vector<double> one(rows.rows, 1), closeness(rows.rows, kNaN);
    for (std::size_t i = 0; i < rows.rows; ++i) {
      const double most = std::max({rgb[i][0], rgb[i][1], rgb[i][2]});
      if (!(most > 0) || !(rows.value[i] > 0)) continue;
      closeness[i] = 1;
      // The luminance is compared already.
      const double level = luminance(rgb[i]) / rows.value[i];
      for (std::size_t c = 0; c < 3; ++c)
        closeness[i] =
            std::max(closeness[i], 1 + std::fabs(level * rows.rgb[i][c] - rgb[i][c]) / most);
    }
    Finding colour = finding_of(light, "colour");
    Strictness loose = strictness;
    // Light colours may have been rounded to eight bits or to four digits on their way.
    loose.tolerance = std::max(5e-3, strictness.tolerance);
    compare(one, closeness, {}, rows.place, loose, &colour);
    if (colour.verdict == Verdict::kDiffers) {
      f.verdict = Verdict::kDiffers;
      f.off = colour.off;
      f.where = rows.place(0);
      f.sentence = "the luminance agrees, but the colour does not";
      return f;
    }
  }
  if (f.rows == 0) f.sentence = "another surface hides the light in all rows";
  f.explain = [&truth, &light, rows, ours](Finding& finding) {
    explain_values(truth, light, rows, ours, &finding);
  };
  return f;
}

}  // namespace

std::vector<Way> ways_of(const v1::Light& light, bool normals) {
  if (light.kind_case() != v1::Light::kDiffuseArea) return {{}};
  std::vector<Way> ways = {{v1::AREA_SAMPLING_SOLID_ANGLE, "by solid angle"},
                           {v1::AREA_SAMPLING_KRAEMER, "by area"}};
  if (normals) ways.push_back({v1::AREA_SAMPLING_COSINE_SOLID_ANGLE, "by projected solid angle"});
  // Numbers of Lucerna itself: the server chooses among the ways at each receiver.
  ways.push_back({v1::AREA_SAMPLING_UNSPECIFIED, "as Lucerna chooses at each receiver"});
  return ways;
}

std::vector<Finding> check_samples(Truth& truth, const v1::Light& light, const Records& rows,
                                   const Strictness& strictness) {
  std::vector<Finding> all;
  if (light.delta()) {
    all = check_delta(truth, light, rows, strictness);
  } else {
    const BestWay best = best_way(truth, light, rows, strictness);
    if (!rows.pdf.empty()) {
      all.push_back(density_finding(truth, light, rows, best, strictness));
      all.back().own_way_allowed = !strictness.same_density;
      all.back().tests = {"directions", "integral"};
      all.back().needs_tests = true;
    }
    // A sample on the back of the light counts as a sample that missed.
    std::vector<double> q = best.q;
    const std::vector<bool> back = on_back(light, rows);
    for (std::size_t i = 0; i < q.size(); ++i)
      if (back[i]) q[i] = 0;
    std::vector<Finding> tests = check_directions(truth, light, rows, best.way, q, strictness);
    if (!all.empty() && tests.size() > 1) {
      // A density of the renderer's own is explained by its samples.
      all.front().explain = [first = all.front().explain, then = tests[1].explain](Finding& f) {
        first(f);
        if (f.mistake.empty() && then) then(f);
        if (f.mistake.empty()) f.sentence.clear();
      };
    }
    std::ranges::move(tests, std::back_inserter(all));
  }
  if (!rows.value.empty()) all.push_back(value_finding(truth, light, rows, strictness));
  if (!rows.distance.empty()) all.push_back(check_distances(truth, light, rows, strictness));
  return all;
}

std::vector<Finding> check_densities(Truth& truth, const v1::Light& light, const Records& rows,
                                     const Strictness& strictness) {
  std::vector<Finding> all;
  Records judged = rows;
  if (light.delta()) {
    Finding f = finding_of(light, "density");
    compare(rows.pdf, std::vector<double>(rows.rows, 0), {}, rows.place, strictness, &f);
    if (f.verdict == Verdict::kDiffers) f.sentence = "the light has no density, so it must be 0";
    return {f};
  }
  const BestWay best = best_way(truth, light, rows, strictness);
  all.push_back(density_finding(truth, light, rows, best, strictness));
  all.back().quantity = "given density";
  if (!rows.drawn.empty()) {
    Finding f = finding_of(light, "given integral");
    std::vector<double> weights;
    for (std::size_t i = 0; i < rows.rows; ++i) weights.push_back(rows.pdf[i] / rows.drawn[i]);
    const MeanResult m = mean_is(weights, 1, strictness.tolerance);
    f.rows = rows.rows;
    f.p = m.p;
    f.integral = m.mean;
    f.integral_low = m.mean - 1.96 * m.standard_error;
    f.integral_high = m.mean + 1.96 * m.standard_error;
    if (!m.p) f.sentence = "too few rows";
    all.push_back(std::move(f));
  }
  // Without the column `drawn`, the densities must be Lucerna's.
  all.front().own_way_allowed = !strictness.same_density;
  all.front().tests = {"given integral"};
  all.front().rival = "density";
  return all;
}

std::vector<Finding> check_selection(Truth& truth, const Records& rows,
                                     const Strictness& strictness) {
  std::vector<Finding> all;
  if (rows.selection.empty() || rows.lights.empty() || truth.lights().size() < 2) return all;
  // Each receiver once for each light: a light that does not reach it may have probability 0.
  std::map<Double3, std::size_t> number;
  std::vector<Double3> receivers;
  std::vector<std::size_t> receiver_of(rows.rows);
  for (std::size_t i = 0; i < rows.rows; ++i) {
    const auto [at, added] = number.emplace(rows.points[i], receivers.size());
    if (added) receivers.push_back(rows.points[i]);
    receiver_of[i] = at->second;
  }
  for (const v1::Light& light : truth.lights()) {
    const LightSamples s =
        truth.samples(light.id(), receivers, {}, 1, 1, v1::AREA_SAMPLING_UNSPECIFIED);
    std::vector<double> weights;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      if (std::isnan(rows.selection[i]) || !s.ok[receiver_of[i]]) continue;
      weights.push_back(rows.lights[i] == light.id() ? 1 / rows.selection[i] : 0);
    }
    if (weights.empty()) continue;
    Finding f = finding_of(light, "selection");
    f.rows = weights.size();
    const MeanResult m = mean_is(weights, 1, strictness.tolerance);
    f.p = m.p;
    f.integral = m.mean;
    f.integral_low = m.mean - 1.96 * m.standard_error;
    f.integral_high = m.mean + 1.96 * m.standard_error;
    if (!m.p) f.sentence = "too few rows of this light";
    f.explain = [mean = m.mean](Finding& finding) {
      finding.mistake = "selection";
      finding.sentence =
          fmt::format("the light is chosen {:.3g} times as often as its stated probability", mean);
    };
    all.push_back(std::move(f));
  }
  return all;
}

}  // namespace lucerna::verify
