#include "client/tradeoff/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lucerna::tradeoff {
namespace {

using std::numbers::pi;
using Colour = std::array<double, 3>;
using Plane = std::vector<double>;

// Linear Rec. 709 RGB to XYZ, and back.  (1, 1, 1) becomes the white of D65.  [IEC61966]
constexpr std::array<Colour, 3> kXyzFromRgb = {
    {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
     {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
     {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}}};

Colour multiply(const std::array<Colour, 3>& m, const Colour& v) {
  Colour r{};
  for (int i = 0; i < 3; ++i) r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return r;
}

std::array<Colour, 3> inverse(const std::array<Colour, 3>& m) {
  std::array<Colour, 3> r{};
  double determinant = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      r[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
    determinant += r[0][i] * m[i][0];
  }
  for (Colour& row : r)
    for (double& x : row) x /= determinant;
  return r;
}

const std::array<Colour, 3> kRgbFromXyz = inverse(kXyzFromRgb);
const Colour kWhite = multiply(kXyzFromRgb, {1, 1, 1});

/// XYZ divided by the XYZ of white.
Colour relative_xyz(const Colour& rgb) {
  Colour xyz = multiply(kXyzFromRgb, rgb);
  for (int i = 0; i < 3; ++i) xyz[i] /= kWhite[i];
  return xyz;
}

/// The channels achromatic, red-green and blue-yellow.  They are linear in the light, so that they
/// can be filtered.
Colour ycxcz(const Colour& rgb) {
  const auto [x, y, z] = relative_xyz(rgb);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Colour rgb_from_ycxcz(const Colour& c) {
  const double y = (c[0] + 16) / 116;
  return multiply(kRgbFromXyz,
                  {(y + c[1] / 500) * kWhite[0], y * kWhite[1], (y - c[2] / 200) * kWhite[2]});
}

/// CIELAB with less chroma at lower lightness, after Hunt, since dark colours look similar.
Colour hunt_lab(const Colour& rgb) {
  const auto f = [](double t) {
    constexpr double kDelta = 6.0 / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const auto [x, y, z] = relative_xyz(rgb);
  const double lightness = 116 * f(y) - 16;
  return {lightness, 0.01 * lightness * 500 * (f(x) - f(y)),
          0.01 * lightness * 200 * (f(y) - f(z))};
}

double hyab(const Colour& a, const Colour& b) {
  return std::fabs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

/// Maps differences from [0, the largest difference] to [0, 1] by two linear pieces.  The second
/// one compresses large differences.
double redistributed(double difference) {
  constexpr double kExponent = 0.7, kShare = 0.4, kValue = 0.95;
  static const double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kExponent);
  const double e = std::pow(difference, kExponent);
  const double knee = kShare * largest;
  if (e < knee) return kValue * e / knee;
  return kValue + (e - knee) / (largest - knee) * (1 - kValue);
}

/// One dimension of a filter.  The index of its middle is size / 2.
using Weights = std::vector<double>;

template <typename Function>
Weights weights(int radius, Function f) {
  Weights w;
  for (int i = -radius; i <= radius; ++i) w.push_back(f(i));
  return w;
}

double sum(const Weights& w) {
  double total = 0;
  for (const double x : w) total += x;
  return total;
}

/// Filters a plane of a picture by `across` along rows and then by `down` along columns.
Plane filtered(const Plane& in, int width, int height, const Weights& across, const Weights& down) {
  const int r = static_cast<int>(across.size() / 2), s = static_cast<int>(down.size() / 2);
  Plane between(in.size()), out(in.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double value = 0;
      for (int i = -r; i <= r; ++i)
        value += across[i + r] * in[std::size_t(y) * width + std::clamp(x + i, 0, width - 1)];
      between[std::size_t(y) * width + x] = value;
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int i = -s; i <= s; ++i) {
      const double* row = &between[std::size_t(std::clamp(y + i, 0, height - 1)) * width];
      double* to = &out[std::size_t(y) * width];
      for (int x = 0; x < width; ++x) to[x] += down[i + s] * row[x];
    }
  }
  return out;
}

/// The eye's response to one channel: the sum of up to two Gaussians a sqrt(pi / b) exp(-pi^2 d^2 /
/// b), with d in degrees, normalised to 1.  [Andersson20, table 1]
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivity = {
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

Plane seen(const Plane& in, int width, int height, const Sensitivity& s, double per_degree) {
  // Three standard deviations of the widest Gaussian of all channels.
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * per_degree));
  const auto gaussian = [&](double b) {
    return weights(radius, [&](int i) {
      const double d = i / per_degree;
      return std::exp(-pi * pi * d * d / b);
    });
  };
  const Weights first = gaussian(s.b1), second = gaussian(s.b2);
  const double w1 = s.a1 * std::sqrt(pi / s.b1), w2 = s.a2 * std::sqrt(pi / s.b2);
  const double total = w1 * sum(first) * sum(first) + w2 * sum(second) * sum(second);
  Plane out = filtered(in, width, height, first, first);
  const Plane more = w2 > 0 ? filtered(in, width, height, second, second) : Plane(in.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (w1 * out[i] + w2 * more[i]) / total;
  return out;
}

struct Seen {
  std::vector<Colour> colours;  // hunt_lab
  Plane edges, points;          // strengths
};

Plane magnitude(const Plane& x, const Plane& y) {
  Plane m(x.size());
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = std::hypot(x[i], y[i]);
  return m;
}

Seen look(std::span<const float> rgb, int width, int height, double per_degree) {
  std::array<Plane, 3> planes;
  Plane achromatic;
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
    Colour c{};
    // The comparison turns NaN into 0.
    for (int k = 0; k < 3; ++k) c[k] = rgb[i + k] > 0 ? std::min<double>(rgb[i + k], 1) : 0;
    const Colour opponent = ycxcz(c);
    for (int k = 0; k < 3; ++k) planes[k].push_back(opponent[k]);
    achromatic.push_back((opponent[0] + 16) / 116);
  }
  Seen result;
  for (int k = 0; k < 3; ++k)
    planes[k] = seen(planes[k], width, height, kSensitivity[k], per_degree);
  for (std::size_t i = 0; i < achromatic.size(); ++i) {
    Colour c = rgb_from_ycxcz({planes[0][i], planes[1][i], planes[2][i]});
    for (double& x : c) x = std::clamp(x, 0.0, 1.0);
    result.colours.push_back(hunt_lab(c));
  }
  // The first derivative of a Gaussian finds edges, the second one points.  The positive weights of
  // each sum to 1, the negative ones to -1.
  const double deviation = 0.5 * 0.082 * per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto g = [&](int i) { return std::exp(-0.5 * i * i / (deviation * deviation)); };
  const auto balanced = [](Weights w, double across) {
    double positive = 0, negative = 0;
    for (const double x : w) (x > 0 ? positive : negative) += x;
    for (double& x : w) x /= (x > 0 ? positive : -negative) * across;
    return w;
  };
  const Weights smooth = weights(radius, g);
  const Weights first = balanced(weights(radius, [&](int i) { return -i * g(i); }), sum(smooth));
  const Weights second =
      balanced(weights(radius, [&](int i) { return (i * i / (deviation * deviation) - 1) * g(i); }),
               sum(smooth));
  const auto strength = [&](const Weights& w) {
    return magnitude(filtered(achromatic, width, height, w, smooth),
                     filtered(achromatic, width, height, smooth, w));
  };
  result.edges = strength(first);
  result.points = strength(second);
  return result;
}

}  // namespace

std::vector<float> flip(std::span<const float> reference, std::span<const float> test,
                        std::uint32_t width, std::uint32_t height, double pixels_per_degree) {
  const Seen a =
      look(reference, static_cast<int>(width), static_cast<int>(height), pixels_per_degree);
  const Seen b = look(test, static_cast<int>(width), static_cast<int>(height), pixels_per_degree);
  std::vector<float> result;
  result.reserve(a.colours.size());
  for (std::size_t i = 0; i < a.colours.size(); ++i) {
    const double colour = redistributed(hyab(a.colours[i], b.colours[i]));
    const double feature = std::sqrt(
        std::max(std::fabs(a.edges[i] - b.edges[i]), std::fabs(a.points[i] - b.points[i])) /
        std::numbers::sqrt2);
    result.push_back(static_cast<float>(std::pow(colour, 1 - feature)));
  }
  return result;
}

}  // namespace lucerna::tradeoff
