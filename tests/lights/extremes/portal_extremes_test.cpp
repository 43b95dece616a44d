// Row 20: portals that are tiny, huge or far, or seen from nearly in their plane.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "lights/models/portal_light.h"
#include "tests/extremes_sweep.h"
#include "tests/lights/sample_statistics.h"
#include "tests/reference_table.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;

/// A square portal with a corner at the origin.
const PortalLight& portal(double side) {
  static std::map<double, PortalLight> made;
  const auto at = made.find(side);
  if (at != made.end()) return at->second;
  return made
      .emplace(side, *PortalLight::create(
                         {.corners_m = {{{0, 0, 0}, {0, side, 0}, {side, side, 0}, {side, 0, 0}}}}))
      .first->second;
}

Vec3 receiver_of(const Row& row) { return {row["x"], row["y"], -row["depth"]}; }
std::string portal_of(const Row& row) {
  return row.text("side") + " m from (" + row.text("x") + ", " + row.text("y") + ", " +
         row.text("depth") + ")";
}

const char* const kSeen =
    "sides of 1e-6 ... 1e6 m, 1e-12 ... 1e12 sides away, directions inside and outside";

TEST(PortalExtremes, Density) {
  Sweep sweep(20, "portal", kSeen, "density of sampled directions");
  const ReferenceTable table("portals");
  for (const auto& row : table.rows()) {
    const auto& light = portal(row["side"]);
    const Vec3 w{row["wx"], row["wy"], row["wz"]};
    sweep.compare(light.pdf_li(receiver_of(row), w).per_sr, row["per_sr"], portal_of(row));
    EXPECT_EQ(light.le_escaped(receiver_of(row), w).g, 1) << portal_of(row);
  }
  sweep.expect_within(1e-11);
}

/// The density is 0 just beyond the edges, and positive just within them.
TEST(PortalExtremes, Edges) {
  Sweep sweep(20, "portal", "half-angles of 1e-9 ... 1.5 rad",
              "density at a thousandth inside and outside an edge");
  const auto& light = portal(1);
  for (const double half : {1e-9, 1e-7, 1e-5, 1e-3, 0.1, 0.5, 1.0, 1.5}) {
    const double depth = 0.5 / std::tan(half);
    const Vec3 middle{0.5, 0.5, -depth};
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, {-1.0, 0.3}, {0.2, 1.0}, {0.7, -1.0}}) {
      const auto towards = [&](double share) {
        return normalized(Vec3{0.5 * share * x, 0.5 * share * y, depth});
      };
      const bool within = light.pdf_li(middle, towards(0.999)).per_sr > 0;
      const bool beyond = light.pdf_li(middle, towards(1.001)).per_sr > 0;
      sweep.answer(!within ? "none within" : beyond ? "some beyond" : "only inside");
    }
  }
  sweep.expect_answers("only inside");
}

/// Values and densities of samples equal those of their directions, and each sample passes through
/// the portal.  The exception is a portal 1e-15 rad above the receiver's plane and narrower than
/// that.
TEST(PortalExtremes, SamplesLeadThroughThePortal) {
  Sweep sweep(20, "portal", kSeen, "samples");
  const ReferenceTable table("portals");
  RandomU random(20);
  for (const auto& row : table.rows()) {
    const auto& light = portal(row["side"]);
    const bool resolved = row["wz"] > 1e-14;
    for (int i = 0; i < 64; ++i) {
      const Vec2 u = random.pair();
      const auto s = light.sample_li(receiver_of(row), u);
      if (!resolved && s.reason == NoLight::kOutOfRange) continue;
      const bool same = light.pdf_li(receiver_of(row), s.wi) == s.pdf;
      const bool through = light.le_escaped(receiver_of(row), s.wi) == s.value;
      sweep.answer(s.reason != NoLight::kNone ? Sweep::name_of(s.reason) + ": " + portal_of(row)
                   : !same                    ? "another density: " + portal_of(row)
                   : through                  ? "pass through it, with the right density"
                                              : "beside it: " + portal_of(row));
    }
  }
  sweep.expect_answers("pass through it, with the right density");
}

}  // namespace
}  // namespace lucerna::testing
