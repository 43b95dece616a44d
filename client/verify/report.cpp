#include "client/verify/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace lucerna::verify {
namespace {

/// A relative error, for people in percent.
cli::Cell percent(const std::optional<double>& error) {
  if (!error) return "";
  if (std::isinf(*error)) return {"only one is 0", {"inf"}};
  return {fmt::format("{:.2g}%", 100 * *error), {fmt::format("{}", *error)}};
}

std::string name_of(std::uint64_t id, const Truth& truth) {
  if (id == 0) return "all";
  const std::string& name = truth.light(id).name();
  return name.empty() ? std::to_string(id) : fmt::format("{} ({})", id, name);
}

/// An integral, with the upper end of its interval.
cli::Cell integral_of(const Finding& f) {
  if (!f.integral) return "";
  return {fmt::format("{:.4g} ± {:.2g}", *f.integral, *f.integral_high - *f.integral),
          {fmt::format("{}", *f.integral), fmt::format("{}", *f.integral_high)}};
}

/// Only what differs is wrong.
cli::Cell verdict_of(const Finding& f) {
  return cli::Cell::coloured(word(f.verdict), f.verdict == Verdict::kDiffers ? shell::Colour::kBad
                                              : f.verdict == Verdict::kAgrees
                                                  ? shell::Colour::kGood
                                                  : shell::Colour::kPlain);
}

std::size_t count(const std::vector<Finding>& findings, Verdict verdict) {
  return static_cast<std::size_t>(std::ranges::count(findings, verdict, &Finding::verdict));
}

}  // namespace

bool any_differs(const std::vector<Finding>& findings) {
  return count(findings, Verdict::kDiffers) > 0;
}

cli::Table table_of(const std::vector<Finding>& findings, const Truth& truth) {
  cli::Table table({{"light"},
                    {"quantity", true},
                    {"rows"},
                    {"off"},
                    {"median"},
                    {"worst"},
                    {"p"},
                    {"integral", false, {"integral", "integral upper"}},
                    {"verdict", true}});
  for (const Finding& f : findings) {
    table.add({name_of(f.light, truth), f.quantity, std::to_string(f.rows),
               f.median ? std::to_string(f.off) : "", percent(f.median), percent(f.worst),
               f.adjusted_p ? cli::Cell(fmt::format("{:.2g}", *f.adjusted_p),
                                        {fmt::format("{}", *f.adjusted_p)})
                            : cli::Cell(),
               integral_of(f), verdict_of(f)});
  }
  return table;
}

std::string notes_of(const std::vector<Finding>& findings, const Truth& truth,
                     const Strictness& strictness) {
  std::string sentences;
  for (const Finding& f : findings) {
    if (f.verdict == Verdict::kAgrees) continue;
    std::string line =
        fmt::format("light {}, {}: {}", name_of(f.light, truth), f.quantity, word(f.verdict));
    if (!f.sentence.empty()) {
      line += f.verdict == Verdict::kDiffers && !f.mistake.empty() ? "; likely mistake: " : "; ";
      line += f.sentence;
    }
    if (!f.where.empty()) line += fmt::format("\n  {}", f.where);
    sentences += line + "\n";
  }
  std::string summary = fmt::format("{} of {} quantities differ",
                                    count(findings, Verdict::kDiffers), findings.size());
  if (const std::size_t n = count(findings, Verdict::kNotJudged); n > 0)
    summary += fmt::format(", {} not judged", n);
  summary +=
      fmt::format("; a correct renderer differs with a chance of at most {:g}", strictness.level);
  return sentences + summary + "\n";
}

std::string json_of(const std::vector<Finding>& findings, const Truth& truth,
                    const Strictness& strictness) {
  using nlohmann::ordered_json;
  ordered_json all = ordered_json::array();
  for (const Finding& f : findings) {
    ordered_json one = {
        {"light", f.light},         {"lightName", f.light == 0 ? "" : truth.light(f.light).name()},
        {"quantity", f.quantity},   {"verdict", word(f.verdict)},
        {"rows", f.rows},           {"rowsOff", f.off},
        {"rowsLeftOut", f.left_out}};
    const auto put = [&](const char* name, const std::optional<double>& value) {
      // JSON has no infinity: an error of a number that is 0 on one side only.
      if (value)
        one[name] = std::isfinite(*value) ? ordered_json(*value) : ordered_json("Infinity");
    };
    put("medianError", f.median);
    put("worstError", f.worst);
    put("p", f.p);
    put("adjustedP", f.adjusted_p);
    put("integral", f.integral);
    put("integralLow", f.integral_low);
    put("integralHigh", f.integral_high);
    one["where"] = f.where;
    one["mistake"] = f.mistake;
    one["sentence"] = f.sentence;
    all.push_back(std::move(one));
  }
  const ordered_json json = {{"sceneId", truth.scene_id()},
                             {"level", strictness.level},
                             {"tolerance", strictness.tolerance},
                             {"differs", any_differs(findings)},
                             {"findings", std::move(all)}};
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace lucerna::verify
