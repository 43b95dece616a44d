// What was found about one quantity of one light.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lucerna::verify {

enum class Verdict : std::uint8_t {
  kAgrees,
  kDiffers,
  /// The renderer samples in another way than Lucerna, and its densities fit its samples.
  kOwnWay,
  /// There were too few rows, or Lucerna has no answer for them.
  kNotJudged,
};

/// "agrees", "differs", "own way", "not judged".
const char* word(Verdict verdict);

struct Finding {
  /// Such as "density".
  std::string quantity;
  /// 0: all lights together.
  std::uint64_t light = 0;
  /// The rows that were compared, how many of them differ, and how many were left out.
  std::size_t rows = 0, off = 0, left_out = 0;
  /// Errors relative to Lucerna's numbers: the median and the worst.
  std::optional<double> median, worst;
  /// The place of the worst row, or the direction in which samples are too many or too few.
  std::string where;
  /// Of a statistical test, before and after the correction for the number of tests.
  std::optional<double> p, adjusted_p;
  /// The claimed density's integral, with its 95% interval.
  std::optional<double> integral, integral_low, integral_high;
  Verdict verdict = Verdict::kNotJudged;
  /// A word for programs; empty if there is none.
  std::string mistake;
  /// The likely mistake, or why something was not judged.
  std::string sentence;

  /// If it differs: finds the likely mistake.
  std::function<void(Finding&)> explain;
  /// True: a difference is the renderer's own way if the tests `tests` of the same light pass.  It
  /// stays a difference if one of them fails.
  bool own_way_allowed = false;
  std::vector<std::string> tests;
  /// True: if a test could not be made, the difference is not judged.
  bool needs_tests = false;
  /// A quantity of the same light.  If it agrees with Lucerna, the renderer has no way of its own.
  std::string rival;
  /// False: the test informs, and never decides.
  bool decides = true;
};

/// How strictly rows are compared.
struct Strictness {
  /// The chance that a correct set of files is called wrong.
  double level = 1e-3;
  /// Relative errors of numbers up to this are rounding.
  double tolerance = 1e-3;
  /// Angles of directions up to this are rounding [rad].
  double angle_rad = 1e-5;
  /// The share of rows that may differ.
  double outliers = 5e-3;
  /// A density must be one of Lucerna's.
  bool same_density = false;
  /// Samples of Lucerna's illuminances.
  std::uint32_t samples = 4096;
  /// Most reflections in the illuminances.
  std::uint32_t bounces = 0;
  std::uint64_t seed = 0;
};

/// Corrects the p-values for the number of tests, decides the verdicts that depend on them, and
/// explains what differs.
void decide(std::vector<Finding>& findings, const Strictness& strictness);

}  // namespace lucerna::verify
