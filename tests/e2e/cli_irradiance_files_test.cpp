// lucerna irradiance from files into files.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include "client/library/irradiance_job.h"
#include "tests/e2e/cli_fixture.h"

// This header removes macros that Protobuf's headers need, so it comes last.
#include <OpenImageIO/imageio.h>

namespace lucerna {
namespace {

using ::testing::HasSubstr;

class CliIrradianceFiles : public Cli {
 protected:
  static constexpr int kWidth = 16, kHeight = 12;

  void SetUp() override {
    Cli::SetUp();
    // 10 cd two metres above a floor.
    std::ofstream(path("scenes/plane.pbrt"))
        << "WorldBegin\nLightSource \"point\" \"rgb I\" [10 10 10] \"point3 from\" [0.3 -0.2 2]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n";
  }
  void TearDown() override {
    for (const std::string& name : files()) fs::remove_all(path(name));
  }

  static std::string bytes(const std::string& name) {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static void write(const std::string& name, const std::string& bytes) {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }

  /// The format in which numpy.save() writes arrays of doubles.
  static void write_npy(const std::string& name, int columns, const std::vector<double>& values) {
    std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                       std::to_string(values.size() / columns) + ", " + std::to_string(columns) +
                       "), }";
    text += std::string(117 - text.size(), ' ') + "\n";
    std::string numbers(values.size() * sizeof(double), '\0');
    std::memcpy(numbers.data(), values.data(), numbers.size());
    write(name, std::string("\x93NUMPY\x01\x00v\x00", 10) + text + numbers);
  }

  /// A row for each texel.
  static void write_exr(const std::string& name, const std::vector<std::string>& channels,
                        const std::vector<float>& values) {
    const auto file = OIIO::ImageOutput::create("openexr");
    OIIO::ImageSpec spec(kWidth, kHeight, static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = channels;
    ASSERT_TRUE(file->open(path(name), spec));
    ASSERT_TRUE(file->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    ASSERT_TRUE(file->close());
  }

  /// Points on the floor; texels in a corner have no surface.
  static std::vector<float> map(bool points, bool normals) {
    std::vector<float> values;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const bool surface = u < 12 || v < 10;
        if (points) {
          for (const float x :
               {0.4F * static_cast<float>(u) - 3, 0.5F * static_cast<float>(v) - 3, 0.0F})
            values.push_back(surface ? x : 0);
        }
        if (normals) {
          for (const float n : {0.0F, 0.0F, 2.0F}) values.push_back(surface ? n : 0);
        }
      }
    }
    return values;
  }

  static Outcome irradiance(std::vector<std::string> more,
                            const std::string& scene = "plane.pbrt") {
    // All light is sampled, so that there are errors.
    more.insert(more.begin(), {"irradiance", scene, "--samples", "16", "--closed-forms", "off"});
    return lucerna(more);
  }
};

TEST_F(CliIrradianceFiles, FilesHoldTheNumbersOfTheTableToTheBit) {
  std::string csv = "x,y,z,nx,ny,nz\n";
  std::vector<double> rows;
  for (int i = 0; i < 150; ++i) {
    const std::array<double, 6> row = {1000.1 + 0.02 * i, 0.013 * i - 1, 0.1, 0, 0.1 * i, 1};
    rows.insert(rows.end(), row.begin(), row.end());
  }
  rows[6 * 70] = std::nan("");
  std::ostringstream text;
  text.precision(17);
  for (std::size_t i = 0; i < rows.size(); ++i) text << rows[i] << (i % 6 == 5 ? '\n' : ',');
  csv += text.str();
  write("points.csv", csv);
  write_npy("points.npy", 6, rows);
  // The scene with the sky has light from everywhere, and shadows.
  const Outcome terminal = irradiance({"--points", path("points.csv"), "--json"}, "sky.pbrt");
  EXPECT_EQ(terminal.status, 1) << terminal.err;  // one point has no answer
  const auto array = [&](const std::string& name) {
    std::vector<float> values;
    const std::size_t at = terminal.out.find("\"" + name + "\":[");
    EXPECT_NE(at, std::string::npos) << name;
    if (at == std::string::npos) return values;
    std::string list = terminal.out.substr(at);
    list = list.substr(list.find('[') + 1);
    list = list.substr(0, list.find(']'));
    std::istringstream in(list);
    for (std::string value; std::getline(in, value, ',');) values.push_back(std::stof(value));
    return values;
  };
  const Outcome outcome =
      irradiance({"--points", path("points.csv"), "-o", path("a.csv")}, "sky.pbrt");
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("a.csv: 150 points, 1 INVALID_INPUT; "));
  std::istringstream lines(bytes("a.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "x,y,z,illuminance_lx,red_lx,green_lx,blue_lx,standard_error_lx,zero_bound_lx,status,"
            "lower_lx,upper_lx,approximate,unsampled_bound_lx");
  std::vector<float> illuminance, errors, lower, upper;
  int invalid = 0;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::vector<std::string> values;
    for (std::string field; std::getline(fields, field, ',');) values.push_back(field);
    ASSERT_EQ(values.size(), 14U) << line;
    illuminance.push_back(std::stof(values[3]));
    errors.push_back(std::stof(values[7]));
    lower.push_back(std::stof(values[10]));
    upper.push_back(std::stof(values[11]));
    EXPECT_TRUE(values[9] == "OK" || values[9] == "INVALID_INPUT") << line;
    invalid += values[9] == "OK" ? 0 : 1;
  }
  EXPECT_EQ(invalid, 1);
  EXPECT_EQ(illuminance, array("illuminanceLx"));
  EXPECT_EQ(errors, array("standardErrorLx"));
  EXPECT_EQ(lower, array("lowerLx"));
  EXPECT_EQ(upper, array("upperLx"));
  EXPECT_GT(illuminance[0], 1);
  EXPECT_GT(errors[0], 0);

  // Files of doubles, and any list of servers.
  EXPECT_EQ(irradiance({"--points", path("points.csv"), "-o", path("a.npy")}, "sky.pbrt").status,
            1);
  const Outcome listed = irradiance({"--points", path("points.npy"), "-o", path("b.npy"),
                                     "--servers", server_->target(), "--journal", path("journal")},
                                    "sky.pbrt");
  EXPECT_EQ(listed.status, 1) << listed.err;
  EXPECT_EQ(bytes("a.npy").size(), 128U + 150 * client::kIrradianceColumns * 4);
  EXPECT_EQ(bytes("a.npy"), bytes("b.npy"));
  // Normals in a file of their own.
  std::vector<double> points, normals;
  for (std::size_t i = 0; i < rows.size(); ++i) (i % 6 < 3 ? points : normals).push_back(rows[i]);
  write_npy("p.npy", 3, points);
  write_npy("n.npy", 3, normals);
  EXPECT_EQ(irradiance({"--points", path("p.npy"), "--normals", path("n.npy"), "-o", path("c.npy")},
                       "sky.pbrt")
                .status,
            1);
  EXPECT_EQ(bytes("a.npy"), bytes("c.npy"));
  // A scene that is uploaded.
  fs::copy_file(path("scenes/sky.pbrt"), path("my.pbrt"));
  for (const char* option : {"--server", "--servers"}) {
    const Outcome sent = lucerna({"irradiance", path("my.pbrt"), "--upload", "--samples", "16",
                                  "--closed-forms", "off", "--points", path("points.npy"), "-o",
                                  path("b.npy"), option, server_->target()});
    EXPECT_EQ(sent.status, 1) << sent.err;
    EXPECT_EQ(bytes("a.npy"), bytes("b.npy"));
    fs::remove(path("b.npy"));
  }
  EXPECT_THAT(files(), ::testing::UnorderedElementsAre("points.csv", "points.npy", "p.npy", "n.npy",
                                                       "a.csv", "a.npy", "c.npy", "my.pbrt"));
}

TEST_F(CliIrradianceFiles, TheBoundOfMissedLightHasAColumn) {
  std::ofstream(path("scenes/bowl.pbrt"))
      << "WorldBegin\n"
         "AttributeBegin Translate 0 0 3 AreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\n"
         "Shape \"sphere\" \"float radius\" 1e-3 AttributeEnd\n"
         "Material \"dielectric\" Shape \"sphere\" \"float radius\" 0.01\n";
  write("points.csv", "x,y,z,nx,ny,nz\n0.5,0,0,0,0,1\n");
  const Outcome outcome = lucerna({"irradiance", "bowl.pbrt", "--points", path("points.csv"), "-o",
                                   path("a.csv"), "--error", "5%"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("a.csv: 1 points, 1 MAY_MISS_LIGHT; light by way of "
                                     "bowl.pbrt:4:23 may be missed at 1 of 1 points; "));
  EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("missed the target")));
  std::istringstream lines(bytes("a.csv"));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  std::istringstream fields(line);
  std::vector<std::string> values;
  for (std::string field; std::getline(fields, field, ',');) values.push_back(field);
  ASSERT_EQ(values.size(), 16U) << line;
  const double lower = std::stod(values[10]), upper = std::stod(values[11]),
               bound = std::stod(values[13]);
  EXPECT_GT(bound, 0);
  EXPECT_NEAR(upper - bound, lower, 0.05 * lower);
  EXPECT_EQ(values[15], "true") << "the target is judged without the bound";
}

TEST_F(CliIrradianceFiles, ATargetErrorAddsSamples) {
  write("points.csv", "x,y,z,nx,ny,nz\n1000.1,0.2,0.1,0,0,1\n1001,-0.3,0.2,0,1,1\n");
  const std::vector<std::string> base = {"irradiance", "sky.pbrt", "--points", path("points.csv"),
                                         "--error",    "5%",       "-o"};
  const auto into = [&](const std::string& name) {
    std::vector<std::string> arguments = base;
    arguments.push_back(path(name));
    return lucerna(arguments);
  };
  const Outcome csv = into("a.csv");
  ASSERT_EQ(csv.status, 0) << csv.err;
  std::istringstream lines(bytes("a.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line,
              ::testing::EndsWith(
                  ",status,lower_lx,upper_lx,approximate,unsampled_bound_lx,samples,reached"));
  std::vector<float> rows;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::vector<std::string> values;
    for (std::string field; std::getline(fields, field, ',');) values.push_back(field);
    ASSERT_EQ(values.size(), 16U) << line;
    const float lux = std::stof(values[3]), lower = std::stof(values[10]),
                upper = std::stof(values[11]), samples = std::stof(values[14]);
    EXPECT_LE(lower, lux);
    EXPECT_GE(upper, lux);
    EXPECT_GE(samples, 64);
    rows.insert(rows.end(), {lower, upper, samples});
  }
  ASSERT_EQ(rows.size(), 6U);
  ASSERT_EQ(into("a.npy").status, 0);
  const std::string npy = bytes("a.npy");
  EXPECT_THAT(npy, HasSubstr("(2, 11)"));
  std::vector<float> numbers(22);
  std::memcpy(numbers.data(), npy.data() + npy.size() - 88, 88);
  constexpr std::array<std::size_t, 3> kColumns{client::kLowerColumn, client::kUpperColumn,
                                                client::kSamplesColumn};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(numbers[i / 3 * 11 + kColumns[i % 3]], rows[i]) << i;
  // The same in channels of a map.
  write_exr("points.exr", {"P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z"}, map(true, true));
  const Outcome exr = lucerna({"irradiance", "plane.pbrt", "--points", path("points.exr"),
                               "--error", "5%", "-o", path("a.exr")});
  ASSERT_EQ(exr.status, 0) << exr.err;
  const auto in = OIIO::ImageInput::open(path("a.exr"));
  ASSERT_NE(in, nullptr);
  for (const char* name : {"lower.Y", "upper.Y", "samples.Y"})
    EXPECT_NE(in->spec().channelindex(name), -1) << name;
}

TEST_F(CliIrradianceFiles, ALightMapIsTheClosedForm) {
  write_exr("map.exr", {"P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z"}, map(true, true));
  write_exr("points.exr", {"R", "G", "B"}, map(true, false));
  write_exr("normals.exr", {"X", "Y", "Z"}, map(false, true));
  const Outcome outcome =
      irradiance({"--points", path("map.exr"), "-o", path("light.exr"), "--bounces", "0"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("192 points, 8 INVALID_INPUT"));
  const auto file = OIIO::ImageInput::open(path("light.exr"));
  ASSERT_TRUE(file);
  const OIIO::ImageSpec& spec = file->spec();
  ASSERT_EQ(spec.width, kWidth);
  ASSERT_EQ(spec.height, kHeight);
  EXPECT_THAT(spec.channelnames,
              ::testing::UnorderedElementsAre("R", "G", "B", "illuminance.Y", "standard_error.Y",
                                              "zero_bound.Y", "status.Y", "lower.Y", "upper.Y",
                                              "unsampled_bound.Y"));
  std::vector<float> values(std::size_t{kWidth} * kHeight * 10);
  ASSERT_TRUE(file->read_image(0, 0, 0, 10, OIIO::TypeDesc::FLOAT, values.data()));
  const auto at = [&](int u, int v, const char* channel) {
    return values[(static_cast<std::size_t>(v) * kWidth + u) * 10 + spec.channelindex(channel)];
  };
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool surface = u < 12 || v < 10;
      // I cos / d^2, and the cosine is 2 / d.
      const double x = 0.4F * static_cast<float>(u) - 3 - 0.3,
                   y = 0.5F * static_cast<float>(v) - 3 + 0.2;
      const double expected = surface ? 10 * 2 / std::pow(x * x + y * y + 4, 1.5) : 0;
      for (const char* channel : {"R", "G", "B", "illuminance.Y"})
        EXPECT_NEAR(at(u, v, channel), expected, 2e-6 * expected) << u << ' ' << v;
      EXPECT_EQ(at(u, v, "standard_error.Y"), 0);
      EXPECT_EQ(at(u, v, "lower.Y"), at(u, v, "illuminance.Y"));
      EXPECT_EQ(at(u, v, "upper.Y"), at(u, v, "illuminance.Y"));
      EXPECT_EQ(at(u, v, "status.Y"), surface ? 1 : 7);
    }
  }
  EXPECT_EQ(irradiance({"--points", path("points.exr"), "--normals", path("normals.exr"), "-o",
                        path("two.exr"), "--bounces", "0"})
                .status,
            0);
  // The files hold the time of their creation.
  const auto two = OIIO::ImageInput::open(path("two.exr"));
  ASSERT_TRUE(two);
  std::vector<float> others(values.size());
  ASSERT_TRUE(two->read_image(0, 0, 0, 10, OIIO::TypeDesc::FLOAT, others.data()));
  EXPECT_EQ(values, others);
  // A single sample has no error, so there is no picture of it.
  EXPECT_EQ(lucerna({"irradiance", "plane.pbrt", "--samples", "1", "--points", path("points.exr"),
                     "--normal", "0,0,1", "-o", path("one.exr")})
                .status,
            0);
  const auto one = OIIO::ImageInput::open(path("one.exr"));
  ASSERT_TRUE(one);
  for (const char* name : {"standard_error.Y", "lower.Y", "upper.Y"})
    EXPECT_EQ(one->spec().channelindex(name), -1) << name;
  EXPECT_GE(one->spec().channelindex("status.Y"), 0);
}

TEST_F(CliIrradianceFiles, WrongUseIsRefusedBeforeAnyCall) {
  write("six.csv", "0,0,0,0,0,1\n1,0,0,0,0,1\n");
  write("three.csv", "x,y,z\n0,0,0\n1,0,0\n");
  write("bad.csv", "0,0,0,0,0,1\n1,zero,0,0,0,1\n");
  write("empty.csv", "x,y,z\n");
  write("one.csv", "0,0,1\n");
  write_exr("map.exr", {"R", "G", "B"}, map(true, false));
  const auto before = files();
  const auto refused = [&](std::vector<std::string> more, const std::string& what) {
    SCOPED_TRACE(what);
    more.insert(more.begin(), {"irradiance", "plane.pbrt", "--servers", "127.0.0.1:1"});
    expect_wrong_use(lucerna(more), what);
    EXPECT_THAT(files(), ::testing::UnorderedElementsAreArray(before));
  };
  const std::string out = path("out.npy");
  refused({"--points", path("bad.csv"), "-o", out},
          "bad.csv:2: column 2: \"zero\" is not a number");
  refused({"--points", path("empty.csv"), "-o", out}, "empty.csv: has no points");
  refused({"--points", path("three.csv"), "-o", out},
          "no normals: give --normals FILE or --normal");
  refused({"--points", path("three.csv"), "-o", out, "--normals", path("one.csv")},
          "one.csv has 1 normals, ");
  refused({"--points", path("three.csv"), "-o", out, "--normals", path("six.csv")},
          "six.csv: 6 columns, must be 3");
  refused({"--points", path("six.csv"), "-o", out, "--normals", path("three.csv")},
          "six.csv: has its own normals");
  refused({"--points", path("three.csv"), "-o", out, "--normals", path("three.csv"), "--normal",
           "0,0,1"},
          "only one of them");
  refused({"--points", path("six.csv"), "-o", path("six.csv")}, "is given twice");
  refused({"--points", path("six.csv"), "-o", path("none/../six.csv")}, "is given twice");
  refused({"--points", path("six.csv"), "-o", out, "--journal", out}, "is given twice");
  refused({"--points", path("six.csv"), "-o", path("out.txt")}, "must be .npy, .csv or .exr");
  refused({"--points", path("six.txt"), "-o", out}, "must be .npy, .csv or .exr");
  refused({"--points", path("six.csv"), "-o", path("out.exr")}, "six.csv is not a map");
  refused({"--points", path("six.csv"), "-o", path("no/out.npy")}, "No such file or directory");
  refused({"--points", path("scenes"), "-o", out}, "must be .npy, .csv or .exr");
  refused({"--points", "-", "-o", out}, "-o requires --points FILE");
  refused({"--point", "0,0,0", "--normal", "0,0,1", "-o", out}, "-o requires --points FILE");
  refused({"--points", path("six.csv"), "-o", out, "--per-light"}, "--per-light: not with -o");
  refused({"--points", path("six.csv"), "-o", out, "--asset-root", "x"}, "requires --upload");
  refused({"--points", path("six.csv")}, "--servers requires -o");
  expect_wrong_use(lucerna({"irradiance", "plane.pbrt", "--points", path("map.exr")}),
                   "map.exr: a table accepts only CSV; for other files use irradiance -o");
  expect_wrong_use(irradiance({"--points", path("map.exr"), "-o", out, "--normals", path("map.exr"),
                               "--servers", "x:y"}),
                   "--servers: server \"x:y\"");
  EXPECT_THAT(files(), ::testing::UnorderedElementsAreArray(before));
}

TEST_F(CliIrradianceFiles, AFailedJobLeavesNoFile) {
  write("six.csv", "0,0,0,0,0,1\n");
  write("out.npy", "old");
  const Outcome nobody =
      irradiance({"--points", path("six.csv"), "-o", path("out.npy"), "--server", "127.0.0.1:1"});
  expect_no(nobody, "cannot reach a server at 127.0.0.1:1");
  expect_no(irradiance({"--points", path("six.csv"), "-o", path("out.npy"), "--servers",
                        "127.0.0.1:1", "--timeout", "0.5"}),
            "no answer within --timeout 0.5 s");
  expect_no(irradiance({"--points", path("six.csv"), "-o", path("out.npy"), "--servers",
                        server_->target()},
                       "none.pbrt"),
            "none.pbrt");
  EXPECT_THAT(files(), ::testing::UnorderedElementsAre("six.csv", "out.npy"));
  EXPECT_EQ(bytes("out.npy"), "old");
  EXPECT_EQ(irradiance({"--points", path("six.csv"), "-o", path("out.npy")}).status, 0);
  EXPECT_EQ(bytes("out.npy").size(), 128U + client::kIrradianceColumns * 4);
}

}  // namespace
}  // namespace lucerna
