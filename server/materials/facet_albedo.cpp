#include "server/materials/facet_albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "server/materials/microfacet.h"

namespace lucerna {
namespace {

// Nodes are at equal steps of the square roots of the cosine and of alpha: the values change
// fastest at grazing directions and on smooth surfaces.
constexpr int kCosines = 33, kAlphas = 17;

double schlick_weight(double cosine) {
  const double x = 1 - cosine;
  return x * x * x * x * x;
}

/// The mean over visible normals, by a Fibonacci lattice.  [Sloan94]
FacetAlbedo integral(double cosine, double alpha) {
  constexpr int kPoints = 987, kStep = 610;
  const Microfacets facets(alpha, alpha);
  const Vec3 wo{std::sqrt(1 - cosine * cosine), 0, cosine};
  // Points are closer near 0 and 1, which give the steepest facets.
  const auto place = [](double x) { return x * x * (3 - 2 * x); };
  const auto width = [](double x) { return 6 * x * (1 - x); };
  FacetAlbedo sum;
  double total = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double x = (i + 0.5) / kPoints, y = (i * kStep % kPoints + 0.5) / kPoints;
    const double area = width(x) * width(y);
    total += area;
    const Vec3 m = facets.sample(wo, {place(x), place(y)});
    const double cos_m = dot(wo, m);
    const Vec3 wi = m * (2 * cos_m) - wo;
    if (!(wi.z > 0)) continue;
    const double seen = facets.also_seen(wo, wi) * area;
    sum.all += seen;
    sum.schlick += seen * schlick_weight(std::min(1.0, cos_m));
  }
  return {sum.all / total, sum.schlick / total};
}

class Table {
 public:
  Table() {
    constexpr double kLeastCosine = 1e-6;
    for (int a = 0; a < kAlphas; ++a) {
      const double root = a / double{kAlphas - 1};
      for (int c = 0; c < kCosines; ++c) {
        const double t = c / double{kCosines - 1};
        at(a, c) = a == 0 ? FacetAlbedo{1, schlick_weight(t * t)}
                          : integral(std::max(kLeastCosine, t * t), std::pow(root, 4));
      }
      means_[static_cast<std::size_t>(a)] = mean(a);
    }
  }

  FacetAlbedo lookup(double cosine, double alpha) const {
    const auto [c, u] = place(std::sqrt(cosine), kCosines);
    const auto [a, v] = alpha_place(alpha);
    return mix(mix(at(a, c), at(a, c + 1), u), mix(at(a + 1, c), at(a + 1, c + 1), u), v);
  }
  FacetAlbedo mean_lookup(double alpha) const {
    const auto [a, v] = alpha_place(alpha);
    return mix(means_[static_cast<std::size_t>(a)], means_[static_cast<std::size_t>(a) + 1], v);
  }

 private:
  struct TablePosition {
    int first;
    double share;
  };
  static TablePosition alpha_place(double alpha) {
    return place(std::sqrt(std::sqrt(alpha)), kAlphas);
  }
  static TablePosition place(double x, int n) {
    const double at = std::clamp(x, 0.0, 1.0) * (n - 1);
    const int first = std::min(static_cast<int>(at), n - 2);
    return {first, at - first};
  }
  static FacetAlbedo mix(const FacetAlbedo& a, const FacetAlbedo& b, double share) {
    return {a.all + (b.all - a.all) * share, a.schlick + (b.schlick - a.schlick) * share};
  }
  const FacetAlbedo& at(int a, int c) const {
    return values_[static_cast<std::size_t>(a * kCosines + c)];
  }
  FacetAlbedo& at(int a, int c) { return values_[static_cast<std::size_t>(a * kCosines + c)]; }
  /// The integral of 2 cos d cos = 4 t^3 dt, with t the root of the cosine and values linear in t.
  FacetAlbedo mean(int a) const {
    FacetAlbedo sum;
    for (int c = 0; c + 1 < kCosines; ++c) {
      const double h = 1.0 / (kCosines - 1), from = c * h, to = from + h;
      const double all = std::pow(to, 4) - std::pow(from, 4);
      const double rising = (0.8 * (std::pow(to, 5) - std::pow(from, 5)) - from * all) / h;
      const auto add = [&](double x, double y) { return x * (all - rising) + y * rising; };
      sum.all += add(at(a, c).all, at(a, c + 1).all);
      sum.schlick += add(at(a, c).schlick, at(a, c + 1).schlick);
    }
    return sum;
  }

  std::array<FacetAlbedo, kAlphas * kCosines> values_;
  std::array<FacetAlbedo, kAlphas> means_;
};

const Table& table() {
  static const Table kTable;
  return kTable;
}

}  // namespace

FacetAlbedo facet_albedo(double cosine, double alpha) { return table().lookup(cosine, alpha); }

FacetAlbedo mean_facet_albedo(double alpha) { return table().mean_lookup(alpha); }

}  // namespace lucerna
