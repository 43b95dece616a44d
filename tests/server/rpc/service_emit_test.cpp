// SampleLe and PdfLe.
#include <limits>
#include <map>
#include <vector>

#include "every_light.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

/// The contribution of ray `i` to the mean that equals the light's power, as documented at
/// SampleLeResponse.
double contribution(const v1::SampleLeResponse& r, int i) {
  double x = luminance_of(r.value(3 * i), r.value(3 * i + 1), r.value(3 * i + 2));
  double cosine = 0;
  bool surface = false;
  for (int c = 3 * i; c < 3 * i + 3; ++c) {
    cosine += double{r.light_normals(c)} * r.directions(c);
    surface |= r.light_normals(c) != 0;
  }
  if (surface) x *= std::fabs(cosine);
  if (r.pdf_position_per_m2(i) > 0) x /= r.pdf_position_per_m2(i);
  if (r.pdf_direction_per_sr(i) > 0) x /= r.pdf_direction_per_sr(i);
  return r.selection_probability_size() > 0 ? x / r.selection_probability(i) : x;
}

/// Expects the mean of all contributions to be `lumens` within 5.5 standard errors and the
/// roundings of floats.  The standard errors alone are exceeded by chance less than once in 1e7.
void expect_mean(const v1::SampleLeResponse& r, double lumens, const std::string& what) {
  const int n = r.pdf_direction_per_sr_size();
  double mean = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = contribution(r, i), before = x - mean;
    mean += before / (i + 1);
    squares += before * (x - mean);
  }
  const double error = std::sqrt(squares / n / (n - 1));
  EXPECT_NEAR(mean, lumens, 5.5 * error + 1e-6 * lumens) << what;
  // A mean of mere noise does not pass.
  EXPECT_LT(error, 0.02 * lumens) << what;
}

TEST_F(EveryLightTest, SeedsAreAsAccurateAsOwnSampleValues) {
  for (const v1::Light& light : lights_.lights()) {
    const auto r = service_.answer(rays_of(light, 16384, 7));
    // Owen scrambling has at most sqrt(e) times the error of random numbers.
    expect_mean(r, light.power_lm(), light.ShortDebugString());
  }
}

TEST_F(EveryLightTest, ChosenLightsAddUpToTheScene) {
  constexpr int kRays = 65536;
  const auto r = service_.answer(rays(kRays, 3));
  ASSERT_EQ(r.light_ids_size(), kRays);
  std::map<std::uint64_t, double> probability, count;
  for (int i = 0; i < kRays; ++i) {
    const double p = r.selection_probability(i);
    EXPECT_EQ(probability.emplace(r.light_ids(i), p).first->second, p);
    ++count[r.light_ids(i)];
  }
  ASSERT_EQ(probability.size(), static_cast<std::size_t>(lights_.lights_size()));
  double sum = 0, lumens = 0;
  std::vector<double> observed, expected;
  for (const v1::Light& light : lights_.lights()) {
    sum += probability[light.id()];
    lumens += light.power_lm();
    observed.push_back(count[light.id()]);
    expected.push_back(kRays * probability[light.id()]);
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_GT(chi_square_p_value(observed, expected), 1e-8);
  expect_mean(r, lumens, "all");
  // By power: the brightest is chosen most often.
  const auto brightest =
      std::max_element(lights_.lights().begin(), lights_.lights().end(),
                       [](const auto& a, const auto& b) { return a.power_lm() < b.power_lm(); });
  for (const auto& [id, p] : probability) EXPECT_LE(p, probability[brightest->id()]);
}

TEST_F(EveryLightTest, OwnValuesThatChooseLightsCutTheUnitInterval) {
  constexpr int kRays = 8192;
  v1::SampleLeRequest q = rays(kRays);
  for (int i = 0; i < kRays; ++i) {
    for (int k = 0; k < 4; ++k) q.mutable_u()->add_u(0.5F);
    q.mutable_u()->add_u_light((i + 0.5) / kRays);
  }
  const auto r = service_.answer(q);
  std::map<std::uint64_t, double> probability, share;
  for (int i = 0; i < kRays; ++i) {
    share[r.light_ids(i)] += 1.0 / kRays;
    probability[r.light_ids(i)] = r.selection_probability(i);
    EXPECT_GE(r.light_ids(i), r.light_ids(std::max(i - 1, 0)));
  }
  for (const auto& [id, p] : probability) EXPECT_NEAR(share[id], p, 1.0 / kRays) << id;
}

TEST_F(EveryLightTest, RangesOfASeedJoin) {
  v1::SampleLeRequest q = rays(6000, 3);
  auto whole = service_.answer(q);
  q.set_count(2000);
  q.mutable_seed()->set_first_item(4000);
  auto part = service_.answer(q);
  const auto end_of = [](const auto& of, const auto& all) {
    return std::equal(of.begin(), of.end(), all.end() - of.size());
  };
  EXPECT_TRUE(end_of(part.points().offsets_m(), whole.points().offsets_m()));
  EXPECT_TRUE(end_of(part.directions(), whole.directions()));
  EXPECT_TRUE(end_of(part.value(), whole.value()));
  EXPECT_TRUE(end_of(part.light_ids(), whole.light_ids()));
  EXPECT_TRUE(end_of(part.selection_probability(), whole.selection_probability()));
  // Where the index of a 32-bit sequence ends, the next sequence begins.
  q.set_count(4);
  q.mutable_seed()->set_first_item((std::uint64_t{1} << 32) - 2);
  whole = service_.answer(q);
  q.set_count(2);
  q.mutable_seed()->set_first_item(std::uint64_t{1} << 32);
  part = service_.answer(q);
  EXPECT_TRUE(end_of(part.directions(), whole.directions()));
  q.mutable_seed()->set_first_item(0);
  part = service_.answer(q);
  EXPECT_FALSE(end_of(part.directions(), whole.directions()));
}

TEST_F(EveryLightTest, RaysDependOnSeedAndNotOnThreads) {
  v1::SampleLeRequest q = rays(3000, 3);
  const auto two_threads = service_.answer(q);
  rpc::ServerOptions options = all_data();
  options.lanes.threads = 1;
  Service alone(options);
  alone.load("lights/every_light.pbrt");
  const auto one_thread = alone.answer(q);
  EXPECT_TRUE(without_cost(two_threads) == without_cost(one_thread));
  q.mutable_seed()->set_seed(4);
  const auto other_seed = service_.answer(q);
  EXPECT_FALSE(without_cost(two_threads) == without_cost(other_seed));
}

TEST_F(EveryLightTest, CertainPositionsAndDirectionsHaveNoDensity) {
  for (const v1::Light& light : lights_.lights()) {
    const auto r = service_.answer(rays_of(light, 64));
    const bool point =
        light.has_point() || light.has_spot() || light.has_goniometric() || light.has_projection();
    const bool one_direction = light.has_distant() || light.has_beam();
    for (int i = 0; i < 64; ++i) {
      EXPECT_EQ(r.pdf_position_per_m2(i) == 0, point) << light.ShortDebugString();
      EXPECT_EQ(r.pdf_direction_per_sr(i) == 0, one_direction) << light.ShortDebugString();
      const bool normal = r.light_normals(3 * i) != 0 || r.light_normals(3 * i + 1) != 0 ||
                          r.light_normals(3 * i + 2) != 0;
      EXPECT_EQ(normal, light.has_diffuse_area() || has_portal(light)) << light.ShortDebugString();
    }
  }
}

TEST_F(EveryLightTest, PdfLeReportsTheDensitiesOfSampledRays) {
  for (const v1::Light& light : lights_.lights()) {
    const auto r = service_.answer(rays_of(light, 512, 5));
    v1::PdfLeRequest q = density_of(light);
    *q.mutable_points() = r.points();
    *q.mutable_directions() = r.directions();
    // A direction of any length.
    for (int i = 0; i < 3 * 512; ++i)
      q.set_directions(i, q.directions(i) * (0.25F + 0.01F * (i / 3)));
    auto d = service_.answer(q);
    EXPECT_EQ(d.status_size(), 0);
    const auto expect_same = [&](float reported, float sampled) {
      EXPECT_NEAR(reported, sampled, 2e-4F * sampled) << light.ShortDebugString();
    };
    for (int i = 0; i < 512; ++i) {
      expect_same(d.pdf_position_per_m2(i), r.pdf_position_per_m2(i));
      expect_same(d.pdf_direction_per_sr(i), r.pdf_direction_per_sr(i));
    }
    // Single queries equal the joint one.
    v1::PdfLeRequest one = density_of(light);
    *one.mutable_points()->mutable_origin_m() = q.points().origin_m();
    for (int c = 3 * 100; c < 3 * 101; ++c) {
      one.mutable_points()->add_offsets_m(q.points().offsets_m(c));
      one.add_directions(q.directions(c));
    }
    const auto alone = service_.answer(one);
    ASSERT_EQ(alone.pdf_direction_per_sr_size(), 1);
    EXPECT_EQ(alone.pdf_position_per_m2(0), d.pdf_position_per_m2(100));
    EXPECT_EQ(alone.pdf_direction_per_sr(0), d.pdf_direction_per_sr(100));
    // No ray of the light starts elsewhere.
    q.mutable_points()->mutable_origin_m()->set_z(q.points().origin_m().z() + 1000);
    d = service_.answer(q);
    for (int i = 0; i < 512; ++i) {
      EXPECT_EQ(d.pdf_position_per_m2(i), 0) << light.ShortDebugString();
      EXPECT_EQ(d.pdf_direction_per_sr(i), 0) << light.ShortDebugString();
    }
  }
}

}  // namespace
}  // namespace lucerna::testing
