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
Request spectral(const std::string& scene) {
  auto q = about<Request>(scene);
  for (int i = 0; i < 128; ++i) q.add_wavelengths_nm(400 + i);
  return q;
}

v1::SampleLiRequest li(const std::string& scene, int items) {
  auto q = spectral<v1::SampleLiRequest>(scene);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * items, 0.5F);
  q.mutable_seed();
  q.set_test_visibility(true);
  return q;
}

v1::LeRequest le(const std::string& scene, int items) {
  auto q = spectral<v1::LeRequest>(scene);
  q.mutable_points()->mutable_offsets_m()->Resize(3 * items, 0.5F);
  q.mutable_directions()->Resize(3 * items, 1);
  return q;
}

v1::SampleLeRequest emit(const std::string& scene, std::uint32_t rays) {
  auto q = spectral<v1::SampleLeRequest>(scene);
  q.set_count(rays);
  q.mutable_seed();
  return q;
}

v1::EstimateIrradianceRequest irradiance(const std::string& scene, int items) {
  auto q = spectral<v1::EstimateIrradianceRequest>(scene);
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
  auto samples = service.answer(sample);
  expect_bounded(samples, answer_size(sample), kItems);
  // With the optional values of each receiver.
  sample.mutable_accuracy()->mutable_target_error()->set_relative(1);
  sample.mutable_receivers()->mutable_offsets_m()->Truncate(3 * 100);
  sample.mutable_accuracy()->mutable_target_error()->set_max_samples(64);
  samples = service.answer(sample);
  ASSERT_EQ(samples.estimates().spectral_standard_error_size(), 128 * 100);
  expect_bounded(samples, answer_size(sample), samples.pdf_per_sr_size());

  v1::LeRequest look = le(scene, kItems);
  spoil(look.mutable_points());
  const auto seen = service.answer(look);
  expect_bounded(seen, answer_size(look), kItems);

  v1::SampleLeRequest rays = emit(scene, kItems);
  rays.mutable_u()->mutable_u()->Resize(4 * kItems, 0.5F);
  rays.mutable_u()->mutable_u_light()->Resize(kItems, 0.5);
  rays.mutable_u()->set_u(0, std::numeric_limits<float>::quiet_NaN());
  const auto emitted = service.answer(rays);
  expect_bounded(emitted, answer_size(rays), kItems);

  v1::EstimateIrradianceRequest meter = irradiance(scene, kItems);
  spoil(meter.mutable_receivers());
  const auto lux = service.answer(meter);
  ASSERT_EQ(lux.shares_size(), static_cast<int>(kLights));
  expect_bounded(lux, answer_size(meter, kLights), kItems);

  auto power = spectral<v1::EstimatePowerRequest>(scene);
  const auto flux = service.answer(power);
  expect_bounded(flux, answer_size(power), static_cast<int>(kLights));
}

TEST(AnswerSizes, AreBoundsOfDensitiesBitsAndTiles) {
  Service service;
  const std::string scene = service.load("point.pbrt");
  auto density = about<v1::PdfLiRequest>(scene);
  density.set_light_id(1);
  density.mutable_receivers()->mutable_offsets_m()->Resize(3 * kItems, 0.5F);
  density.mutable_wi()->Resize(3 * kItems, 1);
  spoil(density.mutable_receivers());
  const auto pdf = service.answer(density);
  expect_bounded(pdf, answer_size(density), kItems);

  auto leaving = about<v1::PdfLeRequest>(scene);
  leaving.set_light_id(1);
  leaving.mutable_points()->mutable_offsets_m()->Resize(3 * kItems, 0.5F);
  leaving.mutable_directions()->Resize(3 * kItems, 1);
  spoil(leaving.mutable_points());
  const auto pdfs = service.answer(leaving);
  expect_bounded(pdfs, answer_size(leaving), kItems);

  auto visibility = about<v1::TestVisibilityRequest>(scene);
  visibility.mutable_rays()->mutable_from()->mutable_offsets_m()->Resize(3 * kItems, 0.5F);
  visibility.mutable_rays()->mutable_directions()->Resize(3 * kItems, 1);
  spoil(visibility.mutable_rays()->mutable_from());
  const auto bits = service.answer(visibility);
  // A bit counts as a byte: 9 of 16.
  EXPECT_LE(bits.ByteSizeLong(), answer_size(visibility, false).fixed + 2 * kItems);
  EXPECT_GE(bits.ByteSizeLong(), 9 * kItems / 8);

  auto tile = about<v1::RenderTileRequest>(scene);
  set_rect(&tile, 40, 25);
  tile.mutable_accuracy()->set_samples(1);
  auto picture = service.answer(tile);
  expect_bounded(picture, tile_size({}, false), 40 * 25);
  tile.set_intervals(true);
  picture = service.answer(tile);
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
  expect_limit(answer_size(li(scene_, 1)), "receivers times accuracy.samples",
               [&](int n) { return service_.status(li(scene_, n)); });
  expect_limit(answer_size(le(scene_, 1)), "points",
               [&](int n) { return service_.status(le(scene_, n)); });
  expect_limit(answer_size(emit(scene_, 1)), "count",
               [&](int n) { return service_.status(emit(scene_, n)); });
}

TEST_F(MessageLimits, LimitSharesByTheNumberOfLights) {
  const AnswerSize size = answer_size(irradiance(scene_, 1), kLights);
  // Illuminance and its error of each light.
  EXPECT_GE(size.per_item, 8 * kLights);
  const auto call = [&](int n) { return service_.status(irradiance(scene_, n)); };
  expect_limit(size, "receivers", call);
}

TEST_F(MessageLimits, LimitTiles) {
  auto q = about<v1::RenderTileRequest>(scene_);
  q.mutable_accuracy()->set_samples(1);
  set_rect(&q, 160, 6);
  // 48 bytes per pixel: 960 pixels and 1120.
  auto r = service_.answer(q);
  q.mutable_rect()->set_y1(7);
  expect_error(service_.call(q, &r), grpc::StatusCode::RESOURCE_EXHAUSTED,
               "pixels of rect (48 bytes each in the answer) = 1120");
  auto image = about<v1::RenderImageRequest>(scene_);
  image.mutable_accuracy()->set_samples(1);
  image.set_tile_size(64);
  expect_error(service_.status(image), grpc::StatusCode::RESOURCE_EXHAUSTED, "pixels of a tile");
}

TEST_F(MessageLimits, ShortenPagesOfPowers) {
  auto q = spectral<v1::EstimatePowerRequest>(scene_);
  std::vector<std::uint64_t> ids;
  int pages = 0;
  do {
    const auto r = service_.answer(q);
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
  expect_error(service.status(emit(scene, 1 << 24)), grpc::StatusCode::RESOURCE_EXHAUSTED,
               "count (587 bytes each in the answer) = 16777216");
  v1::SampleLiRequest q = li(scene, 1);
  q.mutable_accuracy()->set_samples(1 << 24);
  EXPECT_EQ(service.status(q).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace lucerna::testing
