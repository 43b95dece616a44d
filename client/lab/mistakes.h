// Names the mistake that explains how numbers of a renderer differ from Lucerna's.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lucerna::verify {

/// What the renderer's numbers would be with one mistake.
struct Hypothesis {
  /// A word for programs, such as "factor_pi".
  std::string mistake;
  /// For people, without a full stop.
  std::string sentence;
  /// One number per row.  NaN: the mistake predicts nothing for this row.
  std::vector<double> predicted;
  /// Of two mistakes that fit equally well, the smaller number is named.
  int complexity = 1;
  /// The mistake changes some rows only.  Then the rows that differ, or would, decide alone.
  bool partial = false;
};

struct Mistake {
  std::string mistake, sentence;
};

/// The mistake whose predictions agree with `theirs`.  `ours` are Lucerna's numbers.  `scatter` is
/// the relative standard error of each row; empty: none.  Nothing if no prediction fits:
///
/// - 85% of the rows must agree with the prediction within 1% and three standard errors.
/// - Without the mistake, the same share of rows must be at least four times as far away.
///
/// If several mistakes of the same complexity fit, the sentence names up to three.
std::optional<Mistake> likely_mistake(const std::vector<double>& theirs,
                                      const std::vector<double>& ours,
                                      const std::vector<double>& scatter,
                                      const std::vector<Hypothesis>& hypotheses);

/// Adds hypotheses in which all numbers have the same factor: pi, 2 pi, 4 pi, pi / 4, 683, 2 and
/// others, and the number of lights.
void add_factors(const std::vector<double>& ours, std::size_t lights,
                 std::vector<Hypothesis>* hypotheses);

/// Adds the hypothesis `ours` times `factor`^`power`, row by row; and with the factors of
/// add_factors() times that.
void add_product(const std::vector<double>& ours, const std::vector<double>& factor, double power,
                 const std::string& mistake, const std::string& sentence,
                 std::vector<Hypothesis>* hypotheses);

/// Adds hypotheses in which light ends at a distance: at once, or by a window such as that of
/// glTF's `range`.  `distance` [m] may have NaN.  Adds nothing if the numbers do not end so.
void add_range(const std::vector<double>& theirs, const std::vector<double>& ours,
               const std::vector<double>& distance, std::vector<Hypothesis>* hypotheses);

/// Adds the hypothesis that numbers are cut at the largest of `theirs`.  Adds nothing if none, or
/// all, would be cut.
void add_clamp(const std::vector<double>& theirs, const std::vector<double>& ours,
               std::vector<Hypothesis>* hypotheses);

}  // namespace lucerna::verify
