#include "lights/pictures/rectified_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

/// The illuminance from the cell in column i and row j of n x n, under radiance 1.  It is the form
/// factor of a rectangle above one of its corners, taken four times.  [Howell20]
///
/// The differences cancel, to about 1e-13 of the smallest cell at n = 64.
double by_corners(int n, int i, int j) {
  constexpr long double kPi = std::numbers::pi_v<long double>;
  // Sine and cosine of the angles.  Cosines at the ends are just above 0, because rounding may make
  // them negative.
  const auto sine = [&](int k) { return std::sin((static_cast<long double>(k) / n - 0.5L) * kPi); };
  const auto cosine = [&](int k) {
    return std::fmax(1e-30L, std::sin(static_cast<long double>(std::min(k, n - k)) / n * kPi));
  };
  const auto part = [&](int k, int l) {
    return sine(k) * std::atan2(sine(l) * cosine(k), cosine(l)) / 2;
  };
  const auto corner = [&](int k, int l) { return part(k, l) + part(l, k); };
  return double(corner(i + 1, j + 1) - corner(i, j + 1) - corner(i + 1, j) + corner(i, j));
}

struct OfACell {
  int n, i, j;
  double lx;
};

/// The same formula at 60 digits.
constexpr OfACell kCells[] = {{1, 0, 0, 3.1415926535897932385},
                              {2, 1, 0, 0.78539816339744830962},
                              {3, 1, 0, 0.3217505543966421934},
                              {3, 0, 0, 0.23182380450040305811},
                              {5, 2, 2, 0.37046020275521334813},
                              {5, 2, 0, 0.048919725190778891405},
                              {64, 0, 0, 0.0003441376096734374037},
                              {64, 0, 1, 0.00023616074076034142521},
                              {64, 1, 1, 0.00056362644049935675847},
                              {64, 0, 2, 0.00011095633892857181241},
                              {64, 3, 5, 0.00051556638606011364664},
                              {64, 20, 0, 2.7081580717704124826e-6},
                              {64, 17, 9, 0.00064179318639620237627},
                              {64, 0, 16, 3.6809522008846962473e-6},
                              {64, 0, 31, 1.9359630001951514014e-6},
                              {64, 8, 0, 0.000011644942337595982649},
                              {64, 30, 5, 0.00017265105540941896842},
                              {64, 16, 16, 0.0011062800261849013138},
                              {64, 31, 31, 0.0024057072122848479394},
                              {4096, 0, 0, 8.3946214830835863119e-8},
                              {4096, 0, 1, 5.7495440253386568653e-8},
                              {4096, 1, 1, 1.3684797415243667387e-7},
                              {4096, 0, 2, 2.6922648701888199652e-8},
                              {4096, 3, 5, 1.1995203126664964432e-7},
                              {4096, 20, 0, 4.6559123373009819382e-10},
                              {4096, 17, 9, 1.0338352794349876196e-7},
                              {4096, 0, 23, 3.5450535404195139561e-10},
                              {4096, 0, 24, 3.2620469449831011467e-10},
                              {4096, 0, 1024, 2.3053411143388798915e-13},
                              {4096, 0, 2047, 1.1535554576675448444e-13},
                              {4096, 512, 0, 7.8623784370011789936e-13},
                              {4096, 30, 5, 1.7985799806463576387e-8},
                              {4096, 1024, 1024, 2.6158893483757891912e-7},
                              {4096, 2047, 2047, 5.882740336895847253e-7}};

TEST(RectifiedCells, EqualTheFormFactorEvenWhereItsDifferencesCancel) {
  for (const OfACell& cell : kCells) {
    const RectifiedCells cells(cell.n);
    // From every corner, and with the axes exchanged.
    for (const auto& [column, row] : {std::pair{cell.i, cell.j}, std::pair{cell.j, cell.i}})
      for (const int i : {column, cell.n - 1 - column})
        for (const int j : {row, cell.n - 1 - row})
          EXPECT_NEAR(cells.row(j)[static_cast<std::size_t>(i)] / cell.lx, 1, 1e-13)
              << i << ", " << j << " of " << cell.n;
  }
}

TEST(RectifiedCells, OfTheWholeSquareArePi) {
  for (const int n : {1, 2, 7, 64, 1000}) {
    const RectifiedCells cells(n);
    double sum = 0;
    for (int j = 0; j < n; ++j)
      for (const double lx : cells.row(j)) sum += lx;
    EXPECT_NEAR(sum, std::numbers::pi, 1e-12) << n;
  }
}

TEST(RectifiedMap, IlluminanceIsTheSumOfItsCells) {
  testing::RandomU random(3);
  const Vec3 x{0, 1, 0}, y{0, 0, 1}, z{1, 0, 0};
  for (const int n : {1, 5, 64}) {
    std::vector<Rgbf> texels;
    for (int k = 0; k < n * n; ++k) {
      const double lit = random.next();
      // Nine of ten are dark, so that few cells at the edges count.
      texels.push_back(lit < 0.9 && n > 1 ? Rgbf() : Rgbf(1, 2, float(lit)));
    }
    const auto map = *SphereMap::create(*Image::create(n, n, std::move(texels)),
                                        SphereMapping::kEqualArea, ImageFilter::kNearest);
    const RectifiedMap seen(*map, x, y, z);
    Rgb expected;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        expected += seen.lookup({(i + 0.5) / n, (j + 0.5) / n}) * by_corners(n, i, j);
    const MapIlluminance got = seen.illuminance(Rgb(1, 2, 3));
    EXPECT_EQ(got.error_lx, 0);
    EXPECT_NEAR(got.lx.r, expected.r, 1e-12 * expected.r);
    EXPECT_NEAR(got.lx.g, 2 * expected.g, 2e-12 * expected.g);
    EXPECT_NEAR(got.lx.b, 3 * expected.b, 3e-12 * expected.b);
  }
}

}  // namespace
}  // namespace lucerna
