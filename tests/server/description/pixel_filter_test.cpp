#include "server/description/pixel_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace lucerna {
namespace {

using ::testing::HasSubstr;

constexpr int kCount = 1 << 18;  // strata of u, each with a sample in its middle

std::shared_ptr<const PixelFilter> made(const PixelFilterParams& params) {
  auto filter = PixelFilter::create(params);
  EXPECT_TRUE(filter.ok()) << filter.status();
  return *filter;
}

using Function = std::function<double(double)>;

/// The mean of weight g(x) over samples; x is the horizontal distance from the pixel's centre.
/// With one u for the other axis at 1/2, so the sign is that of the horizontal axis.
double sampled(const PixelFilter& filter, const Function& g, bool vertical = false) {
  double sum = 0;
  for (int i = 0; i < kCount; ++i) {
    const float u = (static_cast<float>(i) + 0.5F) / kCount;
    const auto s = filter.sample(vertical ? Vec2f{0.5F, u} : Vec2f{u, 0.5F});
    sum += s.weight * g((vertical ? s.position_px.y : s.position_px.x) - 0.5);
  }
  return sum / kCount;
}

/// The integral of f g over [-radius, radius] over that of f, by the trapezoidal rule.
double integrated(const Function& f, double radius, const Function& g) {
  double above = 0, below = 0;
  constexpr int kSteps = 200000;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = radius * (2.0 * i / kSteps - 1), w = i == 0 || i == kSteps ? 0.5 : 1;
    above += w * f(x) * g(x);
    below += w * f(x);
  }
  return above / below;
}

const Function kOne = [](double) { return 1.0; };
const Function kSquare = [](double x) { return x * x; };
Function wave(double per_pixel) {
  return [=](double x) { return std::cos(2 * M_PI * per_pixel * x); };
}

/// Samples agree with the function `f` in the moments that separate filters: the mean weight, the
/// second moment over the square of the radius, and three waves.  The other axis doubles a weight
/// of both axes, so `excess` is the mean of the vertical weights' magnitude.
double largest_error(const PixelFilter& filter, const Function& f, double radius,
                     double excess = 1) {
  double worst = 0;
  const Function squared_share = [=](double x) { return x * x / (radius * radius); };
  for (const Function& g : {kOne, squared_share, wave(0.25), wave(0.5), wave(1)})
    worst = std::max(worst, std::fabs(sampled(filter, g) / excess - integrated(f, radius, g)));
  return worst;
}

/// The integral of |f| over that of f.
double excess_of(const Function& f, double radius) {
  double above = 0, below = 0;
  for (int i = 0; i < 200000; ++i) {
    const double v = f(radius * (i + 0.5) / 200000);
    above += std::fabs(v);
    below += v;
  }
  return above / below;
}

Function gaussian(double radius, double sigma) {
  return [=](double x) {
    const auto g = [&](double t) { return std::exp(-t * t / (2 * sigma * sigma)); };
    return g(x) - g(radius);
  };
}

Function sinc(double tau) {
  return [=](double x) {
    const auto s = [](double t) { return t == 0 ? 1 : std::sin(M_PI * t) / (M_PI * t); };
    return s(x) * s(x / tau);
  };
}

TEST(PixelFilter, BoxAndTriangleHaveTheirMoments) {
  const auto box = made({{1.5, 0.25}, BoxFilter{}});
  EXPECT_NEAR(sampled(*box, kSquare), 1.5 * 1.5 / 3, 1e-5);
  EXPECT_NEAR(sampled(*box, kSquare, true), 0.25 * 0.25 / 3, 1e-5);
  const auto triangle = made({{2, 0.5}, TriangleFilter{}});
  EXPECT_NEAR(sampled(*triangle, kSquare), 4.0 / 6, 1e-5);
  EXPECT_NEAR(sampled(*triangle, kSquare, true), 0.25 / 6, 1e-5);
  // Its transform is the square of a sinc.
  EXPECT_NEAR(sampled(*triangle, wave(0.25)), 4 / (M_PI * M_PI), 1e-5);
  EXPECT_NEAR(sampled(*triangle, wave(0.5)), 0, 1e-5);
}

TEST(PixelFilter, GaussianFollowsItsFunction) {
  for (const double radius : {1.5, 4.0})
    for (const double sigma : {0.1, 0.5, 2.0})
      EXPECT_LT(largest_error(*made({{radius, 1}, GaussianFilter{sigma}}), gaussian(radius, sigma),
                              radius),
                3e-5)
          << radius << " " << sigma;
  // The limit of a wide one is a parabola, with a fifth of the squared radius.
  EXPECT_NEAR(sampled(*made({{1.5, 1}, GaussianFilter{1e6}}), kSquare), 1.5 * 1.5 / 5, 1e-5);
  // That of a narrow one has the variance of the normal distribution.
  EXPECT_NEAR(sampled(*made({{1.5, 1}, GaussianFilter{0.01}}), kSquare), 1e-4, 1e-8);
}

TEST(PixelFilter, TheTestOfFunctionsSeesAWrongOne) {
  EXPECT_GT(largest_error(*made({{1.5, 1}, GaussianFilter{0.5}}), gaussian(1.5, 0.502), 1.5), 1e-3);
}

// Copies of Mitchell's cubic at whole steps of half the radius sum up to 1, so its transform is 0
// at all whole frequencies.  If B + 2 C = 1, its second moment is B / 3: that of the cubic B-spline
// is 1/3, that of Catmull and Rom's spline is 0, and it is linear in B.  [Mitchell88]
TEST(PixelFilter, MitchellIsAPartitionOfUnity) {
  for (const double b : {0.0, 1.0 / 3, 1.0}) {
    const double c = (1 - b) / 2;
    const auto filter = made({{2, 1}, MitchellFilter{b, c}});
    const double excess =
        std::fabs(filter->sample({0.5F, 0.5F}).weight) / std::fabs(sampled(*filter, kOne));
    // Both axes have the same excess, so the mean over one axis is that of the other axis.
    const double other = sampled(*filter, kOne);
    EXPECT_NEAR(excess, other, 1e-4) << b;
    EXPECT_NEAR(sampled(*filter, kSquare) / other, b / 3, 1e-4) << b;
    for (const double k : {1.0, 2.0, 3.0})
      EXPECT_NEAR(sampled(*filter, wave(k)) / other, 0, 1e-4) << b << " " << k;
    EXPECT_EQ(filter->has_negative_weights(), b < 1) << b;
  }
  // Twice the radius halves the frequency.
  const auto wide = made({{4, 4}, MitchellFilter{}});
  EXPECT_NEAR(sampled(*wide, wave(0.5)), 0, 1e-4);
  EXPECT_NEAR(sampled(*wide, kSquare) / sampled(*wide, kOne), 4.0 / 9, 1e-4);
}

TEST(PixelFilter, SincFollowsItsFunction) {
  for (const double radius : {0.75, 3.0, 4.0, 20.0})
    for (const double tau : {0.25, 1.5, 3.0, 1e6}) {
      const auto filter = made({{radius, radius}, SincFilter{tau}});
      EXPECT_LT(largest_error(*filter, sinc(tau), radius, excess_of(sinc(tau), radius)), 5e-4)
          << radius << " " << tau;
    }
}

TEST(PixelFilter, SignedWeightsHaveMeanOne) {
  for (const PixelFilterParams& params :
       {PixelFilterParams{{2, 2}, MitchellFilter{}}, PixelFilterParams{{4, 3}, SincFilter{}}}) {
    const auto filter = made(params);
    double sum = 0;
    constexpr int kEdge = 4096;
    for (int y = 0; y < kEdge; ++y)
      for (int x = 0; x < kEdge; ++x)
        sum += filter
                   ->sample({(static_cast<float>(x) + 0.5F) / kEdge,
                             (static_cast<float>(y) + 0.5F) / kEdge})
                   .weight;
    EXPECT_NEAR(sum / (kEdge * kEdge), 1, 3e-3);
    EXPECT_TRUE(filter->has_negative_weights());
  }
}

TEST(PixelFilter, OthersHaveTheWeightOne) {
  for (const PixelFilterParams& params :
       {PixelFilterParams{{2, 2}, BoxFilter{}}, PixelFilterParams{{2, 2}, TriangleFilter{}},
        PixelFilterParams{{1.5, 1.5}, GaussianFilter{}},
        PixelFilterParams{{2, 2}, MitchellFilter{1, 0}}}) {
    const auto filter = made(params);
    EXPECT_FALSE(filter->has_negative_weights());
    for (const float u : {0.0F, 0.03F, 0.4F, 0.98F})
      EXPECT_EQ(filter->sample({u, 1 - u}).weight, 1);
  }
}

// So that points that cover the square evenly cover the filter evenly.
TEST(PixelFilter, PositionsAscendFromEdgeToEdge) {
  for (const PixelFilterParams& params :
       {PixelFilterParams{{0.7, 3}, BoxFilter{}}, PixelFilterParams{{0.7, 3}, TriangleFilter{}},
        PixelFilterParams{{0.7, 3}, GaussianFilter{}},
        PixelFilterParams{{0.7, 3}, MitchellFilter{}}, PixelFilterParams{{0.7, 3}, SincFilter{}}}) {
    const auto filter = made(params);
    EXPECT_NEAR(filter->sample({0, 0}).position_px.x, 0.5 - 0.7, 1e-6);
    EXPECT_NEAR(filter->sample({0, 0}).position_px.y, 0.5 - 3, 1e-6);
    EXPECT_NEAR(filter->sample({1, 1}).position_px.x, 0.5 + 0.7, 1e-6);
    EXPECT_NEAR(filter->sample({0.5F, 0.5F}).position_px.y, 0.5, 1e-6);
    Vec2f last = filter->sample({0, 0}).position_px;
    for (int i = 1; i <= 1 << 12; ++i) {
      const float u = static_cast<float>(i) / (1 << 12);
      const Vec2f p = filter->sample({u, u}).position_px;
      ASSERT_GE(p.x, last.x);
      ASSERT_GE(p.y, last.y);
      last = p;
    }
  }
}

TEST(PixelFilter, WrongParametersAreErrors) {
  const std::pair<PixelFilterParams, const char*> kCases[] = {
      {{{0, 1}, BoxFilter{}}, "xradius = 0 pixels, allowed [0.001, 64]"},
      {{{1, -1}, BoxFilter{}}, "yradius = -1 pixels, allowed [0.001, 64]"},
      {{{1e9, 1}, SincFilter{}}, "xradius = 1000000000 pixels, allowed [0.001, 64]"},
      {{{std::nan(""), 1}, SincFilter{}}, "xradius = nan pixels"},
      {{{1, 1}, GaussianFilter{0}}, "sigma = 0 pixels, allowed (0, 1e+06]"},
      {{{1, 1}, GaussianFilter{std::nan("")}}, "sigma = nan pixels"},
      {{{4, 4}, SincFilter{0}}, "tau = 0 pixels, allowed [0.25, inf)"},
      {{{4, 4}, SincFilter{-3}}, "tau = -3 pixels"},
      {{{2, 2}, MitchellFilter{100, 0}},
       "B = 100, C = 0: the integral of the filter's magnitude is"},
      {{{2, 2}, MitchellFilter{1e308, 0}}, "B = 1e+308, C = 0: the integral"},
  };
  for (const auto& [params, expected] : kCases) {
    const auto filter = PixelFilter::create(params);
    ASSERT_FALSE(filter.ok()) << expected;
    EXPECT_THAT(std::string(filter.status().message()), HasSubstr(expected));
  }
}

// The largest tables.
TEST(PixelFilter, TakesAtMostFourMegabytes) {
  EXPECT_LT(made({{64, 64}, SincFilter{0.25}})->bytes(), 4U << 20);
  EXPECT_LT(made({{64, 64}, TriangleFilter{}})->bytes(), 1000U);
}

}  // namespace
}  // namespace lucerna
