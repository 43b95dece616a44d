#include "lights/pictures/photometric_angles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace lucerna {
namespace {

absl::Status check_angles(std::string_view kind, const std::vector<double>& angles) {
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const bool good = std::isfinite(angles[i]) && std::fabs(angles[i]) <= 720 &&
                      (i == 0 || angles[i] > angles[i - 1]);
    if (!good)
      return absl::InvalidArgumentError(
          fmt::format("{} angle[{}] = {} degrees, allowed: ascending, within 720 degrees of 0",
                      kind, i, angles[i]));
  }
  return absl::OkStatus();
}

std::string range(std::string_view kind, const std::vector<double>& angles) {
  return fmt::format("{} angles from {} to {} degrees", kind, angles.front(), angles.back());
}

absl::Status outside(std::string_view kind, const std::vector<double>& angles,
                     std::string_view allowed) {
  return absl::InvalidArgumentError(
      fmt::format("{}, allowed for {}", range(kind, angles), allowed));
}

absl::Status too_few(std::string_view kind, const std::vector<double>& angles,
                     std::string_view allowed) {
  return absl::InvalidArgumentError(fmt::format("{} {} angle{}, allowed: {}", angles.size(), kind,
                                                angles.size() == 1 ? "" : "s", allowed));
}

bool within(const std::vector<double>& angles, double least, double most) {
  return angles.front() >= least && angles.back() <= most;
}

bool is_range(const std::vector<double>& angles, double first, double last) {
  return angles.front() == first && angles.back() == last;
}

/// The planes [degrees] about which planes of type C are symmetric.
struct Mirrors {
  double lower, upper;
};

/// Nothing if there is no symmetry.  For two or more planes.
std::optional<Mirrors> mirrors_of(const std::vector<double>& h) {
  const double first = h.front(), last = h.back();
  if (last - first > 180) return std::nullopt;
  const double lower = 90 * std::floor(first / 90);
  if (first == lower && last == lower + 45) return Mirrors{lower, last};
  if (last <= lower + 90) return Mirrors{lower, lower + 90};
  if (last <= lower + 180) return Mirrors{lower, lower + 180};
  return std::nullopt;
}

double largest_step(const std::vector<double>& h) {
  double largest = 0;
  for (std::size_t i = 1; i < h.size(); ++i) largest = std::max(largest, h[i] - h[i - 1]);
  return largest;
}

/// Whether the planes make a circle, of which at most the last one is missing.
bool is_around(const std::vector<double>& h) {
  // A relative 1e-9 allows for angles with few digits.
  return 360 - (h.back() - h.front()) <= largest_step(h) * (1 + 1e-9);
}

/// The same for type A, whose planes over 180 degrees leave the other half dark.
bool is_around_in_type_a(const std::vector<double>& h) {
  return h.back() - h.front() > 180 && is_around(h);
}

/// Whether planes of types A and B continue by symmetry.
bool has_mirror_at_0(const std::vector<double>& h) { return h.front() == 0 && h.back() <= 180; }

}  // namespace

absl::Status check_vertical_angles(PhotometricType type, const std::vector<double>& degrees) {
  constexpr std::string_view kKind = "vertical";
  if (degrees.size() < 2) return too_few(kKind, degrees, "2 or more");
  if (auto s = check_angles(kKind, degrees); !s.ok()) return s;
  if (type == PhotometricType::kC)
    return within(degrees, 0, 180) ? absl::OkStatus()
                                   : outside(kKind, degrees, "type C: from 0 to 180");
  return within(degrees, -90, 90) ? absl::OkStatus()
                                  : outside(kKind, degrees, "types A and B: from -90 to 90");
}

absl::Status check_horizontal_angles(PhotometricType type, const std::vector<double>& degrees) {
  constexpr std::string_view kKind = "horizontal";
  if (degrees.empty()) return too_few(kKind, degrees, "1 or more");
  if (type != PhotometricType::kC && degrees.size() < 2)
    return too_few(kKind, degrees, "2 or more for types A and B");
  if (auto s = check_angles(kKind, degrees); !s.ok()) return s;
  if (type == PhotometricType::kB)
    return within(degrees, -90, 90) ? absl::OkStatus()
                                    : outside(kKind, degrees, "type B: from -90 to 90");
  return degrees.back() - degrees.front() <= 360
             ? absl::OkStatus()
             : outside(kKind, degrees, "types A and C: over 360 degrees at most");
}

std::optional<AngleGap> vertical_gap(PhotometricType type, const std::vector<double>& degrees) {
  const double first = degrees.front(), last = degrees.back();
  const bool whole = type == PhotometricType::kC
                         ? (first == 0 || first == 90) && (last == 90 || last == 180)
                         : is_range(degrees, -90, 90);
  if (whole) return std::nullopt;
  return AngleGap{range("vertical", degrees), "dark outside of them"};
}

std::optional<AngleGap> horizontal_gap(PhotometricType type, const std::vector<double>& degrees) {
  const std::string what = range("horizontal", degrees);
  const double first = degrees.front(), last = degrees.back();
  if (type != PhotometricType::kC) {
    if (is_range(degrees, 0, 90) || is_range(degrees, -90, 90)) return std::nullopt;
    if (is_around_in_type_a(degrees) || is_range(degrees, 0, 180))
      return AngleGap{what, "all around, although the standard has -90 to 90 only"};
    return AngleGap{what, has_mirror_at_0(degrees)
                              ? fmt::format("symmetric about 0, and dark beyond {}", last)
                              : "dark outside of them"};
  }
  if (degrees.size() == 1) {
    if (first == 0) return std::nullopt;
    return AngleGap{fmt::format("one horizontal angle, {} degrees", first),
                    "symmetric about the axis"};
  }
  if (const auto mirrors = mirrors_of(degrees)) {
    const bool known = is_range(degrees, 0, 90) || is_range(degrees, 0, 180) ||
                       is_range(degrees, 90, 270) || is_range(degrees, -90, 90);
    if (known) return std::nullopt;
    return AngleGap{
        what, fmt::format("symmetric about the planes {} and {}", mirrors->lower, mirrors->upper)};
  }
  if (is_around(degrees)) return std::nullopt;
  return AngleGap{what, fmt::format("linear from the last plane to the first, over {} degrees",
                                    360 - (last - first))};
}

std::vector<PhotometricPlane> all_planes(PhotometricType type, const std::vector<double>& degrees) {
  std::vector<PhotometricPlane> planes;
  planes.reserve(2 * degrees.size());
  if (type != PhotometricType::kC && has_mirror_at_0(degrees))
    for (std::size_t i = degrees.size(); --i > 0;) planes.push_back({-degrees[i], i});
  for (std::size_t i = 0; i < degrees.size(); ++i) planes.push_back({degrees[i], i});
  if (type != PhotometricType::kC && !is_around_in_type_a(degrees)) return planes;
  if (type == PhotometricType::kC && degrees.size() > 1)
    if (const auto mirrors = mirrors_of(degrees)) {
      // Each mirror image doubles the range, up to the circle.
      for (double open = mirrors->upper - mirrors->lower; open < 360; open *= 2) {
        const double mirror = mirrors->lower + open;
        for (std::size_t i = planes.size(); i-- > 0;)
          if (planes[i].deg != mirror) planes.push_back({2 * mirror - planes[i].deg, planes[i].of});
      }
    }
  if (const double end = degrees.front() + 360; planes.back().deg < end) planes.push_back({end, 0});
  return planes;
}

}  // namespace lucerna
