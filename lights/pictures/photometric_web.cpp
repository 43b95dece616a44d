#include "lights/pictures/photometric_web.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

constexpr double kRadPerDegree = kPi / 180;

/// The angle by which rounding of angles and directions to float may turn a direction.
constexpr double kSlack = 1e-6;

/// The distance from a pole within which an azimuth is rounding.  Beams may be as narrow as 1e-9.
constexpr double kAtPole = 1e-10;

/// The axes of a type's grid in light space.
struct Axes {
  Vec3 pole, zero, ninety;
};

Axes axes_of(PhotometricType type) {
  switch (type) {
    case PhotometricType::kA:
      return {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}};
    case PhotometricType::kB:
      return {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    case PhotometricType::kC:
      break;
  }
  return {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}};
}

/// Integrals of the sine over an interval, times the two linear functions that are 1 at one end and
/// 0 at the other.  They are sin(m) sin(d) -+ cos(m) (sin(d) - d cos(d)) / d, with m the middle and
/// d half of the length.
struct EndWeights {
  double lower, upper;
};

EndWeights end_weights(double a, double b) {
  const double m = a + (b - a) / 2, d = (b - a) / 2;
  // (sin d - d cos d) / d cancels; below 0.1 its series is exact to 1e-16 of its first term.
  const double d2 = d * d;
  const double slope =
      d < 0.1
          ? d2 * (1.0 / 3 - d2 * (1.0 / 30 - d2 * (1.0 / 840 - d2 * (1.0 / 45360 - d2 / 3991680))))
          : std::sin(d) / d - std::cos(d);
  const double even = std::sin(m) * std::sin(d), odd = std::cos(m) * slope;
  return {even - odd, even + odd};
}

/// (1 - cos(angle)) / 2, without cancellation at the pole.  It is uniform in solid angle.
double half_one_minus_cos(double angle) {
  const double s = std::sin(angle / 2);
  return s * s;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const PhotometricWeb>> PhotometricWeb::create(
    const PhotometricWebParams& params) {
  if (auto s = check_vertical_angles(params.type, params.vertical_deg); !s.ok()) return s;
  if (auto s = check_horizontal_angles(params.type, params.horizontal_deg); !s.ok()) return s;
  const std::size_t points = params.vertical_deg.size() * params.horizontal_deg.size();
  if (params.intensity_cd.size() != points)
    return absl::InvalidArgumentError(
        fmt::format("{} intensities, allowed: {}, one for each grid point",
                    params.intensity_cd.size(), points));
  StopPoll poll;
  for (std::size_t i = 0; i < points; ++i, poll()) {
    // With this bound, sums over the sphere do not overflow.
    if (!(params.intensity_cd[i] >= 0 && params.intensity_cd[i] <= 1e300))
      return absl::InvalidArgumentError(
          fmt::format("intensity {} at horizontal angle {} and vertical angle {} = {} cd, allowed: "
                      "finite, not negative",
                      i, params.horizontal_deg[i / params.vertical_deg.size()],
                      params.vertical_deg[i % params.vertical_deg.size()], params.intensity_cd[i]));
  }
  return std::shared_ptr<const PhotometricWeb>(new PhotometricWeb(params));
}

PhotometricWeb::PhotometricWeb(const PhotometricWebParams& params) : type_(params.type) {
  write_out(params);
  max_cd_ = *std::max_element(cd_.begin(), cd_.end());
  integrate();
  bound();
}

// Expands the symmetries of the file's grid.  Polar angles are from the pole, and azimuths cover
// all directions with light.
void PhotometricWeb::write_out(const PhotometricWebParams& params) {
  const std::vector<double>& v = params.vertical_deg;
  const std::vector<PhotometricPlane> planes = all_planes(type_, params.horizontal_deg);
  const auto add_row = [&](double azimuth_deg, auto&& index_of) {
    azimuth_rad_.push_back(azimuth_deg * kRadPerDegree);
    for (std::size_t j = 0; j < polar_rad_.size(); ++j)
      cd_.push_back(params.intensity_cd[index_of(j)]);
  };
  if (type_ == PhotometricType::kB) {
    // The horizontal angle is the latitude: the file's planes are the columns.
    const std::size_t m = planes.size();
    polar_rad_.reserve(m), azimuth_rad_.reserve(v.size()), cd_.reserve(v.size() * m);
    for (std::size_t j = m; j-- > 0;) polar_rad_.push_back((90 - planes[j].deg) * kRadPerDegree);
    for (std::size_t i = 0; i < v.size(); ++i)
      add_row(v[i], [&](std::size_t j) { return planes[m - 1 - j].of * v.size() + i; });
    return;
  }
  const std::size_t n = v.size();
  const bool from_pole = type_ == PhotometricType::kC;
  polar_rad_.reserve(n), azimuth_rad_.reserve(planes.size()), cd_.reserve(planes.size() * n);
  for (std::size_t j = 0; j < n; ++j)
    polar_rad_.push_back((from_pole ? v[j] : 90 - v[n - 1 - j]) * kRadPerDegree);
  for (const PhotometricPlane& plane : planes)
    add_row(plane.deg, [&](std::size_t j) { return plane.of * n + (from_pole ? j : n - 1 - j); });
}

double PhotometricWeb::cell_flux(std::size_t row, std::size_t column) const {
  // Over the azimuth, the mean of a bilinear function is the mean of its two ends.
  const EndWeights w = end_weights(polar_rad_[column], polar_rad_[column + 1]);
  const double lower = (value(row, column) + value(row + 1, column)) / 2;
  const double upper = (value(row, column + 1) + value(row + 1, column + 1)) / 2;
  return (azimuth_rad_[row + 1] - azimuth_rad_[row]) * (lower * w.lower + upper * w.upper);
}

void PhotometricWeb::integrate() {
  cumulative_.reserve(rows() * columns());
  StopPoll poll;
  for (std::size_t i = 0; i < rows(); ++i)
    for (std::size_t j = 0; j < columns(); ++j, poll())
      cumulative_.push_back(flux_lm_ += cell_flux(i, j));
}

double PhotometricWeb::flux_between(double from, double to) const {
  double sum = 0;
  StopPoll poll;
  for (std::size_t i = 0; i < rows(); ++i)
    for (std::size_t j = 0; j < columns(); ++j, poll()) {
      // The part of the cell between `from` and `to`.  It is linear in the angle, like the cell.
      const double p = polar_rad_[j], q = polar_rad_[j + 1];
      const double a = std::max(p, from), b = std::min(q, to);
      if (!(a < b)) continue;
      const double first = (value(i, j) + value(i + 1, j)) / 2;
      const double last = (value(i, j + 1) + value(i + 1, j + 1)) / 2;
      const auto at = [&](double angle) { return std::lerp(first, last, (angle - p) / (q - p)); };
      const EndWeights w = end_weights(a, b);
      sum += (azimuth_rad_[i + 1] - azimuth_rad_[i]) * (at(a) * w.lower + at(b) * w.upper);
    }
  return sum;
}

double PhotometricWeb::downward_flux_lm() const {
  if (type_ == PhotometricType::kB) return flux_lm_;
  return type_ == PhotometricType::kC ? flux_between(0, kPi / 2) : flux_between(kPi / 2, kPi);
}

double PhotometricWeb::horizon_flux_bound_lm(double width_rad) const {
  if (!(width_rad > 0)) return 0;
  if (type_ != PhotometricType::kB)
    return std::max(flux_between(kPi / 2 - width_rad, kPi / 2),
                    flux_between(kPi / 2, kPi / 2 + width_rad));
  // All light of type B is on one side, at the height sin(polar) cos(azimuth) above the horizon.
  // Within a cell, `least_off` bounds each angle of the band away from the middle of its range.
  // The intensity is linear in each angle, so it is largest at an end of one of these pieces.
  const double height = std::sin(width_rad);
  const auto ends = [](double begin, double end, double middle, double off) {
    std::vector<double> at;
    for (const double angle : {begin, end})
      if (std::fabs(angle - middle) >= off) at.push_back(angle);
    for (const double angle : {middle - off, middle + off})
      if (begin < angle && angle < end) at.push_back(angle);
    return at;
  };
  const auto least_off = [&](double least_of_other) {
    return std::acos(std::min(1.0, height / std::max(0.0, least_of_other)));
  };
  double largest = 0;
  StopPoll poll;
  for (std::size_t i = 0; i < rows(); ++i)
    for (std::size_t j = 0; j < columns(); ++j, poll()) {
      const double a = azimuth_rad_[i], b = azimuth_rad_[i + 1];
      const double p = polar_rad_[j], q = polar_rad_[j + 1];
      const double from_zero = least_off(std::min(std::sin(p), std::sin(q)));
      const double from_equator = least_off(std::min(std::cos(a), std::cos(b)));
      for (const double azimuth : ends(a, b, 0, from_zero))
        for (const double polar : ends(p, q, kPi / 2, from_equator)) {
          const double s = (azimuth - a) / (b - a), t = (polar - p) / (q - p);
          largest =
              std::max(largest, std::lerp(std::lerp(value(i, j), value(i, j + 1), t),
                                          std::lerp(value(i + 1, j), value(i + 1, j + 1), t), s));
        }
    }
  return 2 * kPi * height * largest;
}

void PhotometricWeb::bound() {
  double from_pole = 0, from_other_pole = 0;
  // Grids of type C cover all azimuths.  Those of types A and B mostly lie in the half towards
  // `zero`.
  const bool in_half = type_ != PhotometricType::kC && azimuth_rad_.front() > -kPi / 2 - kSlack &&
                       azimuth_rad_.back() < kPi / 2 + kSlack;
  double from_zero = in_half ? 0 : kPi;
  StopPoll poll;
  for (std::size_t i = 0; i < rows(); ++i) {
    for (std::size_t j = 0; j < columns(); ++j, poll()) {
      if (std::max({value(i, j), value(i + 1, j), value(i, j + 1), value(i + 1, j + 1)}) == 0)
        continue;
      from_pole = std::max(from_pole, polar_rad_[j + 1]);
      from_other_pole = std::max(from_other_pole, kPi - polar_rad_[j]);
      // The cosine of the angle is a product of two factors, each least at an end.  So the farthest
      // point is a corner.
      if (!in_half) continue;
      for (const std::size_t row : {i, i + 1})
        for (const std::size_t column : {j, j + 1}) {
          const double cos = std::sin(polar_rad_[column]) * std::cos(azimuth_rad_[row]);
          from_zero = std::max(from_zero, std::acos(std::clamp(cos, -1.0, 1.0)));
        }
    }
  }
  const Axes axes = axes_of(type_);
  cone_ = {axes.pole, from_pole};
  if (from_other_pole < cone_.half_angle_rad) cone_ = {-axes.pole, from_other_pole};
  if (from_zero < cone_.half_angle_rad) cone_ = {axes.zero, from_zero};
  cone_.half_angle_rad = std::min(kPi, cone_.half_angle_rad + kSlack);
}

PhotometricWeb::GridPosition PhotometricWeb::find(const Vec3& w) const {
  const Axes axes = axes_of(type_);
  const double x = dot(w, axes.zero), y = dot(w, axes.ninety), z = dot(w, axes.pole);
  const double polar = std::atan2(std::hypot(x, y), z);
  double azimuth = std::atan2(y, x);
  // The file's planes may begin anywhere within a turn of 0.
  while (azimuth < azimuth_rad_.front()) azimuth += 2 * kPi;
  while (azimuth > azimuth_rad_.front() + 2 * kPi) azimuth -= 2 * kPi;
  // A full circle has no gap, even if rounding moved its ends.
  const bool around = azimuth_rad_.back() - azimuth_rad_.front() > 6.28;
  const bool at_pole = std::min(polar, kPi - polar) < kAtPole;
  const bool inside =
      polar >= polar_rad_.front() && polar <= polar_rad_.back() &&
      (around || at_pole || (azimuth >= azimuth_rad_.front() && azimuth <= azimuth_rad_.back()));
  GridPosition place{0, 0, 0, 0, inside, at_pole};
  if (!inside) return place;
  const auto locate = [](const std::vector<double>& grid, double at, std::size_t& cell,
                         double& within) {
    const auto next = std::upper_bound(grid.begin() + 1, grid.end() - 1, at);
    cell = static_cast<std::size_t>(next - grid.begin()) - 1;
    within = std::clamp((at - grid[cell]) / (grid[cell + 1] - grid[cell]), 0.0, 1.0);
  };
  locate(azimuth_rad_, azimuth, place.row, place.s);
  locate(polar_rad_, polar, place.column, place.t);
  return place;
}

double PhotometricWeb::at(const Vec3& w) const {
  const GridPosition p = find(w);
  if (!p.inside) return 0;
  // A pole has no azimuth.
  if (p.at_pole) return mean_of_column(p.column) * (1 - p.t) + mean_of_column(p.column + 1) * p.t;
  const double lower = value(p.row, p.column) * (1 - p.s) + value(p.row + 1, p.column) * p.s;
  const double upper =
      value(p.row, p.column + 1) * (1 - p.s) + value(p.row + 1, p.column + 1) * p.s;
  return lower * (1 - p.t) + upper * p.t;
}

double PhotometricWeb::mean_of_column(std::size_t column) const {
  // Relative to one of them, so that equal values have this mean.
  const double first = value(0, column);
  double sum = 0;
  for (std::size_t i = 0; i < rows(); ++i)
    sum += (azimuth_rad_[i + 1] - azimuth_rad_[i]) *
           (value(i, column) - first + value(i + 1, column) - first) / 2;
  return std::clamp(first + sum / (azimuth_rad_.back() - azimuth_rad_.front()), 0.0, max_cd_);
}

double PhotometricWeb::solid_angle(std::size_t row, std::size_t column) const {
  const double a = polar_rad_[column], b = polar_rad_[column + 1];
  return (azimuth_rad_[row + 1] - azimuth_rad_[row]) * 2 * std::sin((a + b) / 2) *
         std::sin((b - a) / 2);
}

Vec3 PhotometricWeb::sample(Vec2 u) const {
  // `u.x` chooses the row of cells, and its rest is the position in the row.  `u.y` chooses the
  // cell in the same way.  Cells without flux are never chosen, even for u = 1.
  const auto pick = [](std::size_t count, double from, double to, double u, auto&& end,
                       double& rest) {
    const double target = from + u * (to - from);
    std::size_t low = 0, high = count - 1;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (end(middle) > target || end(middle) >= to)
        high = middle;
      else
        low = middle + 1;
    }
    const double before = low == 0 ? from : end(low - 1);
    rest = std::clamp((target - before) / (end(low) - before), 0.0, 1.0);
    return low;
  };
  double s = 0, t = 0;
  const auto row_end = [&](std::size_t i) { return cumulative_[(i + 1) * columns() - 1]; };
  const std::size_t row = pick(rows(), 0, flux_lm_, u.x, row_end, s);
  const auto cell_end = [&](std::size_t j) { return cumulative_[row * columns() + j]; };
  const std::size_t column =
      pick(columns(), row == 0 ? 0 : row_end(row - 1), row_end(row), u.y, cell_end, t);

  const double azimuth = azimuth_rad_[row] + s * (azimuth_rad_[row + 1] - azimuth_rad_[row]);
  const double h0 = half_one_minus_cos(polar_rad_[column]);
  const double h1 = half_one_minus_cos(polar_rad_[column + 1]);
  const double h = std::clamp(h0 + t * (h1 - h0), 0.0, 1.0);
  const double r = 2 * std::sqrt(h * (1 - h));
  const Axes axes = axes_of(type_);
  return normalized(axes.zero * (r * std::cos(azimuth)) + axes.ninety * (r * std::sin(azimuth)) +
                    axes.pole * (1 - 2 * h));
}

SolidAnglePdf PhotometricWeb::pdf(const Vec3& w) const {
  const GridPosition p = find(w);
  if (!p.inside || !(flux_lm_ > 0)) return {};
  // Uses the flux of the cell.  A difference of sums would lose a faint cell beside bright ones.
  return {cell_flux(p.row, p.column) / flux_lm_ / solid_angle(p.row, p.column)};
}

std::uint64_t PhotometricWeb::bytes() const {
  return sizeof(*this) + sizeof(double) * (polar_rad_.capacity() + azimuth_rad_.capacity() +
                                           cd_.capacity() + cumulative_.capacity());
}

}  // namespace lucerna
