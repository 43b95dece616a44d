// Batches of Le, SampleLe and PdfLe: requests are split, answers joined.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/library/batch_parts.h"
#include "client/library/batches.h"
#include "tests/client/library/fake_server.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Batches, RaysOfLeAreSplitAndTheirAnswersJoined) {
  v1::LeRequest request;
  request.set_scene_id("s");
  request.set_light_id(3);
  request.set_time_s(0.5);
  request.add_wavelengths_nm(555);
  request.mutable_points()->mutable_origin_m()->set_y(4);
  for (int i = 0; i < 9; ++i) {
    request.mutable_points()->add_offsets_m(static_cast<float>(i));
    request.add_directions(static_cast<float>(10 + i));
  }
  ASSERT_EQ(client::item_count(request), 3U);
  const v1::LeRequest part = client::part(request, 1, 2);
  EXPECT_THAT(part.points().offsets_m(), ElementsAre(3, 4, 5, 6, 7, 8));
  EXPECT_THAT(part.directions(), ElementsAre(13, 14, 15, 16, 17, 18));
  EXPECT_EQ(part.points().origin_m().y(), 4);
  EXPECT_EQ(part.light_id(), 3U);
  EXPECT_EQ(part.time_s(), 0.5);
  EXPECT_THAT(part.wavelengths_nm(), ElementsAre(555));
  request.add_directions(1);
  EXPECT_EQ(client::item_count(request), 0U);

  v1::LeResponse next, whole;
  for (int i = 0; i < 3; ++i) next.add_radiance_cd_m2(static_cast<float>(i));
  next.add_light_ids(2);
  next.add_spectral_radiance(8);
  client::append(next, &whole);
  next.add_status(v1::ITEM_STATUS_OUT_OF_RANGE);
  client::append(next, &whole);
  EXPECT_THAT(whole.radiance_cd_m2(), ElementsAre(0, 1, 2, 0, 1, 2));
  EXPECT_THAT(whole.light_ids(), ElementsAre(2, 2));
  EXPECT_THAT(whole.spectral_radiance(), ElementsAre(8, 8));
  EXPECT_THAT(whole.status(), ElementsAre(v1::ITEM_STATUS_OK, v1::ITEM_STATUS_OUT_OF_RANGE));
}

/// Three rays of u = 0, 1, 2, ...
v1::SampleLeRequest own_values() {
  v1::SampleLeRequest request;
  request.set_scene_id("s");
  request.set_count(3);
  for (int i = 0; i < 12; ++i) request.mutable_u()->add_u(static_cast<float>(i));
  for (int i = 0; i < 3; ++i) request.mutable_u()->add_u_light(20 + i);
  return request;
}

TEST(Batches, SampleValuesOfSampleLeAreSplitByRays) {
  v1::SampleLeRequest request = own_values();
  request.set_light_name("desk");
  ASSERT_EQ(client::item_count(request), 3U);
  const v1::SampleLeRequest part = client::part(request, 1, 2);
  EXPECT_EQ(part.light_name(), "desk");
  EXPECT_EQ(part.scene_id(), "s");
  EXPECT_EQ(part.count(), 2U);
  EXPECT_THAT(part.u().u(), ElementsAre(4, 5, 6, 7, 8, 9, 10, 11));
  EXPECT_THAT(part.u().u_light(), ElementsAre(21, 22));
  EXPECT_FALSE(part.has_seed());
  EXPECT_FALSE(part.has_light_id());
  EXPECT_FALSE(part.has_time_s());
}

TEST(Batches, SeedOfSampleLeContinues) {
  v1::SampleLeRequest request;
  request.set_count(10);
  request.set_light_id(6);
  request.set_time_s(0.25);
  request.add_wavelengths_nm(555);
  request.mutable_accuracy()->set_samples(2);
  request.mutable_seed()->set_seed(9);
  request.mutable_seed()->set_first_item(100);
  ASSERT_EQ(client::item_count(request), 10U);
  const v1::SampleLeRequest part = client::part(request, 4, 3);
  EXPECT_EQ(part.count(), 3U);
  EXPECT_EQ(part.light_id(), 6U);
  EXPECT_EQ(part.time_s(), 0.25);
  EXPECT_THAT(part.wavelengths_nm(), ElementsAre(555));
  EXPECT_EQ(part.accuracy().samples(), 2U);
  EXPECT_EQ(part.seed().seed(), 9U);
  EXPECT_EQ(part.seed().first_item(), 104U);
}

TEST(Batches, SampleValuesThatDoNotMatchAreSentUnchanged) {
  v1::SampleLeRequest request = own_values();
  request.mutable_u()->add_u(1);
  EXPECT_EQ(client::item_count(request), 0U);
  request = own_values();
  request.mutable_u()->add_u_light(1);
  EXPECT_EQ(client::item_count(request), 0U);
  request = own_values();
  request.mutable_u()->clear_u_light();  // for a light that is named
  EXPECT_EQ(client::item_count(request), 3U);
}

TEST(Batches, AnswersOfSampleLeAreJoined) {
  v1::SampleLeResponse next, whole;
  next.mutable_points()->mutable_origin_m()->set_x(100);
  for (int i = 0; i < 3; ++i) {
    next.mutable_points()->add_offsets_m(static_cast<float>(i));
    next.add_directions(static_cast<float>(10 + i));
    next.add_light_normals(static_cast<float>(20 + i));
    next.add_value(static_cast<float>(30 + i));
  }
  next.add_pdf_position_per_m2(4);
  next.add_pdf_direction_per_sr(5);
  next.add_light_ids(6);
  next.add_selection_probability(0.5);
  next.add_spectral_value(7);
  next.mutable_cost()->set_samples(1);
  client::append(next, &whole);
  next.add_status(v1::ITEM_STATUS_BLACK);
  client::append(next, &whole);
  EXPECT_EQ(whole.points().origin_m().x(), 100);
  EXPECT_THAT(whole.points().offsets_m(), ElementsAre(0, 1, 2, 0, 1, 2));
  EXPECT_THAT(whole.directions(), ElementsAre(10, 11, 12, 10, 11, 12));
  EXPECT_THAT(whole.light_normals(), ElementsAre(20, 21, 22, 20, 21, 22));
  EXPECT_THAT(whole.value(), ElementsAre(30, 31, 32, 30, 31, 32));
  EXPECT_THAT(whole.pdf_position_per_m2(), ElementsAre(4, 4));
  EXPECT_THAT(whole.pdf_direction_per_sr(), ElementsAre(5, 5));
  EXPECT_THAT(whole.light_ids(), ElementsAre(6, 6));
  EXPECT_THAT(whole.selection_probability(), ElementsAre(0.5, 0.5));
  EXPECT_THAT(whole.spectral_value(), ElementsAre(7, 7));
  EXPECT_THAT(whole.status(), ElementsAre(v1::ITEM_STATUS_OK, v1::ITEM_STATUS_BLACK));
  EXPECT_EQ(whole.cost().samples(), 2U);
}

TEST(Batches, RaysOfPdfLeAreSplitAndTheirAnswersJoined) {
  v1::PdfLeRequest request;
  request.set_scene_id("s");
  request.set_light_id(3);
  request.set_time_s(0.5);
  request.mutable_accuracy()->set_samples(2);
  request.mutable_points()->mutable_origin_m()->set_y(4);
  for (int i = 0; i < 9; ++i) {
    request.mutable_points()->add_offsets_m(static_cast<float>(i));
    request.add_directions(static_cast<float>(10 + i));
  }
  ASSERT_EQ(client::item_count(request), 3U);
  const v1::PdfLeRequest part = client::part(request, 1, 2);
  EXPECT_EQ(part.scene_id(), "s");
  EXPECT_EQ(part.light_id(), 3U);
  EXPECT_EQ(part.time_s(), 0.5);
  EXPECT_EQ(part.accuracy().samples(), 2U);
  EXPECT_EQ(part.points().origin_m().y(), 4);
  EXPECT_THAT(part.points().offsets_m(), ElementsAre(3, 4, 5, 6, 7, 8));
  EXPECT_THAT(part.directions(), ElementsAre(13, 14, 15, 16, 17, 18));
  request.add_directions(1);
  EXPECT_EQ(client::item_count(request), 0U);

  v1::PdfLeResponse next, whole;
  next.add_pdf_position_per_m2(1);
  next.add_pdf_direction_per_sr(2);
  next.mutable_cost()->set_cpu_time_s(0.5);
  client::append(next, &whole);
  EXPECT_THAT(whole.status(), IsEmpty());
  next.add_status(v1::ITEM_STATUS_INVALID_INPUT);
  client::append(next, &whole);
  EXPECT_THAT(whole.pdf_position_per_m2(), ElementsAre(1, 1));
  EXPECT_THAT(whole.pdf_direction_per_sr(), ElementsAre(2, 2));
  EXPECT_THAT(whole.status(), ElementsAre(v1::ITEM_STATUS_OK, v1::ITEM_STATUS_INVALID_INPUT));
  EXPECT_EQ(whole.cost().cpu_time_s(), 1);
}

TEST(Batches, LongRequestsForRaysAreSentInParts) {
  FakeServer server;
  std::vector<std::uint64_t> first_items;
  std::vector<std::uint32_t> counts;
  server.sample_le = [&](auto&, const v1::SampleLeRequest& request,
                         v1::SampleLeResponse* response) {
    first_items.push_back(request.seed().first_item());
    counts.push_back(request.count());
    for (std::uint32_t i = 0; i < request.count(); ++i) response->add_pdf_direction_per_sr(1);
    return grpc::Status::OK;
  };
  v1::SampleLeRequest request;
  request.set_count(11);
  request.mutable_seed()->set_first_item(100);
  const auto split = sample_le_in_batches(server.client(), request, {.max_items = 4, .call = {}});
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_THAT(first_items, ElementsAre(100, 104, 108));
  EXPECT_THAT(counts, ElementsAre(4, 4, 3));
  EXPECT_EQ(split->pdf_direction_per_sr_size(), 11);
}

}  // namespace
}  // namespace lucerna
