#include "client/lab/direction_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "client/lab/comparison.h"
#include "client/lab/explain.h"
#include "client/lab/light_check.h"
#include "client/lab/verify_statistics.h"

namespace lucerna::verify {
namespace {

// Lucerna's samples for each sample of the renderer.  Their error adds a quarter to the variance.
constexpr std::uint32_t kReferenceSamples = 4;
constexpr std::size_t kFewestRows = 80;
constexpr std::size_t kRowsPerCell = 20;
constexpr std::size_t kMostCells = 64;
// A direction must fit this well to be named.
constexpr double kGoodFit = 0.01;
// The error of an integral that the right factor may leave.
constexpr double kFactorError = 0.01;

/// Lucerna's samples at the receivers of the rows.
struct Reference {
  std::vector<Feature> features;  // above the horizon
  std::vector<bool> lit;          // rows whose receivers get light
  // Of all samples at lit receivers: those that shine there, from above the horizon.
  double share = 1;
  // Of all samples at lit receivers: those that did not fail, as on the back of the light.
  double shining = 1;
};

bool is_above(const Records& rows, std::size_t row, const Double3& w) {
  return rows.normals.empty() || dot(rows.normals[row], w) > 0;
}

/// The features of samples of one light.  For a local light, the direction becomes the place where
/// the ray meets the plane through the middle of the light, at right angles to the way to it.  Then
/// receivers at different places share the cells.
class Features {
 public:
  explicit Features(const v1::Light& light) : local_(light.has_bounds()) {
    if (local_)
      center_ = 0.5 * (double3(light.bounds().lower_m()) + double3(light.bounds().upper_m()));
  }

  Feature operator()(const Double3& w, const Double3& x) const {
    const Double3 at = local_ ? place(w, x) : w;
    return {at[0], at[1], at[2], x[0], x[1], x[2]};
  }

  std::string describe(const Double3& mean) const {
    if (local_) return fmt::format("near {} m", text(mean));
    return length(mean) > 0 ? fmt::format("towards {}", text(normalized(mean))) : "";
  }

 private:
  Double3 place(const Double3& w, const Double3& x) const {
    const Double3 way = center_ - x;
    const double far = length(way);
    if (!(far > 0)) return x + w;
    // Rays almost along the plane would go far beyond the light.
    constexpr double kLeastCosine = 0.05;
    return x + (far / std::max(kLeastCosine, dot(w, way) / far)) * w;
  }

  bool local_;
  Double3 center_{};
};

Reference reference_of(Truth& truth, const v1::Light& light, const Records& rows,
                       v1::AreaSampling way, const Variation& variation, std::uint64_t seed) {
  const Features feature(light);
  const LightSamples s =
      truth.samples(light.id(), rows.points, rows.normals, kReferenceSamples, seed, way, variation);
  Reference r;
  std::size_t lit = 0, shining = 0;
  for (std::size_t row = 0; row < rows.rows; ++row) {
    bool any = false;
    for (std::size_t k = row * kReferenceSamples; k < (row + 1) * kReferenceSamples; ++k) {
      // A sample without light still has its density.
      if (!(s.pdf[k] > 0) || s.directions[k] == Double3{} || s.behind[k]) continue;
      any = true;
      ++shining;
      if (is_above(rows, row, s.directions[k]))
        r.features.push_back(feature(s.directions[k], rows.points[row]));
    }
    r.lit.push_back(any);
    if (any) lit += kReferenceSamples;
  }
  if (lit > 0) r.shining = static_cast<double>(shining) / static_cast<double>(lit);
  if (lit > 0) r.share = static_cast<double>(r.features.size()) / static_cast<double>(lit);
  return r;
}

/// The weights of rows in the cells of a reference.
struct Weighted {
  std::vector<std::size_t> cells;
  std::vector<double> weights;
  std::vector<std::size_t> rows;  // of the file
  std::size_t outside = 0;        // rows in which Lucerna's density is 0
};

std::size_t cells_for(std::size_t rows) {
  return std::clamp<std::size_t>(rows / kRowsPerCell, 2, kMostCells);
}

std::string describe(const Features& features, const Partition& partition,
                     const Reference& reference, const TestResult& test) {
  Double3 sum{};
  double count = 0;
  for (const Feature& f : reference.features) {
    if (partition.cell(f) != test.worst_cell) continue;
    sum = sum + Double3{f[0], f[1], f[2]};
    ++count;
  }
  return fmt::format("{}: {:.3g} times as many samples", features.describe((1 / count) * sum),
                     test.worst_ratio);
}

/// Names a factor that is missing in the claimed densities: with it, they fit the directions.
void explain_by_factor(const v1::Light& light, const Records& rows, const Partition& partition,
                       const Weighted& claimed, double reference, double share, Finding* finding) {
  double best = kGoodFit;
  for (const MissingFactor& f : missing_factors(light, rows)) {
    std::vector<double> weights = claimed.weights;
    for (std::size_t i = 0; i < weights.size(); ++i)
      if (weights[i] > 0) weights[i] *= f.factor[claimed.rows[i]];
    const TestResult test = cells_have_probabilities(partition, claimed.cells, weights, reference);
    if (!test.p || *test.p <= best) continue;
    const MeanResult mean = mean_is(weights, share, kFactorError);
    if (!mean.p || *mean.p <= kGoodFit) continue;
    best = *test.p;
    finding->mistake = f.mistake;
    finding->sentence = f.sentence;
  }
}

/// Names another density that the directions follow.
void explain_directions(Truth& truth, const v1::Light& light, const Records& rows,
                        std::uint64_t seed, Finding* finding) {
  struct Candidate {
    std::string mistake, sentence;
    Way way;
    Variation variation;
  };
  const Features feature(light);
  std::vector<Candidate> all;
  for (const Way& way : ways_of(light, !rows.normals.empty())) {
    const std::string name = *way.name == 0 ? "" : std::string(" sampled ") + way.name;
    all.push_back({"other_density",
                   "the directions follow Lucerna's density" + name +
                       ", so the mistake is in the claimed density",
                   way,
                   {}});
    for (const Variation& v : variations(truth, light))
      all.push_back({v.mistake, "the directions follow another light: " + v.sentence, way, v});
  }
  double best = kGoodFit;
  for (const Candidate& c : all) {
    const Reference reference =
        reference_of(truth, light, rows, c.way.sampling, c.variation, seed + 1);
    if (reference.features.empty()) continue;
    const std::vector<double> q = truth.densities(light.id(), rows.points, rows.normals,
                                                  rows.directions, c.way.sampling, c.variation);
    const Partition partition(reference.features, cells_for(rows.rows));
    Weighted w;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      if (!is_above(rows, i, rows.directions[i])) continue;
      if (!(q[i] > 0)) {
        if (rows.value.empty() || rows.value[i] > 0) ++w.outside;
        continue;
      }
      w.cells.push_back(partition.cell(feature(rows.directions[i], rows.points[i])));
      w.weights.push_back(1);
    }
    if (w.outside * 100 > rows.rows) continue;
    const TestResult test = cells_have_probabilities(
        partition, w.cells, w.weights, static_cast<double>(reference.features.size()));
    if (!test.p || *test.p <= best) continue;
    best = *test.p;
    finding->mistake = c.mistake;
    finding->sentence = c.sentence;
    if (c.mistake == "other_density") return;
  }
}

}  // namespace

std::vector<Finding> check_directions(Truth& truth, const v1::Light& light, const Records& rows,
                                      const Way& way, const std::vector<double>& q,
                                      const Strictness& strictness) {
  const bool claimed = !rows.pdf.empty();
  Finding own, integral, lucerna;
  own.quantity = "directions";
  integral.quantity = "integral";
  lucerna.quantity = claimed ? "Lucerna's directions" : "directions";
  own.light = integral.light = lucerna.light = light.id();
  const auto give = [&](const std::string& why) {
    std::vector<Finding> all = {lucerna};
    if (claimed) all = {own, integral, lucerna};
    for (Finding& f : all) {
      f.left_out = rows.rows;
      f.sentence = why;
    }
    return all;
  };
  if (rows.rows < kFewestRows)
    return give(fmt::format("{} rows are too few, needed: {}", rows.rows, kFewestRows));
  const Reference reference = reference_of(truth, light, rows, way.sampling, {}, strictness.seed);
  if (reference.features.size() < kFewestRows)
    return give("the light reaches too few of the receivers");
  const Features feature(light);
  const Partition partition(reference.features, cells_for(rows.rows));
  Weighted w, counts;
  std::size_t unusable = 0;
  for (std::size_t i = 0; i < rows.rows; ++i) {
    const bool above = is_above(rows, i, rows.directions[i]);
    if (!reference.lit[i] || (claimed && std::isnan(rows.pdf[i]))) {
      ++unusable;
      continue;
    }
    const std::size_t cell = partition.cell(feature(rows.directions[i], rows.points[i]));
    if (claimed) {
      // Outside of Lucerna's density and below the horizon the weight is 0, in any cell.
      w.cells.push_back(cell);
      w.rows.push_back(i);
      w.weights.push_back(above && rows.pdf[i] > 0 ? q[i] / rows.pdf[i] : 0);
    }
    if (!above) continue;
    if (q[i] > 0) {
      counts.cells.push_back(cell);
      counts.weights.push_back(1);
    } else if (rows.value.empty() || rows.value[i] > 0) {
      ++counts.outside;
    }
  }
  const auto size = static_cast<double>(reference.features.size());
  const TestResult against_lucerna =
      cells_have_probabilities(partition, counts.cells, counts.weights, size);
  lucerna.rows = counts.weights.size() + counts.outside;
  lucerna.left_out = unusable;
  lucerna.p = against_lucerna.p;
  if (against_lucerna.p) lucerna.where = describe(feature, partition, reference, against_lucerna);
  if (static_cast<double>(counts.outside) >
      strictness.outliers * static_cast<double>(lucerna.rows)) {
    lucerna.p = 0;
    lucerna.where = fmt::format("{} directions miss the light", counts.outside);
  }
  if (!lucerna.p) lucerna.sentence = "too few rows with light";
  lucerna.decides = !claimed || strictness.same_density;
  const auto explain = [&truth, &light, rows, seed = strictness.seed](Finding& f) {
    explain_directions(truth, light, rows, seed, &f);
  };
  lucerna.explain = explain;
  if (!claimed) return {lucerna};

  const TestResult shape = cells_have_probabilities(partition, w.cells, w.weights, size);
  own.rows = w.weights.size();
  own.left_out = unusable;
  own.p = shape.p;
  if (shape.p) own.where = describe(feature, partition, reference, shape);
  if (!shape.p) own.sentence = "too few effective rows: the densities are too unlike Lucerna's";
  const auto by_factor = [&light, rows, partition, w, size, share = reference.share](Finding& f) {
    explain_by_factor(light, rows, partition, w, size, share, &f);
  };
  own.explain = [explain, by_factor](Finding& f) {
    by_factor(f);
    if (f.mistake.empty()) explain(f);
  };
  // Lucerna's samples below the horizon and on the back of the light make the mean uncertain.
  const double size_of_all = size / reference.share;
  double share = reference.share;
  const auto test = [&](double expected) {
    return mean_is(w.weights, expected, strictness.tolerance,
                   std::sqrt(expected * (1 - expected) / size_of_all));
  };
  MeanResult mean = test(share);
  if (reference.shining < 1) {
    // The file may have samples that failed, as on the back of a light, or not.
    const double of_shining = reference.share / reference.shining;
    const MeanResult other = test(of_shining);
    if (other.p && (!mean.p || *other.p > *mean.p)) {
      mean = other;
      share = of_shining;
    }
  }
  integral.rows = w.weights.size();
  integral.left_out = unusable;
  integral.p = mean.p;
  if (mean.mean > 0) {
    integral.integral = share / mean.mean;
    const double error = *integral.integral * mean.standard_error / mean.mean;
    integral.integral_low = *integral.integral - 1.96 * error;
    integral.integral_high = *integral.integral + 1.96 * error;
  }
  if (!mean.p) integral.sentence = "too few effective rows: the densities are too unlike Lucerna's";
  integral.explain = [by_factor](Finding& f) {
    f.sentence = "the claimed densities are not those of the samples by this factor";
    by_factor(f);
  };
  return {own, integral, lucerna};
}

}  // namespace lucerna::verify
