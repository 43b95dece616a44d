// lucerna tradeoff: the files it writes, and the arguments it refuses.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <vector>

#include "tests/e2e/cli_fixture.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

using nlohmann::json;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
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

  static Outcome tradeoff(std::vector<std::string> more,
                          const std::string& scene = "lamp_over_table.pbrt") {
    more.insert(more.begin(), {"tradeoff", scene, "--out", path("out")});
    return lucerna(more);
  }
  /// A study that counts rounds: its amounts do not depend on the speed of the machine.
  static Outcome measured(std::vector<std::string> more, int max_samples,
                          const std::string& scene = "lamp_over_table.pbrt") {
    more.insert(more.end(), {"--rounds", "3", "--max-samples", std::to_string(max_samples)});
    return tradeoff(more, scene);
  }
  /// The command with at most 64 samples, or with a target error of at least 30%.  Extrapolated
  /// amounts may take hours, or exceed the limits of the server.
  static std::string with_small_amounts(const std::string& command) {
    std::smatch match;
    std::string small = command;
    if (std::regex_search(command, match, std::regex("(--samples|--count) ([0-9]+)")) &&
        std::stod(match[2]) > 64)
      small = std::string(match.prefix()) + match[1].str() + " 64" + std::string(match.suffix());
    if (std::regex_search(command, match, std::regex("--error ([0-9.e-]+)%")) &&
        std::stod(match[1]) < 30)
      small = std::string(match.prefix()) + "--error 30%" + std::string(match.suffix());
    return small;
  }
  static std::string text(const std::string& name) {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  /// The three files agree, the page loads nothing, and the JSON alone makes the same page.
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

    const Outcome again =
        lucerna({"tradeoff", "--report", path("out/tradeoff.json"), "--out", path("again")});
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.out, HasSubstr(path("again/report.html")));
    EXPECT_TRUE(text("again/report.html") == page) << "differs from the page of the study";
  }
};

TEST_F(CliTradeoff, IrradianceIsMeasuredAndReported) {
  const Outcome outcome = measured({"--query", "irradiance", "--points", path("points.csv")}, 256);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Its own error: "));
  EXPECT_THAT(outcome.out, HasSubstr("lucerna irradiance lamp_over_table.pbrt --points "));
  EXPECT_THAT(outcome.out, HasSubstr("report.html"));
  expect_report("irradiance");
  const json all = json::parse(text("out/tradeoff.json"));
  EXPECT_EQ(all["reference"]["values"].size(), 30);
  EXPECT_EQ(all["points"].size(), 30);
  // More samples have less error: the answers are compared with their converged values.
  const auto& cells = all["settings"][0]["cells"];
  ASSERT_GE(cells.size(), 2);
  const double first = cells[0]["relative_error"]["mean"];
  const double last = cells[cells.size() - 1]["relative_error"]["mean"];
  const double reference = all["reference"]["relative_error"];
  EXPECT_TRUE(last < first || last < 5 * reference) << first << ' ' << last << ' ' << reference;
  // Answers with an error of a tenth are noticed.
  EXPECT_EQ(cells[cells.size() - 1]["amount"]["value"], 256);
  EXPECT_LT(last, 0.05);
}

TEST_F(CliTradeoff, PicturesHaveFlip) {
  const Outcome outcome = measured({"--query", "render", "--quiet"}, 16);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  expect_report("render");
  const json all = json::parse(text("out/tradeoff.json"));
  const auto& cell = all["settings"][0]["cells"][0];
  EXPECT_GT(cell["flip"]["mean"], 0);
  EXPECT_LT(cell["flip"]["mean"], 1);
  const auto& cells = all["settings"][0]["cells"];
  EXPECT_LT(cells[cells.size() - 1]["flip"]["mean"], cell["flip"]["mean"]);
  EXPECT_THAT(text("out/report.html"), HasSubstr("\"pictures\":[{"));
}

TEST_F(CliTradeoff, PowerIsComparedWithExactValues) {
  // Every ray of the point light and the panel has the same flux.  Rays of the window differ.
  std::ofstream(path("scenes/lamps_and_window.pbrt"))
      << "WorldBegin\nLightSource \"point\" \"rgb I\" [10 10 10]\n"
         "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
         "  \"point3 portal\" [-1 -1 4  1 -1 4  1 1 4  -1 1 4]\n"
         "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 3 3] \"bool twosided\" true\n"
         "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 2  0 -1 2  -1 0 2  0 0 2]\nAttributeEnd\n";
  const Outcome outcome = measured({"--query", "power"}, 1 << 16, "lamps_and_window.pbrt");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  expect_report("power");
  const json all = json::parse(text("out/tradeoff.json"));
  EXPECT_EQ(all["reference"]["exact"], true);
  // 4 pi I; pi A L of the window, of both sides of the panel.
  std::vector<double> values = all["reference"]["values"];
  std::ranges::sort(values);
  EXPECT_THAT(values, ElementsAre(DoubleNear(4 * M_PI, 1e-3), DoubleNear(2 * M_PI * 3, 1e-3),
                                  DoubleNear(4 * M_PI * 10, 1e-3)));
  const auto named = [&](const std::string& name) {
    for (const auto& setting : all["settings"])
      if (setting["name"] == name) return setting;
    return json();
  };
  for (const std::string name : {"emitted rays", "method sampled"}) {
    const json setting = named(name);
    const auto& cells = setting["cells"];
    ASSERT_GE(cells.size(), 2) << name;
    EXPECT_LT(cells[cells.size() - 1]["relative_error"]["mean"], 0.01) << name;
    EXPECT_GT(cells[cells.size() - 1]["relative_error"]["mean"], 0) << name;
    EXPECT_THAT(setting["about"].get<std::string>(), HasSubstr("rays"));
  }
  EXPECT_FALSE(named("method sampled, by target error")["cells"].empty());
  EXPECT_EQ(all["settings"][0]["exact_at"], 0);
  EXPECT_EQ(all["settings"][0]["cells"][0]["exact"], true);
}

TEST_F(CliTradeoff, ClosedFormsAreTheReference) {
  // 10 cd one metre above a floor with no other light and no reflected light.
  std::ofstream(path("scenes/one_lamp.pbrt"))
      << "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
         "LookAt 0 0 3  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 20\nWorldBegin\n"
         "LightSource \"distant\" \"rgb L\" [3 3 3] \"point3 from\" [0 0 1] \"point3 to\" [0 0 0]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n";
  std::ofstream(path("three.csv")) << "0,0,0,0,0,1\n1,0,0,0,0,1\n0,2,0,0,3,4\n";
  for (const std::vector<std::string>& query :
       {std::vector<std::string>{"irradiance", "--points", path("three.csv")}, {"render"}}) {
    std::vector<std::string> arguments = {
        "tradeoff", "one_lamp.pbrt", "--out", path("out"), "--bounces", "0", "--rounds",
        "3",        "--max-samples", "16",    "--query"};
    arguments.insert(arguments.end(), query.begin(), query.end());
    const Outcome outcome = lucerna(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("Reference: closed forms"));
    EXPECT_THAT(outcome.out, HasSubstr("Its own error: 0, except rounding."));
    EXPECT_THAT(outcome.out, HasSubstr("any error: automatic"));
    expect_report(query[0]);
    const json all = json::parse(text("out/tradeoff.json"));
    EXPECT_EQ(all["reference"]["exact"], true);
    EXPECT_EQ(all["reference"]["relative_error"], 0);
    EXPECT_TRUE(all["settings"][0].contains("exact_at"));
    if (query[0] == "irradiance") {
      EXPECT_NEAR(all["reference"]["values"][0], 3, 1e-5);
      EXPECT_NEAR(all["reference"]["values"][2], 3 * 0.8, 1e-5);
    }
  }
}

TEST_F(CliTradeoff, PrintedCommandsWork) {
  fs::copy_file(path("points.csv"), path("my points.csv"));
  for (const std::string query : {"irradiance", "render", "sample", "visibility", "power"}) {
    std::vector<std::string> arguments = {build_path("bin/lucerna"),
                                          "tradeoff",
                                          "lamp_over_table.pbrt",
                                          "--server",
                                          server_->target(),
                                          "--out",
                                          path("out"),
                                          "--query",
                                          query,
                                          "--rounds",
                                          "3",
                                          "--max-samples",
                                          "16"};
    if (query != "render" && query != "power")
      arguments.insert(arguments.end(), {"--points", path("my points.csv")});
    const Outcome outcome = run_program(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::size_t commands = 0;
    const json all = json::parse(text("out/tradeoff.json"));
    for (const auto& level : all["levels"]) {
      if (!level.contains("command")) continue;
      ++commands;
      const std::string command = level["command"];
      EXPECT_THAT(command, HasSubstr(" --server " + server_->target()));
      const Outcome again =
          run_program({"/bin/sh", "-c",
                       "cd '" + path(".") + "' && lucerna() { '" + build_path("bin/lucerna") +
                           "' \"$@\"; } && " + with_small_amounts(command)});
      EXPECT_EQ(again.status, 0) << command << '\n' << again.err;
    }
    EXPECT_GT(commands, 0) << query;
  }
}

TEST_F(CliTradeoff, SamplesAndVisibilityConvergeToTheirReferences) {
  for (const std::string query : {"sample", "visibility"}) {
    const Outcome outcome = measured({"--query", query, "--points", path("points.csv")}, 256);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    expect_report(query);
    const json all = json::parse(text("out/tradeoff.json"));
    const auto& cells = all["settings"][0]["cells"];
    const auto& last = cells[cells.size() - 1];
    const double samples = last["amount"]["value"];
    EXPECT_EQ(samples, 256) << query;
    EXPECT_LT(last["relative_error"]["mean"], 4 / std::sqrt(samples)) << query;
    for (const auto& setting : all["settings"]) {
      std::vector<std::string> arguments = {"sample", "lamp_over_table.pbrt", "--points",
                                            path("points.csv"), "--visible"};
      for (const auto& flag : setting["flags"]) arguments.push_back(flag);
      EXPECT_EQ(lucerna(arguments).status, 0) << setting["name"];
    }
  }
}

/// Panes that block are an approximation only in scenes with panes.
TEST_F(CliTradeoff, PanesThatBlockAreMeasuredWherePanesAre) {
  std::ofstream(path("scenes/lamp_over_pane.pbrt"))
      << "WorldBegin\n"
         "LightSource \"point\" \"rgb I\" [10 10 10] \"point3 from\" [1 0 2]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n"
         "Material \"thindielectric\"\n"
         "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 1  4 -4 1  -4 4 1  4 4 1]\n";
  const auto blocking = [](const json& all) {
    for (const auto& setting : all["settings"])
      if (setting["name"] == "thin-glass blocks") return setting;
    return json();
  };
  for (const std::string query : {"irradiance", "sample", "visibility"}) {
    const std::vector<std::string> asked{"--query",          query,     "--points",
                                         path("points.csv"), "--quiet", "--bounces=0"};
    Outcome outcome = measured(asked, 16, "lamp_over_pane.pbrt");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json all = json::parse(text("out/tradeoff.json"));
    const json setting = blocking(all);
    EXPECT_EQ(setting["fate"], "swept") << query;
    // All light passes the pane, and a sample of light counts its share.
    const auto error = [](const json& cells) {
      return cells[0]["relative_error"]["mean"].get<double>();
    };
    EXPECT_NEAR(error(setting["cells"]), 1, 1e-2) << query;
    EXPECT_LT(error(all["settings"][0]["cells"]), 1e-5) << query;

    outcome = measured(asked, 16);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(blocking(json::parse(text("out/tradeoff.json")))["fate"], "same") << query;
  }
}

TEST_F(CliTradeoff, RefusesQueriesThatCannotBeMeasured) {
  const std::string points = path("points.csv");
  expect_wrong_use(tradeoff({"--query", "colour"}),
                   "colour is not one of irradiance, render, sample, power, visibility");
  expect_wrong_use(tradeoff({"--query", "irradiance"}), "no points: give --points FILE");
  expect_wrong_use(tradeoff({"--points", path("none.csv")}), "cannot be opened");
  std::ofstream(path("bare.csv")) << "0,0,0\n";
  expect_wrong_use(tradeoff({"--points", path("bare.csv")}), "no normals, must have six columns");
  expect_wrong_use(tradeoff({"--points", points, "--budget", "0s"}), "is not a time above 0");
  expect_wrong_use(tradeoff({"--points", points, "--budget", "1e-6ms", "--quiet"}),
                   "--budget 1e-09s is too short");
  expect_wrong_use(
      tradeoff({"--points", points, "--budget", "1e-6ms", "--quiet", "--timeout", "600"}),
      "--budget 1e-09s is too short");
  std::ofstream(path("a_file")) << "\n";
  expect_wrong_use(
      lucerna({"tradeoff", "lamp_over_table.pbrt", "--points", points, "--out", path("a_file/x")}),
      "--out " + path("a_file/x") + ": cannot be written to");
  expect_no(lucerna({"tradeoff", "nowhere.pbrt", "--points", points, "--out", path("out")}),
            "nowhere.pbrt");
  EXPECT_FALSE(fs::exists(path("out/report.html")));
}

TEST_F(CliTradeoff, RefusesOptionsThatContradict) {
  const std::string points = path("points.csv");
  EXPECT_EQ(tradeoff({"--points", points, "--rounds", "2", "--budget", "1s"}).status, 2);
  EXPECT_EQ(tradeoff({"--points", points, "--max-samples", "2"}).status, 2);
  expect_wrong_use(tradeoff({"--points", points, "--rounds", "1"}), "is not a whole number from 2");
  expect_wrong_use(lucerna({"tradeoff", "--out", path("out")}), "SCENE is required");
  expect_wrong_use(lucerna({"tradeoff", "lamp_over_table.pbrt", "--points", points}),
                   "--out is required");
  std::ofstream(path("other.json")) << "{\"lucerna_tradeoff\": 7}";
  for (const std::string& file : {path("other.json"), points})
    expect_wrong_use(tradeoff({"--report", file}, "unused"), "is not a tradeoff.json");
  expect_wrong_use(tradeoff({"--report", path("none.json")}, "unused"), "cannot be opened");
  EXPECT_FALSE(fs::exists(path("out/report.html")));
}

TEST_F(CliTradeoff, ReportsOfOtherStudiesAreDrawn) {
  // A chromium that writes the address of the page into the picture.
  fs::create_directories(path("tools"));
  std::ofstream(path("tools/chromium"))
      << "#!/bin/sh\nfor word; do case $word in --screenshot=*) out=${word#*=};; esac; done\n"
         "printf %s \"$word\" >\"$out\"\n";
  fs::permissions(path("tools/chromium"), fs::perms::owner_all);
  std::ofstream(path("study.json"))
      << R"({"lucerna_tradeoff": 1, "runs": {"rows": [[7]]}, "text": "</script><!--"})";
  const std::vector<std::string> words = {build_path("bin/lucerna"), "tradeoff", "--report",
                                          path("study.json"),        "--out",    path("my #1")};
  const Outcome drawn =
      run_program(words, "", {{"PATH", path("tools") + ":" + std::getenv("PATH")}});
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_THAT(text("my #1/errors.png"), ::testing::StartsWith("file:///"));
  EXPECT_THAT(text("my #1/errors.png"), ::testing::EndsWith("/my%20%231/report.html#only=errors"));
  EXPECT_THAT(text("my #1/report.html"),
              HasSubstr(R"({"lucerna_tradeoff":1,"text":"\u003c/script>\u003c!--"}</script>)"));
  // Without chromium there is the page alone.
  fs::remove_all(path("my #1"));
  const Outcome bare = run_program(words, "", {{"PATH", path("nowhere")}});
  EXPECT_EQ(bare.status, 0) << bare.err;
  EXPECT_THAT(bare.err, HasSubstr("no chromium in PATH"));
  EXPECT_TRUE(fs::exists(path("my #1/report.html")));
  // A chromium that fails is an error.
  std::ofstream(path("tools/chromium")) << "#!/bin/sh\nexit 3\n";
  const Outcome failed =
      run_program(words, "", {{"PATH", path("tools") + ":" + std::getenv("PATH")}});
  expect_no(failed, "exit status 3");
}

TEST_F(CliTradeoff, ThePagesInDocsCanBeMade) {
  for (const char* scene : {"cornell", "meadow", "room", "stage", "street"}) {
    const std::string json = source_path("docs/tradeoff/") + scene + "/tradeoff.json";
    const Outcome outcome = lucerna({"tradeoff", "--report", json, "--out", path("page")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(text("page/report.html"), HasSubstr("\"items\":[{")) << scene;
  }
}

TEST_F(CliTradeoff, NeedsTheProgramBesideLucerna) {
  fs::copy_file(build_path("bin/lucerna"), path("lucerna"));
  const Outcome outcome = run_program({path("lucerna"), "tradeoff", "--help"});
  expect_wrong_use(outcome, "cannot start " + path("lucerna-tradeoff"));
  fs::copy_file(build_path("bin/lucerna-tradeoff"), path("lucerna-tradeoff"));
  const Outcome beside =
      run_program({path("lucerna"), "--server", "a:1", "--timeout=5", "--json", "tradeoff",
                   "tradeoff", "--query", "power", "--out", path("out")});
  expect_no(beside, "cannot reach a server at a:1");
}

TEST_F(CliTradeoff, EveryQueryEndsWithItsTimeout) {
  for (const char* query : {"irradiance", "render", "sample", "visibility", "power"}) {
    const Outcome outcome = tradeoff({"--points", path("points.csv"), "--query", query, "--quiet",
                                      "--rounds", "1000000000", "--timeout", "1"});
    expect_no(outcome, "no answer within --timeout 1 s");
    EXPECT_FALSE(fs::exists(path("out/report.html"))) << query;
    fs::remove_all(path("out"));
  }
}

TEST_F(CliTradeoff, TakesThePointsBesideTheScene) {
  fs::create_directories(path("scenes/place"));
  fs::copy_file(path("scenes/lamp_over_table.pbrt"), path("scenes/place/scene.pbrt"));
  fs::copy_file(path("points.csv"), path("scenes/place/points.csv"));
  const fs::path before = fs::current_path();
  fs::current_path(path("."));
  const Outcome outcome = measured({"--bounces", "0"}, 4, "place/scene.pbrt");
  fs::current_path(before);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("--points scenes/place/points.csv --bounces 0 --samples"));
}

}  // namespace
}  // namespace lucerna
