#include "server/description/pixel_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "lights/sampling/sampling.h"

namespace lucerna {
namespace {

constexpr double kLeastRadius = 1e-3, kMostRadius = 64;
constexpr double kMostSigma = 1e6, kLeastTau = 0.25;
/// A filter whose negative parts cancel more than this would need very many samples.
constexpr double kMostExcess = 8;
/// Cells of a table.  Linear interpolation then errs by less than 1e-4 of the largest value.
constexpr int kCells = 512;
constexpr int kCellsPerLobe = 128;
/// Beyond this many standard deviations, a normal distribution is below 1e-21 of its largest value.
constexpr double kMostSigmas = 10;

absl::Status check_radius(const char* name, double radius_px) {
  if (radius_px >= kLeastRadius && radius_px <= kMostRadius) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} = {} pixels, allowed [{}, {}]", name, radius_px, kLeastRadius, kMostRadius));
}

absl::Status check_shape(const PixelFilterParams& params) {
  if (const auto* g = std::get_if<GaussianFilter>(&params.shape);
      g != nullptr && !(g->sigma_px > 0 && g->sigma_px <= kMostSigma))
    return absl::InvalidArgumentError(
        fmt::format("sigma = {} pixels, allowed (0, {:g}]", g->sigma_px, kMostSigma));
  if (const auto* s = std::get_if<SincFilter>(&params.shape);
      s != nullptr && !(s->tau >= kLeastTau && std::isfinite(s->tau)))
    return absl::InvalidArgumentError(
        fmt::format("tau = {} pixels, allowed [{}, inf)", s->tau, kLeastTau));
  return absl::OkStatus();
}

/// The magnitude of the function at `count` + 1 equal steps from 0 to `end`.
template <typename Function>
std::vector<double> table(double end, int count, Function&& function) {
  std::vector<double> values(static_cast<std::size_t>(count) + 1);
  for (int i = 0; i <= count; ++i) values[static_cast<std::size_t>(i)] = function(end * i / count);
  return values;
}

double mitchell(const MitchellFilter& f, double x) {
  const double b = f.b, c = f.c;
  if (x <= 1)
    return (((12 - 9 * b - 6 * c) * x + (-18 + 12 * b + 6 * c)) * x * x + (6 - 2 * b)) / 6;
  return (((-b - 6 * c) * x + (6 * b + 30 * c)) * x * x + (-12 * b - 48 * c) * x +
          (8 * b + 24 * c)) /
         6;
}

double sinc(double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); }

}  // namespace

PixelFilter::Axis::Axis(double radius_px, const std::vector<double>& values)
    : radius_px_(radius_px) {
  const auto cells = static_cast<double>(values.size() - 1);
  nodes_.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = radius_px * static_cast<double>(i) / cells, value = values[i];
    if (i > 0 && values[i - 1] * value < 0) {
      // The function has one sign between two nodes.
      const double from = nodes_.back().x_px;
      const double share = values[i - 1] / (values[i - 1] - value);
      nodes_.push_back({from + share * (x - from), 0, 0, value < 0});
    } else if (i > 0) {
      nodes_.back().is_negative = values[i - 1] + value < 0;
    }
    nodes_.push_back({x, std::fabs(value), 0, value < 0});
  }
  double magnitude = 0, integral = 0;
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    const Node& next = nodes_[i + 1];
    const double area = (node.magnitude + next.magnitude) / 2 * (next.x_px - node.x_px);
    node.before = magnitude;
    magnitude += area;
    integral += node.is_negative ? -area : area;
    is_signed_ |= node.is_negative && area > 0;
  }
  nodes_.shrink_to_fit();
  nodes_.back().before = magnitude;
  for (Node& node : nodes_) node.before /= magnitude;
  if (is_signed_) excess_ = magnitude / integral;
  if (!(magnitude > 0)) excess_ = 0;
}

PixelFilter::Axis::Offset PixelFilter::Axis::sample(double u) const {
  // The function is even.  So the distance from the centre has the share |2 u - 1|, and the
  // position is an increasing function of u.
  const double side = 2 * u - 1, share = std::fabs(side);
  double distance = 0;
  bool is_negative = false;
  if (nodes_.empty()) {
    distance = radius_px_ * (is_triangle_ ? share / (1 + std::sqrt(1 - share)) : share);
  } else {
    // The last node with a smaller share: the cell after it is not empty.
    const auto next = std::lower_bound(nodes_.begin() + 1, nodes_.end() - 1, share,
                                       [](const Node& n, double s) { return n.before < s; });
    const Node& from = *(next - 1);
    const double within =
        std::clamp((share - from.before) / (next->before - from.before), 0.0, 1.0);
    distance = from.x_px +
               (next->x_px - from.x_px) * sample_linear(within, from.magnitude, next->magnitude);
    is_negative = from.is_negative;
  }
  return {std::copysign(distance, side), is_negative};
}

PixelFilter::Axis PixelFilter::axis(const PixelFilterParams& params, double radius_px) {
  return std::visit(
      [&]<typename Shape>(const Shape& shape) {
        if constexpr (std::is_same_v<Shape, GaussianFilter>) {
          // Farther away there is nothing, and a narrow peak needs the nodes.
          const double end = std::min(radius_px, kMostSigmas * shape.sigma_px);
          const double twice = 2 * shape.sigma_px * shape.sigma_px;
          return Axis(end, table(end, kCells, [&](double x) {
                        // exp(-x^2 / 2 s^2) - exp(-r^2 / 2 s^2), without cancellation.
                        return -std::exp(-x * x / twice) *
                               std::expm1((x - radius_px) * (x + radius_px) / twice);
                      }));
        } else if constexpr (std::is_same_v<Shape, MitchellFilter>) {
          return Axis(radius_px, table(2, kCells, [&](double x) { return mitchell(shape, x); }));
        } else if constexpr (std::is_same_v<Shape, SincFilter>) {
          const double lobes = radius_px * std::max(1.0, 1 / shape.tau);
          const int cells = std::max(kCells, static_cast<int>(std::ceil(lobes * kCellsPerLobe)));
          return Axis(radius_px, table(radius_px, cells,
                                       [&](double x) { return sinc(x) * sinc(x / shape.tau); }));
        } else {
          return Axis(radius_px, std::is_same_v<Shape, TriangleFilter>);
        }
      },
      params.shape);
}

absl::StatusOr<std::shared_ptr<const PixelFilter>> PixelFilter::create(
    const PixelFilterParams& params) {
  for (const absl::Status& status :
       {check_radius("xradius", params.radius_px.x), check_radius("yradius", params.radius_px.y),
        check_shape(params)})
    if (!status.ok()) return status;
  std::shared_ptr<const PixelFilter> filter(
      new PixelFilter(axis(params, params.radius_px.x), axis(params, params.radius_px.y)));
  for (const Axis* a : {&filter->x_, &filter->y_}) {
    if (a->excess() > 0 && a->excess() <= kMostExcess) continue;
    const auto* m = std::get_if<MitchellFilter>(&params.shape);
    return absl::InvalidArgumentError(fmt::format(
        "{}the integral of the filter's magnitude is {:.3g} times that of the filter along an "
        "axis, allowed (0, {}]",
        m != nullptr ? fmt::format("B = {}, C = {}: ", m->b, m->c) : "", a->excess(), kMostExcess));
  }
  return filter;
}

PixelFilter::Sample PixelFilter::sample(Vec2f u) const {
  const Axis::Offset x = x_.sample(u.x), y = y_.sample(u.y);
  return {{static_cast<float>(0.5 + x.offset_px), static_cast<float>(0.5 + y.offset_px)},
          x.is_negative != y.is_negative ? -weight_ : weight_};
}

}  // namespace lucerna
