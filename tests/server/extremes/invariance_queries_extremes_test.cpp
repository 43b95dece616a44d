// The same scene in other units gives the same answers to every query about each of its lights.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "server/estimate/render.h"
#include "server/queries/emission_queries.h"
#include "server/queries/queries.h"
#include "server/queries/visibility.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/invariant_scene.h"
#include "tests/server/extremes/scaled_scene.h"
#include "tests/server/queries/li_samples.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// The answers of each query, with lengths and what scales with them in units of the scene.
using QueryAnswers = std::map<std::string, std::vector<double>>;

/// Queries light `light` of a scene that was scaled by `s`.
class Queries {
 public:
  Queries(const Scene& scene, double s, std::uint32_t light, QueryAnswers& answers)
      : scene_(scene), s_(s), light_(light), answers_(answers) {
    for (int i = 0; i < 24; ++i) {
      put(offsets_, Vec3{1.1 * (i % 5) - 2.3, 0.9 * (i / 5) - 2.1, 0.02 + 0.11 * (i % 7)} * s);
      put(normals_, normalized(Vec3{0.3 * (i % 3) - 0.2, 0.4 * (i % 2) - 0.1, 1}));
    }
    status_.resize(offsets_.size() / 3);
  }

  void run() {
    power();
    arriving();
    leaving();
  }

 private:
  static void put(std::vector<float>& to, const Vec3& v) {
    const Vec3f f(v);
    to.insert(to.end(), {f.x, f.y, f.z});
  }
  PointArray points(std::span<const float> offsets) const {
    return {kEveryLightMiddle * s_, offsets};
  }
  void record(const std::string& query, std::span<const float> values, double unit) {
    auto& all = answers_[query];
    for (const float v : values) all.push_back(v / unit);
  }
  void record(const std::string& query, std::span<const int> values) {
    auto& all = answers_[query];
    all.insert(all.end(), values.begin(), values.end());
  }
  void record_bits(const std::string& query, std::span<const std::uint8_t> bits, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) answers_[query].push_back(bits[i / 8] >> (i % 8) & 1);
  }

  void power() {
    for (const Power& p : {light_power(scene_, light_), light_power_approximate(scene_, light_)})
      for (const double lumens : {p.lumens.r, p.lumens.g, p.lumens.b, p.error_lumens})
        answers_["EstimatePower"].push_back(lumens / (s_ * s_));
  }

  /// SampleLi, PdfLi of its samples, and the hit there.
  void arriving() {
    const std::size_t receivers = offsets_.size() / 3, n = 4 * receivers;
    const LiSamples s(scene_, {.receivers = points(offsets_),
                               .samples = 4,
                               .light = light_,
                               .seed = SeedRange{5, 0},
                               .test_visibility = true,
                               .normals = normals_});
    record("SampleLi", s.value, 1), record("SampleLi", s.wi, 1);
    record("SampleLi", s.distance_m, s_), record("SampleLi", s.light_offsets_m, s_);
    record("SampleLi", s.light_normals, 1), record("SampleLi", s.pdf_per_sr, 1);
    record("SampleLi", s.status), record_bits("SampleLi", s.delta, n);
    record_bits("SampleLi", s.visible, n);

    // The first sample of each receiver, or straight up where it has none.
    std::vector<float> towards, to, densities(receivers);
    for (std::size_t r = 0; r < receivers; ++r) {
      Vec3f w = triple(s.wi, 4 * r), end = triple(s.light_offsets_m, 4 * r);
      if (w == Vec3f{}) w = {0, 0, 1};
      if (end == Vec3f{}) end = triple(offsets_, r) + Vec3f(Vec3{1, 2, 3} * s_);
      put(towards, Vec3(w)), put(to, Vec3(end));
    }
    pdf_li(scene_,
           {.light = light_, .receivers = points(offsets_), .wi = towards, .normals = normals_},
           densities.data(), status_.data(), {});
    // Compared as the solid angles that they stand for.  Where a light is seen nearly edge-on, the
    // density amplifies the rounding of its direction and outweighs all others.
    for (float& d : densities) d = d > 0 ? 1 / d : 0;
    record("PdfLi", densities, 1), record("PdfLi", status_);

    std::vector<float> radiance(3 * receivers);
    std::vector<std::uint64_t> met(receivers);
    le(scene_, {points(offsets_), towards, light_}, {radiance.data(), met.data(), status_.data()},
       {});
    record("Le", radiance, 1), record("Le", status_);
    answers_["Le"].insert(answers_["Le"].end(), met.begin(), met.end());

    for (const bool with_normals : {false, true})
      for (const bool segments : {false, true}) {
        VisibilityQuery query{.from = points(offsets_)};
        if (segments) query.to = points(to);
        if (!segments) query.directions = towards;
        if (with_normals) query.normals = normals_;
        std::vector<std::uint8_t> free((receivers + 7) / 8);
        test_visibility(scene_, query, {free.data(), nullptr, status_.data()}, {});
        record_bits("TestVisibility", free, receivers), record("TestVisibility", status_);
      }
  }

  /// SampleLe, and PdfLe of its rays.
  void leaving() {
    const std::size_t n = 64;
    std::vector<float> at(3 * n), w(3 * n), normals(3 * n), value(3 * n), position(n), direction(n);
    std::vector<std::uint64_t> ids(n);
    std::vector<double> probability(n);
    std::vector<int> status(n);
    sample_le(scene_, {.rays = std::uint32_t{n}, .light = light_, .seed = SeedRange{6, 0}},
              {at.data(), w.data(), normals.data(), value.data(), position.data(), direction.data(),
               ids.data(), probability.data(), status.data()},
              {});
    // A light at a point has an intensity, which scales with the square of lengths.
    const bool is_point = position[0] == 0;
    const Vec3 shift = scene_.origin() - kEveryLightMiddle * s_;
    for (std::size_t i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) answers_["SampleLe"].push_back((at[3 * i + k] + shift[k]) / s_);
    record("SampleLe", w, 1), record("SampleLe", normals, 1);
    record("SampleLe", value, is_point ? s_ * s_ : 1), record("SampleLe", position, 1 / (s_ * s_));
    record("SampleLe", direction, 1), record("SampleLe", status);

    std::vector<float> way;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3f v = triple(w, i);
      put(way, Vec3(v == Vec3f{} ? Vec3f{0, 0, 1} : v));
    }
    std::vector<float> pdf_position(n), pdf_direction(n);
    pdf_le(scene_, light_, {scene_.origin(), at}, way, 0, pdf_position.data(), pdf_direction.data(),
           status.data(), {});
    record("PdfLe", pdf_position, 1 / (s_ * s_)), record("PdfLe", pdf_direction, 1);
    record("PdfLe", status);
  }

  const Scene& scene_;
  double s_;
  std::uint32_t light_;
  QueryAnswers& answers_;
  std::vector<float> offsets_, normals_;
  std::vector<int> status_;
};

QueryAnswers query_answers(const SceneDescription& description, double s) {
  const auto scene = build(scaled_scene(description, s));
  QueryAnswers answers;
  for (std::uint32_t l = 0; l < scene->lights().size(); ++l) Queries(*scene, s, l, answers).run();
  return answers;
}

TEST(InvarianceQueriesExtremes, PowersOfTwoChangeNoBitOfAnyQuery) {
  Sweep sweep(9, "every query about every light, the scene scaled by a power of two",
              "2^-40 ... 2^40", "answers");
  const SceneDescription d = invariant_scene();
  const QueryAnswers one = query_answers(d, 1);
  EXPECT_EQ(one.size(), 7U);
  for (const int exponent : {-40, -20, -10, -1, 1, 10, 20, 40})
    for (const auto& [query, values] : query_answers(d, std::ldexp(1.0, exponent))) {
      const std::vector<double>& truth = one.at(query);
      ASSERT_EQ(values.size(), truth.size());
      for (std::size_t i = 0; i < truth.size(); ++i)
        sweep.compare(values[i], truth[i],
                      query + " " + std::to_string(i) + " by 2^" + std::to_string(exponent));
    }
  sweep.expect_within(0);
}

double sum_of_sizes(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += std::fabs(v);
  return sum;
}

TEST(InvarianceQueriesExtremes, MillimetresAndKilometresKeepTheMeanOfAnyQuery) {
  Sweep sweep(9, "every query about every light, the scene in other units", "mm, km",
              "mean of answers");
  const SceneDescription d = invariant_scene();
  const QueryAnswers metres = query_answers(d, 1);
  for (const double s : {1e3, 1e-3})
    for (const auto& [query, values] : query_answers(d, s))
      sweep.compare(sum_of_sizes(values), sum_of_sizes(metres.at(query)),
                    query + " " + std::to_string(s));
  sweep.expect_within(1e-5);
}

}  // namespace
}  // namespace lucerna::testing
