#include "client/lab/verify_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace lucerna::verify {
namespace {

cli::Cell percent(const std::optional<double>& error) {
  if (!error) return "";
  std::string text =
      *error < 1 ? fmt::format("{:.2g}%", 100 * *error) : fmt::format("{:.0f}%", 100 * *error);
  if (std::isinf(*error)) text = "only one is 0";
  return {std::move(text), {fmt::format("{}", *error)}};
}

std::string name_of(std::uint64_t id, const Truth& truth) {
  if (id == 0) return "all";
  const std::string& name = truth.light(id).name();
  return name.empty() ? std::to_string(id) : fmt::format("{} ({})", id, name);
}

cli::Cell light_of(std::uint64_t id, const Truth& truth) {
  return {name_of(id, truth), {id == 0 ? "" : std::to_string(id)}};
}

cli::Cell p_of(const std::optional<double>& p) {
  if (!p) return "";
  return {fmt::format("{:.2g}", *p), {fmt::format("{}", *p)}};
}

cli::Cell integral_of(const Finding& f) {
  if (!f.integral) return {"", {"", "", ""}};
  return {fmt::format("{:.4g} ± {:.2g}", *f.integral, *f.integral_high - *f.integral),
          {fmt::format("{}", *f.integral), fmt::format("{}", *f.integral_low),
           fmt::format("{}", *f.integral_high)}};
}

/// For programs also what the notes have.
cli::Cell verdict_of(const Finding& f) {
  return {word(f.verdict), {word(f.verdict), f.mistake, f.sentence, f.where}};
}

std::size_t count(const std::vector<Finding>& findings, Verdict verdict) {
  return static_cast<std::size_t>(std::ranges::count(findings, verdict, &Finding::verdict));
}

}  // namespace

bool any_differs(const std::vector<Finding>& findings) {
  return count(findings, Verdict::kDiffers) > 0;
}

cli::Table rows_of(const std::vector<Finding>& findings, const Truth& truth) {
  cli::Table table({{"light"},
                    {"quantity", true},
                    {"rows"},
                    {"off"},
                    {"median", false, {"median error"}},
                    {"worst", false, {"worst error"}},
                    {"p"},
                    {"integral", false, {"integral", "integral low", "integral high"}},
                    {"verdict", true, {"verdict", "mistake", "sentence", "where"}}});
  for (const Finding& f : findings) {
    table.add({light_of(f.light, truth), f.quantity, std::to_string(f.rows),
               f.median ? std::to_string(f.off) : "", percent(f.median), percent(f.worst),
               p_of(f.adjusted_p), integral_of(f), verdict_of(f)});
  }
  return table;
}

std::string notes_of(const std::vector<Finding>& findings, const Truth& truth,
                     const Strictness& strictness) {
  std::string notes;
  for (const Finding& f : findings) {
    if (f.verdict == Verdict::kAgrees) continue;
    std::string line =
        fmt::format("light {}, {}: {}", name_of(f.light, truth), f.quantity, word(f.verdict));
    if (!f.sentence.empty()) {
      line += f.verdict == Verdict::kDiffers && !f.mistake.empty() ? "; likely mistake: " : "; ";
      line += f.sentence;
    }
    if (!f.where.empty()) line += fmt::format("\n  {}", f.where);
    notes += line + "\n";
  }
  notes += fmt::format("{} of {} quantities differ", count(findings, Verdict::kDiffers),
                       findings.size());
  if (const std::size_t n = count(findings, Verdict::kNotJudged); n > 0)
    notes += fmt::format(", {} not judged", n);
  return notes + fmt::format("; a correct renderer differs with a chance of at most {:g}\n",
                             strictness.level);
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
