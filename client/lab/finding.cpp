#include "client/lab/finding.h"

#include <algorithm>

#include "client/lab/verify_statistics.h"

namespace lucerna::verify {

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAgrees:
      return "agrees";
    case Verdict::kDiffers:
      return "differs";
    case Verdict::kOwnWay:
      return "own way";
    case Verdict::kNotJudged:
      break;
  }
  return "not judged";
}

namespace {

/// The verdict about a density that is not Lucerna's.
Verdict own_way(const Finding& density, const std::vector<Finding>& findings) {
  const auto verdict = [&](const std::string& quantity) {
    const auto found = std::ranges::find_if(findings, [&](const Finding& f) {
      return f.light == density.light && f.quantity == quantity;
    });
    return found == findings.end() ? Verdict::kNotJudged : found->verdict;
  };
  if (!density.rival.empty() && verdict(density.rival) == Verdict::kAgrees)
    return Verdict::kDiffers;
  bool all = true;
  for (const std::string& test : density.tests) {
    if (verdict(test) == Verdict::kDiffers) return Verdict::kDiffers;
    all &= verdict(test) == Verdict::kAgrees;
  }
  if (all) return Verdict::kOwnWay;
  return density.needs_tests ? Verdict::kNotJudged : Verdict::kDiffers;
}

}  // namespace

void decide(std::vector<Finding>& findings, const Strictness& strictness) {
  std::vector<double> p;
  for (const Finding& f : findings)
    if (f.p && f.decides) p.push_back(*f.p);
  const std::vector<double> adjusted = holm(p);
  std::size_t next = 0;
  for (Finding& f : findings) {
    if (!f.p) continue;
    // A test that only informs stands alone.
    f.adjusted_p = f.decides ? adjusted[next++] : *f.p;
    f.verdict = *f.adjusted_p <= strictness.level ? Verdict::kDiffers : Verdict::kAgrees;
    if (!f.decides && f.verdict == Verdict::kDiffers) f.verdict = Verdict::kOwnWay;
  }
  for (Finding& f : findings)
    if (f.verdict == Verdict::kDiffers && f.own_way_allowed) f.verdict = own_way(f, findings);
  for (Finding& f : findings) {
    if (f.verdict == Verdict::kNotJudged && f.needs_tests && f.off > 0) {
      f.sentence = "not Lucerna's, and too few rows to test it against its samples";
      continue;
    }
    if (f.verdict != Verdict::kDiffers) continue;
    if (f.explain) f.explain(f);
    if (f.sentence.empty()) f.sentence = "no known mistake fits";
  }
}

}  // namespace lucerna::verify
