// Answers that exceed the size limit of messages are refused before they are computed.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "proto/common/answer_size.h"
#include "service_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

constexpr std::uint64_t kLights = 400;  // of many_points.pbrt
constexpr int kItems = 1000;

template <typename Request>
Request about(const std::string& scene, int wavelengths = 128) {
  Request q;
  q.set_scene_id(scene);
  for (int i = 0; i < wavelengths; ++i) q.add_wavelengths_nm(400 + i);
  return q;
}

v1::SampleLiRequest li(const std::string& scene, int items) {
  auto q = about<v1::SampleLiRequest>(scene);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * items, 0.5F);
  q.mutable_seed();
  q.set_test_visibility(true);
  return q;
}

v1::LeRequest le(const std::string& scene, int items) {
  auto q = about<v1::LeRequest>(scene);
  q.mutable_points()->mutable_offsets_m()->Resize(3 * items, 0.5F);
  q.mutable_directions()->Resize(3 * items, 1);
  return q;
}

v1::SampleLeRequest emit(const std::string& scene, std::uint32_t rays) {
  auto q = about<v1::SampleLeRequest>(scene);
  q.set_count(rays);
  q.mutable_seed();
  return q;
}

v1::EstimateIrradianceRequest irradiance(const std::string& scene, int items) {
  auto q = about<v1::EstimateIrradianceRequest>(scene);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * items, 0.5F);
  q.mutable_normals()->Resize(3 * items, 1);
  q.set_bounces(0);
  q.set_per_light(true);
  q.mutable_accuracy()->set_samples(2);
  return q;
}

/// The first item is NaN, so that the answer has a status for each item.
template <typename Points>
void spoil(Points* points) {
  points->set_offsets_m(0, std::numeric_limits<float>::quiet_NaN());
}

/// Expects the predicted size to be an upper bound that is not much larger than the answer.
template <typename Response>
void expect_bounded(const Response& r, const AnswerSize& size, int items) {
  const auto n = static_cast<double>(items);
  EXPECT_LE(r.ByteSizeLong(), size.fixed + n * size.per_item);
  EXPECT_GE(r.ByteSizeLong(), 0.6 * n * size.per_item) << size.per_item;
}

TEST(AnswerSizes, AreBoundsOfTheAnswersToEachCall) {
  Service service;
  const std::string scene = service.load("many_points.pbrt");
  v1::SampleLiRequest sample = li(scene, kItems);
  spoil(sample.mutable_receivers());
  v1::SampleLiResponse samples;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.lighting.SampleLi(c, sample, &samples); }).ok());
  expect_bounded(samples, answer_size(sample), kItems);
  // With the optional values of each receiver.
  sample.mutable_accuracy()->mutable_target_error()->set_relative(1);
  sample.mutable_receivers()->mutable_offsets_m()->Truncate(3 * 100);
  sample.mutable_accuracy()->mutable_target_error()->set_max_samples(64);
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.lighting.SampleLi(c, sample, &samples); }).ok());
  ASSERT_EQ(samples.estimates().spectral_standard_error_size(), 128 * 100);
  expect_bounded(samples, answer_size(sample), samples.pdf_per_sr_size());

  v1::LeRequest look = le(scene, kItems);
  spoil(look.mutable_points());
  v1::LeResponse seen;
  ASSERT_TRUE(status_of([&](auto* c) { return service.lighting.Le(c, look, &seen); }).ok());
  expect_bounded(seen, answer_size(look), kItems);

  v1::SampleLeRequest rays = emit(scene, kItems);
  rays.mutable_u()->mutable_u()->Resize(4 * kItems, 0.5F);
  rays.mutable_u()->mutable_u_light()->Resize(kItems, 0.5);
  rays.mutable_u()->set_u(0, std::numeric_limits<float>::quiet_NaN());
  v1::SampleLeResponse emitted;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.lighting.SampleLe(c, rays, &emitted); }).ok());
  expect_bounded(emitted, answer_size(rays), kItems);

  v1::EstimateIrradianceRequest meter = irradiance(scene, kItems);
  spoil(meter.mutable_receivers());
  v1::EstimateIrradianceResponse lux;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.lighting.EstimateIrradiance(c, meter, &lux); }).ok());
  ASSERT_EQ(lux.shares_size(), static_cast<int>(kLights));
  expect_bounded(lux, answer_size(meter, kLights), kItems);

  auto power = about<v1::EstimatePowerRequest>(scene);
  v1::EstimatePowerResponse flux;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.lighting.EstimatePower(c, power, &flux); }).ok());
  expect_bounded(flux, answer_size(power), static_cast<int>(kLights));
}

TEST(AnswerSizes, AreBoundsOfDensitiesBitsAndTiles) {
  Service service;
  const std::string scene = service.load("point.pbrt");
  v1::PdfLiRequest density;
  density.set_scene_id(scene);
  density.set_light_id(1);
  density.mutable_receivers()->mutable_offsets_m()->Resize(3 * kItems, 0.5F);
  density.mutable_wi()->Resize(3 * kItems, 1);
  spoil(density.mutable_receivers());
  v1::PdfLiResponse pdf;
  ASSERT_TRUE(status_of([&](auto* c) { return service.lighting.PdfLi(c, density, &pdf); }).ok());
  expect_bounded(pdf, answer_size(density), kItems);

  v1::PdfLeRequest leaving;
  leaving.set_scene_id(scene);
  leaving.set_light_id(1);
  leaving.mutable_points()->mutable_offsets_m()->Resize(3 * kItems, 0.5F);
  leaving.mutable_directions()->Resize(3 * kItems, 1);
  spoil(leaving.mutable_points());
  v1::PdfLeResponse pdfs;
  ASSERT_TRUE(status_of([&](auto* c) { return service.lighting.PdfLe(c, leaving, &pdfs); }).ok());
  expect_bounded(pdfs, answer_size(leaving), kItems);

  v1::TestVisibilityRequest visibility;
  visibility.set_scene_id(scene);
  visibility.mutable_rays()->mutable_from()->mutable_offsets_m()->Resize(3 * kItems, 0.5F);
  visibility.mutable_rays()->mutable_directions()->Resize(3 * kItems, 1);
  spoil(visibility.mutable_rays()->mutable_from());
  v1::TestVisibilityResponse bits;
  ASSERT_TRUE(status_of([&](auto* c) {
                return service.lighting.TestVisibility(c, visibility, &bits);
              }).ok());
  // A bit counts as a byte: 9 of 16.
  EXPECT_LE(bits.ByteSizeLong(), answer_size(visibility, false).fixed + 2 * kItems);
  EXPECT_GE(bits.ByteSizeLong(), 9 * kItems / 8);

  v1::RenderTileRequest tile;
  tile.set_scene_id(scene);
  tile.mutable_rect()->set_x1(40);
  tile.mutable_rect()->set_y1(25);
  tile.mutable_accuracy()->set_samples(1);
  v1::RenderTileResponse picture;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.render.RenderTile(c, tile, &picture); }).ok());
  expect_bounded(picture, tile_size({}, false), 40 * 25);
  tile.set_intervals(true);
  ASSERT_TRUE(
      status_of([&](auto* c) { return service.render.RenderTile(c, tile, &picture); }).ok());
  expect_bounded(picture, tile_size({}, true), 40 * 25);
}

/// A server with small messages.
class MessageLimits : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kBytes = 50000;

  static rpc::ServerOptions small() {
    rpc::ServerOptions options = service_options();
    options.limits.max_message_bytes = kBytes;
    return options;
  }
  /// Expects `call(n)` to succeed and `call(n + 1)` to be refused, for the largest `n` that fits.
  template <typename Call>
  static void expect_limit(const AnswerSize& size, const std::string& field, Call&& call) {
    const auto n = static_cast<int>(size.items_within(kBytes));
    ASSERT_GT(n, 0);
    const grpc::Status fits = call(n), refused = call(n + 1);
    EXPECT_TRUE(fits.ok()) << fits.error_message();
    EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_EQ(refused.error_message(), field + " (" + std::to_string(size.per_item) +
                                           " bytes each in the answer) = " + std::to_string(n + 1) +
                                           ", limit of this server: " + std::to_string(n));
    EXPECT_EQ(detail<google::rpc::ErrorInfo>(refused).reason(), "OVER_LIMIT");
    EXPECT_FALSE(detail<google::rpc::RetryInfo>(refused).has_retry_delay());
  }

  Service service_{small()};
  std::string scene_ = service_.load("many_points.pbrt");
};

TEST_F(MessageLimits, LimitEachCallWithWavelengths) {
  expect_limit(answer_size(li(scene_, 1)), "receivers times accuracy.samples", [&](int n) {
    v1::SampleLiResponse r;
    return status_of([&](auto* c) { return service_.lighting.SampleLi(c, li(scene_, n), &r); });
  });
  expect_limit(answer_size(le(scene_, 1)), "points", [&](int n) {
    v1::LeResponse r;
    return status_of([&](auto* c) { return service_.lighting.Le(c, le(scene_, n), &r); });
  });
  expect_limit(answer_size(emit(scene_, 1)), "count", [&](int n) {
    v1::SampleLeResponse r;
    return status_of([&](auto* c) { return service_.lighting.SampleLe(c, emit(scene_, n), &r); });
  });
}

TEST_F(MessageLimits, LimitSharesByTheNumberOfLights) {
  const AnswerSize size = answer_size(irradiance(scene_, 1), kLights);
  // Illuminance and its error of each light.
  EXPECT_GE(size.per_item, 8 * kLights);
  const auto call = [&](int n) {
    v1::EstimateIrradianceResponse r;
    return status_of([&](auto* c) {
      return service_.lighting.EstimateIrradiance(c, irradiance(scene_, n), &r);
    });
  };
  expect_limit(size, "receivers", call);
}

TEST_F(MessageLimits, LimitTiles) {
  v1::RenderTileRequest q;
  q.set_scene_id(scene_);
  q.mutable_accuracy()->set_samples(1);
  q.mutable_rect()->set_x1(160);
  q.mutable_rect()->set_y1(6);
  v1::RenderTileResponse r;
  // 48 bytes per pixel: 960 pixels and 1120.
  EXPECT_TRUE(status_of([&](auto* c) { return service_.render.RenderTile(c, q, &r); }).ok());
  q.mutable_rect()->set_y1(7);
  const grpc::Status tile =
      status_of([&](auto* c) { return service_.render.RenderTile(c, q, &r); });
  EXPECT_EQ(tile.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(tile.error_message(),
              HasSubstr("pixels of rect (48 bytes each in the answer) = 1120"));
  v1::RenderImageRequest image;
  image.set_scene_id(scene_);
  image.mutable_accuracy()->set_samples(1);
  image.set_tile_size(64);
  const grpc::Status tiles =
      status_of([&](auto* c) { return service_.render.RenderImage(c, image)->Finish(); });
  EXPECT_EQ(tiles.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(tiles.error_message(), HasSubstr("pixels of a tile"));
}

TEST_F(MessageLimits, ShortenPagesOfPowers) {
  auto q = about<v1::EstimatePowerRequest>(scene_);
  std::vector<std::uint64_t> ids;
  int pages = 0;
  do {
    v1::EstimatePowerResponse r;
    const grpc::Status s =
        status_of([&](auto* c) { return service_.lighting.EstimatePower(c, q, &r); });
    ASSERT_TRUE(s.ok()) << s.error_message();
    EXPECT_LE(r.ByteSizeLong(), kBytes);
    for (const v1::LightPower& light : r.lights()) ids.push_back(light.light_id());
    q.set_page_token(r.next_page_token());
    ++pages;
  } while (!q.page_token().empty());
  EXPECT_GT(pages, 5);
  EXPECT_LT(pages, 15);  // each has 128 doubles and a little more
  ASSERT_EQ(ids.size(), kLights);
  for (std::uint64_t i = 0; i < kLights; ++i) EXPECT_EQ(ids[i], i + 1);
}

// The array of wavelengths would have 2^31 entries, but an int counts them.
TEST(LargestLimits, RefuseArraysThatAreTooLong) {
  rpc::ServerOptions options = service_options();
  options.limits.max_batch_items = 1 << 24;
  options.limits.max_samples = 1 << 24;
  options.limits.max_message_bytes = std::numeric_limits<int>::max();
  Service service(options);
  const std::string scene = service.load("many_points.pbrt");
  v1::SampleLeResponse rays;
  const grpc::Status emitted =
      status_of([&](auto* c) { return service.lighting.SampleLe(c, emit(scene, 1 << 24), &rays); });
  EXPECT_EQ(emitted.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(emitted.error_message(),
              HasSubstr("count (587 bytes each in the answer) = 16777216"));
  v1::SampleLiRequest q = li(scene, 1);
  q.mutable_accuracy()->set_samples(1 << 24);
  v1::SampleLiResponse samples;
  EXPECT_EQ(
      status_of([&](auto* c) { return service.lighting.SampleLi(c, q, &samples); }).error_code(),
      grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace lucerna::testing
