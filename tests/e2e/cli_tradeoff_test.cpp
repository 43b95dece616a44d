// lucerna tradeoff: what it writes, and what it refuses.
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class CliTradeoff : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    // A lamp over a floor, and a table between; a picture of both.
    std::ofstream(path("scenes/lamp_over_table.pbrt"))
        << "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 16\n"
           "LookAt 0 -6 3  0 0 0.5  0 0 1\nCamera \"perspective\" \"float fov\" 50\nWorldBegin\n"
           "LightSource \"point\" \"rgb I\" [10 10 10] \"point3 from\" [1 0 2]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [0 0 1  1 0 1  0 1 1  1 1 1]\n"
           "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 3 3] \"bool twosided\" true\n"
           "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 2  0 -1 2  -1 0 2  0 0 2]\nAttributeEnd\n";
    std::ofstream points(path("points.csv"));
    for (int i = 0; i < 30; ++i) points << 0.2 * i - 3 << ',' << 0.1 * i - 1 << ",0,0,0,1\n";
  }
  void TearDown() override {
    for (const std::string& name : files()) fs::remove_all(path(name));
  }

  static Outcome tradeoff(std::vector<std::string> more) {
    more.insert(more.begin(), {"tradeoff", "lamp_over_table.pbrt", "--out", path("out")});
    return lucerna(more);
  }
  static std::string text(const std::string& name) {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  /// The files of a query belong together, and the page needs nothing but itself.
  static void expect_report(const std::string& query) {
    const json all = json::parse(text("out/tradeoff.json"));
    EXPECT_EQ(all["query"], query);
    EXPECT_EQ(all["circumstances"]["scene_id"].get<std::string>().size(), 64);
    EXPECT_EQ(all["circumstances"]["fingerprint"].get<std::string>().empty(), false);
    EXPECT_GT(all["circumstances"]["server_threads"], 0);
    EXPECT_EQ(all["settings"][0]["name"], "automatic");
    EXPECT_EQ(all["settings"][0]["fate"], "swept");
    EXPECT_EQ(all["levels"].size(), 3);
    const auto& rows = all["runs"]["rows"];
    // A row a run, and the header.
    std::istringstream csv(text("out/tradeoff.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_THAT(line, HasSubstr("scene,query,setting,amount_kind,amount,round,seed,seconds"));
    std::size_t lines = 0;
    for (; std::getline(csv, line); ++lines) EXPECT_THAT(line, HasSubstr(query));
    EXPECT_EQ(lines, rows.size());
    EXPECT_GT(lines, 3);

    const std::string page = text("out/report.html");
    EXPECT_THAT(page, HasSubstr("Chart.js v3"));
    EXPECT_THAT(page, HasSubstr("THE SOFTWARE IS PROVIDED"));
    EXPECT_THAT(page, Not(HasSubstr("{{")));
    // Nothing is loaded: no attribute and no style names anything outside.
    EXPECT_FALSE(std::regex_search(
        page, std::regex(R"re((src|href)\s*=\s*["']|@import|url\(\s*["']?http|<link)re")));
    const std::string begin = "<script id=\"data\" type=\"application/json\">";
    const std::size_t at = page.find(begin) + begin.size();
    const json shown = json::parse(page.substr(at, page.find("</script>", at) - at));
    EXPECT_EQ(shown["levels"], all["levels"]);
  }
};

TEST_F(CliTradeoff, IrradianceIsMeasuredAndReported) {
  const Outcome outcome =
      tradeoff({"--query", "irradiance", "--points", path("points.csv"), "--budget", "5s"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Its own error: "));
  EXPECT_THAT(outcome.out, HasSubstr("lucerna irradiance lamp_over_table.pbrt --points "));
  EXPECT_THAT(outcome.out, HasSubstr("report.html"));
  expect_report("irradiance");
  const json all = json::parse(text("out/tradeoff.json"));
  EXPECT_EQ(all["reference"]["values"].size(), 30);
  EXPECT_EQ(all["points"].size(), 30);
  EXPECT_LT(all["circumstances"]["spent_s"], 10);
  // More samples, less error: the answers are compared with what they converge to.
  const auto& cells = all["settings"][0]["cells"];
  ASSERT_GE(cells.size(), 2);
  const double first = cells[0]["relative_error"]["mean"];
  const double last = cells[cells.size() - 1]["relative_error"]["mean"];
  const double reference = all["reference"]["relative_error"];
  EXPECT_TRUE(last < first || last < 5 * reference) << first << ' ' << last << ' ' << reference;
  EXPECT_LT(last, 0.2);
}

TEST_F(CliTradeoff, PicturesHaveFlip) {
  const Outcome outcome = tradeoff({"--query", "render", "--budget", "8s", "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  expect_report("render");
  const json all = json::parse(text("out/tradeoff.json"));
  const auto& cell = all["settings"][0]["cells"][0];
  EXPECT_GT(cell["flip"]["mean"], 0);
  EXPECT_LT(cell["flip"]["mean"], 1);
  EXPECT_THAT(text("out/report.html"), HasSubstr("\"pictures\":[{"));
}

TEST_F(CliTradeoff, PowerIsComparedWithWhatIsKnown) {
  const Outcome outcome = tradeoff({"--query", "power", "--budget", "2s"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  expect_report("power");
  const json all = json::parse(text("out/tradeoff.json"));
  EXPECT_EQ(all["reference"]["exact"], true);
  ASSERT_EQ(all["reference"]["values"].size(), 2);
  // 4 pi I; pi A L of both sides.
  EXPECT_NEAR(all["reference"]["values"][0], 4 * M_PI * 10, 1e-3);
  EXPECT_NEAR(all["reference"]["values"][1], 2 * M_PI * 3, 1e-3);
  const auto& rays = all["settings"][2];
  EXPECT_EQ(rays["name"], "emitted rays");
  const auto& cells = rays["cells"];
  ASSERT_GE(cells.size(), 2);
  EXPECT_LT(cells[cells.size() - 1]["relative_error"]["mean"], 0.01);
}

TEST_F(CliTradeoff, SamplesAndVisibilityConvergeToTheirReferences) {
  for (const std::string query : {"sample", "visibility"}) {
    const Outcome outcome =
        tradeoff({"--query", query, "--points", path("points.csv"), "--budget", "5s"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    expect_report(query);
    const json all = json::parse(text("out/tradeoff.json"));
    const auto& cells = all["settings"][0]["cells"];
    EXPECT_LT(cells[cells.size() - 1]["relative_error"]["mean"], 0.2) << query;
  }
}

TEST_F(CliTradeoff, RefusesWhatCannotBeMeasured) {
  const std::string points = path("points.csv");
  expect_wrong_use(tradeoff({"--query", "colour"}),
                   "colour is not one of irradiance, render, sample, power, visibility");
  expect_wrong_use(tradeoff({"--query", "irradiance"}), "no points: give --points FILE");
  expect_wrong_use(tradeoff({"--points", path("none.csv")}), "cannot be opened");
  std::ofstream(path("bare.csv")) << "0,0,0\n";
  expect_wrong_use(tradeoff({"--points", path("bare.csv")}), "no normals, must have six columns");
  expect_wrong_use(tradeoff({"--points", points, "--budget", "0s"}), "is not a time above 0");
  expect_wrong_use(tradeoff({"--points", points, "--budget", "1ms", "--quiet"}),
                   "--budget 0.001s is too short");
  expect_wrong_use(tradeoff({"--points", points, "--budget", "0.001s", "--quiet"}),
                   "--budget 0.001s is too short");
  std::ofstream(path("a_file")) << "\n";
  expect_wrong_use(
      lucerna({"tradeoff", "lamp_over_table.pbrt", "--points", points, "--out", path("a_file/x")}),
      "--out " + path("a_file/x") + ": cannot be written to");
  expect_no(lucerna({"tradeoff", "nowhere.pbrt", "--points", points, "--out", path("out")}),
            "nowhere.pbrt");
  EXPECT_FALSE(fs::exists(path("out/report.html")));
}

TEST_F(CliTradeoff, TakesThePointsBesideTheScene) {
  fs::create_directories(path("scenes/place"));
  fs::copy_file(path("scenes/lamp_over_table.pbrt"), path("scenes/place/scene.pbrt"));
  fs::copy_file(path("points.csv"), path("scenes/place/points.csv"));
  const fs::path before = fs::current_path();
  fs::current_path(path("."));
  const Outcome outcome = lucerna(
      {"tradeoff", "place/scene.pbrt", "--budget", "4s", "--bounces", "0", "--out", path("out")});
  fs::current_path(before);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("--points scenes/place/points.csv --bounces 0 --samples"));
}

}  // namespace
}  // namespace lucerna
