// Answers of a broken server, by the public client.
#include "client/library/answer_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <future>
#include <limits>
#include <string>
#include <vector>

#include "client/library/batches.h"
#include "tests/client/library/fake_server.h"

namespace lucerna {
namespace {

using client::check_answer;
using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void expect_broken(const absl::Status& status, const std::string& what) {
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("the server broke the protocol: "));
  EXPECT_THAT(std::string(status.message()), HasSubstr(what));
}

class AnswerChecks : public ::testing::Test {
 protected:
  AnswerChecks() {
    server_.completes_answers = false;
    for (int i = 0; i < 6; ++i) {
      irradiance_.mutable_receivers()->add_offsets_m(0);
      irradiance_.add_normals(1);
    }
    server_.irradiance = [this](auto&, auto&, v1::EstimateIrradianceResponse* response) {
      *response = answer_;
      return grpc::Status::OK;
    };
    answer_.mutable_irradiance_lx()->Resize(6, 1);
    answer_.mutable_illuminance_lx()->Resize(2, 1);
    answer_.mutable_zero_bound_lx()->Resize(2, 0);
  }
  absl::Status ask() { return server_.client().estimate_irradiance(irradiance_).status(); }

  FakeServer server_;
  v1::EstimateIrradianceRequest irradiance_;
  v1::EstimateIrradianceResponse answer_;
};

TEST_F(AnswerChecks, AnArrayOfAnotherLengthIsBroken) {
  EXPECT_TRUE(ask().ok()) << ask();
  answer_.mutable_illuminance_lx()->Resize(1, 1);
  expect_broken(ask(), "EstimateIrradianceResponse.illuminance_lx: has 1 entries, must be 2");
  answer_.mutable_illuminance_lx()->Resize(3, 1);
  expect_broken(ask(), "illuminance_lx: has 3 entries, must be 2");
  answer_.mutable_illuminance_lx()->Resize(2, 1);
  answer_.mutable_status()->Resize(1, v1::ITEM_STATUS_OK);
  expect_broken(ask(), "status: has 1 entries, must be 2 or 0");
  answer_.mutable_status()->Clear();
  answer_.mutable_lower_lx()->Resize(2, 0);
  expect_broken(ask(), "upper_lx: has 0 entries, must be 2");
}

TEST_F(AnswerChecks, ANumberThatIsNotFiniteIsBroken) {
  answer_.set_irradiance_lx(4, kNan);
  expect_broken(ask(), "irradiance_lx: has a number that is not finite");
  answer_.set_irradiance_lx(4, 1);
  answer_.mutable_cost()->set_cpu_time_s(kInfinity);
  expect_broken(ask(), "Cost.cpu_time_s: has a number that is not finite");
}

TEST_F(AnswerChecks, SharesThatNobodyRequestedAreBroken) {
  answer_.add_shares()->mutable_illuminance_lx()->Resize(2, 1);
  expect_broken(ask(), "shares: was not requested");
  irradiance_.set_per_light(true);
  EXPECT_TRUE(ask().ok()) << ask();
}

TEST_F(AnswerChecks, CallsWithoutABlockingFormCheckToo) {
  answer_.mutable_illuminance_lx()->Clear();
  std::promise<absl::Status> done;
  const client::Client client = server_.client();
  client.estimate_irradiance(irradiance_, {},
                             [&](const auto& answer) { done.set_value(answer.status()); });
  expect_broken(done.get_future().get(), "illuminance_lx: has 0 entries");
}

TEST_F(AnswerChecks, ABatchWithoutAnArrayOfTheOthersIsBroken) {
  bool first = true;
  server_.irradiance = [&](auto&, auto&, v1::EstimateIrradianceResponse* response) {
    response->mutable_irradiance_lx()->Resize(3, 1);
    response->mutable_illuminance_lx()->Resize(1, 1);
    response->mutable_zero_bound_lx()->Resize(1, 0);
    if (first) response->mutable_standard_error_lx()->Resize(1, 0);
    first = false;
    return grpc::Status::OK;
  };
  expect_broken(client::estimate_irradiance_in_batches(server_.client(), irradiance_,
                                                       {.max_items = 1, .call = {}})
                    .status(),
                "standard_error_lx: has 1 entries, must be 2 or 0");
}

TEST_F(AnswerChecks, SamplesMustBeThoseOfTheRequest) {
  v1::SampleLiRequest request;
  request.mutable_receivers()->mutable_offsets_m()->Resize(3, 0);
  request.set_light_id(1);
  server_.sample_li = [](auto&, auto&, v1::SampleLiResponse* response) {
    response->mutable_value()->Resize(3, 1);
    return grpc::Status::OK;
  };
  expect_broken(server_.client().sample_li(request).status(), "wi: has 0 entries, must be 3");
}

TEST_F(AnswerChecks, AListMustHaveAnEnd) {
  v1::ListLightsRequest request;
  request.set_page_token("b");
  v1::ListLightsResponse answer;
  answer.set_next_page_token("c");
  expect_broken(check_answer(request, answer), "ListLightsResponse.next_page_token");
  answer.add_lights();
  EXPECT_TRUE(check_answer(request, answer).ok());
  answer.set_next_page_token("b");
  expect_broken(check_answer(request, answer), "the list has no end");
  answer.set_next_page_token("");
  answer.mutable_lights(0)->set_power_lm(kInfinity);
  expect_broken(check_answer(request, answer), "Light.power_lm");
}

TEST_F(AnswerChecks, FilesThatNobodyOfferedAreBroken) {
  v1::FindMissingAssetsRequest request;
  request.add_sha256("a");
  v1::FindMissingAssetsResponse answer;
  answer.add_missing_sha256("a");
  expect_broken(check_answer(request, answer), "received_bytes: has 0 entries, must be 1");
  answer.add_received_bytes(0);
  EXPECT_TRUE(check_answer(request, answer).ok());
  answer.set_missing_sha256(0, "b");
  expect_broken(check_answer(request, answer), "missing_sha256");
}

v1::RenderImageResponse tile_at(std::uint32_t x, std::uint64_t blocks) {
  v1::RenderImageResponse response;
  v1::Tile& tile = *response.mutable_tile();
  tile.mutable_rect()->set_x0(x);
  tile.mutable_rect()->set_x1(x + 1);
  tile.mutable_rect()->set_y1(1);
  tile.set_image_width(2);
  tile.set_image_height(1);
  tile.set_block_count(blocks);
  tile.set_sum(std::string(3 * sizeof(double), '\0'));
  tile.set_deviation(tile.sum());
  return response;
}

/// The status of a picture of these responses.  `for_ever`: the server never
/// stops sending the last one.
absl::Status picture_of(std::vector<v1::RenderImageResponse> responses, bool for_ever = false) {
  FakeServer server;
  server.render_image = [&](grpc::ServerContext& context,
                            grpc::ServerWriter<v1::RenderImageResponse>& writer) {
    for (const v1::RenderImageResponse& response : responses) writer.Write(response);
    while (for_ever && !context.IsCancelled() && writer.Write(responses.back())) continue;
    return grpc::Status::OK;
  };
  return server.client().render_image({}, [](const auto&) { return true; });
}

TEST(ImageCheck, EqualTilesEndTheCall) {
  expect_broken(picture_of({tile_at(0, 1)}, true), "came again without more blocks");
}

TEST(ImageCheck, TilesMustCoverThePicture) {
  EXPECT_TRUE(picture_of({tile_at(0, 1), tile_at(0, 2), tile_at(1, 1)}).ok());
  expect_broken(picture_of({tile_at(0, 1)}), "the picture ended with 1 of 2 pixels");
  expect_broken(picture_of({}), "the picture ended with 0 of 0 pixels");
}

TEST(ImageCheck, ThePictureKeepsItsSize) {
  v1::RenderImageResponse other = tile_at(1, 1);
  other.mutable_tile()->set_image_width(3);
  expect_broken(picture_of({tile_at(0, 1), other}), "the size of the picture changed");
}

TEST(ImageCheck, PixelsMustBeFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, 1e39, -1e39}) {
    v1::RenderImageResponse response = tile_at(0, 1);
    std::memcpy(response.mutable_tile()->mutable_sum()->data() + 8, &bad, sizeof bad);
    expect_broken(picture_of({response}), "a number that is not finite or too large");
  }
  v1::RenderImageResponse response = tile_at(0, 2);
  const double negative = -1;
  std::memcpy(response.mutable_tile()->mutable_deviation()->data(), &negative, sizeof negative);
  expect_broken(picture_of({response}), "a number that is not finite or too large");
}

TEST_F(AnswerChecks, ATileMustBeTheOneRequested) {
  v1::RenderTileRequest request;
  request.mutable_rect()->set_x1(1);
  request.mutable_rect()->set_y1(1);
  request.mutable_accuracy()->set_samples(4);
  v1::RenderTileResponse answer;
  *answer.mutable_tile() = tile_at(0, 4).tile();
  answer.mutable_tile()->set_samples_per_block(1);
  EXPECT_TRUE(check_answer(request, answer).ok()) << check_answer(request, answer);
  answer.mutable_tile()->set_block_count(2);
  expect_broken(check_answer(request, answer), "others than requested");
  *answer.mutable_tile()->mutable_rect() = tile_at(1, 4).tile().rect();
  expect_broken(check_answer(request, answer), "requested was tile [0, 1) x [0, 1)");
}

}  // namespace
}  // namespace lucerna
