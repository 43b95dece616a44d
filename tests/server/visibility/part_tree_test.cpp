#include "server/visibility/part_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "server/visibility/specular_path.h"

namespace lucerna::testing {
namespace {

/// Small mirrors at random places, turned at random.
std::vector<SmoothPart> mirrors(int count, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
  std::vector<SmoothPart> parts;
  for (int i = 0; i < count; ++i) {
    SmoothPart p{.reflects = true, .reflected = 0.9};
    p.n = normalized(vector());
    p.middle = vector() * 3.0;
    const Frame frame = Frame::around(p.n);
    p.half_u = frame.s * 0.3, p.half_v = frame.t * 0.2;
    parts.push_back(p);
  }
  return parts;
}

/// Whether a mirror sends light from `light` to `to`.
bool mirrors_light(const SmoothPart& p, const Vec3& to, const Vec3& light) {
  const Vec3 way = light - mirror_image(p, to);
  const double t = p.height(to) / dot(p.n, way);
  const Vec3 at = mirror_image(p, to) + way * t;
  return t > 0 && t < 1 && p.may_contain(at);
}

constexpr auto kAny = [](const PartTree::Node&) { return true; };

TEST(PartTree, VisitsEveryMirrorThatSendsLightAndFewOthers) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-4, 4);
  const std::vector<SmoothPart> parts = mirrors(2000, random);
  const PartTree tree(parts);
  int sending = 0, visited = 0;
  constexpr int kTries = 200;
  for (int i = 0; i < kTries; ++i) {
    const Vec3 to{place(random), place(random), place(random)};
    const Vec3 lamp{place(random), place(random), place(random)};
    constexpr double kRadius = 0.05;
    std::vector<bool> found(parts.size());
    tree.visit([&](const PartTree::Node& node) { return node.may_mirror(to, lamp, kRadius); },
               [&](std::uint32_t part) { found[part] = true, ++visited; });
    const Vec3 far = normalized(lamp);
    std::vector<bool> found_far(parts.size());
    tree.visit([&](const PartTree::Node& node) { return node.may_mirror_from(to, far, 0.01); },
               [&](std::uint32_t part) { found_far[part] = true; });
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const Vec3 point = lamp + Vec3{0.02, -0.03, 0.03};
      if (mirrors_light(parts[p], to, point)) {
        ++sending;
        EXPECT_TRUE(found[p]) << p;
      }
      if (mirrors_light(parts[p], to, to + far * 1e9)) {
        EXPECT_TRUE(found_far[p]) << p;
      }
    }
  }
  EXPECT_GT(sending, kTries);
  EXPECT_LT(visited, kTries * static_cast<int>(parts.size()) / 10);
}

TEST(PartTree, ChoosesWithTheProbabilityThatItSays) {
  std::mt19937 random(3);
  const std::vector<SmoothPart> parts = mirrors(40, random);
  const PartTree tree(parts);
  const Vec3 from{1, 0, -1};
  std::vector<double> share(parts.size()), said(parts.size());
  constexpr int kTries = 100000;
  for (int i = 0; i < kTries; ++i) {
    const auto choice = tree.choose(from, (i + 0.5) / kTries, kAny);
    ASSERT_TRUE(choice);
    share[choice->part] += 1.0 / kTries;
    said[choice->part] = choice->probability;
  }
  double sum = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    EXPECT_GT(said[p], 0) << p;
    EXPECT_NEAR(share[p], said[p], 1e-4) << p;
    sum += said[p];
  }
  EXPECT_NEAR(sum, 1, 1e-9);
  EXPECT_FALSE(PartTree().choose(from, 0.5, kAny));
}

TEST(PartTree, ChoosesOnlyWhatMaySendLight) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-4, 4);
  const std::vector<SmoothPart> parts = mirrors(2000, random);
  const PartTree tree(parts);
  int by_area = 0, chosen = 0;
  for (int pair = 0; pair < 20; ++pair) {
    const Vec3 to{place(random), place(random), place(random)};
    const Vec3 lamp{place(random), place(random), place(random)};
    const auto may = [&](const PartTree::Node& node) { return node.may_mirror(to, lamp, 0.01); };
    std::vector<bool> found(parts.size());
    constexpr int kTries = 5000;
    for (int i = 0; i < kTries; ++i) {
      const double u = (i + 0.5) / kTries;
      const auto any = tree.choose(to, u, kAny);
      ASSERT_TRUE(any);
      by_area += mirrors_light(parts[any->part], to, lamp) ? 1 : 0;
      // A branch may end without a part.
      const auto choice = tree.choose(to, u, may);
      if (!choice) continue;
      found[choice->part] = true;
      chosen += mirrors_light(parts[choice->part], to, lamp) ? 1 : 0;
    }
    for (std::size_t p = 0; p < parts.size(); ++p)
      EXPECT_TRUE(found[p] || !mirrors_light(parts[p], to, lamp)) << p;
  }
  EXPECT_GT(by_area, 0);
  EXPECT_GT(chosen, 3 * by_area);
}

TEST(PartTree, LeavesOutPartsThatAreOnlyNearlySmooth) {
  std::mt19937 random(3);
  std::vector<SmoothPart> parts = mirrors(3, random);
  parts[1].reflects = false;
  int visited = 0;
  PartTree(parts).visit(kAny, [&](std::uint32_t part) { visited += part != 1 ? 1 : 100; });
  EXPECT_EQ(visited, 2);
}

}  // namespace
}  // namespace lucerna::testing
