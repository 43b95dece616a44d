#include "client/cli/output.h"

#include <gtest/gtest.h>

#include "client/cli/progress.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna {
namespace {

using namespace std::chrono_literals;

TEST(Table, AlignsNumbersRightAndTextLeft) {
  cli::Table table({{"id"}, {"type", true}, {"± [lm]"}});
  table.add({"1", "point", "0.5"});
  table.add({"12", "spot", "1000.25"});
  EXPECT_EQ(table.to_string(),
            "id  type    ± [lm]\n"
            " 1  point      0.5\n"
            "12  spot   1000.25\n");
}

TEST(Table, OfNothingIsItsHeader) {
  EXPECT_EQ(cli::Table({{"id"}, {"", true}}).to_string(), "id\n");
}

TEST(Json, HasTheNamesOfTheContractAndAllPlainFields) {
  v1::LoadSceneResponse response;
  response.set_scene_id("ab");
  response.add_remarks()->set_line(3);
  // uint64 is a string in the JSON of protocol buffers, uint32 a number.
  response.mutable_cost()->set_samples(5);
  EXPECT_EQ(cli::to_json(response),
            R"({"scene_id":"ab","already_loaded":false,)"
            R"("remarks":[{"file":"","line":3,"column":0,"what":"","instead":""}],"missing":[],)"
            R"("cost":{"samples":"5","camera_rays":"0","indirect_rays":"0","shadow_rays":"0",)"
            R"("cpu_time_s":0,"wall_time_s":0,"queue_time_s":0,"shadow_map_lookups":"0",)"
            R"("shadow_map_compared":"0","shadow_map_disagreed":"0"},)"
            R"("lease_id":"","lease_s":0})"
            "\n");
}

TEST(Json, WritesFloatsThatReadBackTheSame) {
  v1::PdfLiResponse response;
  response.add_pdf_per_sr(0.1F);
  EXPECT_NE(cli::to_json(response).find(R"("pdf_per_sr":[0.1])"), std::string::npos);
}

TEST(Cost, TellsOfShadowMapsWhereTheyWereAsked) {
  v1::Cost cost;
  cost.set_wall_time_s(0.25);
  cost.set_shadow_rays(100);
  EXPECT_EQ(cli::describe(cost), "0.25 s, 100 rays");
  cost.set_shadow_map_lookups(6400);
  cost.set_shadow_map_compared(100);
  cost.set_shadow_map_disagreed(3);
  EXPECT_EQ(cli::describe(cost),
            "0.25 s, 100 rays, 6400 look-ups in shadow maps, of which 3 of 100 compared disagree "
            "with rays");
}

TEST(ItemStatus, IsNamedWithoutItsPrefix) {
  google::protobuf::RepeatedField<int> statuses;
  EXPECT_EQ(cli::item_status(statuses, 0), "");
  statuses.Add(v1::ITEM_STATUS_OK);
  statuses.Add(v1::ITEM_STATUS_INVALID_INPUT);
  statuses.Add(99);
  EXPECT_EQ(cli::item_status(statuses, 0), "");
  EXPECT_EQ(cli::item_status(statuses, 1), "INVALID_INPUT");
  EXPECT_EQ(cli::item_status(statuses, 2), "status 99");
}

TEST(ItemStatus, NoLightIsAnAnswerAndNoAnswerIsNot) {
  const auto failed = [](v1::ItemStatus status) {
    google::protobuf::RepeatedField<int> statuses;
    statuses.Add(v1::ITEM_STATUS_OK);
    statuses.Add(status);
    return cli::any_failed(statuses);
  };
  EXPECT_FALSE(failed(v1::ITEM_STATUS_BEHIND));
  EXPECT_FALSE(failed(v1::ITEM_STATUS_OUTSIDE_CONE));
  EXPECT_FALSE(failed(v1::ITEM_STATUS_BLACK));
  EXPECT_TRUE(failed(v1::ITEM_STATUS_DEGENERATE));
  EXPECT_TRUE(failed(v1::ITEM_STATUS_OUT_OF_RANGE));
  EXPECT_TRUE(failed(v1::ITEM_STATUS_INVALID_INPUT));
}

TEST(Progress, TellsPartAndTimeLeft) {
  EXPECT_EQ(cli::progress_line(0, 100, 5s), "[--------------------]   0%");
  // A quarter took 25 s, three quarters take 75 s.
  EXPECT_EQ(cli::progress_line(25, 100, 25s), "[#####---------------]  25%  ETA 1:15");
  EXPECT_EQ(cli::progress_line(100, 100, 5s), "[####################] 100%");
  EXPECT_EQ(cli::progress_line(999, 1000, 990s), "[###################-]  99%  ETA 0:01");
  EXPECT_EQ(cli::progress_line(0, 0, 5s), "[--------------------]   0%");
}

}  // namespace
}  // namespace lucerna
