// Samples to a target error or with a time budget, in batches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/library/batches.h"
#include "tests/client/library/fake_server.h"

namespace lucerna {
namespace {

using client::BatchOptions;
using client::sample_li_in_batches;
using ::testing::ElementsAre;

TEST(Batches, SamplesToATargetCountWithTheirMaximum) {
  FakeServer server;
  std::vector<std::uint64_t> first_items, most;
  server.sample_li = [&](auto&, const v1::SampleLiRequest& request,
                         v1::SampleLiResponse* response) {
    first_items.push_back(request.seed().first_item());
    most.push_back(request.accuracy().target_error().max_samples());
    v1::ReceiverEstimates* e = response->mutable_estimates();
    const int receivers = request.receivers().offsets_m_size() / 3;
    for (int i = 0; i < receivers; ++i) {
      const auto item = static_cast<float>(request.seed().first_item()) + static_cast<float>(i);
      response->add_pdf_per_sr(1);
      e->add_samples(1);
      e->add_illuminance_lx(item);
      e->add_standard_error_lx(item / 10);
      e->add_lower_lx(item - 1);
      e->add_upper_lx(item + 1);
      e->add_spectral_irradiance(item);
      e->add_spectral_standard_error(item);
    }
    if (first_items.size() == 2 && receivers == 2) {
      e->add_status(v1::ITEM_STATUS_OUT_OF_RANGE);
      e->add_status(v1::ITEM_STATUS_OK);
    }
    return grpc::Status::OK;
  };
  v1::SampleLiRequest request;
  for (int i = 0; i < 15; ++i) request.mutable_receivers()->add_offsets_m(1);
  request.add_wavelengths_nm(550);
  request.mutable_seed();
  request.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  request.mutable_accuracy()->mutable_target_error()->set_max_samples(64);
  const BatchOptions options{.max_items = 128, .call = {}};
  const auto split = sample_li_in_batches(server.client(), request, options);
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_THAT(first_items, ElementsAre(0, 2, 4));
  EXPECT_THAT(most, ElementsAre(64, 64, 64));
  const v1::ReceiverEstimates& e = split->estimates();
  EXPECT_THAT(e.samples(), ElementsAre(1, 1, 1, 1, 1));
  EXPECT_THAT(e.illuminance_lx(), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(e.lower_lx(), ElementsAre(-1, 0, 1, 2, 3));
  EXPECT_THAT(e.upper_lx(), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(e.standard_error_lx_size(), 5);
  EXPECT_THAT(e.spectral_irradiance(), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(e.spectral_standard_error(), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(e.status(),
              ElementsAre(v1::ITEM_STATUS_OK, v1::ITEM_STATUS_OK, v1::ITEM_STATUS_OUT_OF_RANGE,
                          v1::ITEM_STATUS_OK, v1::ITEM_STATUS_OK));

  // By default each receiver may have as many samples as in a request of its own.  A time budget
  // makes one request.
  server.max_batch_items = 1000;
  first_items.clear(), most.clear();
  request.mutable_accuracy()->mutable_target_error()->clear_max_samples();
  ASSERT_TRUE(sample_li_in_batches(server.client(), request).ok());
  EXPECT_THAT(first_items, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(most, ::testing::Each(1000));
  first_items.clear();
  request.mutable_accuracy()->set_time_budget_s(1);
  ASSERT_TRUE(sample_li_in_batches(server.client(), request, options).ok());
  EXPECT_THAT(first_items, ElementsAre(0));
}

}  // namespace
}  // namespace lucerna
