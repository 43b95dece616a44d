// The certainty of answers of `lucerna`: intervals, missed targets, approximations.
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

class CliCertainty : public Cli {
 protected:
  void TearDown() override {
    for (const std::string& name : files()) fs::remove_all(path(name));
  }

  static std::string said(std::vector<std::string> arguments) {
    const Outcome outcome = lucerna(std::move(arguments));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  }
  /// A field of the answer in JSON.
  static json answered(std::vector<std::string> words, const char* name) {
    words.emplace_back("--json");
    return json::parse(said(std::move(words)))[name];
  }

  /// The light of a sphere, all of it sampled.
  static std::vector<std::string> irradiance(const std::vector<std::string>& more) {
    std::vector<std::string> words = {"irradiance",     "sphere.pbrt", "--point",   "0.1,-1.3,0",
                                      "--normal",       "0.2,0,1",     "--bounces", "0",
                                      "--closed-forms", "off"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(CliCertainty, PlusMinusIsHalfTheIntervalForAllStopRules) {
  const std::vector<std::vector<std::string>> stops = {{"--samples", "16"},
                                                       {"--samples", "64"},
                                                       {"--error", "5%"},
                                                       {"--error", "5%", "--confidence", "80%"}};
  for (const std::vector<std::string>& stop : stops) {
    std::vector<std::string> words = irradiance({"--per-light"});
    words.insert(words.end(), stop.begin(), stop.end());
    const std::string text = said(words);
    SCOPED_TRACE(text);
    words.emplace_back("--json");
    const json answer = json::parse(said(words));
    std::istringstream lines(text);
    std::string line, x, y, z, value, error;
    std::getline(lines, line);
    std::getline(lines, line);
    std::istringstream(line) >> x >> y >> z >> value >> error;
    const auto half = [](const json& numbers) {
      return (numbers["upperLx"][0].get<double>() - numbers["lowerLx"][0].get<double>()) / 2;
    };
    EXPECT_NEAR(std::stod(error) / half(answer), 1, 1e-5);
    EXPECT_GT(std::stod(error), 1.2 * answer["standardErrorLx"][0].get<double>());
    while (line != "") std::getline(lines, line);
    std::string light;
    std::getline(lines, line);
    std::getline(lines, line);
    std::istringstream(line) >> light >> x >> y >> z >> value >> error;
    EXPECT_NEAR(std::stod(error) / half(answer["shares"][0]), 1, 1e-5);
    EXPECT_THAT(text, HasSubstr(stop.size() == 4 ? "± and < hold with 80% confidence; "
                                                 : "± and < hold with 95% confidence; "));
  }
  EXPECT_THAT(said(irradiance({"--samples", "1"})), ContainsRegex(" unknown "));
  EXPECT_THAT(said(irradiance({"--budget", "20ms"})),
              HasSubstr("± and < hold with 95% confidence"));
}

TEST_F(CliCertainty, ApproximationsAreNotExact) {
  const std::vector<std::string> sphere = {"irradiance", "sphere.pbrt", "--point",   "0.7,-1.2,0",
                                           "--normal",   "0,0,1",       "--bounces", "0"};
  const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return said(words);
  };
  const std::string far = with(sphere, {"--far-light", "1"});
  EXPECT_THAT(far, AllOf(ContainsRegex(" no scatter "), Not(HasSubstr("exact")),
                         EndsWith("; approximated: area lights as points beyond 1 radii\n")));
  const std::vector<std::string> point = {"irradiance", "point.pbrt", "--point",   "1.2,-1.5,0",
                                          "--normal",   "0,0,1",      "--bounces", "0"};
  EXPECT_THAT(with(point, {}), AllOf(ContainsRegex(" exact "), Not(HasSubstr("approximated"))));
  const std::string maps = with(point, {"--visibility", "shadow-maps", "--per-light"});
  EXPECT_THAT(maps, AllOf(ContainsRegex(" no scatter +0\\.97"), Not(HasSubstr("exact")),
                          ContainsRegex("no scatter\n"),
                          ContainsRegex("; approximated: shadow maps, [01] of [01] compared "
                                        "disagree\n$")));
  const auto approximate = [&](const std::vector<std::string>& words,
                               std::vector<std::string> more) {
    more.emplace_back("--json");
    return json::parse(with(words, more))["approximate"].get<bool>();
  };
  EXPECT_FALSE(approximate(point, {}));
  EXPECT_FALSE(approximate(point, {"--visibility", "rays"}));
  EXPECT_TRUE(approximate(point, {"--visibility", "shadow-maps"}));
  EXPECT_TRUE(approximate(sphere, {"--far-light", "1"}));
  const std::vector<std::string> render = {"render",    "point.pbrt", "-o",        path("a.pfm"),
                                           "--samples", "1",          "--bounces", "0"};
  EXPECT_THAT(
      with(render, {"--visibility", "shadow-maps"}),
      ContainsRegex("; approximated: shadow maps, [0-9]+ of [1-9][0-9]* compared disagree\n"));
  EXPECT_FALSE(approximate(render, {}));
  EXPECT_TRUE(approximate(render, {"--far-light", "2"}));
  // In the columns of a file.
  std::ofstream(path("p.csv")) << "1.2,-1.5,0,0,0,1\n";
  for (const char* way : {"rays", "shadow-maps"}) {
    EXPECT_EQ(lucerna({"irradiance", "point.pbrt", "--points", path("p.csv"), "--bounces", "0",
                       "--visibility", way, "-o", path("a.csv")})
                  .status,
              0);
    std::ifstream file(path("a.csv"));
    std::string header, row;
    std::getline(file, header);
    std::getline(file, row);
    EXPECT_THAT(header, EndsWith(",status,lower_lx,upper_lx,approximate,unsampled_bound_lx"));
    EXPECT_THAT(row, EndsWith(std::string(way) == "rays" ? ",false,0" : ",true,0"));
  }
}

TEST_F(CliCertainty, MissedTargetsAreCounted) {
  const std::vector<std::string> hard = {"--error", "0.01%", "--max-samples", "64"};
  const std::string missed = said(irradiance(hard));
  EXPECT_THAT(missed, ContainsRegex("; 1 of 1 points missed the target; the worst interval is "
                                    "[0-9.e+]+ times too wide; --max-samples reached; "));
  EXPECT_THAT(said(irradiance({"--error", "60%"})), Not(HasSubstr("missed the target")));
  EXPECT_THAT(said(irradiance({"--error", "0.01%", "--max-samples", "64", "--floor", "1000"})),
              Not(HasSubstr("missed the target")));
  EXPECT_EQ(answered(irradiance(hard), "reached"), json({false}));
  EXPECT_EQ(answered(irradiance({"--error", "60%"}), "reached"), json({true}));
  EXPECT_TRUE(answered(irradiance({"--samples", "4"}), "reached").is_null());

  // A bent patch, whose points are not uniform by area.
  std::ofstream(path("scenes/bent.pbrt"))
      << "WorldBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 3 3]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 1.5]\n";
  std::vector<std::string> power = {"power",         "bent.pbrt", "--method", "sampled",
                                    "--max-samples", "64",        "--error",  "0.00001%"};
  EXPECT_THAT(said(power), ContainsRegex("; 1 of 1 lights missed the target; .*; "
                                         "--max-samples reached; "));
  EXPECT_EQ(answered(power, "reached"), json({false}));
  power.back() = "50%";
  EXPECT_THAT(said(power), Not(HasSubstr("missed the target")));
  EXPECT_EQ(answered(power, "reached"), json({true}));

  std::vector<std::string> render = {"render", "small.pbrt",    "-o", path("a.pfm"), "--bounces",
                                     "0",      "--max-samples", "64", "--error",     "0.01%"};
  EXPECT_THAT(said(render), ContainsRegex("; [1-9][0-9]* of [1-9][0-9]* pixels missed the target; "
                                          ".*; --max-samples reached"));
  EXPECT_GT(answered(render, "pixelsNotReached"), 10);
  render.insert(render.end(), {"--floor", "1e9"});
  EXPECT_EQ(answered(render, "pixelsNotReached"), 0);

  // In the columns of a file.
  std::ofstream(path("p.csv")) << "0.1,-1.3,0,0.2,0,1\n0.1,-1.3,0,0,0,-1\n";
  const std::string file = said({"irradiance", "sphere.pbrt", "--points", path("p.csv"),
                                 "--bounces", "0", "--closed-forms", "off", "--error", "0.01%",
                                 "--max-samples", "64", "-o", path("a.csv")});
  EXPECT_THAT(file, ContainsRegex("2 points; 1 of 2 points missed the target"));
  std::ifstream rows(path("a.csv"));
  std::string line;
  std::getline(rows, line);
  EXPECT_THAT(line, EndsWith(",approximate,unsampled_bound_lx,samples,reached"));
  std::getline(rows, line);
  EXPECT_THAT(line, EndsWith(",false,0,64,false"));
  std::getline(rows, line);  // no light is visible from below
  EXPECT_THAT(line, EndsWith(",true"));
}

TEST_F(CliCertainty, FootersDescribeTheComputation) {
  EXPECT_THAT(said(irradiance({"--error", "50%", "--confidence", "99.9999999%"})),
              HasSubstr("± and < hold with 99.9999999% confidence; "));
  const std::vector<std::string> point = {"irradiance", "point.pbrt", "--point",   "1.2,-1.5,0",
                                          "--normal",   "0,0,1",      "--bounces", "0"};
  EXPECT_THAT(said(point), AllOf(HasSubstr("\nno samples taken; "), Not(HasSubstr("256"))));
  EXPECT_THAT(said(irradiance({"--samples", "32"})), HasSubstr("\n32 samples per point; "));
}

TEST_F(CliCertainty, EveryAnswerIsPrintedWithItsCost) {
  const std::vector<std::vector<std::string>> commands = {
      {"visible", "point.pbrt", "--point", "0,0,0", "--to", "0,0,1"},
      {"sample", "point.pbrt", "--point", "0,0,0"},
      {"sample", "point.pbrt", "--point", "0,0,0", "--error", "5%"},
      {"pdf", "sphere.pbrt", "--light", "1", "--point", "0,0,0", "--direction", "0,0,1"},
      {"le", "sphere.pbrt", "--point", "0,0,0", "--direction", "0,0,1"},
      {"emit", "point.pbrt"},
      {"emit-pdf", "sphere.pbrt", "--light", "1", "--point", "0,0,0", "--direction", "0,0,1"},
      {"power", "point.pbrt", "--method", "sampled"},
      {"irradiance", "point.pbrt", "--point", "0,0,0", "--normal", "0,0,1"},
      {"render", "point.pbrt", "-o", path("a.pfm"), "--samples", "1"}};
  for (const std::vector<std::string>& words : commands)
    EXPECT_THAT(said(words), ContainsRegex("[0-9] s(, [0-9]+ samples?)?(, [0-9]+ rays?)?\n$"))
        << words[0];
}

TEST_F(CliCertainty, SamplesReportMissedTargetsAndApproximations) {
  std::vector<std::string> words = {
      "sample", "rectangle_near.pbrt", "--error",     "0.01%",   "--max-samples",
      "64",     "--area-sampling",     "square-root", "--point", "-1.25,-0.75,1.25"};
  EXPECT_THAT(said(words), ContainsRegex("; 1 of 1 points missed the target; .*; "
                                         "--max-samples reached; "));
  EXPECT_EQ(answered(words, "reached"), json({false}));
  EXPECT_EQ(answered(words, "approximate"), json(false));
  words[3] = "1000%";
  EXPECT_THAT(said(words), Not(HasSubstr("missed the target")));
  EXPECT_EQ(answered(words, "reached"), json({true}));
  words.insert(words.end(), {"--visible", "--visibility", "shadow-maps"});
  EXPECT_EQ(answered(words, "approximate"), json(true));
  EXPECT_THAT(said(words), HasSubstr("; approximated: shadow maps, "));
}

TEST_F(CliCertainty, NumbersOutsideOfTheirRangeAreRefused) {
  const std::vector<std::vector<std::string>> commands = {
      {"sample", "point.pbrt", "--point", "0,0,0", "--seed"},
      {"emit", "point.pbrt", "--seed"},
      {"power", "point.pbrt", "--method", "sampled", "--seed"},
      {"irradiance", "point.pbrt", "--point", "0,0,0", "--normal", "0,0,1", "--seed"},
      {"render", "point.pbrt", "-o", path("a.pfm"), "--seed"},
      {"tradeoff", "point.pbrt", "--out", path("out"), "--query", "power", "--seed"}};
  for (const std::vector<std::string>& command : commands) {
    for (const char* seed : {"18446744073709551616", "999999999999999999999", "-1", "1.5"}) {
      std::vector<std::string> words = command;
      words.back() += std::string("=") + seed;
      expect_wrong_use(lucerna(words),
                       std::string(seed) + " is not a whole number from 0 to 18446744073709551615");
    }
  }
  const auto seeded = [](const char* seed) {
    return json::parse(said({"emit", "sphere.pbrt", "--json", "--seed", seed}))["points"];
  };
  EXPECT_NE(seeded("18446744073709551615"), seeded("18446744073709551614"));
  for (const char* command : {"sample", "pdf", "emit", "emit-pdf", "le", "power"}) {
    expect_wrong_use(lucerna({command, "point.pbrt", "--light=18446744073709551616"}),
                     "18446744073709551616 is not a whole number from 1 to 18446744073709551615");
  }
  expect_wrong_use(lucerna({"render", "point.pbrt", "-o", path("a.pfm"), "--servers", "a:1",
                            "--split-samples=18446744073709551616"}),
                   "is not a whole number from 1 to 18446744073709551615");
  for (const char* samples : {"--samples=0", "--samples=5000000000"}) {
    expect_wrong_use(
        lucerna({"irradiance", "point.pbrt", samples}),
        " is not a whole number from 1 to the server's limit (1048576, unless `lucerna "
        "info` shows another)");
  }
  expect_no(lucerna({"irradiance", "point.pbrt", "--point", "0,0,0", "--normal", "0,0,1",
                     "--samples", "1048577"}),
            "[1, 1048576]");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--error=1%", "--max-samples=63"}),
                   "63 is not a whole number from 64 to the server's limit");
  EXPECT_THAT(said({"irradiance", "--help"}), HasSubstr("from 64 to the server's limit"));
}

}  // namespace
}  // namespace lucerna
