#include "client/lab/mistakes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "proto/common/quantile.h"

namespace lucerna::verify {
namespace {

// Maps are compared between interpolations, and rows near an edge may be on either side of it.
constexpr double kFitShare = 0.85;
constexpr double kFitError = 0.01;
constexpr double kStandardErrors = 3;
// How much better a mistake must explain the numbers than no mistake.
constexpr double kMargin = 4;
// A second mistake fits equally well within this factor.
constexpr double kEqual = 2;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The relative difference of two numbers, in units of the error that a fit allows.
double difference(double theirs, double predicted, double scatter) {
  if (std::isnan(predicted) || std::isnan(theirs)) return kInfinite;
  if (theirs == 0 && predicted == 0) return 0;
  if (theirs <= 0 || predicted <= 0) return kInfinite;
  return std::fabs(std::log(theirs / predicted)) / (kFitError + kStandardErrors * scatter);
}

/// Over rows with light.  Rows without light agree with anything dark, and would hide the others.
/// `partial`: over the rows that differ from `ours`, or would.
double misfit(const std::vector<double>& theirs, const std::vector<double>& ours,
              const std::vector<double>& predicted, const std::vector<double>& scatter,
              bool partial = false) {
  std::vector<double> all;
  bool any_light = false;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (!(theirs[i] > 0 || ours[i] > 0 || predicted[i] > 0)) continue;
    any_light |= theirs[i] > 0 && predicted[i] > 0;
    const double each = scatter.empty() ? 0 : scatter[i];
    if (partial && difference(theirs[i], ours[i], each) <= 1 &&
        difference(predicted[i], ours[i], each) <= 1)
      continue;
    all.push_back(difference(theirs[i], predicted[i], each));
  }
  return any_light && !all.empty() ? quantile(std::move(all), kFitShare) : kInfinite;
}

struct Factor {
  double value;
  const char *mistake, *name, *reason;
};

constexpr double kPi = std::numbers::pi;
constexpr Factor kFactors[] = {
    {kPi, "factor_pi", "pi", "such as radiant exitance for radiance"},
    {2 * kPi, "factor_2pi", "2 pi", "such as the solid angle of a hemisphere"},
    {4 * kPi, "factor_4pi", "4 pi", "such as power for intensity, or the solid angle of a sphere"},
    {683, "factor_683", "683", "lumens for watts at 555 nm"},
    {179, "factor_179", "179", "the luminous efficacy of Radiance"},
    {106.856895, "factor_cie_y", "106.857", "the integral of the CIE's Y over wavelengths"},
    {kPi / 4, "factor_quarter_pi", "pi / 4", "the area of a disk over that of its square"},
    {177.83, "factor_177_83", "177.83", "the luminous efficacy of white light in Cycles"},
    {2, "factor_2", "2", "such as one side for two"},
    {4, "factor_4", "4", "such as a diameter for a radius, squared"},
    {100, "factor_100", "100", "such as centimetres for metres"},
    {1000, "factor_1000", "1000", "such as millimetres for metres"},
    {10000, "factor_10000", "10000", "such as square centimetres for square metres"},
};

}  // namespace

std::optional<Mistake> likely_mistake(const std::vector<double>& theirs,
                                      const std::vector<double>& ours,
                                      const std::vector<double>& scatter,
                                      const std::vector<Hypothesis>& hypotheses) {
  if (theirs.empty()) return {};
  const double without = misfit(theirs, ours, ours, scatter);
  struct Candidate {
    const Hypothesis* hypothesis;
    double misfit;
  };
  std::vector<Candidate> fits;
  for (const Hypothesis& h : hypotheses) {
    const double m = misfit(theirs, ours, h.predicted, scatter, h.partial);
    // What a partial mistake explains differs by more than a fit allows.
    if (m <= 1 && (h.partial || m * kMargin <= without)) fits.push_back({&h, m});
  }
  if (fits.empty()) return {};
  // Of mistakes that fit equally well, the simplest.
  double best = kInfinite;
  for (const Candidate& c : fits) best = std::min(best, c.misfit);
  const double limit = std::max(kEqual * best, 0.1);
  std::erase_if(fits, [&](const Candidate& c) { return c.misfit > limit; });
  int simplest = std::numeric_limits<int>::max();
  for (const Candidate& c : fits) simplest = std::min(simplest, c.hypothesis->complexity);
  std::erase_if(fits, [&](const Candidate& c) { return c.hypothesis->complexity > simplest; });
  std::ranges::stable_sort(fits, {}, &Candidate::misfit);
  Mistake named{fits[0].hypothesis->mistake, fits[0].hypothesis->sentence};
  std::set<std::string> seen = {named.sentence};
  for (const Candidate& c : fits) {
    if (seen.size() == 3) break;
    if (!seen.insert(c.hypothesis->sentence).second) continue;
    named.sentence += "; or " + c.hypothesis->sentence;
    if (named.mistake.find(c.hypothesis->mistake) == std::string::npos)
      named.mistake += "|" + c.hypothesis->mistake;
  }
  return named;
}

void add_factors(const std::vector<double>& ours, std::size_t lights,
                 std::vector<Hypothesis>* hypotheses) {
  const auto add = [&](double factor, const std::string& mistake, const std::string& sentence) {
    std::vector<double> predicted = ours;
    for (double& v : predicted) v *= factor;
    hypotheses->push_back({mistake, sentence, std::move(predicted), 1});
  };
  for (const Factor& f : kFactors) {
    add(f.value, f.mistake, fmt::format("a factor of {} is too many ({})", f.name, f.reason));
    add(1 / f.value, f.mistake, fmt::format("a factor of {} is missing ({})", f.name, f.reason));
  }
  if (lights < 2) return;
  const auto n = static_cast<double>(lights);
  add(n, "selection",
      fmt::format("the probability of choosing the light, 1/{}, is a divisor too many", lights));
  add(1 / n, "selection",
      fmt::format("a division by the probability of choosing the light, 1/{}, is missing", lights));
}

void add_product(const std::vector<double>& ours, const std::vector<double>& factor, double power,
                 const std::string& mistake, const std::string& sentence,
                 std::vector<Hypothesis>* hypotheses) {
  if (factor.empty()) return;
  std::vector<double> product = ours;
  for (std::size_t i = 0; i < product.size(); ++i)
    if (product[i] != 0) product[i] *= std::pow(factor[i], power);
  hypotheses->push_back({mistake, sentence, product, 1});
  for (const Factor& f : kFactors) {
    for (const bool more : {true, false}) {
      std::vector<double> both = product;
      for (double& v : both) v *= more ? f.value : 1 / f.value;
      hypotheses->push_back({mistake + "+" + f.mistake,
                             fmt::format("{}, and a factor of {} is {}", sentence, f.name,
                                         more ? "too many" : "missing"),
                             std::move(both), 2});
    }
  }
}

namespace {

// So many dark rows are not the farthest ones by chance.
constexpr std::size_t kFewestDark = 4;

/// Light within `range` [m] of a window over the distance.
void add_window(const std::vector<double>& ours, const std::vector<double>& distance, double range,
                double power, std::vector<Hypothesis>* hypotheses) {
  std::vector<double> predicted = ours;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const double share = std::pow(distance[i] / range, 4);
    if (!std::isnan(share)) predicted[i] *= std::pow(std::max(0.0, 1 - share), power);
  }
  hypotheses->push_back(
      {"range", fmt::format("the light falls to 0 at a range of {:.3g} m, such as glTF's", range),
       std::move(predicted), 2, true});
}

}  // namespace

void add_range(const std::vector<double>& theirs, const std::vector<double>& ours,
               const std::vector<double>& distance, std::vector<Hypothesis>* hypotheses) {
  if (distance.empty()) return;
  double lit = 0, dark = kInfinite;
  std::size_t dark_rows = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (!(ours[i] > 0) || !std::isfinite(distance[i])) continue;
    if (theirs[i] > 0) {
      lit = std::max(lit, distance[i]);
    } else {
      dark = std::min(dark, distance[i]);
      ++dark_rows;
    }
  }
  if (lit > 0 && lit < dark && dark_rows >= kFewestDark) {
    std::vector<double> cut = ours;
    for (std::size_t i = 0; i < cut.size(); ++i)
      if (distance[i] > lit) cut[i] = 0;
    hypotheses->push_back(
        {"range", fmt::format("the light ends at a range of {:.3g} to {:.3g} m", lit, dark),
         std::move(cut), 2, true});
  }
  for (const double power : {1.0, 2.0}) {
    // Each row in the slope of the window tells its range.
    std::vector<double> ranges;
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      const double share = 1 - std::pow(theirs[i] / ours[i], 1 / power);
      if (share > 0.05 && share < 0.95 && std::isfinite(distance[i]))
        ranges.push_back(distance[i] / std::pow(share, 0.25));
    }
    if (ranges.size() >= kFewestDark)
      add_window(ours, distance, quantile(std::move(ranges), 0.5), power, hypotheses);
  }
}

void add_clamp(const std::vector<double>& theirs, const std::vector<double>& ours,
               std::vector<Hypothesis>* hypotheses) {
  if (theirs.empty()) return;
  const double most = *std::ranges::max_element(theirs);
  std::vector<double> cut = ours;
  std::size_t above = 0, below = 0;
  for (double& v : cut) {
    above += v > most * (1 + kFitError) ? 1 : 0;
    below += v > 0 && v < most * (1 - kFitError) ? 1 : 0;
    v = std::min(v, most);
  }
  if (above < kFewestDark || below < kFewestDark) return;
  hypotheses->push_back({"clamped", fmt::format("numbers above {:.3g} are cut to it", most),
                         std::move(cut), 2, true});
}

}  // namespace lucerna::verify
