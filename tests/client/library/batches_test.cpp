#include "client/library/batches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/library/batch_parts.h"
#include "tests/client/library/fake_server.h"

namespace lucerna {
namespace {

using client::append_bits;
using client::BatchOptions;
using client::bit;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Bits, AreAppendedAtAnyPosition) {
  // 1, 0, 1 after 0 1 1 0 1 1 0 (seven bits: 0b0110110): bits 7 and 9 are set too.
  std::string whole(1, '\x36');
  append_bits(std::string(1, '\x05'), 3, 7, &whole);
  EXPECT_EQ(whole, std::string("\xb6\x02", 2));
}

TEST(Bits, BeyondTheCountAreIgnored) {
  std::string whole;
  append_bits(std::string(1, '\xff'), 2, 0, &whole);
  EXPECT_EQ(whole, std::string(1, '\x03'));
  EXPECT_FALSE(bit(whole, 2));
  EXPECT_FALSE(bit(whole, 800));
}

v1::EstimateIrradianceRequest irradiance_request(int items) {
  v1::EstimateIrradianceRequest request;
  request.set_scene_id("s");
  request.mutable_receivers()->mutable_origin_m()->set_x(1000);
  for (int i = 0; i < 3 * items; ++i) {
    request.mutable_receivers()->add_offsets_m(static_cast<float>(i));
    request.add_normals(static_cast<float>(-i));
  }
  request.set_bounces(2);
  request.set_per_light(true);
  request.mutable_seed()->set_seed(9);
  request.mutable_seed()->set_first_item(100);
  request.mutable_accuracy()->set_samples(64);
  return request;
}

/// Answers each item with its number in the whole set and the x of its point; item 103 is invalid.
grpc::Status answer(grpc::ServerContext&, const v1::EstimateIrradianceRequest& request,
                    v1::EstimateIrradianceResponse* response) {
  const int items = request.normals_size() / 3;
  v1::LightShare* share = response->add_shares();
  share->set_light_id(4);
  for (int i = 0; i < items; ++i) {
    const auto number = static_cast<int>(request.seed().first_item()) + i;
    response->add_illuminance_lx(static_cast<float>(number));
    response->add_zero_bound_lx(0);
    response->add_standard_error_lx(request.receivers().offsets_m(3 * i));
    for (int c = 0; c < 3; ++c) response->add_irradiance_lx(request.normals(3 * i + c));
    share->add_illuminance_lx(static_cast<float>(number) / 2);
    if (number == 103) {
      response->mutable_status()->Resize(items, v1::ITEM_STATUS_OK);
      response->set_status(i, v1::ITEM_STATUS_INVALID_INPUT);
    }
  }
  response->set_samples(request.accuracy().samples());
  response->mutable_cost()->set_samples(items * 64ULL);
  return grpc::Status::OK;
}

/// A scene with this many lights.
auto scene_of(std::uint64_t lights) {
  return [lights](auto&, const v1::GetSceneRequest& request, v1::GetSceneResponse* response) {
    EXPECT_EQ(request.scene_id(), "s");
    response->mutable_summary()->set_lights(lights);
    return grpc::Status::OK;
  };
}

TEST(Batches, SplitIrradianceIsTheAnswerToTheWhole) {
  FakeServer server;
  server.get_scene = scene_of(1);
  std::vector<int> sizes;
  server.irradiance = [&](auto& context, const auto& request, auto* response) {
    EXPECT_EQ(request.receivers().origin_m().x(), 1000);
    EXPECT_EQ(request.bounces(), 2U);
    EXPECT_TRUE(request.per_light());
    EXPECT_EQ(request.seed().seed(), 9U);
    sizes.push_back(request.normals_size() / 3);
    return answer(context, request, response);
  };
  const client::Client client = server.client();
  const auto request = irradiance_request(11);
  const auto whole = client.estimate_irradiance(request);
  ASSERT_TRUE(whole.ok()) << whole.status();
  sizes.clear();
  const auto split = estimate_irradiance_in_batches(client, request, {.max_items = 4, .call = {}});
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_THAT(sizes, ElementsAre(4, 4, 3));
  EXPECT_EQ(split->SerializeAsString(), whole->SerializeAsString());
  EXPECT_EQ(split->status(3), v1::ITEM_STATUS_INVALID_INPUT);
  EXPECT_EQ(split->cost().samples(), 11U * 64);
}

TEST(Batches, GetTheServersLimitForManyItems) {
  FakeServer server;
  server.max_batch_items = 700;
  server.get_scene = scene_of(1);
  std::vector<int> sizes;
  server.irradiance = [&](auto& context, const auto& request, auto* response) {
    sizes.push_back(request.normals_size() / 3);
    return answer(context, request, response);
  };
  const client::Client client = server.client();
  ASSERT_TRUE(estimate_irradiance_in_batches(client, irradiance_request(1024)).ok());
  EXPECT_EQ(server.info_calls, 0);
  EXPECT_THAT(sizes, ElementsAre(1024));
  sizes.clear();
  ASSERT_TRUE(estimate_irradiance_in_batches(client, irradiance_request(1500)).ok());
  EXPECT_EQ(server.info_calls, 1);
  EXPECT_THAT(sizes, ElementsAre(700, 700, 100));
}

TEST(Batches, StopAtTheFirstError) {
  FakeServer server;
  server.get_scene = scene_of(1);
  int calls = 0;
  server.irradiance = [&](auto& context, const auto& request, auto* response) {
    return ++calls == 2 ? grpc::Status(grpc::StatusCode::NOT_FOUND, "gone")
                        : answer(context, request, response);
  };
  const auto split = estimate_irradiance_in_batches(server.client(), irradiance_request(11),
                                                    {.max_items = 4, .call = {}});
  EXPECT_EQ(split.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(calls, 2);
}

// Each receiver's answer has 3000 lights and 128 wavelengths: 24.5 kB.
TEST(Batches, WithManyLightsAndWavelengthsFitTheServersMessages) {
  constexpr int kLights = 3000, kReceivers = 200;
  FakeServer server;
  server.max_message_bytes = 2000000;
  server.max_batch_items = 65536;
  server.get_scene = scene_of(kLights);
  int receivers = 0, batches = 0;
  server.irradiance = [&](auto&, const v1::EstimateIrradianceRequest& request,
                          v1::EstimateIrradianceResponse* response) {
    const int n = request.normals_size() / 3;
    EXPECT_EQ(request.wavelengths_nm_size(), 128);
    EXPECT_EQ(request.seed().first_item(), 100U + receivers);
    response->mutable_irradiance_lx()->Resize(3 * n, 1);
    for (auto* array : {response->mutable_illuminance_lx(), response->mutable_standard_error_lx(),
                        response->mutable_zero_bound_lx(), response->mutable_lower_lx(),
                        response->mutable_upper_lx()}) {
      array->Resize(n, 1);
    }
    response->mutable_spectral_irradiance()->Resize(128 * n, 1);
    response->mutable_spectral_standard_error()->Resize(128 * n, 1);
    response->mutable_status()->Resize(n, v1::ITEM_STATUS_OUT_OF_RANGE);
    for (int l = 0; l < kLights; ++l) {
      v1::LightShare* share = response->add_shares();
      share->set_light_id(l + 1);
      for (auto* array : {share->mutable_illuminance_lx(), share->mutable_standard_error_lx(),
                          share->mutable_lower_lx(), share->mutable_upper_lx()})
        array->Resize(n, 1);
    }
    EXPECT_LE(response->ByteSizeLong(), server.max_message_bytes);
    // There are not many more batches than necessary.
    receivers += n;
    if (receivers < kReceivers) {
      EXPECT_GT(response->ByteSizeLong(), 0.9 * server.max_message_bytes);
    }
    ++batches;
    return grpc::Status::OK;
  };
  v1::EstimateIrradianceRequest request = irradiance_request(kReceivers);
  for (int i = 0; i < 128; ++i) request.add_wavelengths_nm(400 + i);
  const client::Client client = server.client();
  const auto split = estimate_irradiance_in_batches(client, request);
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(receivers, kReceivers);
  EXPECT_EQ(batches, 6);
  EXPECT_EQ(split->shares(kLights - 1).illuminance_lx_size(), kReceivers);
  // Also with a given number of items per batch.
  receivers = batches = 0;
  ASSERT_TRUE(estimate_irradiance_in_batches(client, request, {.max_items = 1000}).ok());
  EXPECT_EQ(batches, 6);
  // A receiver with a larger answer is sent alone, and the server decides.
  server.get_scene = scene_of(1000000);
  server.irradiance = [&](auto&, const v1::EstimateIrradianceRequest& one, auto*) {
    EXPECT_EQ(one.normals_size(), 3);
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "too large");
  };
  EXPECT_EQ(estimate_irradiance_in_batches(client, request).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(Batches, WithManyWavelengthsFitTheServersMessages) {
  FakeServer server;
  server.max_message_bytes = 1 << 20;
  server.max_batch_items = 65536;
  std::vector<int> sizes;
  server.sample_li = [&](auto&, const v1::SampleLiRequest& request,
                         v1::SampleLiResponse* response) {
    const int n = 4 * (request.receivers().offsets_m_size() / 3);
    sizes.push_back(n / 4);
    response->mutable_pdf_per_sr()->Resize(n, 1);
    response->mutable_distance_m()->Resize(n, 1);
    for (auto* array : {response->mutable_value(), response->mutable_wi(),
                        response->mutable_light_offsets_m(), response->mutable_light_normals()}) {
      array->Resize(3 * n, 1);
    }
    response->mutable_light_ids()->Resize(n, ~std::uint64_t{0});
    response->mutable_selection_probability()->Resize(n, 1);
    response->mutable_status()->Resize(n, v1::ITEM_STATUS_BEHIND);
    response->set_delta(std::string((n + 7) / 8, '\0'));
    response->set_visible(std::string((n + 7) / 8, '\0'));
    response->mutable_spectral_value()->Resize(128 * n, 1);
    EXPECT_LE(response->ByteSizeLong(), server.max_message_bytes);
    return grpc::Status::OK;
  };
  v1::SampleLiRequest request;
  request.mutable_receivers()->mutable_offsets_m()->Resize(3 * 1000, 1);
  request.mutable_seed();
  request.set_test_visibility(true);
  request.mutable_accuracy()->set_samples(4);
  request.mutable_wavelengths_nm()->Resize(128, 555);
  ASSERT_TRUE(sample_li_in_batches(server.client(), request).ok());
  // 4 samples of 601 bytes: 435 receivers take 1045740 of 1048576 bytes; other fields take 2 kB.
  EXPECT_THAT(sizes, ElementsAre(435, 435, 130));
  EXPECT_EQ(server.info_calls, 1);
}

TEST(Batches, ArraysThatDoNotMatchAreSentUnchanged) {
  FakeServer server;
  int calls = 0;
  server.irradiance = [&](auto&, const v1::EstimateIrradianceRequest& request, auto*) {
    ++calls;
    EXPECT_EQ(request.normals_size(), 32);
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "normals");
  };
  auto request = irradiance_request(11);
  request.mutable_normals()->RemoveLast();
  const auto split =
      estimate_irradiance_in_batches(server.client(), request, {.max_items = 4, .call = {}});
  EXPECT_EQ(split.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(calls, 1);
}

TEST(Batches, SamplesCountAgainstTheLimitOfSampleLi) {
  FakeServer server;
  std::vector<std::uint64_t> first_items;
  server.sample_li = [&](auto&, const v1::SampleLiRequest& request,
                         v1::SampleLiResponse* response) {
    first_items.push_back(request.seed().first_item());
    const int receivers = request.receivers().offsets_m_size() / 3;
    EXPECT_EQ(request.normals_size(), 3 * receivers);
    for (int i = 0; i < receivers * 3; ++i) response->add_pdf_per_sr(1);
    // All delta; only the first is visible.
    response->set_delta(std::string((receivers * 3 + 7) / 8, '\xff'));
    std::string visible((receivers * 3 + 7) / 8, '\0');
    visible[0] = '\1';
    response->set_visible(visible);
    return grpc::Status::OK;
  };
  v1::SampleLiRequest request;
  for (int i = 0; i < 15; ++i) {
    request.mutable_receivers()->add_offsets_m(1);
    request.add_normals(1);
  }
  request.mutable_seed()->set_seed(1);
  request.mutable_accuracy()->set_samples(3);
  const auto split = sample_li_in_batches(server.client(), request, {.max_items = 7, .call = {}});
  ASSERT_TRUE(split.ok()) << split.status();
  // 7 / 3 = 2 receivers per batch, of six samples.
  EXPECT_THAT(first_items, ElementsAre(0, 2, 4));
  EXPECT_EQ(split->pdf_per_sr_size(), 15);
  EXPECT_EQ(split->delta(), std::string("\xff\x7f", 2));
  // Bits 0, 6 and 12.
  EXPECT_EQ(split->visible(), std::string("\x41\x10", 2));
}

TEST(Batches, OwnSampleValuesGoWithTheirReceivers) {
  v1::SampleLiRequest request;
  for (int i = 0; i < 9; ++i) request.mutable_receivers()->add_offsets_m(static_cast<float>(i));
  for (int i = 0; i < 6; ++i) request.mutable_u()->add_u(static_cast<float>(i));
  for (int i = 0; i < 3; ++i) request.mutable_u()->add_u_light(i);
  ASSERT_EQ(client::item_count(request), 3U);
  const v1::SampleLiRequest part = client::part(request, 1, 2);
  EXPECT_THAT(part.receivers().offsets_m(), ElementsAre(3, 4, 5, 6, 7, 8));
  EXPECT_THAT(part.u().u(), ElementsAre(2, 3, 4, 5));
  EXPECT_THAT(part.u().u_light(), ElementsAre(1, 2));
  EXPECT_FALSE(part.has_seed());
}

TEST(Batches, DirectionsOfPdfLiGoWithTheirReceivers) {
  v1::PdfLiRequest request;
  for (int i = 0; i < 6; ++i) {
    request.mutable_receivers()->add_offsets_m(static_cast<float>(i));
    request.add_wi(static_cast<float>(10 + i));
    request.add_normals(static_cast<float>(20 + i));
  }
  ASSERT_EQ(client::item_count(request), 2U);
  EXPECT_THAT(client::part(request, 1, 1).wi(), ElementsAre(13, 14, 15));
  EXPECT_THAT(client::part(request, 1, 1).normals(), ElementsAre(23, 24, 25));
  request.clear_normals();
  EXPECT_EQ(client::item_count(request), 2U);
  EXPECT_THAT(client::part(request, 1, 1).normals(), IsEmpty());
  request.add_normals(1);
  EXPECT_EQ(client::item_count(request), 0U);  // the server reports the error
}

TEST(Batches, RaysAndSegmentsAreSplit) {
  v1::TestVisibilityRequest rays;
  v1::TestVisibilityRequest segments;
  for (int i = 0; i < 6; ++i) {
    rays.mutable_rays()->mutable_from()->add_offsets_m(static_cast<float>(i));
    rays.mutable_rays()->add_directions(static_cast<float>(10 + i));
    segments.mutable_segments()->mutable_from()->add_offsets_m(static_cast<float>(i));
    segments.mutable_segments()->mutable_to()->add_offsets_m(static_cast<float>(20 + i));
  }
  rays.mutable_rays()->add_lengths_m(1);
  EXPECT_EQ(client::item_count(rays), 0U);  // one length for two rays
  rays.mutable_rays()->add_lengths_m(2);
  ASSERT_EQ(client::item_count(rays), 2U);
  EXPECT_THAT(client::part(rays, 1, 1).rays().directions(), ElementsAre(13, 14, 15));
  EXPECT_THAT(client::part(rays, 1, 1).rays().lengths_m(), ElementsAre(2));
  ASSERT_EQ(client::item_count(segments), 2U);
  EXPECT_THAT(client::part(segments, 1, 1).segments().to().offsets_m(), ElementsAre(23, 24, 25));
}

TEST(Parts, WavelengthsGoWithEachPartAndTheirValuesWithTheItems) {
  v1::SampleLiRequest li;
  li.add_wavelengths_nm(450);
  li.add_wavelengths_nm(555);
  for (int i = 0; i < 9; ++i) li.mutable_receivers()->add_offsets_m(static_cast<float>(i));
  EXPECT_THAT(client::part(li, 1, 2).wavelengths_nm(), ElementsAre(450, 555));
  v1::EstimateIrradianceRequest irradiance = irradiance_request(3);
  irradiance.add_wavelengths_nm(700);
  EXPECT_THAT(client::part(irradiance, 1, 2).wavelengths_nm(), ElementsAre(700));

  v1::SampleLiResponse next, whole;
  next.add_pdf_per_sr(1);
  next.add_spectral_value(3);
  next.add_spectral_value(4);
  client::append(next, &whole);
  client::append(next, &whole);
  EXPECT_THAT(whole.spectral_value(), ElementsAre(3, 4, 3, 4));
  v1::EstimateIrradianceResponse point, all;
  point.add_illuminance_lx(1);
  point.add_spectral_irradiance(5);
  client::append(point, &all);
  client::append(point, &all);
  EXPECT_THAT(all.spectral_irradiance(), ElementsAre(5, 5));
}

TEST(Batches, StatusStaysEmptyIfAllItemsAreOk) {
  v1::PdfLiResponse part;
  part.add_pdf_per_sr(1);
  v1::PdfLiResponse whole;
  client::append(part, &whole);
  client::append(part, &whole);
  EXPECT_THAT(whole.status(), IsEmpty());
  part.add_status(v1::ITEM_STATUS_DEGENERATE);
  client::append(part, &whole);
  part.clear_status();
  client::append(part, &whole);
  EXPECT_THAT(whole.status(), ElementsAre(v1::ITEM_STATUS_OK, v1::ITEM_STATUS_OK,
                                          v1::ITEM_STATUS_DEGENERATE, v1::ITEM_STATUS_OK));
}

}  // namespace
}  // namespace lucerna
