#include "lights/pictures/photometric_web.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lights/maths/normal_cone.h"
#include "lights/maths/vec.h"
#include "tests/lights/pictures/angle_range.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::chi_square_p_value;
using ::testing::HasSubstr;
using testing::integrate;
using testing::RandomU;
using testing::range;
using testing::Region;

constexpr double kRad = kPi / 180;

/// A grid of random intensities with some dark patches.
PhotometricWebParams random_grid(PhotometricType type, std::vector<double> v, std::vector<double> h,
                                 std::uint64_t seed) {
  PhotometricWebParams params{type, std::move(v), std::move(h), {}};
  RandomU random(seed);
  for (std::size_t i = 0; i < params.vertical_deg.size() * params.horizontal_deg.size(); ++i) {
    const double x = random.next();
    params.intensity_cd.push_back(x < 0.3 ? 0 : 100 * x);
  }
  return params;
}

std::shared_ptr<const PhotometricWeb> web(const PhotometricWebParams& params) {
  auto made = PhotometricWeb::create(params);
  EXPECT_TRUE(made.ok()) << made.status();
  return *made;
}

std::string error(const PhotometricWebParams& params) {
  const auto made = PhotometricWeb::create(params);
  return made.ok() ? "" : std::string(made.status().message());
}

std::vector<PhotometricWebParams> grids() {
  using enum PhotometricType;
  return {random_grid(kC, range(0, 180, 10), {0}, 1),
          random_grid(kC, range(0, 90, 7.5), range(0, 90, 15), 2),
          random_grid(kC, {90, 95, 120, 180}, range(0, 180, 20), 3),
          random_grid(kC, range(0, 180, 30), range(90, 270, 30), 4),
          random_grid(kC, {0, 1, 5, 30, 90, 180}, range(0, 360, 22.5), 5),
          random_grid(kC, range(0, 90, 15), range(-90, 90, 45), 6),
          random_grid(kB, range(-90, 90, 15), range(-90, 90, 30), 7),
          random_grid(kB, range(0, 90, 15), range(0, 90, 30), 8),
          random_grid(kA, range(-90, 90, 10), range(0, 90, 10), 9),
          random_grid(kA, range(0, 90, 10), range(-90, 90, 45), 10)};
}

/// The direction of the file's angles, from the standard's definitions.  Straight down is +z, the
/// photometric horizontal +x.  Seen from above (-z), horizontal angles run counter-clockwise for
/// type C, clockwise for A and B.
Vec3 direction(PhotometricType type, double v_deg, double h_deg) {
  const double v = v_deg * kRad, h = h_deg * kRad;
  switch (type) {
    case PhotometricType::kC:  // up is -z, so a turn to the left as seen from above takes +x to -y
      return {std::sin(v) * std::cos(h), -std::sin(v) * std::sin(h), std::cos(v)};
    case PhotometricType::kB:
      return {std::cos(h) * std::sin(v), std::sin(h), std::cos(h) * std::cos(v)};
    case PhotometricType::kA:
      return {std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), -std::sin(v)};
  }
  return {};
}

TEST(PhotometricWeb, HoldsTheFilesIntensitiesAtItsAngles) {
  for (const auto& params : grids()) {
    const auto w = web(params);
    for (std::size_t i = 0; i < params.horizontal_deg.size(); ++i)
      for (std::size_t j = 0; j < params.vertical_deg.size(); ++j) {
        const double v = params.vertical_deg[j], h = params.horizontal_deg[i];
        // At a pole all planes meet.  Beyond the ends of a partial range it is dark.
        const bool pole = params.type == PhotometricType::kC && (v == 0 || v == 180);
        const bool wraps = h == 360 || (h == 0 && params.horizontal_deg.back() == 360);
        const bool end =
            params.type != PhotometricType::kC && (h * h == 8100 || v * v == 8100 || v == 0);
        if (pole || wraps || end || v == 90) continue;
        EXPECT_NEAR(w->at(direction(params.type, v, h)),
                    params.intensity_cd[i * params.vertical_deg.size() + j], 1e-9)
            << v << " " << h;
      }
  }
}

TEST(PhotometricWeb, IsBilinearBetweenAngles) {
  PhotometricWebParams p{PhotometricType::kC, {0, 90, 180}, {0, 90}, {8, 16, 0, 8, 32, 4}};
  const auto w = web(p);
  // A third of the way from V = 0 to 90, two thirds from H = 0 to 90: by hand.
  const double at_0 = 8 + (16 - 8) / 3., at_90 = 8 + (32 - 8) / 3.;
  EXPECT_NEAR(w->at(direction(p.type, 30, 60)), at_0 / 3 + at_90 * 2 / 3, 1e-12);
  EXPECT_EQ(w->max_cd(), 32);
}

TEST(PhotometricWeb, SymmetriesRepeatTheirPlanes) {
  const auto at = [](const PhotometricWebParams& p, double h) {
    return web(p)->at(direction(PhotometricType::kC, 40, h));
  };
  RandomU random(11);
  const auto axial = random_grid(PhotometricType::kC, range(0, 180, 10), {0}, 12);
  const auto quadrant = random_grid(PhotometricType::kC, range(0, 180, 10), range(0, 90, 10), 13);
  const auto half = random_grid(PhotometricType::kC, range(0, 180, 10), range(0, 180, 10), 14);
  const auto across = random_grid(PhotometricType::kC, range(0, 180, 10), range(90, 270, 10), 15);
  const auto across2 = random_grid(PhotometricType::kC, range(0, 180, 10), range(-90, 90, 10), 16);
  for (int i = 0; i < 50; ++i) {
    const double h = 360 * random.next();
    EXPECT_NEAR(at(axial, h), at(axial, 0), 1e-9);
    EXPECT_NEAR(at(quadrant, h), at(quadrant, -h), 1e-9);
    EXPECT_NEAR(at(quadrant, h), at(quadrant, 180 - h), 1e-9);
    EXPECT_NEAR(at(half, h), at(half, -h), 1e-9);
    EXPECT_NEAR(at(across, h), at(across, 180 - h), 1e-9);
    EXPECT_NEAR(at(across2, h), at(across2, 180 - h), 1e-9);
  }
  const auto b = random_grid(PhotometricType::kB, range(-90, 90, 10), range(0, 90, 10), 17);
  for (double h = 5; h < 90; h += 10)
    EXPECT_NEAR(web(b)->at(direction(b.type, 35, h)), web(b)->at(direction(b.type, 35, -h)), 1e-9);
}

TEST(PhotometricWeb, IsDarkOutsideOfItsAngles) {
  using enum PhotometricType;
  const auto down = web({kC, {0, 90}, {0}, {5, 5}});
  EXPECT_EQ(down->at({0, 0, 1}), 5);
  EXPECT_EQ(down->at({0.5, 0.1, -1e-6}), 0);
  const auto up = web({kC, {90, 180}, {0}, {5, 5}});
  EXPECT_EQ(up->at({0.5, 0.1, 1e-6}), 0);
  EXPECT_EQ(up->at({0, 0, -1}), 5);
  const auto b = web({kB, {-90, 90}, {0, 90}, {5, 5, 5, 5}});
  EXPECT_EQ(b->at({0.2, -0.3, 0.1}), 5);
  EXPECT_EQ(b->at({0.2, -0.3, -0.1}), 0);
  const auto a = web({kA, {-90, 90}, {-90, 90}, {5, 5, 5, 5}});
  EXPECT_EQ(a->at({0.1, -0.3, 0.5}), 5);
  EXPECT_EQ(a->at({-0.1, -0.3, 0.5}), 0);
}

// The midpoint rule on n x n cells, with halved steps until stable, does not use the grid.  Kinks
// along the grid's 20 or so lines leave an error of 1e-4 at n = 1500.
TEST(PhotometricWeb, FluxEqualsQuadratureOverTheSphere) {
  for (const auto& params : grids()) {
    const auto w = web(params);
    const double expected = integrate(Region{}, 1500, [&](const Vec3& d) { return w->at(d); });
    EXPECT_NEAR(w->flux_lm() / expected, 1, 3e-4);
  }
}

// The midpoint rule over height and azimuth, in which solid angle is uniform.
TEST(PhotometricWeb, FluxNearTheHorizonIsBounded) {
  for (const auto& params : grids()) {
    const auto w = web(params);
    EXPECT_EQ(w->horizon_flux_bound_lm(0), 0);
    for (const double width : {1e-3, 0.1, 0.4}) {
      constexpr int kHeights = 200, kAzimuths = 720;
      const auto quadrature = [&](double top) {
        double sum = 0;
        for (int i = 0; i < kHeights; ++i)
          for (int j = 0; j < kAzimuths; ++j) {
            const double z = top * (i + 0.5) / kHeights, phi = 2 * kPi * (j + 0.5) / kAzimuths;
            const double r = std::sqrt(1 - z * z);
            sum += w->at({r * std::cos(phi), r * std::sin(phi), z});
          }
        return sum * std::fabs(top) * 2 * kPi / (double{kHeights} * kAzimuths);
      };
      const double flux = std::max(quadrature(std::sin(width)), quadrature(-std::sin(width)));
      const double bound = w->horizon_flux_bound_lm(width);
      EXPECT_LE(flux, bound * (1 + 1e-3)) << width;
      if (params.type == PhotometricType::kB)
        EXPECT_LE(bound, 2 * kPi * std::sin(width) * w->max_cd());
      else
        EXPECT_NEAR(bound, flux, 1e-3 * flux) << width;
    }
  }
}

// Intensity is the cosine from straight down, on a grid of 5 degrees about a horizontal axis.  In
// the band of the horizon it is at most that of the grid's first lines, linear up to them.
TEST(PhotometricWeb, FluxNearTheHorizonOfTypeBIsThatOfItsEdge) {
  PhotometricWebParams p{PhotometricType::kB, range(-90, 90, 5), range(-90, 90, 5), {}};
  for (const double h : p.horizontal_deg)
    for (const double v : p.vertical_deg)
      p.intensity_cd.push_back(std::fmax(0, std::cos(h * kRad) * std::cos(v * kRad)));
  constexpr double kWidth = 1e-3;
  const double bound = web(p)->horizon_flux_bound_lm(kWidth);
  // The integral of 2 pi z over z.
  EXPECT_GE(bound, kPi * kWidth * kWidth * 0.99);
  EXPECT_LE(bound, 2 * kPi * kWidth * std::pow(std::sin(5 * kRad), 2));
}

// Intensity is linear in the angle from straight down.  The flux is 2 pi times the integral of (1 -
// t / (pi/2)) sin t over [0, pi/2] = 2 pi (1 - 2 / pi), for all steps.
TEST(PhotometricWeb, FluxIsExactForFunctionsThatAreLinearInTheAngle) {
  for (const double step : {90., 30., 2.5, 0.01}) {
    PhotometricWebParams p{PhotometricType::kC, range(0, 90, step), {0}, {}};
    for (const double v : p.vertical_deg) p.intensity_cd.push_back(1000 * (1 - v / 90));
    EXPECT_NEAR(web(p)->flux_lm(), 2000 * kPi * (1 - 2 / kPi), 1e-8);
  }
  EXPECT_NEAR(web({PhotometricType::kB, {-90, 90}, {-90, 90}, {1, 1, 1, 1}})->flux_lm(), 2 * kPi,
              1e-14);
}

// In type B the planes share a horizontal axis, with H the latitude.  Intensity that falls linearly
// with H gives pi times the integral of (1 - |H| / (pi/2)) cos H over [-pi/2, pi/2] = 4.  With V it
// gives the integral of 1 - |V| / (pi/2), which is pi / 2, times that of cos H, which is 2.
TEST(PhotometricWeb, TheHorizontalAngleOfTypeBIsTheLatitude) {
  for (const double step : {90., 30., 2.5}) {
    PhotometricWebParams by_h{PhotometricType::kB, range(-90, 90, step), range(-90, 90, step), {}};
    PhotometricWebParams by_v = by_h;
    for (const double h : by_h.horizontal_deg)
      for (const double v : by_h.vertical_deg) {
        by_h.intensity_cd.push_back(1000 * (1 - std::fabs(h) / 90));
        by_v.intensity_cd.push_back(1000 * (1 - std::fabs(v) / 90));
      }
    EXPECT_NEAR(web(by_h)->flux_lm(), 4000, 1e-8);
    EXPECT_NEAR(web(by_v)->flux_lm(), 1000 * kPi, 1e-8);
    by_h.type = by_v.type = PhotometricType::kA;
    EXPECT_NEAR(web(by_h)->flux_lm(), 1000 * kPi, 1e-8);
    EXPECT_NEAR(web(by_v)->flux_lm(), 4000, 1e-8);
  }
}

// At H = +-90 all vertical angles are one direction, so measured values agree there: 7 at +y, 3 at
// -y.  The plane H = 0 is across: 0 at +x and -x, 9 straight down.
TEST(PhotometricWeb, ThePolesOfTypeBAreOnePoint) {
  const auto w =
      web({PhotometricType::kB, {-90, 0, 90}, {-90, 0, 90}, {3, 3, 3, 0, 9, 0, 7, 7, 7}});
  for (int i = 0; i <= 8; ++i) {
    const double v = (i - 4) * 22.4 * kRad, tilt = 1e-9;
    const Vec3 off{tilt * std::sin(v), 0, tilt * std::cos(v)};
    EXPECT_NEAR(w->at(Vec3(0, 1, 0) + off), 7, 1e-6);
    EXPECT_NEAR(w->at(Vec3(0, -1, 0) + off), 3, 1e-6);
  }
  EXPECT_EQ(w->at({0, 0, 1}), 9);
  EXPECT_NEAR(w->at({1, 0, 1e-9}), 0, 1e-6);
  EXPECT_NEAR(w->at({-1, 0, 1e-9}), 0, 1e-6);
}

TEST(PhotometricWeb, DensityIntegratesToOneAndIsPositiveWhereTheIntensityIs) {
  RandomU random(21);
  for (const auto& params : grids()) {
    const auto w = web(params);
    const double whole = integrate(Region{}, 1000, [&](const Vec3& d) { return w->pdf(d).per_sr; });
    EXPECT_NEAR(whole, 1, 3e-3);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 d = Region{}.at(random.next(), random.next());
      if (w->at(d) > 0) {
        ASSERT_GT(w->pdf(d).per_sr, 0);
      }
    }
  }
}

// Fails by chance once in 1e8 for each grid.
TEST(PhotometricWeb, SamplesFollowTheDensity) {
  constexpr int kSamples = 100000, kBins = 16, kSub = 40;
  for (const bool wrong : {false, true}) {
    int rejected = 0;
    for (const auto& params : grids()) {
      const auto w = web(params);
      RandomU random(22);
      std::vector<double> observed(kBins * kBins), expected(kBins * kBins);
      for (int i = 0; i < kSamples; ++i) {
        const Vec2 at = Region{}.where(w->sample(random.pair()));
        const int x = std::min(int(at.x * kBins), kBins - 1);
        const int y = std::min(int(at.y * kBins), kBins - 1);
        ++observed[static_cast<std::size_t>(x * kBins + y)];
      }
      constexpr int kFine = kBins * kSub;
      for (int i = 0; i < kFine; ++i)
        for (int j = 0; j < kFine; ++j) {
          const Vec3 d = Region{}.at((i + 0.5) / kFine, (j + 0.5) / kFine);
          // The companion: a density in proportion to the intensity itself.
          const double pdf = wrong ? w->at(d) / w->flux_lm() : w->pdf(d).per_sr;
          expected[static_cast<std::size_t>(i / kSub * kBins + j / kSub)] +=
              kSamples * 4 * kPi / kFine / kFine * pdf;
        }
      const double p = chi_square_p_value(observed, expected);
      rejected += p < 1e-8;
      if (!wrong) {
        EXPECT_GT(p, 1e-8);
      }
    }
    EXPECT_EQ(rejected > 0, wrong);
  }
}

TEST(PhotometricWeb, ExtremeSampleValuesStayInLitCells) {
  for (const auto& params : grids()) {
    const auto w = web(params);
    for (const double x : {0., 1 - 0x1p-24, 1.})
      for (const double y : {0., 1 - 0x1p-24, 1.}) {
        const Vec3 d = w->sample({x, y});
        EXPECT_NEAR(length(d), 1, 1e-15);
        EXPECT_LE(angle_between(w->cone().axis, d), w->cone().half_angle_rad);
      }
  }
}

TEST(PhotometricWeb, ConeHoldsAllLightAndNoMoreThanItsCells) {
  RandomU random(31);
  for (const auto& params : grids()) {
    const auto w = web(params);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 d = Region{}.at(random.next(), random.next());
      if (w->at(d) > 0) {
        ASSERT_LE(angle_between(w->cone().axis, d), w->cone().half_angle_rad);
      }
    }
  }
  const auto narrow = web({PhotometricType::kC, {0, 10, 20, 90}, {0}, {100, 50, 0, 0}});
  EXPECT_NEAR(narrow->cone().half_angle_rad, 20 * kRad, 1e-5);
  EXPECT_EQ(narrow->cone().axis, Vec3(0, 0, 1));
  const auto up = web({PhotometricType::kC, {90, 150, 180}, {0}, {0, 0, 10}});
  EXPECT_NEAR(up->cone().half_angle_rad, 30 * kRad, 1e-5);
  EXPECT_EQ(up->cone().axis, Vec3(0, 0, -1));
  const auto flood = web({PhotometricType::kB,
                          {-90, -10, 0, 10, 90},
                          {0, 20, 90},
                          {0, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}});
  EXPECT_NEAR(flood->cone().half_angle_rad, std::acos(std::cos(10 * kRad) * std::cos(20 * kRad)),
              1e-5);
  EXPECT_EQ(flood->cone().axis, Vec3(0, 0, 1));
  // The same grid about a car's headlamp: V = H = 0 is +x.
  const auto headlamp = web({PhotometricType::kA,
                             {-90, -10, 0, 10, 90},
                             {0, 20, 90},
                             {0, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}});
  EXPECT_NEAR(headlamp->cone().half_angle_rad, flood->cone().half_angle_rad, 1e-15);
  EXPECT_EQ(headlamp->cone().axis, Vec3(1, 0, 0));
  // Light about a pole only: in type A, V = 90 is straight up, which is -z.
  const auto above = web({PhotometricType::kA, {-90, 70, 90}, {-90, 90}, {0, 0, 5, 0, 0, 5}});
  EXPECT_NEAR(above->cone().half_angle_rad, 20 * kRad, 1e-5);
  EXPECT_EQ(above->cone().axis, Vec3(0, 0, -1));
}

TEST(PhotometricWeb, RefusesInvalidGrids) {
  using enum PhotometricType;
  EXPECT_THAT(error({kC, {0}, {0}, {1}}), HasSubstr("1 vertical angle, allowed: 2 or more"));
  EXPECT_THAT(error({kC, {0, 90}, {}, {}}), HasSubstr("0 horizontal angles"));
  EXPECT_THAT(error({kC, {-5, 80}, {0}, {1, 1}}), HasSubstr("from -5 to 80 degrees, allowed for"));
  EXPECT_THAT(error({kC, {0, 90, 90}, {0}, {1, 1, 1}}), HasSubstr("vertical angle[2] = 90"));
  EXPECT_THAT(error({kC, {0, NAN, 90}, {0}, {1, 1, 1}}), HasSubstr("vertical angle[1] = nan"));
  EXPECT_THAT(error({kC, {0, 90}, {-90, 271}, {1, 1, 1, 1}}), HasSubstr("from -90 to 271"));
  EXPECT_THAT(error({kB, {0, 90}, {0, 180}, {1, 1, 1, 1}}), HasSubstr("type B"));
  EXPECT_THAT(error({kB, {-95, 90}, {0, 90}, {1, 1, 1, 1}}), HasSubstr("types A and B"));
  EXPECT_THAT(error({kC, {0, 90}, {0}, {1}}), HasSubstr("1 intensities, allowed: 2"));
  EXPECT_THAT(error({kC, {0, 90}, {0}, {1, -1}}), HasSubstr("vertical angle 90 = -1 cd"));
  EXPECT_THAT(error({kC, {0, 90}, {0}, {1, INFINITY}}), HasSubstr("= inf cd"));
}

TEST(PhotometricWeb, BlackWebsHaveNoDensityAndFaintPartsHaveOne) {
  const auto black = web({PhotometricType::kC, {0, 90}, {0}, {0, 0}});
  EXPECT_EQ(black->flux_lm(), 0);
  EXPECT_EQ(black->pdf({0, 0, 1}).per_sr, 0);
  const auto faint =
      web({PhotometricType::kC, {0, 10, 20, 90, 180}, {0}, {1e30, 1e30, 0, 1e-10, 0}});
  EXPECT_GT(faint->pdf({1, 0, -0.5}).per_sr, 0);
}

}  // namespace
}  // namespace lucerna
