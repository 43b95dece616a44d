// Row 31: luminaires from photometric files.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <fstream>
#include <numbers>
#include <sstream>

#include "server/files/eulumdat.h"
#include "server/files/ies.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/server/files/photometric_texts.h"

namespace lucerna::testing {
namespace {

/// The numbers of "1.5,2,3".
std::vector<double> numbers(const std::string& joined) {
  std::vector<double> result;
  std::istringstream in(joined);
  for (std::string word; std::getline(in, word, ',');) result.push_back(std::stod(word));
  return result;
}

/// The file for one line of the tables.  Commas separate numbers there too.
Ies file_of(const ReferenceTable::Row& row) {
  const std::size_t vertical = numbers(row.text("vertical")).size();
  const std::size_t horizontal = numbers(row.text("horizontal")).size();
  Ies ies;
  ies.counts = std::to_string(vertical) + " " + std::to_string(horizontal);
  ies.type = row.text("type") == "C" ? "1" : row.text("type") == "B" ? "2" : "3";
  ies.angles = row.text("vertical") + "\n" + row.text("horizontal") + "\n";
  ies.candela = row.text("candela") + "\n";
  return ies;
}

std::shared_ptr<const PhotometricWeb> web_of(const std::string& text) {
  auto file = parse_ies(text, "a.ies");
  EXPECT_TRUE(file.ok()) << file.status() << "\n" << text;
  return file.ok() ? file->web : nullptr;
}

/// Zonal lumens: the mean intensity of a zone times 2 pi times the difference of the cosines.  For
/// luminaires that are the same all around their axis.  [Fritz18]
float textbook_flux(const std::vector<double>& vertical, const std::vector<double>& candela) {
  constexpr float kRadPerDegree = std::numbers::pi_v<float> / 180;
  float sum = 0;
  for (std::size_t j = 0; j + 1 < vertical.size(); ++j) {
    const float a = static_cast<float>(vertical[j]) * kRadPerDegree;
    const float b = static_cast<float>(vertical[j + 1]) * kRadPerDegree;
    const float mean = (static_cast<float>(candela[j]) + static_cast<float>(candela[j + 1])) / 2;
    sum += mean * 2 * std::numbers::pi_v<float> * (std::cos(a) - std::cos(b));
  }
  return sum;
}

/// The intensity at the angle whose cosine is given by the direction.
float textbook_intensity(const std::vector<double>& vertical, const std::vector<double>& candela,
                         float cos) {
  const float v = std::acos(cos) * 180 / std::numbers::pi_v<float>;
  std::size_t j = 0;
  while (j + 2 < vertical.size() && v >= static_cast<float>(vertical[j + 1])) ++j;
  const float t =
      (v - static_cast<float>(vertical[j])) / static_cast<float>(vertical[j + 1] - vertical[j]);
  return (1 - t) * static_cast<float>(candela[j]) + t * static_cast<float>(candela[j + 1]);
}

TEST(PhotometricExtremes, FluxOfIesFiles) {
  Sweep sweep(31, "IES files of types A, B and C, planes of every symmetry, beams of",
              "1 ... 1e-7 degrees, 1e-300 ... 1e295 cd", "flux");
  const ReferenceTable table("photometric_flux");
  for (const auto& row : table.rows()) {
    const auto web = web_of(file_of(row).text());
    ASSERT_NE(web, nullptr);
    sweep.compare(web->flux_lm(), row["flux_lm"],
                  row.text("type") + " " + row.text("vertical") + " " + row.text("horizontal"));
    if (row.text("type") == "C" && row.text("horizontal") == "0.0")
      sweep.compare_textbook(
          textbook_flux(numbers(row.text("vertical")), numbers(row.text("candela"))),
          row["flux_lm"]);
  }
  // About a right angle off the pole, the ends of cells are rounded by 2^-47 degrees and by 2^-53
  // rad.  For a beam that reaches 1e-7 degrees to either side this is below 1.3e-7 of its width.
  sweep.expect_within(1e-7);
}

TEST(PhotometricExtremes, IntensitiesOfIesFiles) {
  Sweep sweep(31, "the same", "1 ... 1e-7 degrees, 1e-30 ... 1e30 cd",
              "illuminance 1 m away, in every cell");
  const ReferenceTable table("photometric_intensity");
  for (const auto& row : table.rows()) {
    GoniometricLightParams params;
    params.intensity = Rgb(1);
    params.web = web_of(file_of(row).text());
    const auto light = value_of(GoniometricLight::create(params));
    const Vec3 receiver(row["x"], row["y"], row["z"]);
    const auto sample = light.sample_li(receiver, {0.5, 0.5});
    const double square = dot(receiver, receiver);
    sweep.compare(sample.value.g * square, row["intensity_cd"],
                  row.text("type") + " " + row.text("vertical") + " " + row.text("horizontal"));
    if (row.text("type") == "C" && row.text("horizontal") == "0.0")
      sweep.compare_textbook(
          textbook_intensity(numbers(row.text("vertical")), numbers(row.text("candela")),
                             static_cast<float>(row["z"])),
          row["intensity_cd"]);
  }
  // The same roundings, plus that of the direction's own angle.  At 0.6 of the way through a cell,
  // 0.4 of its light is left, so the errors count 2.5 times as much: below 5e-7.
  sweep.expect_within(2e-7);
}

TEST(PhotometricExtremes, FluxOfEulumdatFiles) {
  Sweep sweep(31, "the files of type C with planes all around, written as EULUMDAT, lamps of",
              "1e-30 ... 1e30 lm; planes of every symmetry", "flux");
  const ReferenceTable table("photometric_flux");
  for (const auto& row : table.rows()) {
    const std::vector<double> planes = numbers(row.text("horizontal"));
    const std::vector<double> candela = numbers(row.text("candela"));
    const std::vector<double> gamma = numbers(row.text("vertical"));
    if (row.text("type") != "C" || *std::ranges::max_element(candela) > 1e35) continue;
    Ldt ldt;
    ldt.ng = static_cast<int>(gamma.size());
    ldt.gamma.clear();
    for (const double g : gamma) ldt.gamma.push_back(fmt::format("{:.17g}", g));
    ldt.c.clear();
    ldt.symmetry = planes.size() == 1     ? 1
                   : planes.back() == 90  ? 4
                   : planes.back() == 180 ? 2
                   : planes.front() == 90 ? -1
                                          : 0;
    if (ldt.symmetry < 0) continue;
    // All planes of the circle.  Where the file has a symmetry, they repeat intensities of the
    // first planes.
    std::vector<double> all = planes;
    if (ldt.symmetry == 0) all.pop_back();
    if (ldt.symmetry == 4)
      for (std::size_t i = planes.size() - 1; i-- > 0;) all.push_back(180 - planes[i]);
    if (ldt.symmetry == 4 || ldt.symmetry == 2)
      for (std::size_t i = all.size() - 1; i-- > 1;) all.push_back(360 - all[i]);
    ldt.mc = static_cast<int>(all.size());
    for (const double c : all) ldt.c.push_back(fmt::format("{:.17g}", c));
    const std::size_t given = gamma.size() * (ldt.symmetry == 0 ? all.size() : planes.size());
    for (const double lumens : {1e-30, 1.0, 1000.0, 1e30}) {
      ldt.lamps[2] = fmt::format("{:g}", lumens);
      ldt.intensities.clear();
      for (std::size_t i = 0; i < given; ++i)
        ldt.intensities.push_back(fmt::format("{:.17g}", candela[i]));
      const auto file = value_of(parse_eulumdat(ldt.text(), "a.ldt"));
      sweep.compare(file.web->flux_lm(), row["flux_lm"] * (lumens / 1000),
                    row.text("vertical") + " " + row.text("horizontal"));
      if (ldt.symmetry == 1) {
        std::vector<double> scaled = candela;
        for (double& cd : scaled) cd *= lumens / 1000;
        sweep.compare_textbook(textbook_flux(gamma, scaled), row["flux_lm"] * (lumens / 1000));
      }
    }
  }
  sweep.expect_within(1e-7);
}

TEST(PhotometricExtremes, WaysToWriteAFile) {
  Sweep sweep(31, "one luminaire written in many ways",
              "lumens -1 ... 1e30, multipliers 1e-30 ... 1e30, tilt tables, CR, CR LF, no final "
              "newline, byte-order mark, five editions",
              "flux");
  const ReferenceTable table("photometric_flux");
  const auto row = std::ranges::find_if(table.rows(), [](const auto& r) {
    return r.text("type") == "C" && r.text("candela") == "300.0,200.0,100.0";
  });
  ASSERT_NE(row, table.rows().end());
  const auto compare = [&](const std::string& text, double factor, const std::string& at) {
    const auto web = web_of(text);
    if (web == nullptr) return;
    sweep.compare(web->flux_lm(), (*row)["flux_lm"] * factor, at);
    const float zonal = textbook_flux({0, 45, 90}, {300, 200, 100});
    sweep.compare_textbook(zonal * static_cast<float>(factor), (*row)["flux_lm"] * factor);
  };
  const Ies plain = file_of(*row);
  for (const char* lumens : {"-1", "0", "1e-30", "1", "2500", "1e30"}) {
    Ies f = plain;
    f.lamps = std::string("1 ") + lumens + " 1";
    compare(f.text(), 1, "lumens");
  }
  for (int exponent = -30; exponent <= 30; exponent += 5) {
    const std::string m = fmt::format("1e{}", exponent);
    Ies f = plain;
    f.lamps = "3 1000 " + m;
    compare(f.text(), std::stod(m), "candela multiplier");
    f = plain;
    f.ballast = m + " 1 10\n";
    compare(f.text(), std::stod(m), "ballast factor");
    f = plain;
    f.header = "IESNA91\n";
    f.ballast = "1 " + m + " 10\n";
    compare(f.text(), std::stod(m), "ballast-lamp factor of 1991");
  }
  for (const char* tilt : {"TILT=INCLUDE\n1\n2\n0 90\n0.5 1\n", "TILT=INCLUDE\n2\n1\n0\n0.5\n",
                           "TILT=INCLUDE\n3\n4 0 1e-6 2e-6 180\n0.5 1e30 1e-30 7\n"}) {
    Ies f = plain;
    f.tilt = tilt;
    compare(f.text(), 0.5, "tilt");
  }
  for (const char* header :
       {"", "free text of 1986\n", "IESNA91\n", "IESNA:LM-63-1995\n", "IES:LM-63-2019\n"}) {
    Ies f = plain;
    f.header = header;
    compare(f.text(), 1, "edition");
  }
  const std::string text = plain.text();
  for (const char* end : {"\r\n", "\r", "\n\n"}) {
    std::string other;
    for (const char c : text) other += c == '\n' ? end : std::string(1, c);
    compare(other, 1, "ends of lines");
    compare(other.substr(0, other.find_last_not_of("\r\n") + 1), 1, "no final newline");
  }
  compare("\xef\xbb\xbf" + text, 1, "byte-order mark");
  compare(text + "more\n", 1, "more behind it");
  // One horizontal angle, and the same luminaire with two, three or five.
  for (const char* planes : {"0 90", "0 180", "0 360", "90 270", "0 45 90", "0 1e-6 90 180 360"}) {
    Ies f = plain;
    const auto count = static_cast<int>(std::count(planes, planes + std::strlen(planes), ' ')) + 1;
    f.counts = "3 " + std::to_string(count);
    f.angles = "0 45 90\n" + std::string(planes) + "\n";
    f.candela.clear();
    for (int i = 0; i < count; ++i) f.candela += "300 200 100\n";
    compare(f.text(), 1, "planes");
  }
  sweep.expect_within(1e-14);
}

// 100 cd over a part of the sphere: its solid angle is a turn times a difference of sines.
TEST(PhotometricExtremes, AnglesThatEndEarly) {
  Sweep sweep(31, "IES files of types A, B and C whose angles end early, ranges of",
              "1e-6 ... 180 degrees", "flux");
  constexpr double kRad = std::numbers::pi / 180;
  for (int exponent = -6; exponent <= 2; ++exponent) {
    const double range = exponent == 2 ? 180 : std::pow(10, exponent);
    const auto flux = [&](const char* type, double from, double to, double wide) {
      const double v0 = from * kRad, v1 = to * kRad;
      const bool c = type[0] == '1';
      // sin(v1) - sin(v0), or cos(v0) - cos(v1), without cancellation.
      const double height =
          2 * std::sin((v1 - v0) / 2) * (c ? std::sin((v0 + v1) / 2) : std::cos((v0 + v1) / 2));
      return 100 * wide * kRad * height;
    };
    const auto compare = [&](const char* type, double v, double h, double truth) {
      Ies f;
      f.type = type;
      f.counts = type[0] == '1' ? "2 1" : "2 2";
      f.angles = type[0] == '1' ? fmt::format("0 {:.17g}\n0\n", v)
                                : fmt::format("{:.17g} {:.17g}\n{:.17g} {:.17g}\n", -v, v, -h, h);
      f.candela = type[0] == '1' ? "100 100\n" : "100 100 100 100\n";
      const auto web = web_of(f.text());
      if (web != nullptr) sweep.compare(web->flux_lm(), truth, fmt::format("{} {}", type, range));
    };
    compare("1", range, 0, flux("1", 0, range, 360));
    if (range > 90) continue;
    compare("2", 30, range, flux("2", -range, range, 60));
    compare("2", range, 30, flux("2", -30, 30, 2 * range));
    compare("3", range, 30, flux("3", -range, range, 60));
    compare("3", 30, range, flux("3", -30, 30, 2 * range));
  }
  sweep.expect_within(1e-7);
}

/// While this object exists, the process can allocate only this much more memory, used or not.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes) {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    EXPECT_GT(pages, 0U);
    EXPECT_EQ(getrlimit(RLIMIT_AS, &before_), 0);
    rlimit limited = before_;
    limited.rlim_cur = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + bytes;
    EXPECT_EQ(setrlimit(RLIMIT_AS, &limited), 0);
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  ~MemoryLimit() { EXPECT_EQ(setrlimit(RLIMIT_AS, &before_), 0); }

 private:
  rlimit before_{};
};

TEST(PhotometricExtremes, CountsBeyondTheEndOfTheFile) {
  Sweep sweep(31, "IES and EULUMDAT files of 1 kB that claim to hold", "500 ... 1e18 numbers",
              "answer");
  const std::string same = "refused at the claim, before memory is allocated";
  const auto answer = [&](auto parse, const std::string& text, const std::string& at) {
    EXPECT_NEAR(static_cast<double>(text.size()), 1000, 200);
    std::string said;
    try {
      const MemoryLimit limit(4'000'000);
      const auto file = parse(text, "a");
      said = file.ok() ? "taken" : std::string(file.status().message());
    } catch (const std::exception& e) {
      said = e.what();  // std::bad_alloc, std::length_error
    }
    sweep.answer(said.find("announced") != std::string::npos ? same : at + ": " + said);
  };
  // After the claim, 1 kB has room for 500 numbers.
  std::string ones;
  for (int i = 0; i < 380; ++i) ones += "1 ";
  const auto parse_as_ies = [](const auto& text, const char* name) {
    return parse_ies(text, name);
  };
  for (const char* counts : {"500 1", "2 250", "22 22", "1000 1000", "1000000 1", "2 1000000",
                             "1000000000 1", "2 1000000000", "1000000000 1000000000"}) {
    Ies f;
    f.counts = counts;
    f.candela = ones + "\n";
    answer(parse_as_ies, f.text(), counts);
  }
  for (const char* pairs : {"250", "1000", "1000000", "1000000000"}) {
    Ies f;
    f.tilt = std::string("TILT=INCLUDE\n1\n") + pairs + "\n";
    f.candela = ones + "\n";
    answer(parse_as_ies, f.text(), pairs);
  }
  const auto parse_as_ldt = [](const auto& text, const char* name) {
    return parse_eulumdat(text, name);
  };
  for (const int count : {500, 1'000'000, 1'000'000'000})
    for (const bool of_planes : {false, true}) {
      Ldt f;
      (of_planes ? f.mc : f.ng) = count;
      f.intensities.assign(400, "1");
      answer(parse_as_ldt, f.text(), std::to_string(count));
    }
  Ldt f;
  f.mc = f.ng = 1'000'000'000;
  f.intensities.assign(400, "1");
  answer(parse_as_ldt, f.text(), "1e9 by 1e9");
  sweep.expect_answers(same);
}

TEST(PhotometricExtremes, FilesThatCannotBeRead) {
  Sweep sweep(31, "files that claim more than they hold, or have invalid values",
              "1e6 ... 1e18 numbers in 1 kB; invalid angles, candela and factors", "answer");
  std::vector<std::string> files;
  const auto ies = [&](auto change) {
    Ies f;
    change(f);
    files.push_back(f.text());
  };
  for (const char* counts : {"1000 1000", "1000000 1", "2 1000000", "1000000000 1000000000", "4 1",
                             "3 2", "1e300 1", "1e999 1", "-3 1", "0 0", "3 0", "1 1", "2.5 1"})
    ies([&](Ies& f) { f.counts = counts; });
  for (const char* angles :
       {"0 45 45\n0\n", "0 45 44\n0\n", "-1e-6 45 90\n0\n", "0 45 nan\n0\n", "-90 0 90\n0\n",
        "0 45 180.000001\n0\n", "0 inf 90\n0\n", "0 45 90\n721\n", "0 45 90\n", ""})
    ies([&](Ies& f) { f.angles = angles; });
  for (const char* candela :
       {"-0.031 1 1\n", "nan 1 1\n", "inf 1 1\n", "1e999 1 1\n", "1e301 1 1\n", "1 1\n", ""})
    ies([&](Ies& f) { f.candela = candela; });
  for (const char* lamps : {"1 -2 1", "1 -1.5 1", "-1 1000 1", "1 1000 0", "1 1000 -1", "1 nan 1",
                            "1 1000 1e-301", "1 1000 1e301", "1e9 1000 1"})
    ies([&](Ies& f) { f.lamps = lamps; });
  // The candela are finite, but their product with the multipliers is not.
  ies([](Ies& f) { f.candela = "1e300 1 1\n", f.lamps = "1 1000 1e300"; });
  for (const char* tilt :
       {"TILT=INCLUDE\n1\n1000000\n0 1\n1 1\n", "TILT=INCLUDE\n1\n2\n1 2\n1 1\n",
        "TILT=INCLUDE\n1\n2\n0 1\n1 -1\n", "TILT=INCLUDE\n0\n1\n0\n1\n", "TILT=\n", ""})
    ies([&](Ies& f) { f.tilt = tilt; });
  files.push_back("");
  files.emplace_back(1000, '\0');
  const std::string whole = Ies().text();
  for (std::size_t n = whole.find("TILT"); n < whole.rfind(' ') + 1; n += 3)
    files.push_back(whole.substr(0, n));

  const std::string same = "error with file, line and column";
  const auto answer = [&](const std::string& name, const std::string& bytes) {
    const std::string quoted = " \"" + name + "\" ";
    for (const auto& [parameter, text] :
         {std::pair<std::string, std::string>{
              "\"string filename\"", "LightSource \"goniometric\" \"string filename\"" + quoted},
          {"\"string profile\"",
           "AreaLightSource \"diffuse\" \"string profile\"" + quoted + "Shape \"disk\""}}) {
      const std::string said = refusal(text, parameter, scene_of(text, {{name, bytes}}));
      EXPECT_EQ(said, same) << bytes;
      sweep.answer(said);
    }
  };
  for (const std::string& bytes : files) answer("a.ies", bytes);
  const auto ldt = [&](auto change) {
    Ldt f;
    change(f);
    answer("a.ldt", f.text());
  };
  for (const int count : {1'000'000, 1'000'000'000, 0, -1}) {
    ldt([&](Ldt& f) { f.symmetry = 0, f.mc = count; });
    ldt([&](Ldt& f) { f.ng = count; });
  }
  for (const int symmetry : {-1, 5}) ldt([&](Ldt& f) { f.symmetry = symmetry; });
  for (const char* value : {"nan", "-4", "1e999", "1e301", "", "x"})
    ldt([&](Ldt& f) { f.intensities[1] = value; });
  ldt([](Ldt& f) { f.gamma[1] = "0"; });
  ldt([](Ldt& f) { f.gamma[2] = "180.000001"; });
  ldt([](Ldt& f) { f.lamps[2] = "1e300", f.intensities[0] = "1e300"; });
  sweep.expect_answers(same);
}

}  // namespace
}  // namespace lucerna::testing
