// Row 32: pictures of every size, pixel type and texel value, through every light that takes one.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A light with a picture; FILE stands for its name.
struct PictureLight {
  std::string text;
  /// Its flux [lm] where all texels are 1, the picture is `aspect` times as wide as high, and the
  /// scene has this radius [m].
  std::function<double(double aspect, double radius_m)> flux_lm;
  bool square = false;  ///< takes no other pictures
};

const std::vector<PictureLight>& picture_lights() {
  const std::string infinite = "LightSource \"infinite\" \"string filename\" FILE ";
  const std::string portal = "\"point3 portal\" [-1 -1 2  -1 1 2  1 1 2  1 -1 2] ";
  const std::string goniometric = "LightSource \"goniometric\" \"string filename\" FILE ";
  const std::string projection = "LightSource \"projection\" \"string filename\" FILE ";
  const std::string area = "AreaLightSource \"diffuse\" \"string filename\" FILE ";
  const std::string latlong = "\"string mapping\" \"latlong\" ";
  const std::string bilinear = "\"string filter\" \"bilinear\" ";
  // All directions, through the disk that the scene's sphere projects to.
  const auto sky = [](double, double radius) { return 4 * kPi * kPi * radius * radius; };
  const auto through_portal = [](double, double) { return 4 * kPi; };
  const auto all_around = [](double, double) { return 4 * kPi; };
  // The shorter side reaches 1 to either side, at a distance of 1: the solid angle of a rectangle.
  const auto thrown = [](double aspect, double) {
    const double a = std::max(aspect, 1 / aspect);
    return 4 * std::asin(a / std::sqrt((1 + a * a) * 2));
  };
  const auto beam = [](double aspect, double) { return std::max(aspect, 1 / aspect); };
  const auto shape = [](double area) { return [=](double, double) { return kPi * area; }; };
  static const std::vector<PictureLight> lights{
      {infinite, sky, true},
      {infinite + latlong, sky},
      {infinite + latlong + bilinear, sky},
      {infinite + portal, through_portal, true},
      {infinite + portal + latlong, through_portal},
      {infinite + portal + latlong + bilinear, through_portal},
      {goniometric, all_around, true},
      {goniometric + bilinear, all_around, true},
      {goniometric + latlong, all_around},
      {goniometric + latlong + bilinear, all_around},
      {projection, thrown},
      {projection + bilinear, thrown},
      {projection + "\"string projection\" \"orthographic\"", beam},
      {area + "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]", shape(4)},
      {area +
           "\"string filter\" \"nearest\" Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 "
           "0 1 1 0]",
       shape(4)},
      {area + "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 1 1 0]", shape(2)},
      {area + "Shape \"sphere\" \"float radius\" 0.5", shape(kPi)},
      {area + "Shape \"disk\"", shape(kPi)},
      {area + "Shape \"cylinder\"", shape(4 * kPi)},
  };
  return lights;
}

/// A floor gives the scene a size, and so gives lights at infinity a flux.
std::string text_of(const PictureLight& light, const std::string& name) {
  std::string text = light.text;
  text.replace(text.find("FILE"), 4, "\"" + name + "\"");
  return "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n" + text;
}

FileScene load(const PictureLight& light, const std::string& name, const std::string& bytes) {
  return scene_of(text_of(light, name), {{name, bytes}});
}

bool through_portal(const PictureLight& light) {
  return light.text.find("portal") != std::string::npos;
}

/// Compares the flux of every light with an even picture with the flux for its value.  Takes either
/// the lights through portals or all others.
void compare_even(Sweep& sweep, const std::string& name, const std::string& bytes, double aspect,
                  double value, bool portals = false) {
  for (const PictureLight& light : picture_lights()) {
    if (through_portal(light) != portals) continue;
    const FileScene loaded = load(light, name, bytes);
    if (light.square && aspect != 1) {
      EXPECT_EQ(refusal(text_of(light, name), "\"string filename\"", loaded),
                "error with file, line and column")
          << light.text;
      continue;
    }
    ASSERT_TRUE(loaded.status.ok()) << light.text << loaded.status;
    const double unit = light.flux_lm(aspect, loaded.scene->sphere().radius_m);
    sweep.compare(flux_lm(*loaded.scene), unit * value,
                  fmt::format("{} {} {}, {}", name, aspect, value, light.text));
    EXPECT_NEAR(flux_lm(*loaded.scene), unit * value,
                flux_error_lm(*loaded.scene) + 2e-7 * unit * value);
  }
}

/// The mean of the texels, in float.
float textbook_mean_of_texels(std::uint64_t count, float texel) {
  float sum = 0;
  for (std::uint64_t i = 0; i < count; ++i) sum += texel;
  return sum / static_cast<float>(count);
}

void compare_sizes(Sweep& sweep, bool portals, const std::vector<float>& texels) {
  struct Size {
    int width, height;
  };
  for (const auto [width, height] : {Size{1, 1}, {64, 64}, {100'000, 1}, {1, 100'000}})
    for (const float texel : texels) {
      // All values at one size and all sizes at one value, because each combination takes long.
      if (width != 64 && texel != texels.front()) continue;
      compare_even(sweep, "even.pfm", even_pfm(width, height, texel),
                   static_cast<double>(width) / height, double{texel}, portals);
      sweep.compare_textbook(
          textbook_mean_of_texels(
              static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height), texel),
          double{texel});
    }
}

TEST(PictureExtremes, SizesAndValues) {
  Sweep sweep(32, "uniform pictures of 1 x 1, 1e5 x 1, 1 x 1e5 and 64 x 64 texels of",
              "1e-36 ... 1e30", "flux of every light that takes a picture");
  compare_sizes(sweep, false, {0.1F, 1e-36F, 1e-20F, 1e20F, 1e30F});
  sweep.expect_within(1e-7);
}

TEST(PictureExtremes, SizesAndValuesThroughPortals) {
  Sweep sweep(32, "the same through a portal, where no sum over texels is exact", "1e-36 ... 1e30",
              "flux");
  compare_sizes(sweep, true, {0.1F, 1e-36F, 1e30F});
  // 2^18 cells.  The error reported with each flux is at least this large.
  sweep.expect_within(2e-4);
}

// The portal's table of directions cannot be as fine as such a picture.
TEST(PictureExtremes, SingleLitRowsThroughAPortal) {
  Sweep sweep(32, "pictures of 1 x 2e4 texels through a portal, one of them lit",
              "rows of all heights", "density where there is light, relative to a uniform density");
  for (const int row : {1, 7941}) {
    std::vector<float> values(60'000, 0);
    std::fill_n(values.begin() + 3 * row, 3, 1.0F);
    const PictureLight light{
        "LightSource \"infinite\" \"string filename\" FILE \"string mapping\" \"latlong\" "
        "\"point3 portal\" [-1 -1 2  -1 1 2  1 1 2  1 -1 2]",
        {}};
    const SceneFiles folder;
    folder.write("row.pfm", pfm(1, 20'000, values));
    folder.write("scene.pbrt", "WorldBegin\n" + text_of(light, "row.pfm"));
    const auto description = value_of(folder.load("scene.pbrt"));
    const auto portal =
        value_of(PortalLight::create(std::get<PortalLightParams>(description.lights.at(0).params)));
    // All around the ring of the row, from a point that sees all of it.
    const Vec3 receiver{0.1, 0.2, 1.999999};
    const auto angle_seen = [&](double at) {
      return std::atan2(1 - at, 2 - receiver.z) + std::atan2(1 + at, 2 - receiver.z);
    };
    const double window = angle_seen(receiver.x) * angle_seen(receiver.y);
    const double polar = (row + 0.5) * kPi / 20'000;
    for (int k = 0; k < 16; ++k) {
      const double azimuth = k * kPi / 8;
      const Vec3 w{std::sin(polar) * std::cos(azimuth), std::cos(polar),
                   std::sin(polar) * std::sin(azimuth)};
      if (portal.le_escaped(receiver, w).is_black()) continue;
      // Even over the angles alpha, beta of (tan alpha, tan beta, 1).
      const double even = w.z / ((1 - w.x * w.x) * (1 - w.y * w.y) * window);
      const double share = portal.pdf_li(receiver, w).per_sr / even;
      sweep.answer(share > (1 - 1e-9) / 16 ? "1/16 or more" : "less: " + std::to_string(share));
    }
  }
  sweep.expect_answers("1/16 or more");
}

TEST(PictureExtremes, Types) {
  Sweep sweep(32, "grey, grey with alpha, RGB, RGBA in half, float, double and 8 and 16 bits",
              "codes 0 ... 65535, values 6e-8 ... 1e30",
              "flux of every light that takes a picture");
  const auto even = [&](const std::string& name, OIIO::TypeDesc type, int channels, auto value,
                        double linear) {
    OIIO::ImageSpec spec(2, 2, channels, type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    // OpenImageIO would call them R and G.
    if (channels == 2) spec.channelnames = {"Y", "A"};
    std::vector<decltype(value)> values(std::size_t{4} * static_cast<std::size_t>(channels), value);
    compare_even(sweep, name, written(name, spec, values), 1, linear);
  };
  for (int channels = 1; channels <= 4; ++channels) {
    for (const float value : {0x1p-24F, 0x1p-14F, 0.333251953125F, 1.0F, 65504.0F})
      even("half.exr", OIIO::TypeDesc::HALF, channels, value, value);
    for (const float value : {1e-30F, 0.1F, 1e30F}) {
      even("float.exr", OIIO::TypeDesc::FLOAT, channels, value, value);
      even("float.tif", OIIO::TypeDesc::FLOAT, channels, value, value);
    }
    even("double.tif", OIIO::TypeDesc::DOUBLE, channels, 0.25, 0.25);
  }
  const ReferenceTable table("srgb_codes");
  for (const auto& row : table.rows()) {
    const double linear = row["linear"];
    const auto code = static_cast<unsigned>(row["code"]);
    if (row.text("bits") == "8") {
      even("byte.png", OIIO::TypeDesc::UINT8, 3, static_cast<std::uint8_t>(code), linear);
      even("byte.tif", OIIO::TypeDesc::UINT8, 1, static_cast<std::uint8_t>(code), linear);
      sweep.compare_textbook(std::pow(static_cast<float>(code) / 255.0F, 2.2F), linear);
    } else {
      even("short.png", OIIO::TypeDesc::UINT16, 4, static_cast<std::uint16_t>(code), linear);
      even("short.tif", OIIO::TypeDesc::UINT16, 3, static_cast<std::uint16_t>(code), linear);
      sweep.compare_textbook(std::pow(static_cast<float>(code) / 65535.0F, 2.2F), linear);
    }
  }
  sweep.expect_within(2e-7);
}

TEST(PictureExtremes, NegativeTexelsCountAsZero) {
  Sweep sweep(32, "pictures of which half of the texels are", "-1e-45 ... -3e38",
              "answer of every light that takes a picture");
  std::vector<float> values(48, 2);
  std::fill(values.begin(), values.begin() + 24, 0.0F);
  const std::string zero = pfm(4, 4, values);
  std::vector<FileScene> of_zeros;
  for (const PictureLight& light : picture_lights())
    of_zeros.push_back(load(light, "zero.pfm", zero));
  for (const float below : {-1e-45F, -1e-30F, -1.0F, -1e30F, -3e38F}) {
    std::fill(values.begin(), values.begin() + 24, below);
    const std::string negative = pfm(4, 4, values);
    for (std::size_t i = 0; i < picture_lights().size(); ++i) {
      const PictureLight& light = picture_lights()[i];
      const FileScene &lit = of_zeros[i], odd = load(light, "below.pfm", negative);
      ASSERT_TRUE(lit.status.ok() && odd.status.ok()) << odd.status;
      const bool same = flux_lm(*odd.scene) == flux_lm(*lit.scene);
      const bool remarked = odd.remarks.find("8 texels with a value below 0") != std::string::npos;
      sweep.answer(same && remarked ? "as 0, with a remark" : light.text + odd.remarks);
    }
    float mean = 0;
    for (const float v : values) mean += v / 48;
    sweep.textbook_answer(mean < 0 ? "negative light" : "too dark");
  }
  sweep.expect_answers("as 0, with a remark");
}

TEST(PictureExtremes, InvalidPictures) {
  Sweep sweep(32, "pictures without texels, and with texels that are NaN or infinite",
              "0 x 0, 4 x 0, NaN, infinity, -infinity; cut short; of too many channels; no "
              "picture",
              "answer of every light that takes a picture");
  const auto with = [](float v) {
    std::vector<float> values(48, 1);
    values[3 * 6 + 1] = v;
    return pfm(4, 4, values);
  };
  const std::string whole = even_pfm(4, 4, 1);
  const OIIO::ImageSpec half(2, 2, 3, OIIO::TypeDesc::HALF), float3(2, 2, 3, OIIO::TypeDesc::FLOAT);
  const OIIO::ImageSpec whole_numbers(2, 2, 3, OIIO::TypeDesc::UINT32);
  const OIIO::ImageSpec two(2, 2, 2, OIIO::TypeDesc::FLOAT);
  const OIIO::ImageSpec doubles(2, 2, 3, OIIO::TypeDesc::DOUBLE);
  std::vector<float> odd(12, 1);
  odd[7] = kNan;
  const std::string half_nan = written("a.exr", half, odd),
                    float_nan = written("a.tif", float3, odd);
  odd[7] = kInfinity;
  const std::string half_infinite = written("a.exr", half, odd);
  const std::string grey_infinite = written("a.exr", two, std::vector<float>(8, kInfinity));
  // More than a float holds.
  const std::string beyond = written("a.tif", doubles, std::vector<double>(12, 1e300));
  OIIO::ImageSpec normals(4, 4, 3, OIIO::TypeDesc::FLOAT);
  const OIIO::ImageSpec codes(4, 4, 3, OIIO::TypeDesc::UINT8);
  const std::string exr = written("a.exr", normals, std::vector<float>(48, 1));
  const std::string png = written("a.png", codes, std::vector<std::uint8_t>(48, 200));
  normals.channelnames = {"n.x", "n.y", "n.z"};
  const std::pair<std::string, std::string> kFiles[] = {
      {"none.pfm", "PF\n0 0\n-1.0\n"},
      {"flat.pfm", "PF\n4 0\n-1.0\n"},
      {"thin.pfm", "PF\n0 4\n-1.0\n"},
      {"minus.pfm", "PF\n-4 4\n-1.0\n"},
      {"nan.pfm", with(kNan)},
      {"infinite.pfm", with(kInfinity)},
      {"minus_infinite.pfm", with(-kInfinity)},
      {"nan.exr", half_nan},
      {"nan.tif", float_nan},
      {"infinite.exr", half_infinite},
      {"grey.exr", grey_infinite},
      {"beyond.tif", beyond},
      {"codes.tif", written("a.tif", whole_numbers, std::vector<std::uint32_t>(12, 7))},
      {"short.pfm", whole.substr(0, whole.size() - 1)},
      {"short.exr", exr.substr(0, exr.size() / 2)},
      {"short.png", png.substr(0, png.size() / 2)},
      {"normals.exr", written("a.exr", normals, std::vector<float>(48, 1))},
      {"empty.exr", ""},
      {"words.png", "no picture"},
  };
  const std::string same = "left out, with a remark";
  for (const PictureLight& light : picture_lights()) {
    for (const auto& [name, bytes] : kFiles) {
      const FileScene loaded = load(light, name, bytes);
      ASSERT_TRUE(loaded.status.ok()) << name << loaded.status;
      const bool is_remarked =
          loaded.remarks.find("\"string filename\": " + name) != std::string::npos &&
          loaded.remarks.find("-> the light is left out") != std::string::npos;
      sweep.answer(is_remarked && loaded.scene->lights().empty() ? same : name + loaded.remarks);
    }
    // Limits of the server are errors.
    const std::string claims = "claims.pfm";
    EXPECT_EQ(refusal(text_of(light, claims), "\"string filename\"",
                      load(light, claims, "PF\n1000000 1000000\n-1.0\n" + whole)),
              "error with file, line and column");
  }
  sweep.textbook_answer(std::isnan(kNan + 1.0F) ? "not a number" : "");
  sweep.expect_answers(same);
}

}  // namespace
}  // namespace lucerna::testing
