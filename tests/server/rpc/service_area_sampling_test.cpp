// The way to sample area lights, in each call that takes one.  contract_sampling_test.cpp tests
// what each way does.
#include <set>
#include <string>

#include "every_query.h"
#include "lights/sampling/spherical_triangle.h"

namespace lucerna::testing {
namespace {

const v1::AreaSampling kWays[] = {
    v1::AREA_SAMPLING_SQUARE_ROOT,       v1::AREA_SAMPLING_KRAEMER,
    v1::AREA_SAMPLING_PARALLELOGRAM,     v1::AREA_SAMPLING_REJECTION,
    v1::AREA_SAMPLING_LOW_DISTORTION,    v1::AREA_SAMPLING_SOLID_ANGLE,
    v1::AREA_SAMPLING_COSINE_SOLID_ANGLE};

class AreaSamplingTest : public ::testing::Test {
 protected:
  /// How many different answers the ways give.
  template <typename Request>
  std::size_t different_answers(Request q) {
    q.mutable_accuracy()->set_closed_forms(v1::CLOSED_FORMS_OFF);
    std::set<std::string> all;
    for (const v1::AreaSampling way : kWays) {
      q.mutable_accuracy()->set_area_sampling(way);
      all.insert(without_cost(service_.answer(q)));
    }
    return all.size();
  }

  Service service_;
};

TEST_F(AreaSamplingTest, EachCallUsesTheRequestedMethod) {
  for_each_query(service_.load("triangle.pbrt"), 64, [&]<typename Request>(Request q) {
    if constexpr (OneOf<Request, v1::SampleLiRequest, v1::PdfLiRequest,
                        v1::EstimateIrradianceRequest>) {
      // To (0.5, -1, 2), under the triangle and above all else.
      q.mutable_receivers()->mutable_origin_m()->set_y(-1.5);
      q.mutable_receivers()->mutable_origin_m()->set_z(1.5);
      q.mutable_normals()->Resize(3 * 64, 1);
      if constexpr (requires { q.mutable_wi(); })
        for (int i = 0; i < 3 * 64; ++i) q.set_wi(i, i % 3 == 2 ? 1.0F : 0.0F);
      // The five methods by area have one density.
      EXPECT_EQ(different_answers(q), (OneOf<Request, v1::PdfLiRequest> ? 3U : 7U))
          << q.GetTypeName();
    }
  });
}

TEST_F(AreaSamplingTest, TheReportedDensityIsThatOfTheRequestedMethod) {
  // Under the near rectangle of 7.04 m2: straight up, and ahead and behind of the normal.
  const Vec3 receiver{-1.25, -0.75, 1.25}, normal = normalized(Vec3{1, 0, 0.25});
  auto q = about<v1::PdfLiRequest>(service_.load("rectangle_near.pbrt"));
  q.set_light_id(1);
  for (const Vec3& w : {Vec3{0, 0, 1}, Vec3{4, 0, 1}, Vec3{-1, 0, 1}})
    for (int c = 0; c < 3; ++c) {
      q.mutable_receivers()->add_offsets_m(static_cast<float>(receiver[c]));
      q.add_normals(static_cast<float>(normal[c]));
      q.add_wi(static_cast<float>(w[c]));
    }
  const auto densities = [&](v1::AreaSampling way) {
    q.mutable_accuracy()->set_area_sampling(way);
    return service_.answer(q).pdf_per_sr();
  };
  const double height = 1.45 - 1.25;
  for (const auto way : {v1::AREA_SAMPLING_SQUARE_ROOT, v1::AREA_SAMPLING_LOW_DISTORTION})
    EXPECT_NEAR(densities(way)[0] / (height * height / 7.04), 1, 1e-5);
  const Vec3 corner = Vec3{-1.6, -1, 1.45} - receiver, x{3.2, 0, 0}, y{0, 2.2, 0};
  const double solid_angle =
      triangle_solid_angle(corner, x, y) + triangle_solid_angle(corner + x + y, -x, -y);
  for (const float density : densities(v1::AREA_SAMPLING_SOLID_ANGLE))
    EXPECT_NEAR(density * solid_angle, 1, 1e-5);
  // The part ahead has more weight than the part below the horizon.
  const auto cosine = densities(v1::AREA_SAMPLING_COSINE_SOLID_ANGLE);
  EXPECT_GT(cosine[1], 1.2 / solid_angle);
  EXPECT_LT(cosine[2], 0.8 / solid_angle);
  q.clear_normals();  // without a normal there is no cosine
  EXPECT_NEAR(densities(v1::AREA_SAMPLING_COSINE_SOLID_ANGLE)[2] * solid_angle, 1, 1e-5);
}

TEST_F(AreaSamplingTest, TilesUseTheRequestedMethod) {
  auto q = about<v1::RenderTileRequest>(service_.load("rectangle_near.pbrt"));
  set_rect(&q, 48, 40, 112, 104);
  q.mutable_accuracy()->set_samples(4);
  // Methods by area are equal on a rectangle.
  EXPECT_EQ(different_answers(q), 3U);
}

TEST_F(AreaSamplingTest, AnUnknownMethodIsNamedByEveryCall) {
  for_each_query(service_.load("triangle.pbrt"), 1, [&]<typename Request>(Request q) {
    if constexpr (OneOf<Request, v1::SampleLiRequest, v1::PdfLiRequest,
                        v1::EstimateIrradianceRequest, v1::RenderTileRequest,
                        v1::RenderImageRequest>) {
      q.mutable_accuracy()->set_area_sampling(static_cast<v1::AreaSampling>(99));
      expect_bad_field(service_.status(q), "accuracy.area_sampling");
    }
  });
}

}  // namespace
}  // namespace lucerna::testing
