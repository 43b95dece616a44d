#include "tests/oracle/interior_truth.h"

#include <complex>
#include <numbers>

#include "tests/oracle/oracle_gauss.h"
#include "tests/oracle/square_integral.h"

namespace lucerna::oracle {
namespace {

constexpr double kOnePi = std::numbers::pi;
/// Floats move the edge of a sheet, as a lamp sees it, by less than this.
constexpr double kMoved = 1e-5;
/// The least cosine at a receiver that the rounding of its normal hardly changes.
constexpr double kGrazing = 1e-3;
/// Of a lamp with a size, a part that is as low above the horizon is a sliver, and rounding decides
/// its area.
constexpr double kSliver = 0.03;
/// From this number of mirrors on, a lamp with a size is far away.
constexpr std::size_t kFarChain = 8;
constexpr std::size_t kLongestChain = 200;

Vector mirrored(const Sheet& sheet, const Vector& p) {
  return p - sheet.n * (2 * dot(sheet.n, p - sheet.corner));
}
Vector turned(const Sheet& sheet, const Vector& w) { return w - sheet.n * (2 * dot(sheet.n, w)); }

/// Fresnel's equations for light from air, the mean of both polarisations.  `eta` may be complex.
template <typename Index>
double fresnel(double cosine, const Index& eta) {
  const Index sine2 = (1 - cosine * cosine) / (eta * eta);
  const Index inside = std::sqrt(Index(1) - sine2);
  const Index parallel = (eta * cosine - inside) / (eta * cosine + inside);
  const Index across = (cosine - eta * inside) / (cosine + eta * inside);
  const double a = std::abs(parallel), b = std::abs(across);
  return (a * a + b * b) / 2;
}

/// The share that a mirror or a pane reflects.
double reflected(const Sheet& sheet, double cosine) {
  cosine = std::min(std::fabs(cosine), 1.0);
  if (sheet.kind == Sheet::Kind::kPane) {
    const double r = fresnel(cosine, sheet.value), t = 1 - r;
    return r + t * t * r / (1 - r * r);
  }
  // pbrt-v4 gives a reflectance this complex index.
  const double k = 2 * std::sqrt(sheet.value) / std::sqrt(1 - sheet.value);
  return fresnel(cosine, std::complex<double>(1, k));
}

/// Where a ray meets the plane of a sheet: the distance, and how far inside its edges; less than 0
/// outside.  The distance is not finite if there is none.
struct Meeting {
  double distance, inside;
};
Meeting meeting(const Sheet& sheet, const Vector& from, const Vector& w) {
  const double distance = dot(sheet.n, sheet.corner - from) / dot(sheet.n, w);
  const Vector p = from + w * distance - sheet.corner;
  const double a = dot(p, sheet.along_u), b = dot(p, sheet.along_v);
  return {distance, std::min(std::min(a, sheet.width - a), std::min(b, sheet.height - b))};
}

/// The distance at which a ray meets a ball from outside; infinite if it does not.
double distance_to_ball(const Vector& middle, double radius, const Vector& from, const Vector& w,
                        bool& doubt) {
  const Vector to = middle - from;
  const double along = dot(to, w), beside = size(to - w * along);
  if (along > 0 && std::fabs(beside - radius) < kMoved) doubt = true;
  if (!(along > 0 && beside < radius)) return INFINITY;
  return along - std::sqrt(radius * radius - beside * beside);
}

std::pair<Vector, Vector> axes_across(const Vector& n) {
  const Vector u = unit(cross(std::fabs(n.x) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0}, n));
  return {u, cross(n, u)};
}

/// A direction around the unit vector, with a density of cosine / pi.
Vector direction(const Vector& n, double s, double t) {
  const auto [u, v] = axes_across(n);
  const double r = std::sqrt(s), angle = 2 * kOnePi * t;
  return u * (r * std::cos(angle)) + v * (r * std::sin(angle)) + n * std::sqrt(1 - s);
}

/// A spot's share of its intensity along the axis: a smoothstep of the cosine.
double of_spot(const Lamp& spot, const Vector& w, bool& doubt) {
  const double cosine = dot(spot.axis, w);
  const double dark = std::cos(spot.angle), full = std::cos(spot.angle - spot.edge);
  if (spot.edge == 0) {
    if (std::fabs(cosine - dark) < kMoved) doubt = true;
    return cosine >= dark ? 1 : 0;
  }
  const double x = std::clamp((cosine - dark) / (full - dark), 0.0, 1.0);
  if (x > 0 && x < 0.01) doubt = true;  // rounding changes little light by a large share
  return x * x * (3 - 2 * x);
}

}  // namespace

InteriorTruth::InteriorTruth(const Interior& interior) : interior_(interior) {
  for (std::size_t n = 0; n < few_.size(); ++n) few_[n] = chains(n);
}

/// Chains of at most so many mirrors.
auto InteriorTruth::chains(std::size_t longest) const -> std::vector<Chain> {
  std::vector<Chain> all{{}};
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].size() == longest) break;
    for (std::size_t k = 0; k < interior_.sheets.size(); ++k) {
      // A plane reflects no light to itself.
      if (!interior_.sheets[k].is_smooth() || (!all[i].empty() && all[i].back() == k)) continue;
      Chain longer = all[i];
      longer.push_back(k);
      all.push_back(std::move(longer));
    }
  }
  return all;
}

/// The share of light that comes along a leg.  `doubt`: floats cannot decide it.
double InteriorTruth::passed(const Leg& leg, std::size_t to_lamp, bool& doubt) const {
  double share = 1;
  bool unsure = false;
  for (std::size_t k = 0; k < interior_.sheets.size(); ++k) {
    const Sheet& sheet = interior_.sheets[k];
    if (static_cast<int>(k) == leg.on || static_cast<int>(k) == leg.to) continue;
    const Meeting m = meeting(sheet, leg.from, leg.w);
    if (!(m.distance > 0 && m.distance < leg.length)) continue;
    if (std::fabs(m.inside) < kMoved)
      unsure = true;
    else if (m.inside > 0 && sheet.kind != Sheet::Kind::kPane)
      return 0;
    else if (m.inside > 0)
      share *= 1 - reflected(sheet, dot(sheet.n, leg.w));
  }
  for (std::size_t k = 0; k < interior_.lamps.size(); ++k) {
    const Lamp& lamp = interior_.lamps[k];
    if (k == to_lamp || !lamp.has_size()) continue;
    if (lamp.kind == Lamp::Kind::kSphere) {
      if (distance_to_ball(lamp.at, lamp.radius, leg.from, leg.w, unsure) < leg.length) return 0;
      continue;
    }
    const Meeting m = meeting(lamp.sheet, leg.from, leg.w);
    if (!(m.distance > 0 && m.distance < leg.length)) continue;
    if (std::fabs(m.inside) < kMoved)
      unsure = true;
    else if (m.inside > 0)
      return 0;
  }
  doubt |= unsure;
  return share;
}

/// The illuminance by a chain of mirrors, from the point (s, t) of the unit square of a lamp; its
/// integral over the square is the illuminance by that chain.
double InteriorTruth::arriving(const Eye& eye, const Lamp& lamp, std::size_t number,
                               const Chain& chain, double s, double t, bool& doubt) const {
  const auto& sheets = interior_.sheets;
  const bool far = lamp.kind == Lamp::Kind::kDistant;
  Vector q = lamp.kind == Lamp::Kind::kRectangle
                 ? lamp.sheet.corner + lamp.sheet.u * s + lamp.sheet.v * t
             : far ? lamp.axis
                   : lamp.at;
  for (std::size_t i = chain.size(); i-- > 0;)
    q = far ? turned(sheets[chain[i]], q) : mirrored(sheets[chain[i]], q);
  Vector w = far ? q : q - eye.at;
  double left = far ? INFINITY : size(w);
  if (!far) w = w * (1 / left);
  double factor = 1;
  if (lamp.kind == Lamp::Kind::kSphere) {
    // Points of the cone in which the ball appears, uniform in solid angle.
    const double sine2 = lamp.radius * lamp.radius / (left * left);
    const double height = s * sine2 / (1 + std::sqrt(1 - sine2));  // 1 - cosine
    const double sine = std::sqrt(height * (2 - height)), angle = 2 * kOnePi * t;
    // The highest point of the ball is a corner of the square, at which Simpson's rule looks.  So
    // no sliver above the horizon is overlooked.
    const Vector up = eye.n - w * dot(eye.n, w);
    const Vector u = size(up) > 1e-6 ? unit(up) : axes_across(w).first, v = cross(w, u);
    const Vector middle = q;
    w = w * (1 - height) + u * (sine * std::cos(angle)) + v * (sine * std::sin(angle));
    bool edge = false;
    left = distance_to_ball(middle, lamp.radius, eye.at, w, edge);
    if (!std::isfinite(left)) left = size(middle - eye.at);  // the rounding of the last point
    factor = 2 * kOnePi * sine2 / (1 + std::sqrt(1 - sine2));
  }
  const double cosine = dot(eye.n, w);
  if (!far && std::fabs(cosine) < (lamp.has_size() ? kSliver : kGrazing)) doubt = true;
  if (!(cosine > 0)) return 0;
  factor *= cosine;
  const double distance = left;
  Leg leg{eye.at, w, 0, eye.on, -1};
  bool beside = false;  // may miss a mirror
  for (const std::size_t k : chain) {
    const Meeting m = meeting(sheets[k], leg.from, leg.w);
    if (!(m.distance > 0 && m.distance < left)) return 0;
    const double moved = kMoved * static_cast<double>(chain.size());
    if (m.inside < -moved) return 0;
    beside |= m.inside < moved;
    leg.length = m.distance;
    leg.to = static_cast<int>(k);
    factor *= passed(leg, kNoLamp, doubt) * reflected(sheets[k], dot(sheets[k].n, leg.w));
    if (factor == 0) return 0;
    leg.from = leg.from + leg.w * m.distance;
    leg.w = turned(sheets[k], leg.w);
    leg.on = leg.to;
    left -= m.distance;
  }
  leg.length = left;
  leg.to = -1;
  factor *= passed(leg, number, doubt);
  doubt |= beside;
  switch (lamp.kind) {
    case Lamp::Kind::kSpot:
      factor *= of_spot(lamp, leg.w * -1.0, doubt);
      [[fallthrough]];
    case Lamp::Kind::kPoint:
      factor /= distance * distance;
      break;
    case Lamp::Kind::kRectangle:
      factor *= std::max(0.0, -dot(lamp.sheet.n, leg.w)) * lamp.sheet.width * lamp.sheet.height /
                (distance * distance);
      break;
    case Lamp::Kind::kDistant:
    case Lamp::Kind::kSphere:
      break;
  }
  return factor * lamp.level;
}

Amount InteriorTruth::by_images(std::size_t receiver, std::size_t number, int bounces) const {
  const Interior::Receiver& r = interior_.receivers[receiver];
  const Eye eye{r.at, r.n};
  const Lamp& lamp = interior_.lamps[number];
  Amount sum;
  const std::vector<Chain> all = bounces == kAll ? chains(kLongestChain) : std::vector<Chain>();
  for (const Chain& chain : bounces == kAll ? all : few_[static_cast<std::size_t>(bounces)]) {
    bool doubt = false, all_doubtful = true;
    const auto at = [&](double s, double t) {
      bool here = false;
      const double value = arriving(eye, lamp, number, chain, s, t, here);
      doubt |= here;
      all_doubtful &= here || value == 0;
      return value;
    };
    if (!lamp.has_size()) {
      const double value = at(0, 0);
      sum.value += value;
      if (doubt) sum.bound += value;
    } else {
      const bool is_far = chain.size() >= kFarChain;
      Amount one = integral(at, is_far ? 1 : 4, 2e-5L * sum.value, 2e-5L, is_far ? 1 : 4000);
      // Such as a lamp of which only a corner is above the horizon.
      if (all_doubtful) one.bound = one.value;
      sum += one;
    }
  }
  return sum;
}

/// The direct illuminance of a point of a wall, and that by mirrors.
double InteriorTruth::lit(const Eye& eye, int bounces) const {
  double sum = 0;
  bool doubt = false;
  for (const Chain& chain : few_[static_cast<std::size_t>(bounces)]) {
    for (std::size_t l = 0; l < interior_.lamps.size(); ++l) {
      const Lamp& lamp = interior_.lamps[l];
      const Rule& rule = kTwo;
      for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t j = 0; j < 2; ++j)
          if (lamp.has_size())
            sum += static_cast<double>(rule.weight[i] * rule.weight[j]) *
                   arriving(eye, lamp, l, chain, static_cast<double>(rule.at[i]),
                            static_cast<double>(rule.at[j]), doubt);
      if (!lamp.has_size()) sum += arriving(eye, lamp, l, chain, 0, 0, doubt);
    }
  }
  return sum;
}

/// What arrives at a point from the direction `w`, by walls alone [cd/m2].  `at_wall(eye, bounces)`
/// is the illuminance of a wall that counts.
template <typename AtWall>
double InteriorTruth::gathered(const Vector& from, const Vector& w, int on, int bounces,
                               const AtWall& at_wall) const {
  int nearest = -1;
  double distance = INFINITY;
  for (std::size_t k = 0; k < interior_.sheets.size(); ++k) {
    if (static_cast<int>(k) == on) continue;
    const Meeting m = meeting(interior_.sheets[k], from, w);
    if (!(m.inside > 0 && m.distance > 0 && m.distance < distance)) continue;
    nearest = static_cast<int>(k);
    distance = m.distance;
  }
  if (nearest < 0) return 0;
  bool doubt = false;
  for (const Lamp& lamp : interior_.lamps) {
    if (lamp.kind == Lamp::Kind::kSphere &&
        distance_to_ball(lamp.at, lamp.radius, from, w, doubt) < distance)
      return 0;
    if (lamp.kind != Lamp::Kind::kRectangle) continue;
    const Meeting m = meeting(lamp.sheet, from, w);
    if (m.inside > 0 && m.distance > 0 && m.distance < distance) return 0;
  }
  const Sheet& sheet = interior_.sheets[static_cast<std::size_t>(nearest)];
  const Vector p = from + w * distance;
  const double cosine = dot(sheet.n, w);
  if (sheet.kind == Sheet::Kind::kGrey) {
    if (bounces == 0 || sheet.is_black()) return 0;
    const Eye eye{p, sheet.n * (cosine > 0 ? -1.0 : 1.0), nearest};
    return sheet.value / kOnePi * at_wall(eye, bounces - 1);
  }
  const double share = reflected(sheet, cosine);
  double sum = 0;
  if (bounces > 0) sum += share * gathered(p, turned(sheet, w), nearest, bounces - 1, at_wall);
  if (sheet.kind == Sheet::Kind::kPane)
    sum += (1 - share) * gathered(p, w, nearest, bounces, at_wall);
  return sum;
}

Amount InteriorTruth::by_one_wall(const Eye& eye, int bounces, Real enough) const {
  const auto at_wall = [&](const Eye& wall, int left) { return lit(wall, left); };
  Amount sum = integral(
      [&](double s, double t) {
        return kOnePi * gathered(eye.at, direction(eye.n, s, t), eye.on, bounces, at_wall);
      },
      20, enough, 3e-4L, 12000);
  // Four points stand for a lamp.
  for (const Lamp& lamp : interior_.lamps)
    if (lamp.has_size()) sum.bound += 1e-4L * sum.value / interior_.lamps.size();
  return sum;
}

/// Points of four dimensions that fill them evenly (multiples of powers of the root of
/// x^5 = x + 1), in eight random places.
Amount InteriorTruth::by_two_walls(const Eye& eye, int bounces) const {
  constexpr int kPlaces = 8, kPoints = 4096;
  constexpr double kRoot = 1.1673039782614187;
  Numbers random(static_cast<std::uint64_t>(bounces));
  std::array<double, kPlaces> means{};
  for (double& mean : means) {
    std::array<double, 4> x{};
    for (double& at : x) at = random.uniform();
    for (int i = 0; i < kPoints; ++i) {
      double step = 1;
      for (double& at : x) {
        step /= kRoot;
        at += step - std::floor(at + step);
      }
      const auto first = [&](const Eye& wall, int left) {
        if (left == 0) return 0.0;
        const auto second = [&](const Eye& other, int rest) { return lit(other, rest); };
        return kOnePi * gathered(wall.at, direction(wall.n, x[2], x[3]), wall.on, left, second);
      };
      mean +=
          kOnePi / kPoints * gathered(eye.at, direction(eye.n, x[0], x[1]), eye.on, bounces, first);
    }
  }
  Amount sum;
  for (const double mean : means) sum.value += mean / kPlaces;
  Real squares = 0;
  for (const double mean : means) squares += (mean - sum.value) * (mean - sum.value);
  sum.bound = 4 * std::sqrt(squares / (kPlaces * (kPlaces - 1)));
  return sum;
}

Amount InteriorTruth::illuminance(std::size_t receiver, int bounces) const {
  Amount sum;
  for (std::size_t l = 0; l < interior_.lamps.size(); ++l) sum += by_images(receiver, l, bounces);
  if (bounces < 1 || !interior_.has_grey()) return sum;
  const Interior::Receiver& r = interior_.receivers[receiver];
  const Eye eye{r.at, r.n};
  sum += by_one_wall(eye, bounces, 3e-4L * sum.value);
  if (bounces > 1) sum += by_two_walls(eye, bounces);
  return sum;
}

}  // namespace lucerna::oracle
