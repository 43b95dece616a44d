#include "client/verify/finding.h"

#include <algorithm>

#include "client/verify/statistics.h"

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
  const auto passes = [&](std::uint64_t light, const std::string& quantity) {
    const auto found = std::ranges::find_if(
        findings, [&](const Finding& f) { return f.light == light && f.quantity == quantity; });
    return found != findings.end() && found->verdict == Verdict::kAgrees;
  };
  for (Finding& f : findings) {
    if (f.verdict != Verdict::kDiffers || !f.own_way_allowed) continue;
    if (std::ranges::all_of(f.tests,
                            [&](const std::string& test) { return passes(f.light, test); }))
      f.verdict = Verdict::kOwnWay;
  }
  for (Finding& f : findings) {
    if (f.verdict != Verdict::kDiffers) continue;
    if (f.explain) f.explain(f);
    if (f.sentence.empty()) f.sentence = "no known mistake fits";
  }
}

}  // namespace lucerna::verify
