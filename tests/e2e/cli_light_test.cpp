// lucerna lights, power, sample, pdf and le.
#include <regex>

#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(Cli, SampledPowerStopsAtACountAnErrorOrATime) {
  const std::vector<std::string> sampled = {"power", "sphere.pbrt", "--method", "sampled"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), sampled.begin(), sampled.end());
    return lucerna(more);
  };
  const Outcome count = with({"--samples", "1000", "--seed", "7"});
  EXPECT_EQ(count.status, 0) << count.err;
  EXPECT_THAT(count.out, ContainsRegex("id +type +flux \\[lm\\] +± \\[lm\\] +samples +RGB"));
  EXPECT_THAT(count.out, ContainsRegex(" 1  area +58\\.0[0-9]* +[0-9.e-]+ +1000 "));
  EXPECT_THAT(count.out, HasSubstr("± holds with 95% confidence; "));
  const Outcome error = with({"--error", "0.1%", "--confidence", "99%"});
  EXPECT_THAT(error.out, HasSubstr("± holds with 99% confidence; "));
  EXPECT_THAT(with({"--budget", "0.01"}).out, HasSubstr("area"));
  expect_wrong_use(lucerna({"power", "sphere.pbrt", "--error", "1%"}),
                   "--error and --budget require --method sampled");
}

TEST_F(Cli, NamesOfLightsAreListedIfThereAreAny) {
  EXPECT_THAT(lucerna({"lights", "named.pbrt"}).out,
              AllOf(ContainsRegex("id +name +type "), ContainsRegex(" 1  desk lamp +point +1 cd "),
                    ContainsRegex(" 2 +point +2 cd ")));
  EXPECT_THAT(lucerna({"lights", "point.pbrt"}).out, Not(HasSubstr("name")));
}

TEST_F(Cli, InspectPrintsWhatAFileHolds) {
  std::ofstream(path("many.pbrt"))
      << "WorldBegin\nLightSource \"point\"\nMaterial \"hair\"\nShape \"sphere\"\n"
         "Material \"hair\"\nShape \"sphere\"\n";
  const Outcome outcome = lucerna({"inspect", "--upload", path("many.pbrt")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(ContainsRegex("\nshape +sphere +2 +2 primitives\n"),
                    ContainsRegex("\nmaterial +diffuse +2\n"), ContainsRegex("\nlight +point +1\n"),
                    ContainsRegex("\ncamera +perspective +picture 1280 x 720 px"),
                    ContainsRegex("\nfile +many.pbrt +0.1 kB\n"), ContainsRegex("\nmemory +bvh "),
                    HasSubstr("Not modelled:\n  many.pbrt:3:1 and 1 more place: material")));
  EXPECT_THAT(lucerna({"inspect", "point.pbrt", "--json"}).out, HasSubstr("\"contents\""));
  expect_no(lucerna({"inspect", "none.pbrt"}), "none.pbrt");
  expect_wrong_use(lucerna({"inspect", "point.pbrt", "--asset-root", "/"}), "requires --upload");
  fs::remove(path("many.pbrt"));
}

TEST_F(Cli, ALightHasANameInPlaceOfItsId) {
  const std::vector<std::vector<std::string>> commands = {
      {"power", "named.pbrt"},
      {"sample", "named.pbrt", "--point", "1,0,0"},
      {"pdf", "named.pbrt", "--point", "1,0,0", "--direction", "-1,0,0"},
      {"emit", "named.pbrt"},
      {"emit-pdf", "named.pbrt", "--point", "0,0,0", "--direction", "-1,0,0"},
      {"le", "named.pbrt", "--point", "1,0,0", "--direction", "-1,0,0"}};
  const std::regex cost("\"cost\": *\\{[^}]*\\}");
  for (std::vector<std::string> command : commands) {
    SCOPED_TRACE(command[0]);
    command.insert(command.end(), {"--json", "--light", "desk lamp"});
    const Outcome by_name = lucerna(command);
    EXPECT_EQ(by_name.status, 0) << by_name.err;
    command.back() = "1";
    EXPECT_EQ(std::regex_replace(by_name.out, cost, ""),
              std::regex_replace(lucerna(command).out, cost, ""));
    command.back() = "desk";
    expect_no(lucerna(command), "which the scene does not have; similar names: ");
    for (const char* wrong : {"0", "1.5", "-1"}) {
      command.back() = wrong;
      expect_wrong_use(lucerna(command), " is not a whole number from 1 to ");
    }
  }
  // Tables show the light as it was named.
  EXPECT_THAT(lucerna({"sample", "named.pbrt", "--point", "1,0,0", "--light", "desk lamp"}).out,
              ContainsRegex(" 1 +desk lamp +1 1 1 +lx "));
}

TEST_F(Cli, FluxOfALightAtInfinityIsMarked) {
  // A square of 2 m by 2 m about the origin has a sphere of R^2 = 2.  A distant light of 1 lx sends
  // pi R^2 = 6.28319 lm through its disk.  A sky of 1 cd/m2 sends that from 4 pi sr: 78.9568 lm.
  EXPECT_THAT(
      lucerna({"lights", "sky.pbrt"}).out,
      AllOf(ContainsRegex(" 1  uniform infinite .* \\*78\\.95[67][0-9]* +exact"),
            ContainsRegex(" 2  distant .* \\*6\\.283[0-9]* +exact"),
            ContainsRegex(" 3  point .* 12\\.5664 +exact"),
            HasSubstr("\n* light at infinity: the flux through the scene's bounding disk or the "
                      "light's portal")));
  EXPECT_THAT(lucerna({"power", "sky.pbrt"}).out,
              AllOf(ContainsRegex(" 1  uniform infinite +\\*78\\.95[67]"),
                    ContainsRegex(" 3  point +12\\.5664 "), ContainsRegex("all +\\*97\\.80[67]"),
                    HasSubstr("\"all\" includes it\n")));
  EXPECT_THAT(lucerna({"power", "sky.pbrt", "--light", "3"}).out,
              AllOf(ContainsRegex("all +12\\.5664 "), Not(HasSubstr("*"))));
  EXPECT_THAT(lucerna({"lights", "point.pbrt"}).out, Not(HasSubstr("*")));
}

TEST_F(Cli, SampleOfAPointLightIsItsIlluminance) {
  // Straight below, 3.2 m: 10 / 3.2^2 lx.
  const Outcome outcome =
      lucerna({"sample", "point.pbrt", "--point", "1.2,-1.5,0", "--light", "1", "--visible"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(
      outcome.out,
      ContainsRegex("0\\.97656[23] 0\\.97656[23] 0\\.97656[23] +lx +0 0 1 +3\\.2 +delta +yes"));
  const Outcome chosen =
      lucerna({"sample", "point.pbrt", "--point", "1.2,-1.5,0", "--u", "0.5,0.5,0.25"});
  EXPECT_EQ(chosen.status, 0) << chosen.err;
  EXPECT_THAT(chosen.out, ContainsRegex("chosen with"));
}

TEST_F(Cli, SamplesToAnErrorOrATimePrintAnEstimate) {
  // Straight below the sphere's centre, 2.6 m: pi 12 (0.35 / 2.6)^2 = 0.683163 lx, and into a small
  // sphere 12 2 pi (1 - sqrt(1 - (0.35 / 2.6)^2)) = 0.686293 lx.
  const auto sample = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"sample", "sphere.pbrt", "--point", "0.7,-1.2,0"});
    return lucerna(more);
  };
  const Outcome error = sample({"--normal", "0,0,1", "--error", "1%", "--confidence", "99%"});
  EXPECT_EQ(error.status, 0) << error.err;
  EXPECT_THAT(
      error.out,
      ContainsRegex("x \\[m\\] +y \\[m\\] +z \\[m\\] +illuminance \\[lx\\] +± \\[lx\\] +samples"));
  EXPECT_THAT(error.out,
              ContainsRegex("0\\.7 +-1\\.2 +0 +0\\.68[23][0-9]* +[0-9.e-]+ +[0-9]+ *\n"));
  EXPECT_THAT(error.out, HasSubstr("± and < hold with 99% confidence, of unoccluded lights"));
  const Outcome around = sample({"--error", "1%", "--visible", "--floor", "0.001"});
  EXPECT_THAT(around.out, HasSubstr("spherical illuminance [lx]"));
  EXPECT_THAT(around.out, ContainsRegex(" 0\\.68[67][0-9]* "));
  EXPECT_THAT(around.out, HasSubstr("of visible lights; "));
  const Outcome most =
      sample({"--error", "1e-9", "--max-samples", "128", "--area-sampling", "square-root"});
  EXPECT_THAT(most.out, ContainsRegex(" 128 *\n"));
  EXPECT_THAT(sample({"--budget", "0.01", "--sampler", "independent"}).out,
              ContainsRegex(" 0\\.[67][0-9]* "));
  EXPECT_THAT(sample({"--error", "10%", "--wavelength", "555", "--visibility", "shadow-maps"}).out,
              HasSubstr("W/m2/nm"));
  const Outcome json = sample({"--error", "10%", "--json"});
  EXPECT_THAT(json.out, ContainsRegex("\"estimates\": ?\\{\"samples\": ?\\[[0-9]+\\],"));
  EXPECT_THAT(json.out, HasSubstr("\"standardErrorLx\""));
  expect_wrong_use(sample({"--u", "0.5,0.5,0.5", "--error", "1%"}), "--u and --error: only one");
  expect_wrong_use(sample({"--u", "0.5,0.5,0.5", "--budget", "1"}), "--u and --budget: only one");
  EXPECT_NE(sample({"--samples", "4", "--error", "1%"}).status, 0);
}

TEST_F(Cli, PdfIsZeroBesideALightAndNotTowardsIt) {
  // Straight below the sphere's centre.
  const Outcome outcome = lucerna({"pdf", "sphere.pbrt", "--light", "1", "--points", "-"},
                                  "x,y,z,nx,ny,nz\n0.7,-1.2,0,0,0,1\n0.7,-1.2,0,1,0,0\n");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("0 0 1 +[1-9][0-9.]*\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("1 0 0 +0\n"));
}

TEST_F(Cli, DensityFollowsTheAreaSamplingMethod) {
  const auto pdf = [](const std::string& way) {
    return lucerna({"pdf", "sphere.pbrt", "--light", "1", "--point", "0.7,-1.2,0", "--direction",
                    "0,0,1", "--area-sampling", way})
        .out;
  };
  // A sphere of radius 0.35 at 2.6 m: 1 / (2 pi (1 - sqrt(1 - (0.35 / 2.6)^2))) = 17.485.
  EXPECT_THAT(pdf("solid-angle"), ContainsRegex("0 0 1 +17\\.485"));
  // By area: 2.25^2 / (4 pi 0.35^2) = 3.2887.
  for (const char* way :
       {"square-root", "kraemer", "parallelogram", "rejection", "low-distortion"}) {
    EXPECT_THAT(pdf(way), ContainsRegex("0 0 1 +3\\.288[67]")) << way;
  }
  for (const char* way : {"automatic", "cosine-solid-angle"}) {
    EXPECT_THAT(pdf(way), ContainsRegex("0 0 1 +17\\.485")) << way;
  }
  expect_wrong_use(lucerna({"pdf", "sphere.pbrt", "--light", "1", "--point", "0,0,0", "--direction",
                            "0,0,1", "--area-sampling", "sideways"}),
                   "--area-sampling: sideways is not one of automatic, square-root, kraemer, "
                   "parallelogram, rejection, low-distortion, solid-angle, cosine-solid-angle; ");
}

TEST_F(Cli, LeIsTheRadianceOfTheLightThatARayMeets) {
  // From below the sphere's centre, upwards and aside.
  const Outcome outcome =
      lucerna({"le", "sphere.pbrt", "--points", "-"}, "0.7,-1.2,0,0,0,1\n0.7,-1.2,0,1,0,1\n");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("0 0 1 +12 12 12 +1\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("1 0 1 +0 0 0 +none\n"));
  expect_no(
      lucerna({"le", "sphere.pbrt", "--point", "0,0,1", "--direction", "0,0,1", "--light", "77"}),
      "77");
  expect_wrong_use(lucerna({"le", "sphere.pbrt", "--point", "0,0,1"}), "no directions");
}

// A flat spectrum from 500 to 600 nm.  The mean of the CIE's table there is 0.80920, with the end
// entries halved.  So 1000 lm are 1000 / (683 * 0.80920) = 1.80935 W, a hundredth in each
// nanometre.
TEST_F(Cli, LightsWithSpectraHaveWattsAndWavelengths) {
  EXPECT_THAT(lucerna({"power", "lamp.pbrt", "--wavelength", "499,555", "--wavelength", "600"}).out,
              AllOf(HasSubstr("flux [W]"), HasSubstr("at 499 555 600 nm [W/nm]"),
                    ContainsRegex(" 1  point +1000 +exact +1\\.80935 .* 0 0\\.0180935 "
                                  "0\\.0180935\n")));
  EXPECT_THAT(lucerna({"lights", "lamp.pbrt"}).out,
              ContainsRegex("spectrum 500 to 600 nm, 1\\.80935 W"));
  EXPECT_THAT(lucerna({"power", "point.pbrt"}).out, Not(HasSubstr("[W]")));
  // 2 m away: 0.0180935 / (4 pi 2^2) W/m2/nm.
  const char* const value = "0\\.000359959";
  EXPECT_THAT(
      lucerna({"sample", "lamp.pbrt", "--point", "0,0,2", "--light", "1", "--wavelength", "555"})
          .out,
      AllOf(HasSubstr("at 555 nm"), ContainsRegex(std::string(value) + " +W/m2/nm")));
  EXPECT_THAT(lucerna({"irradiance", "lamp.pbrt", "--point", "0,0,2", "--normal", "0,0,-1",
                       "--bounces", "0", "--wavelength", "555,700"})
                  .out,
              ContainsRegex(std::string(value) + " 0\n"));
  EXPECT_THAT(lucerna({"emit", "lamp.pbrt", "--light", "1", "--wavelength", "555"}).out,
              ContainsRegex("0\\.00143984 +W/sr/nm"));
  // Up at the sphere of 12 cd/m2: white, so D65, 12 of its W/m2/sr/nm per lm/m2/sr.
  EXPECT_THAT(lucerna({"le", "sphere.pbrt", "--point", "0.7,-1.2,0", "--direction", "0,0,1",
                       "--wavelength", "560"})
                  .out,
              AllOf(HasSubstr("at 560 nm [W/m2/sr/nm]"), ContainsRegex("12 12 12 +0\\.000166263")));
  expect_no(lucerna({"irradiance", "lamp.pbrt", "--point", "0,0,2", "--normal", "0,0,-1",
                     "--wavelength", "555"}),
            "surfaces have a colour and no spectrum");
  for (const char* nm : {"20", "99.9", "1000001", "-555", "nan"}) {
    expect_wrong_use(lucerna({"power", "lamp.pbrt", "--wavelength", nm}),
                     std::string(nm) + " is not a wavelength from 100 to 1000000 nm");
  }
  expect_wrong_use(lucerna({"power", "lamp.pbrt", "--wavelength", "blue"}), "blue");
}

}  // namespace
}  // namespace lucerna
