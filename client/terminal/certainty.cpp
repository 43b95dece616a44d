#include "client/terminal/certainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "client/terminal/output.h"

namespace lucerna::cli {

std::string percent(double share) {
  const double rest = std::min(share, 1 - share);
  std::string text;
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    text = fmt::format("{:.{}g}", 100 * share, digits);
    if (std::fabs(std::stod(text) / 100 - share) <= 1e-3 * rest) break;
  }
  return text;
}

std::string interval_text(double value, double lower, double upper, bool approximate) {
  if (lower == upper) return approximate ? "no scatter" : "exact";
  if (value == 0) return fmt::format("< {}", number(upper));
  const double above = upper - value, below = value - lower;
  // All three are rounded to floats.
  const double rounding = 2 * double{std::numeric_limits<float>::epsilon()} * upper;
  if (std::fabs(above - below) <= 1e-3 * above + rounding) return number((upper - lower) / 2);
  return fmt::format("{} ... {}", number(lower), number(upper));
}

Cell interval_cell(double value, double lower, double upper, bool approximate) {
  return {interval_text(value, lower, upper, approximate),
          {fmt::format("{}", lower), fmt::format("{}", upper)}};
}
Cell interval_cell(float value, float lower, float upper, bool approximate) {
  return {interval_text(value, lower, upper, approximate),
          {fmt::format("{}", lower), fmt::format("{}", upper)}};
}

Table::Column interval_column(const std::string& unit) {
  return {fmt::format("± [{}]", unit),
          false,
          {fmt::format("lower [{}]", unit), fmt::format("upper [{}]", unit)}};
}

bool is_approximate(const v1::Accuracy& accuracy) {
  return accuracy.has_far_light_radii() || accuracy.visibility() == v1::VISIBILITY_SHADOW_MAPS ||
         accuracy.thin_glass() == v1::THIN_GLASS_BLOCKS;
}

std::string describe_approximations(const v1::Accuracy& accuracy, const v1::Cost& cost) {
  std::string text;
  if (accuracy.has_far_light_radii())
    text += fmt::format("; approximated: area lights as points beyond {} radii",
                        number(accuracy.far_light_radii()));
  if (accuracy.visibility() == v1::VISIBILITY_SHADOW_MAPS)
    text += fmt::format("; approximated: shadow maps, {} of {} compared disagree",
                        cost.shadow_map_disagreed(), cost.shadow_map_compared());
  if (accuracy.thin_glass() == v1::THIN_GLASS_BLOCKS)
    text += "; approximated: thin panes block direct light";
  return text;
}

std::string describe_overrun(const v1::Accuracy& accuracy, const v1::Cost& cost,
                             std::uint64_t samples, const std::string& item) {
  const double budget_s = accuracy.time_budget_s(), time_s = cost.wall_time_s();
  if (!accuracy.has_time_budget_s() || time_s <= budget_s || samples == 0 ||
      samples > kDefaultBlocks) {
    return {};
  }
  const double sample_s = time_s / static_cast<double>(samples);
  const double fewer = std::max(1.0, std::floor(budget_s / sample_s));
  return fmt::format(
      "over the budget of {} s: each {} takes at least {} samples; --samples {} would take about "
      "{:.3g} s; ",
      number(budget_s), item, samples, number(fewer), fewer * sample_s);
}

TargetCheck::TargetCheck(const v1::TargetError& target)
    : relative_(target.relative()),
      floor_(target.absolute_floor()),
      max_samples_(target.has_max_samples() ? target.max_samples() : 65536) {}

bool TargetCheck::add(double value, double lower, double upper, std::uint64_t more_samples) {
  ++items_;
  const double allowed = std::max(relative_ * value, floor_), error = (upper - lower) / 2;
  const double rounding = double{std::numeric_limits<float>::epsilon()} * upper;
  if (error <= allowed + rounding) return true;
  ++missed_;
  if (more_samples > max_samples_) ++capped_;
  if (allowed > 0) worst_ = std::max(worst_, error / allowed);
  return false;
}

std::string TargetCheck::describe(const std::string& items) const {
  if (missed_ == 0) return {};
  std::string text = fmt::format("{} of {} {} missed the target", missed_, items_, items);
  if (worst_ > 1) text += fmt::format("; the worst interval is {:.3g} times too wide", worst_);
  if (capped_ > 0) text += "; --max-samples reached";
  if (capped_ > 0 && capped_ < missed_) text += fmt::format(" by {}", capped_);
  return text + "; ";
}

std::string json_of(const char* name, const std::vector<bool>& values) {
  return fmt::format("\"{}\":[{}]", name, fmt::join(values, ","));
}

std::string json_of_approximate(const v1::Accuracy& accuracy) {
  return fmt::format("\"approximate\":{}", is_approximate(accuracy));
}

}  // namespace lucerna::cli
