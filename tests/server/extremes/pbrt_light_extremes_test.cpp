// Rows 12, 27 and 28: lights from .pbrt files, with extreme angles, mirrors and scales.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "server/scene/create_light.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;

/// The only light of a .pbrt file, in world space.
std::shared_ptr<const Light> light_in(const std::string& text) {
  const auto scene = value_of(load_world(text));
  return value_of(scene.lights.empty() ? create_area_light(scene.shapes.at(0), {})
                                       : create_light(scene.lights.at(0), {}));
}

LightSample sample(const std::shared_ptr<const Light>& light, const Receiver& receiver,
                   Vec2 u = {0.5, 0.5}) {
  return light->sample_li(receiver, u);
}

double power(const std::shared_ptr<const Light>& light) { return light->power({}).lumens.g; }

std::string spot(double cone_deg, double delta_deg) {
  return fmt::format(
      "LightSource \"spot\" \"point3 to\" [0 0 -1] \"float coneangle\" {} \"float conedeltaangle\" "
      "{}",
      cone_deg, delta_deg);
}

TEST(PbrtLightExtremes, WideSpots) {
  Sweep sweep(12, "spot in a .pbrt file, half-angle",
              "90, 120, 180 degrees, edges of 0 and 30 degrees and as wide as the cone",
              "illuminance in all directions");
  const ReferenceTable table("spot_wide");
  for (const auto& row : table.rows()) {
    const auto light = light_in(spot(row["cone_deg"], row["delta_deg"]));
    const auto s = sample(light, Vec3{row["x"], 0, row["z"]});
    // In floats, as a request has it.
    sweep.compare(static_cast<float>(s.value.g), row["value_lx"],
                  row.text("cone_deg") + " " + row.text("x"));
    // The slope of a hard edge.
    const double pi = std::numbers::pi;
    const auto cos = [&](double deg) { return std::cos(static_cast<float>(deg * pi / 180)); };
    const auto x = static_cast<float>(row["x"]), z = static_cast<float>(row["z"]);
    const float cos_theta = -z / std::sqrt(x * x + z * z);
    const float t = (cos_theta - cos(row["cone_deg"])) /
                    (cos(row["cone_deg"] - row["delta_deg"]) - cos(row["cone_deg"]));
    const float share = t < 0 ? 0 : t > 1 ? 1 : t * t * (3 - 2 * t);
    if (row["value_lx"] > 0) sweep.compare_textbook(share / (x * x + z * z), row["value_lx"]);
  }
  sweep.expect_within(1e-7);
}

TEST(PbrtLightExtremes, PowerOfWideSpots) {
  Sweep sweep(12, "spot in a .pbrt file, half-angle",
              "90, 120, 180 degrees, edges of 0 and 30 degrees and as wide as the cone", "power");
  const ReferenceTable table("spot_wide");
  for (const auto& row : table.rows())
    sweep.compare(power(light_in(spot(row["cone_deg"], row["delta_deg"]))), row["power_lm"],
                  row.text("cone_deg"));
  sweep.expect_within(1e-15);
}

TEST(PbrtLightExtremes, InvalidSpotAngles) {
  Sweep sweep(12, "spot in a .pbrt file, half-angle",
              "0, below 0, above 180 degrees; edges wider than the cone", "answer");
  for (const std::string angles :
       {"0", "-1e-30", "-30", "180.00000000000003", "181", "1e30", "1e400"})
    sweep.answer(world_error_of("LightSource \"spot\" \"float coneangle\" " + angles)
                         .starts_with("scene.pbrt:1:")
                     ? "refused, with file and line"
                     : "taken: " + angles);
  for (const std::string cone : {"0", "-30", "181", "1e30"})
    EXPECT_NE(world_error_of("LightSource \"spot\" \"float coneangle\" " + cone)
                  .find("degrees, allowed (0, 180]"),
              std::string::npos);
  for (const auto& [cone, delta] : {std::pair{30.0, 30.1}, {30.0, -1e-9}, {1e-5, 2e-5}})
    sweep.answer(world_error_of(spot(cone, delta)).find("allowed [0, coneangle]") !=
                         std::string::npos
                     ? "refused, with file and line"
                     : "taken");
  sweep.expect_answers("refused, with file and line");
}

TEST(PbrtLightExtremes, SidesThatEmitUnderMirrors) {
  Sweep sweep(27, "area lights under mirroring transforms",
              "5 shapes, 4 kinds of normals, reversed or not, scales 1e-3 ... 1e3",
              "whether a receiver on either side gets light");
  static const std::map<std::string, std::string> kShapes{
      {"triangle",
       "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] \"integer indices\" [0 1 2]"},
      {"patch", "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]"},
      {"disk", "Shape \"disk\""},
      {"sphere", "Shape \"sphere\""},
      {"cylinder", "Shape \"cylinder\""}};
  static const std::map<std::string, std::string> kNormals{
      {"front", "0 0 1 "}, {"back", "0 0 -1 "}, {"leaning", "2 -1 1 "}};
  const ReferenceTable table("emitting_sides");
  for (const auto& row : table.rows()) {
    std::string text = "Transform [";
    for (int column = 0; column < 4; ++column) {
      for (int r = 0; r < 3; ++r) text += row.text(fmt::format("m{}{}", r, column)) + " ";
      text += column < 3 ? "0 " : "1] ";
    }
    if (row["reversed"] > 0) text += "ReverseOrientation ";
    const std::string shape = row.text("shape"), normals = row.text("normals");
    text += "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] " + kShapes.at(shape);
    if (normals != "none") {
      text += " \"normal N\" [";
      for (int i = 0; i < (shape == "triangle" ? 3 : 4); ++i) text += kNormals.at(normals);
      text += "]";
    }
    const auto light = light_in(text);
    const Vec3 receiver{row["x"], row["y"], row["z"]};
    // For a cylinder, the point of the table.  For other shapes, all points that a receiver samples
    // are on the same side.
    const Vec2 u = shape == "cylinder" ? Vec2{0.5, 0} : Vec2{0.3, 0.6};
    const bool lit = sample(light, receiver, u).reason == NoLight::kNone;
    sweep.answer(lit == (row["lit"] > 0) ? "as in pbrt-v4" : "not so: " + text);
    sweep.textbook_answer(row["by_winding"] == row["lit"] ? "the right side" : "the wrong side");
  }
  sweep.expect_answers("as in pbrt-v4");
}

const std::map<std::string, std::string>& scaled_lights() {
  static const std::map<std::string, std::string> kLights{
      {"sphere", "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Shape \"sphere\""},
      {"disk", "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Shape \"disk\""},
      {"cylinder",
       "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Shape \"cylinder\" \"float zmin\" 0 "
       "\"float zmax\" 1"},
      {"spot", "LightSource \"spot\" \"rgb I\" [1 1 1]"},
      {"projection", "LightSource \"projection\" \"rgb I\" [1 1 1] \"float fov\" 60"}};
  return kLights;
}

std::string scaled(const Row& row) {
  return fmt::format("Scale {} {} {} ", row.text("sx"), row.text("sy"), row.text("sz")) +
         scaled_lights().at(row.text("light"));
}

const char* const kScales = "1e-12 ... 1e12, mirrors, unequal scales if the light allows them";

TEST(PbrtLightExtremes, PowerUnderScales) {
  Sweep sweep(28, "sphere, disk, cylinder, spot, projection under Scale", kScales, "power");
  const ReferenceTable table("scaled_lights");
  for (const auto& row : table.rows()) {
    sweep.compare(power(light_in(scaled(row))), row["power_lm"],
                  row.text("light") + " " + row.text("sx") + " " + row.text("sz"));
    // The power without the scale.
    const Row* same = &row;
    for (const auto& other : table.rows())
      if (other.text("light") == row.text("light") && other["sx"] == 1 && other["sz"] == 1)
        same = &other;
    if (row["power_lm"] > 1e-30)
      sweep.compare_textbook(static_cast<float>((*same)["power_lm"]), row["power_lm"]);
  }
  sweep.expect_within(1e-14);
}

TEST(PbrtLightExtremes, DensityUnderScales) {
  Sweep sweep(28, "sphere, disk, cylinder under Scale", kScales, "density");
  const ReferenceTable table("scaled_lights");
  for (const auto& row : table.rows()) {
    if (!(row["per_sr"] > 0)) continue;
    const double sx = row["sx"], sz = row["sz"];
    const std::string name = row.text("light");
    Receiver receiver(Vec3{0, 0, name == "sphere" ? 3 * sz : 2 * sz});
    Vec2 u{0, 0};
    if (name == "cylinder") receiver.position = Vec3{4 * sx, 0, sz / 2}, u = {0.5, 0};
    if (name == "disk") receiver.area_sampling = AreaSampling::kSquareRoot;
    const auto s = sample(light_in(scaled(row)), receiver, u);
    // In floats, as a request has it.
    sweep.compare(static_cast<float>(s.pdf.per_sr), row["per_sr"],
                  name + " " + row.text("sx") + " " + row.text("sz"));
  }
  sweep.expect_within(1e-7);
}

/// Spot and projection are seen up to 30 degrees off their axis.  The picture of the projection is
/// scaled.
TEST(PbrtLightExtremes, ConesUnderScales) {
  Sweep sweep(28, "spot, projection under Scale", kScales,
              "light at a thousandth inside and outside the cone");
  const ReferenceTable table("scaled_lights");
  for (const auto& row : table.rows()) {
    const bool is_spot = row.text("light") == "spot";
    if (!is_spot && row.text("light") != "projection") continue;
    const auto towards = [&](double share) {
      const double half = std::numbers::pi / 6;
      const double tangent = is_spot ? std::tan(share * half) : share * std::tan(half);
      const Vec3 at{row["sx"] * tangent, 0, row["sz"]};
      return sample(light_in(scaled(row)), Receiver(normalized(at)), {0, 0});
    };
    EXPECT_NEAR(towards(0.5).value.g, 1, 1e-12) << row.text("light") << " " << row.text("sx");
    const bool within = towards(0.999).reason == NoLight::kNone;
    const bool beyond = towards(1.001).reason != NoLight::kOutsideCone;
    sweep.answer(!within  ? "none within: " + row.text("light") + " " + row.text("sx")
                 : beyond ? "some beyond: " + row.text("light") + " " + row.text("sx")
                          : "light inside, none outside");
  }
  sweep.expect_answers("light inside, none outside");
}

TEST(PbrtLightExtremes, ScalesThatAreRefused) {
  Sweep sweep(28, "sphere, cylinder, filtered picture behind a portal, sun, beam",
              "unequal scales of 1e-6 ... 1e6, shears", "answer");
  SceneFiles files;
  files.write("sky.pfm", std::string("PF\n1 1\n-1.0\n") + std::string(12, '\0'));
  const std::string shear = "ConcatTransform [1 0 0 0  1e-3 1 0 0  0 0 1 0  0 0 0 1] ";
  const std::string steep = "ConcatTransform [1 0 0 0  0 1 0 0  1e6 0 1 0  0 0 0 1] ";
  const auto tall = [](const char* s) { return std::string("Scale 1 1 ") + s + " "; };
  const auto wide = [](const char* s) { return std::string("Scale 1 ") + s + " 1 "; };
  const std::string area = "AreaLightSource \"diffuse\" ";
  const std::vector<std::string> unequal{
      tall("1e-6"),    tall("1.00001"), tall("1e6"), wide("1e-6"),
      wide("1.00001"), wide("1e6"),     shear,       steep};
  const std::vector<std::string> across{wide("1e-6"), wide("1.00001"), wide("1e6"), shear, steep};
  const std::vector<std::pair<std::string, std::vector<std::string>>> kRefused{
      {area + "Shape \"sphere\"", unequal},
      {area + "Shape \"cylinder\"", across},
      {"LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"string filter\" \"bilinear\" "
       "\"point3 portal\" [0 0 3 0 1 3 2 1 3 2 0 3]",
       unequal},
      {"LightSource \"distant\" \"float angulardiameter\" 1", unequal},
      {"LightSource \"projection\" \"string projection\" \"orthographic\"", {shear, steep}}};
  for (const auto& [light, transforms] : kRefused)
    for (const std::string& transform : transforms) {
      files.write("scene.pbrt", "WorldBegin\n" + transform + "\n" + light);
      const std::string error = message(files.load("scene.pbrt").status());
      const bool named = error.starts_with("scene.pbrt:3:") &&
                         error.find("scale") != std::string::npos &&
                         error.find("allowed") != std::string::npos;
      sweep.answer(named ? "refused; the error names place and scales"
                         : error + " of " + transform + light);
    }
  sweep.expect_answers("refused; the error names place and scales");
}

}  // namespace
}  // namespace lucerna::testing
