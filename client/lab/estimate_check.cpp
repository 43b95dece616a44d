#include "client/lab/estimate_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/lab/comparison.h"
#include "client/lab/explain.h"
#include "proto/common/confidence.h"
#include "proto/common/quantile.h"

namespace lucerna::verify {
namespace {

// Lucerna's standard errors come from 16 blocks.
constexpr double kFreedom = 15;
constexpr std::size_t kMostPlaces = 200;
// A segment whose verdict depends on its ends by this share of its length is not judged.
constexpr double kEndsMove = 1e-4;

/// Estimates with errors on both sides.  Fills in the errors and the p-value of the worst row,
/// corrected for the number of rows.  `rounding`: what rounding of the input may change; empty: 0.
void compare_estimates(const std::vector<double>& theirs, const std::vector<double>& their_errors,
                       const Estimates& ours, const std::vector<double>& rounding,
                       const std::function<std::string(std::size_t)>& place,
                       const Strictness& strictness, Finding* finding) {
  std::vector<double> errors;
  double least = 1;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (std::isnan(theirs[i])) {
      ++finding->left_out;
      continue;
    }
    errors.push_back(relative_error(theirs[i], {ours.value[i], ours.value[i]}));
    const double known = i < their_errors.size() && their_errors[i] > 0 ? their_errors[i] : 0;
    const double scatter = std::hypot(known, ours.standard_error[i]);
    const double allowed =
        strictness.tolerance * ours.value[i] + (rounding.empty() ? 0 : rounding[i]);
    const double beyond = std::max(0.0, std::fabs(theirs[i] - ours.value[i]) - allowed);
    const double p = beyond == 0 ? 1 : scatter == 0 ? 0 : student_p(beyond / scatter, kFreedom);
    if (p < strictness.level) ++finding->off;
    if (p < least || errors.size() == 1) {
      least = std::min(least, p);
      worst = i;
    }
  }
  finding->rows = errors.size();
  if (errors.empty()) return;
  finding->p = std::min(1.0, least * static_cast<double>(errors.size()));
  finding->median = median(errors);
  finding->worst = *std::ranges::max_element(errors);
  finding->where =
      fmt::format("{}: {:.6g}, Lucerna: {:.6g}", place(worst), theirs[worst], ours.value[worst]);
}

std::vector<double> scatter_of(const std::vector<double>& theirs,
                               const std::vector<double>& their_errors, const Estimates& ours) {
  std::vector<double> result;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    const double known = i < their_errors.size() && theirs[i] > 0 ? their_errors[i] / theirs[i] : 0;
    const double own = ours.value[i] > 0 ? ours.standard_error[i] / ours.value[i] : 0;
    result.push_back(std::hypot(std::isnan(known) ? 0 : known, own));
  }
  return result;
}

/// Mistakes of one light that show in its power.  They are named rather than a bare factor.
std::vector<Hypothesis> power_hypotheses(Truth& truth, const v1::Light& light, double ours) {
  std::vector<Hypothesis> all;
  add_factors({ours}, truth.lights().size(), &all);
  add_colours(light, {ours}, &all);
  for (const Variation& v : variations(truth, light)) {
    double power = ours;
    if (!v.scene_id.empty()) {
      power = truth.powers({light.id()}, v.scene_id).value.front();
    } else if (v.scale != 1) {
      power *= v.scale * v.scale;
    } else {
      continue;  // turns keep the power
    }
    all.push_back({v.mistake, v.sentence, {power}, 0});
  }
  if (light.kind_case() == v1::Light::kDiffuseArea) {
    const bool two = light.diffuse_area().two_sided();
    all.push_back({two ? "one_side" : "two_sides",
                   two ? "the light shines from one side only, but both sides emit"
                       : "the light shines from both sides, but only one side emits",
                   {ours * (two ? 0.5 : 2)},
                   0});
  }
  return all;
}

Estimates illuminances(Truth& truth, const v1::Light* light, const std::vector<Double3>& points,
                       const std::vector<Double3>& normals, const Strictness& s) {
  if (light == nullptr)
    return truth.illuminances_of_all(points, normals, s.bounces, s.samples, s.seed);
  return truth.illuminances(light->id(), points, normals, s.samples, s.seed);
}

std::vector<Hypothesis> illuminance_hypotheses(Truth& truth, const v1::Light* light,
                                               const Records& rows, const std::vector<double>& ours,
                                               const Strictness& strictness) {
  std::vector<Hypothesis> all;
  add_factors(ours, truth.lights().size(), &all);
  if (!rows.geometric_normals.empty()) {
    all.push_back(
        {"shading_normal", "the geometric normal is used instead of the shading normal",
         illuminances(truth, light, rows.points, rows.geometric_normals, strictness).value, 0});
  }
  if (light == nullptr) return all;
  add_colours(*light, ours, &all);
  // Without obstacles, since a light that is moved has others.
  const std::vector<double> plain = truth.unoccluded(light->id(), rows.points, rows.normals);
  const auto changed = [&](const std::vector<double>& other) {
    std::vector<double> predicted = ours;
    for (std::size_t i = 0; i < ours.size(); ++i)
      predicted[i] = plain[i] > 0 ? ours[i] * (other[i] / plain[i]) : other[i];
    return predicted;
  };
  all.push_back({"cosine_receiver", "the cosine at the receiver is missing",
                 changed(truth.unoccluded(light->id(), rows.points, {})), 1});
  if (!light->delta()) {
    const char* sentence = "the cosine at the receiver is missing";
    all.push_back({"cosine_receiver", sentence,
                   truth.without_cosine(light->id(), rows.points, rows.normals, strictness.samples,
                                        strictness.seed),
                   1});
  }
  if (light->has_bounds()) {
    const Double3 center = frame_of(*light).center;
    std::vector<double> distances;
    for (const Double3& x : rows.points) distances.push_back(length(x - center));
    add_range(rows.value, ours, distances, &all);
    std::vector<double> squares;
    for (const Double3& x : rows.points) squares.push_back(std::pow(length(x - center), 2));
    add_product(ours, squares, 1, "inverse_square", "a division by r2 is missing", &all);
    add_product(ours, squares, -1, "inverse_square", "a division by r2 is too many", &all);
  }
  if (light->has_spot()) {
    const Double3 center = frame_of(*light).center,
                  axis = normalized(double3(light->spot().axis()));
    std::vector<double> cosines;
    for (const Double3& x : rows.points) cosines.push_back(dot(normalized(x - center), axis));
    add_product(ours, cosines, 1, "cosine_light",
                "a cosine about the axis of the spot is a factor too many", &all);
  }
  for (const Variation& v : variations(truth, *light))
    all.push_back({v.mistake, v.sentence,
                   changed(truth.unoccluded(light->id(), rows.points, rows.normals, v)), 1});
  const LightFrame frame = frame_of(*light);
  if (light->kind_case() == v1::Light::kDiffuseArea && frame.flat && frame.has_axes) {
    Variation mirror;
    mirror.center = frame.center;
    const Double3 n = frame.axes[2];
    for (std::size_t column = 0; column < 3; ++column)
      mirror.turn[column] = kIdentity[column] - 2 * n[column] * n;
    const std::vector<double> back =
        truth.unoccluded(light->id(), rows.points, rows.normals, mirror);
    std::vector<double> both = ours, one = ours, other = ours;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const bool front = dot(rows.points[i] - frame.center, n) > 0;
      both[i] = std::max(ours[i], back[i]);
      (front ? other : one)[i] = 0;
    }
    if (!light->diffuse_area().two_sided()) {
      all.push_back({"two_sides", "the light shines from both sides, but only one side emits",
                     std::move(both), 1});
    } else {
      const char* sentence = "the light shines from one side only, but both sides emit";
      all.push_back({"one_side", sentence, std::move(one), 1});
      all.push_back({"one_side", sentence, std::move(other), 1});
    }
  }
  return all;
}

}  // namespace

std::vector<Finding> check_powers(Truth& truth, const Records& rows, const Strictness& strictness) {
  std::vector<Finding> all;
  Estimates ours = truth.powers(rows.lights);
  for (std::size_t i = 0; i < rows.rows; ++i) {
    Finding f;
    f.quantity = "power";
    f.light = rows.lights[i];
    const Records row = rows_of(rows, {i});
    const Estimates one = {{ours.value[i]}, {0}};
    Strictness loose = strictness;
    if (ours.value[i] > 0)
      loose.tolerance += ours.standard_error[i] / ours.value[i];  // a bound, not a deviation
    compare_estimates(row.value, row.standard_error, one, {}, row.place, loose, &f);
    f.explain = [&truth, row, one](Finding& finding) {
      const v1::Light& light = truth.light(row.lights[0]);
      name_mistake(
          likely_mistake(row.value, one.value, scatter_of(row.value, row.standard_error, one),
                         power_hypotheses(truth, light, one.value[0])),
          &finding);
    };
    all.push_back(std::move(f));
  }
  return all;
}

Finding check_illuminances(Truth& truth, const v1::Light* light, const Records& rows,
                           const Strictness& strictness) {
  Finding f;
  f.quantity = "illuminance";
  f.light = light == nullptr ? 0 : light->id();
  const Estimates ours = illuminances(truth, light, rows.points, rows.normals, strictness);
  std::vector<double> rounding;
  if (light != nullptr) {
    // An angle changes the cosine by as much.  This matters for light that grazes the surface.
    rounding = truth.unoccluded(light->id(), rows.points, {});
    for (double& r : rounding) r *= strictness.angle_rad;
  }
  compare_estimates(rows.value, rows.standard_error, ours, rounding, rows.place, strictness, &f);
  f.explain = [&truth, light, rows, ours, strictness](Finding& finding) {
    const std::vector<std::size_t> chosen = some_rows(rows.rows, kMostPlaces);
    const Records some = rows_of(rows, chosen);
    const Estimates theirs_and_ours = {at_rows(ours.value, chosen),
                                       at_rows(ours.standard_error, chosen)};
    name_mistake(likely_mistake(
                     some.value, theirs_and_ours.value,
                     scatter_of(some.value, some.standard_error, theirs_and_ours),
                     illuminance_hypotheses(truth, light, some, theirs_and_ours.value, strictness)),
                 &finding);
  };
  return f;
}

Finding check_visibility(Truth& truth, const Records& rows, const Strictness& strictness) {
  Finding f;
  f.quantity = "visibility";
  const std::vector<bool> ours = truth.visible(rows.points, rows.targets);
  std::vector<std::size_t> wrong;
  for (std::size_t i = 0; i < rows.rows; ++i)
    if (ours[i] != rows.visible[i]) wrong.push_back(i);
  // Segments that graze a surface have no certain answer.
  std::vector<bool> certain(wrong.size(), true);
  for (int axis = 0; axis < 3 && !wrong.empty(); ++axis) {
    for (const double sign : {1.0, -1.0}) {
      for (const bool start : {true, false}) {
        std::vector<Double3> from = at_rows(rows.points, wrong), to = at_rows(rows.targets, wrong);
        for (std::size_t k = 0; k < wrong.size(); ++k) {
          Double3& end = start ? from[k] : to[k];
          end[static_cast<std::size_t>(axis)] += sign * kEndsMove * length(to[k] - from[k]);
        }
        const std::vector<bool> moved = truth.visible(from, to);
        for (std::size_t k = 0; k < wrong.size(); ++k)
          if (moved[k] != ours[wrong[k]]) certain[k] = false;
      }
    }
  }
  std::size_t seen = 0, blocked = 0;
  for (std::size_t k = 0; k < wrong.size(); ++k) {
    if (!certain[k]) {
      ++f.left_out;
      continue;
    }
    if (f.off++ == 0)
      f.where = fmt::format("{}: {}, Lucerna: {}", rows.place(wrong[k]),
                            rows.visible[wrong[k]] ? "visible" : "blocked",
                            ours[wrong[k]] ? "visible" : "blocked");
    ++(rows.visible[wrong[k]] ? seen : blocked);
  }
  f.rows = rows.rows - f.left_out;
  const double allowed = strictness.outliers * static_cast<double>(f.rows);
  f.verdict = static_cast<double>(f.off) > allowed ? Verdict::kDiffers : Verdict::kAgrees;
  f.explain = [seen, blocked, &rows](Finding& finding) {
    const bool none_blocked = std::ranges::all_of(rows.visible, [](bool v) { return v; });
    if (none_blocked) {
      finding.mistake = "no_occlusion";
      finding.sentence = "nothing blocks any ray";
    } else if (seen + blocked > 0.9 * static_cast<double>(finding.rows) && seen > 0 &&
               blocked > 0) {
      finding.mistake = "inverted";
      finding.sentence = "visible and blocked are exchanged";
    } else if (seen == 0) {
      finding.mistake = "self_intersection";
      finding.sentence = fmt::format(
          "{} rays are reported blocked, but nothing blocks them; they may hit the surface on "
          "which they start or end",
          blocked);
    } else {
      finding.sentence = fmt::format(
          "{} rays are reported visible but are blocked; {} are reported blocked but are visible",
          seen, blocked);
    }
  };
  return f;
}

}  // namespace lucerna::verify
