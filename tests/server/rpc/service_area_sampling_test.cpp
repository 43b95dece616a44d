// Accuracy.area_sampling in calls.  Every method gives the same irradiance.  SampleLi and PdfLi
// report the density of the requested method.
#include <cmath>
#include <cstring>
#include <vector>

#include "lights/sampling/spherical_triangle.h"
#include "service_fixture.h"
#include "tests/lights/closed_forms.h"

namespace lucerna::testing {
namespace {

const v1::AreaSampling kWays[] = {
    v1::AREA_SAMPLING_UNSPECIFIED, v1::AREA_SAMPLING_SQUARE_ROOT,
    v1::AREA_SAMPLING_KRAEMER,     v1::AREA_SAMPLING_PARALLELOGRAM,
    v1::AREA_SAMPLING_REJECTION,   v1::AREA_SAMPLING_LOW_DISTORTION,
    v1::AREA_SAMPLING_SOLID_ANGLE, v1::AREA_SAMPLING_COSINE_SOLID_ANGLE};

constexpr double kSky = 1;  // radiance of infinite.pbrt

struct Place {
  std::string scene;
  Vec3 receiver, normal;
  double expected_lx;
};

/// Places in the reference scenes from which the light is unobstructed: above all other objects.
std::vector<Place> places() {
  const std::vector<Vec3> triangle{{-0.5, -1.5, 3.2}, {0.7, -0.6, 3.4}, {1.1, -1.9, 2.9}};
  const std::vector<Vec3> rectangle{
      {-1.6, -1, 1.45}, {-1.6, 1.2, 1.45}, {1.6, 1.2, 1.45}, {1.6, -1, 1.45}};
  const Vec3 centre{0.7, -1.2, 2.6};  // of a sphere of radius 0.35
  const Vec3 up{0, 0, 1}, aside = normalized(Vec3{1, 0.25, 0.125});
  const Vec3 axis{-0.280429629, 0.560859258, -0.778971191};  // of a disk of radius 0.6
  return {{"triangle.pbrt", {0.5, -1, 2}, up, 12 * polygon_irradiance(triangle, {0.5, -1, 2}, up)},
          {"triangle.pbrt",
           {0.5, -1, 2},
           aside,
           12 * polygon_irradiance(triangle, {0.5, -1, 2}, aside)},
          {"rectangle_near.pbrt",
           {-1.25, -0.75, 1.25},
           up,
           2 * polygon_irradiance(rectangle, {-1.25, -0.75, 1.25}, up)},
          {"sphere.pbrt", {0.5, -1, 2}, up, 12 * sphere_irradiance(centre, 0.35, {0.5, -1, 2}, up)},
          {"sphere.pbrt",
           {0.5, -1, 2},
           aside,
           12 * sphere_irradiance(centre, 0.35, {0.5, -1, 2}, aside)},
          {"disk.pbrt", Vec3{0.9, -1.6, 3} + axis * 0.5, -axis, 12 * disk_irradiance(0.6, 0.5, 0)},
          // Above the wall, which is 5 m high.
          {"infinite.pbrt", {0.5, -1, 6}, up, kSky * std::numbers::pi}};
}

/// Mean of independent values with its standard error.
struct Mean {
  explicit Mean(const std::vector<double>& values) {
    for (const double v : values) mean += v / double(values.size());
    for (const double v : values) error += (v - mean) * (v - mean);
    error = std::sqrt(error / double(values.size() * (values.size() - 1)));
  }
  double mean = 0, error = 0;
};

/// Number of items.  A mean is off by 7 of its standard errors once in 5e8 (Student's t).
constexpr int kSampledItems = 64;

class AreaSamplingTest : public ::testing::Test {
 protected:
  template <typename Request>
  Request request(const Place& p, v1::AreaSampling way, bool normals = true) {
    Request q;
    q.set_scene_id(service_.load(p.scene));
    q.mutable_accuracy()->set_area_sampling(way);
    q.mutable_accuracy()->set_closed_forms(v1::CLOSED_FORMS_OFF);
    for (int i = 0; i < kSampledItems; ++i)
      for (int c = 0; c < 3; ++c) {
        q.mutable_receivers()->add_offsets_m(static_cast<float>(p.receiver[c]));
        if (normals) q.add_normals(static_cast<float>(p.normal[c]));
      }
    return q;
  }
  v1::SampleLiRequest sample_request(const Place& p, v1::AreaSampling way) {
    auto q = request<v1::SampleLiRequest>(p, way);
    q.set_light_id(1);
    q.mutable_seed()->set_seed(17);
    return q;
  }
  /// The density of direction `w`.
  float pdf(const Place& p, v1::AreaSampling way, const Vec3f& w, bool normals = true) {
    auto q = request<v1::PdfLiRequest>(p, way, normals);
    q.set_light_id(1);
    for (int i = 0; i < kSampledItems; ++i)
      for (int c = 0; c < 3; ++c) q.add_wi(w[c]);
    v1::PdfLiResponse r;
    EXPECT_TRUE(status_of([&](auto* c) { return service_.lighting.PdfLi(c, q, &r); }).ok());
    return r.pdf_per_sr(0);
  }

  Service service_;
};

TEST_F(AreaSamplingTest, IrradianceEqualsTheClosedFormForEachMethod) {
  for (const Place& p : places()) {
    std::vector<std::string> answers;
    for (const v1::AreaSampling way : kWays) {
      auto q = request<v1::EstimateIrradianceRequest>(p, way);
      q.set_bounces(0);
      q.mutable_accuracy()->set_samples(256);
      v1::EstimateIrradianceResponse r;
      ASSERT_TRUE(
          status_of([&](auto* c) { return service_.lighting.EstimateIrradiance(c, q, &r); }).ok());
      const Mean m({r.illuminance_lx().begin(), r.illuminance_lx().end()});
      EXPECT_NEAR(m.mean, p.expected_lx, 7 * m.error + 1e-5 * p.expected_lx)
          << p.scene << " way " << way;
      EXPECT_LT(m.error, 0.01 * p.expected_lx) << p.scene << " way " << way;
      r.clear_cost();
      answers.push_back(r.SerializeAsString());
    }
    // The server used the method: the five maps of triangles and both solid angles give different
    // bits.
    for (std::size_t i = 1; p.scene == "triangle.pbrt" && i < answers.size(); ++i)
      for (std::size_t j = i + 1; j < answers.size(); ++j)
        EXPECT_NE(answers[i], answers[j]) << kWays[i] << " " << kWays[j];
  }
}

TEST_F(AreaSamplingTest, TheReportedDensityIsThatOfTheRequestedMethod) {
  Place p = places()[2];  // the near rectangle, 7.04 m2, overhead
  p.normal = normalized(Vec3{1, 0, 0.25});
  const Vec3f up{0, 0, 1}, ahead{4, 0, 1}, behind{-1, 0, 1};
  const double height = 1.45 - 1.25;
  for (const auto way : {v1::AREA_SAMPLING_SQUARE_ROOT, v1::AREA_SAMPLING_LOW_DISTORTION})
    EXPECT_NEAR(pdf(p, way, up) / (height * height / 7.04), 1, 1e-5);
  const Vec3 corner = Vec3{-1.6, -1, 1.45} - p.receiver, x{3.2, 0, 0}, y{0, 2.2, 0};
  const double solid_angle =
      triangle_solid_angle(corner, x, y) + triangle_solid_angle(corner + x + y, -x, -y);
  for (const auto& w : {up, ahead, behind})
    EXPECT_NEAR(pdf(p, v1::AREA_SAMPLING_SOLID_ANGLE, w) * solid_angle, 1, 1e-5);
  // With the cosine, the part ahead has more weight than the part below the horizon.  Without a
  // normal there is no cosine.
  const auto cosine = v1::AREA_SAMPLING_COSINE_SOLID_ANGLE;
  EXPECT_GT(pdf(p, cosine, ahead), 1.2 / solid_angle);
  EXPECT_LT(pdf(p, cosine, behind), 0.8 / solid_angle);
  EXPECT_NEAR(pdf(p, cosine, behind, false) * solid_angle, 1, 1e-5);
}

TEST_F(AreaSamplingTest, TilesAgreeInTheirMeanForEachMethod) {
  v1::RenderTileRequest q;
  q.set_scene_id(service_.load("rectangle_near.pbrt"));
  q.mutable_rect()->set_x0(48);
  q.mutable_rect()->set_x1(112);
  q.mutable_rect()->set_y0(40);
  q.mutable_rect()->set_y1(104);
  q.set_seed(23);
  q.mutable_accuracy()->set_samples(64);
  q.set_samples_per_block(4);
  const double blocks = 16;
  double first = 0, first_variance = 0;
  std::vector<std::string> planes;
  for (const v1::AreaSampling way : kWays) {
    q.mutable_accuracy()->set_area_sampling(way);
    q.mutable_accuracy()->set_closed_forms(v1::CLOSED_FORMS_OFF);
    v1::RenderTileResponse r;
    ASSERT_TRUE(status_of([&](auto* c) { return service_.render.RenderTile(c, q, &r); }).ok());
    ASSERT_EQ(r.tile().block_count(), 16U);
    planes.push_back(r.tile().sum());
    double mean = 0, variance = 0;
    for (std::size_t at = 0; at < r.tile().sum().size(); at += 3 * sizeof(double)) {
      double sum = 0, deviation = 0;  // red
      std::memcpy(&sum, r.tile().sum().data() + at, sizeof sum);
      std::memcpy(&deviation, r.tile().deviation().data() + at, sizeof deviation);
      mean += sum / blocks;
      variance += deviation / (blocks * (blocks - 1));
    }
    if (way == kWays[0]) first = mean, first_variance = variance;
    // 4096 pixels with independent errors: normally distributed, beyond 6 once in 5e8.
    EXPECT_NEAR(mean, first, 6 * std::sqrt(variance + first_variance)) << way;
    EXPECT_LT(std::sqrt(variance), 2e-3 * mean) << way;
  }
  // Methods by area (1 to 5) are equal on a rectangle.  Those by solid angle and by its cosine
  // differ.
  EXPECT_EQ(planes[1], planes[5]);
  EXPECT_NE(planes[5], planes[6]);
  EXPECT_NE(planes[6], planes[7]);
}

TEST_F(AreaSamplingTest, AnUnknownMethodIsNamedByEveryCall) {
  const auto bad = static_cast<v1::AreaSampling>(99);
  const Place p = places()[0];
  v1::SampleLiResponse s;
  auto sample = sample_request(p, bad);
  expect_bad_field(status_of([&](auto* c) { return service_.lighting.SampleLi(c, sample, &s); }),
                   "accuracy.area_sampling");
  auto pdf = request<v1::PdfLiRequest>(p, bad);
  pdf.set_light_id(1);
  pdf.mutable_wi()->Resize(3 * kSampledItems, 1);
  v1::PdfLiResponse d;
  expect_bad_field(status_of([&](auto* c) { return service_.lighting.PdfLi(c, pdf, &d); }),
                   "accuracy.area_sampling");
  auto irradiance = request<v1::EstimateIrradianceRequest>(p, bad);
  v1::EstimateIrradianceResponse e;
  expect_bad_field(
      status_of([&](auto* c) { return service_.lighting.EstimateIrradiance(c, irradiance, &e); }),
      "accuracy.area_sampling");
  v1::RenderTileRequest tile;
  tile.set_scene_id(irradiance.scene_id());
  tile.mutable_rect()->set_x1(8);
  tile.mutable_rect()->set_y1(8);
  tile.mutable_accuracy()->set_area_sampling(bad);
  v1::RenderTileResponse t;
  expect_bad_field(status_of([&](auto* c) { return service_.render.RenderTile(c, tile, &t); }),
                   "accuracy.area_sampling");
  v1::RenderImageRequest image;
  image.set_scene_id(irradiance.scene_id());
  image.mutable_accuracy()->set_area_sampling(bad);
  expect_bad_field(
      status_of([&](auto* c) { return service_.render.RenderImage(c, image)->Finish(); }),
      "accuracy.area_sampling");
}

}  // namespace
}  // namespace lucerna::testing
