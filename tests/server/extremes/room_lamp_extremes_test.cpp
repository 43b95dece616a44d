// Rows 4, 6, 7, 8 and 34 with lamps from scene files.  The lamps are small beside the room that
// they hang in, at places that floats cannot hold.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/queries/queries.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/server/extremes/quad.h"
#include "tests/server/queries/li_samples.h"

namespace lucerna::testing {
namespace {

using Corners = std::vector<Vec3>;

/// A floor of 6 m and a lamp above it: a triangle, or a patch of four corners.
std::shared_ptr<const Scene> room(const Corners& lamp, bool two_sided = false) {
  std::string p;
  for (const Vec3& c : lamp) p += fmt::format(" {:.17g} {:.17g} {:.17g}", c.x, c.y, c.z);
  const FileScene file =
      scene_of(fmt::format("Shape \"bilinearmesh\" \"point3 P\" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]\n"
                           "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" {}\n"
                           "Shape \"{}\" \"point3 P\" [{}]",
                           two_sided, lamp.size() == 3 ? "trianglemesh" : "bilinearmesh", p));
  if (!file.status.ok()) throw std::runtime_error(file.status.ToString());
  return file.scene;
}

/// Twice the area, with the corners rounded to floats: the textbook's value.
double doubled_area(const Corners& c) {
  const Quad3 a(c[0]);
  return length(cross(Quad3(c[1]) - a, Quad3(c[2]) - a));
}
double doubled_area_in_floats(const Corners& c) {
  const Vec3f a(c[0]);
  return length(cross(Vec3f(c[1]) - a, Vec3f(c[2]) - a));
}

/// The solid angle of a small triangle from `p`.  [VanOosterom83]
double solid_angle_sr(const Corners& c, const Vec3& p) {
  const Quad3 a = Quad3(c[0]) - Quad3(p), b = Quad3(c[1]) - Quad3(p), d = Quad3(c[2]) - Quad3(p);
  const double la = length(a), lb = length(b), ld = length(d);
  const double below = la * lb * ld + static_cast<double>(dot(a, b)) * ld +
                       static_cast<double>(dot(b, d)) * la + static_cast<double>(dot(d, a)) * lb;
  return 2 * std::atan2(std::fabs(static_cast<double>(dot(a, cross(b, d)))), below);
}

struct Answer {
  float pdf_per_sr;
  ItemResult status;
};

/// Samples the only light of the scene, at a point in double.
Answer sample_at(const Scene& scene, const Vec3& p, AreaSampling way) {
  const std::vector<float> offset{0, 0, 0}, u{0.3F, 0.6F};
  const LiSamples s(
      scene, {.receivers = {p, offset}, .light = 0, .u = u, .methods = {.area_sampling = way}});
  return {s.pdf_per_sr[0], static_cast<ItemResult>(s.status[0])};
}

TEST(RoomLampExtremes, FluxOfNeedles) {
  Sweep sweep(34, "oblique needle in a room, length : width", "1e3 ... 1e9", "flux");
  for (const Vec3& moved : {Vec3{}, {0.1, 0.2, 0.3}, {-1.7, 1.3, 2.1}}) {
    for (int exponent = 3; exponent <= 9; ++exponent) {
      const double width = std::pow(10.0, -exponent);
      const Corners needle{moved, moved + Vec3{1, 1, 0.5}, moved + Vec3{0.5, 0.5 + width, 0.25}};
      const double truth = kPi * doubled_area(needle) / 2;
      sweep.compare(flux_lm(*room(needle)), truth, fmt::format("1e{} at {}", exponent, moved.x));
      sweep.compare_textbook(kPi * doubled_area_in_floats(needle) / 2, truth);
    }
  }
  // The corners about the middle of the scene are rounded: by 4e-16 m of 1e-9 m.
  sweep.expect_within(1e-6);
}

TEST(RoomLampExtremes, SmallTriangles) {
  Sweep flux(34, "triangle in a room of 6 m, side", "1e-8 ... 0.01 m", "flux");
  for (int exponent = -8; exponent <= -2; ++exponent) {
    const double s = std::pow(10.0, exponent);
    const Vec3 a{2.3, 1.7, 2.7};
    const Corners lamp{a, a + Vec3{0, s, 0.1 * s}, a + Vec3{s, 0.3 * s, 0}};
    const double truth = kPi * doubled_area(lamp) / 2;
    flux.compare(flux_lm(*room(lamp)), truth, fmt::format("1e{} m", exponent));
    flux.compare_textbook(kPi * doubled_area_in_floats(lamp) / 2, truth);
  }
  flux.expect_within(1e-7);
}

TEST(RoomLampExtremes, DensityOfSmallTriangles) {
  Sweep sweep(4, "triangle in a room of 6 m", "5e-5 ... 5e-17 sr", "density of directions");
  for (int exponent = -8; exponent <= -2; ++exponent) {
    const double s = std::pow(10.0, exponent);
    const Vec3 a{2.3, 1.7, 2.7}, receiver = a - Vec3{0.1, 0.2, 1};
    const Corners lamp{a, a + Vec3{0, s, 0.1 * s}, a + Vec3{s, 0.3 * s, 0}};
    const Answer answer = sample_at(*room(lamp), receiver, AreaSampling::kSolidAngle);
    EXPECT_EQ(answer.status, ItemResult::kOk);
    const double density = 1 / solid_angle_sr(lamp, receiver);
    sweep.compare(answer.pdf_per_sr, density, fmt::format("1e{} m", exponent));
    const float height = static_cast<float>(a.z) - static_cast<float>(receiver.z);
    sweep.compare_textbook(2 * height * height / doubled_area_in_floats(lamp), density);
  }
  sweep.expect_within(2e-7);
}

TEST(RoomLampExtremes, ReceiversOnLamps) {
  Sweep sweep(7, "receiver on a lamp in a room", "inside, edges, corners; triangle, rectangle",
              "answer");
  for (const double z : {2.4, 2.7, 2.9, 3.1}) {
    for (const bool two_sided : {false, true}) {
      const Corners corners{{0.1, 0.1, z}, {0.1, 0.7, z}, {0.7, 0.1, z}, {0.7, 0.7, z}};
      const auto rectangle = room(corners, two_sided);
      const auto triangle = room({corners[0], corners[1], corners[2]}, two_sided);
      for (const Vec3& p : {Vec3{0.2, 0.3, z}, {0.1, 0.4, z}, {0.1, 0.7, z}, {0.7, 0.1, z}}) {
        for (const auto& scene : {rectangle, triangle}) {
          const Answer answer = sample_at(*scene, p, AreaSampling::kAutomatic);
          sweep.answer(
              answer.status == ItemResult::kDegenerate
                  ? "DEGENERATE"
                  : fmt::format("{} at {} {} {}", static_cast<int>(answer.status), p.x, p.y, p.z));
        }
      }
    }
  }
  sweep.expect_answers("DEGENERATE");
}

TEST(RoomLampExtremes, ReceiversInThePlaneOfALamp) {
  Sweep sweep(8, "receiver in the plane of a lamp in a room", "heights of 2.4 ... 3.1 m", "answer");
  for (const double z : {2.4, 2.7, 2.9, 3.1}) {
    for (const bool two_sided : {false, true}) {
      const auto scene =
          room({{0.1, 0.1, z}, {0.1, 0.7, z}, {0.7, 0.1, z}, {0.7, 0.7, z}}, two_sided);
      for (const Vec3& p : {Vec3{2, 0, z}, {0.1, 0.8, z}, {-2.3, 1.7, z}})
        for (const AreaSampling way :
             {AreaSampling::kAutomatic, AreaSampling::kSolidAngle, AreaSampling::kLowDistortion})
          sweep.answer(sample_at(*scene, p, way).status == ItemResult::kBehind
                           ? "BEHIND"
                           : fmt::format("light at {} {} {}", p.x, p.y, p.z));
    }
  }
  sweep.expect_answers("BEHIND");
}

}  // namespace
}  // namespace lucerna::testing
