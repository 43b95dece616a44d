#include "client/terminal/output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/terminal/certainty.h"
#include "client/terminal/progress.h"
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

TEST(Csv, HasNamesWithUnitsAndEveryDigit) {
  cli::Table table(
      {{"id"}, {"± [lm]"}, {"RGB [lx]", true}, {"value (RGB)"}, {"wi", true}, {"", true}});
  table.add({"1", cli::number_cell(1.0 / 3), cli::triple_cell(0.1F, 2.0F, 3e-9F),
             cli::triple_cell(1.0, 2.0, 3.0), cli::triple_cell(0.0, 0.0, 1.0), ""});
  table.add({"2", "exact", "", "", "", "NO_LIGHT"});
  EXPECT_EQ(table.to_csv(),
            "id,error [lm],R [lx],G [lx],B [lx],value R,value G,value B,wi x,wi y,wi z,status\n"
            "1,0.3333333333333333,0.1,2,3e-09,1,2,3,0,0,1,\n"
            "2,exact,,,,,,,,,,NO_LIGHT\n");
}

TEST(Table, IsPlainText) {
  cli::Table table({{"na\033[1mme", true}, {"n"}});
  table.add({"a\nb\033]0;title\007", "1"});
  EXPECT_EQ(table.to_string(),
            "na\\u001b[1mme                 n\n"
            "a\\u000ab\\u001b]0;title\\u0007  1\n");
}

TEST(Csv, QuotesWhatRfc4180Quotes) {
  cli::Table table({{"a, b"}, {"c"}});
  table.add({"say \"x\"", "two\nlines"});
  table.add({"plain text", ";"});
  EXPECT_EQ(table.to_csv(), "\"a, b\",c\n\"say \"\"x\"\"\",\"two\nlines\"\nplain text,;\n");
}

TEST(Csv, TakesTheNamesOfTheColumn) {
  cli::Table table({{"± [lx]", false, {"lower [lx]", "upper [lx]"}}});
  table.add({cli::Cell("0.5", {"1", "2"})});
  table.add({""});
  EXPECT_EQ(table.to_csv(), "lower [lx],upper [lx]\n1,2\n,\n");
}

TEST(Table, ColoursLeaveTheAlignment) {
  cli::Table table({{"id"}, {"", true}});
  table.add({"12", "NO_LIGHT"});
  table.add({"3", cli::Cell::coloured("ok", shell::Colour::kGood)});
  EXPECT_EQ(table.to_string(true),
            "\033[1mid\033[0m\n"
            "12  \033[33mNO_LIGHT\033[0m\n"
            " 3  \033[32mok\033[0m\n");
}

TEST(Json, HasLowerCamelCaseNamesAndAllPlainFields) {
  v1::LoadSceneResponse response;
  response.set_scene_id("ab");
  response.add_remarks()->set_line(3);
  // uint64 is a string in the JSON of protocol buffers, uint32 a number.
  response.mutable_cost()->set_samples(5);
  EXPECT_EQ(cli::to_json(response),
            R"({"sceneId":"ab","alreadyLoaded":false,)"
            R"("remarks":[{"file":"","line":3,"column":0,"what":"","instead":"","count":"0",)"
            R"("morePlaces":[]}],"missing":[],)"
            R"("cost":{"samples":"5","cameraRays":"0","indirectRays":"0","shadowRays":"0",)"
            R"("cpuTimeS":0,"wallTimeS":0,"queueTimeS":0,"shadowMapLookups":"0",)"
            R"("shadowMapCompared":"0","shadowMapDisagreed":"0","throughThinGlass":"0"},)"
            R"("leaseId":"","leaseS":0})"
            "\n");
}

TEST(Json, WritesFloatsThatReadBackTheSame) {
  v1::PdfLiResponse response;
  response.add_pdf_per_sr(0.1F);
  EXPECT_NE(cli::to_json(response).find(R"("pdfPerSr":[0.1])"), std::string::npos);
}

TEST(Json, HasTheFurtherMembersBehindTheMessage) {
  v1::PdfLiResponse response;
  response.add_pdf_per_sr(1);
  const std::string more = cli::json_of("reached", {true, false});
  EXPECT_THAT(cli::to_json(response, more), ::testing::EndsWith(",\"reached\":[true,false]}\n"));
  EXPECT_EQ(cli::to_json(v1::Points(), "\"a\":1"), "{\"offsetsM\":[],\"a\":1}\n");
}

TEST(Interval, IsPrintedAsHalfItsWidthOrAsItsEnds) {
  EXPECT_EQ(cli::interval_text(10, 8, 12, false), "2");
  EXPECT_EQ(cli::interval_text(10, 9, 12, false), "9 ... 12");
  EXPECT_EQ(cli::interval_text(0, 0, 3, false), "< 3");
  EXPECT_EQ(cli::interval_text(10, 10, 10, false), "exact");
  EXPECT_EQ(cli::interval_text(10, 10, 10, true), "no scatter");
  EXPECT_EQ(cli::interval_text(0, 0, 0, true), "no scatter");
  // The ends are floats, each with an error of half a unit in the last place.
  EXPECT_EQ(cli::interval_text(1e6F, 1e6F - 0.5F, 1e6F + 0.5625F, false), "0.53125");
}

TEST(Percent, HasEnoughDigitsToDifferFromNoneAndAll) {
  EXPECT_EQ(cli::percent(0.95), "95");
  EXPECT_EQ(cli::percent(0.999), "99.9");
  EXPECT_EQ(cli::percent(0.999999999), "99.9999999");
  EXPECT_EQ(cli::percent(1e-9), "1e-07");
  EXPECT_EQ(cli::percent(1 - 0x1p-53), "99.99999999999999");
}

TEST(TargetCheck, CountsMissedTargets) {
  v1::TargetError target;
  target.set_relative(0.01);
  target.set_absolute_floor(0.5);
  target.set_max_samples(256);
  cli::TargetCheck check(target);
  EXPECT_TRUE(check.add(100, 99, 101, 80));
  EXPECT_TRUE(check.add(1, 0.5, 1.5, 80));
  EXPECT_EQ(check.describe("points"), "");
  EXPECT_FALSE(check.add(100, 98, 102, 256));
  EXPECT_EQ(check.describe("points"),
            "1 of 3 points missed the target; the worst interval is 2 times too wide; ");
  EXPECT_FALSE(check.add(100, 97, 103, 257));
  EXPECT_EQ(check.describe("points"),
            "2 of 4 points missed the target; the worst interval is 3 times too wide; "
            "--max-samples reached by 1; ");
  EXPECT_EQ(check.missed(), 2U);
  // No error was allowed, so there is no ratio.
  target.clear_absolute_floor();
  cli::TargetCheck dark(target);
  EXPECT_FALSE(dark.add(0, 0, 1, 1000));
  EXPECT_EQ(dark.describe("pixels"), "1 of 1 pixels missed the target; --max-samples reached; ");
}

TEST(Overrun, OffersAsManySamplesAsTheBudgetAllows) {
  v1::Accuracy accuracy;
  v1::Cost cost;
  cost.set_wall_time_s(28);
  EXPECT_EQ(cli::describe_overrun(accuracy, cost, 16, "point"), "");
  accuracy.set_time_budget_s(3);
  // 28 s for 16 samples are 1.75 s each: one fits.
  EXPECT_EQ(cli::describe_overrun(accuracy, cost, 16, "point"),
            "over the budget of 3 s: each point takes at least 16 samples; --samples 1 would take "
            "about 1.75 s; ");
  accuracy.set_time_budget_s(10);
  EXPECT_THAT(cli::describe_overrun(accuracy, cost, 16, "pixel"),
              ::testing::HasSubstr("; --samples 5 would take about 8.75 s; "));
  // Even a single sample takes longer.
  accuracy.set_time_budget_s(1);
  EXPECT_THAT(cli::describe_overrun(accuracy, cost, 16, "pixel"),
              ::testing::HasSubstr("; --samples 1 would take about 1.75 s; "));
  // More samples than the least: the server chose them.
  EXPECT_EQ(cli::describe_overrun(accuracy, cost, 32, "point"), "");
  accuracy.set_time_budget_s(28);
  EXPECT_EQ(cli::describe_overrun(accuracy, cost, 16, "point"), "");
}

TEST(Cost, CountsLookUpsInShadowMaps) {
  v1::Cost cost;
  cost.set_wall_time_s(0.25);
  cost.set_shadow_rays(100);
  EXPECT_EQ(cli::describe(cost), "0.25 s, 100 rays");
  cost.set_samples(1);
  EXPECT_EQ(cli::describe(cost), "0.25 s, 1 sample, 100 rays");
  cost.set_samples(0);
  cost.set_shadow_map_lookups(6400);
  cost.set_shadow_map_compared(100);
  cost.set_shadow_map_disagreed(3);
  EXPECT_EQ(cli::describe(cost), "0.25 s, 100 rays, 6400 look-ups in shadow maps");
  v1::Accuracy accuracy;
  EXPECT_EQ(cli::describe_approximations(accuracy, cost), "");
  accuracy.set_visibility(v1::VISIBILITY_SHADOW_MAPS);
  accuracy.set_far_light_radii(7.1);
  EXPECT_EQ(cli::describe_approximations(accuracy, cost),
            "; approximated: area lights as points beyond 7.1 radii"
            "; approximated: shadow maps, 3 of 100 compared disagree");
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

TEST(ItemStatus, NoLightIsAnAnswer) {
  const auto failed = [](v1::ItemStatus status) {
    google::protobuf::RepeatedField<int> statuses;
    statuses.Add(v1::ITEM_STATUS_OK);
    statuses.Add(status);
    return cli::any_failed(statuses);
  };
  EXPECT_FALSE(failed(v1::ITEM_STATUS_BEHIND));
  EXPECT_FALSE(failed(v1::ITEM_STATUS_OUTSIDE_CONE));
  EXPECT_FALSE(failed(v1::ITEM_STATUS_BLACK));
  EXPECT_FALSE(failed(v1::ITEM_STATUS_INSIDE_SOLID));
  EXPECT_TRUE(failed(v1::ITEM_STATUS_DEGENERATE));
  EXPECT_TRUE(failed(v1::ITEM_STATUS_OUT_OF_RANGE));
  EXPECT_TRUE(failed(v1::ITEM_STATUS_INVALID_INPUT));
}

TEST(ItemStatus, PointsInsideOfSolidsAreCountedAndHaveAnAnswer) {
  google::protobuf::RepeatedField<int> statuses;
  EXPECT_EQ(cli::describe_inside(statuses), "");
  statuses.Add(v1::ITEM_STATUS_OK);
  EXPECT_EQ(cli::describe_inside(statuses), "");
  statuses.Add(v1::ITEM_STATUS_INSIDE_SOLID);
  EXPECT_EQ(cli::describe_inside(statuses), "1 of 2 points is inside of solids or behind lamps; ");
  statuses.Add(v1::ITEM_STATUS_INSIDE_SOLID);
  EXPECT_EQ(cli::describe_inside(statuses), "2 of 3 points are inside of solids or behind lamps; ");
  EXPECT_TRUE(cli::has_answer(statuses, 0));
  EXPECT_TRUE(cli::has_answer(statuses, 1));
  statuses.Add(v1::ITEM_STATUS_INVALID_INPUT);
  EXPECT_FALSE(cli::has_answer(statuses, 3));
}

TEST(Progress, ShowsTheFinishedPartAndTheTimeLeft) {
  EXPECT_EQ(cli::progress_line(0, 100, 5s), "[--------------------]   0%");
  // A quarter took 25 s, three quarters take 75 s.
  EXPECT_EQ(cli::progress_line(25, 100, 25s), "[#####---------------]  25%  ETA 1:15");
  EXPECT_EQ(cli::progress_line(100, 100, 5s), "[####################] 100%");
  EXPECT_EQ(cli::progress_line(999, 1000, 990s), "[###################-]  99%  ETA 0:01");
  EXPECT_EQ(cli::progress_line(0, 0, 5s), "[--------------------]   0%");
}

}  // namespace
}  // namespace lucerna
