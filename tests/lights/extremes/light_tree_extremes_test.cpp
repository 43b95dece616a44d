// Rows 13 to 16: choosing one of many lights by a tree.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/maths/vec.h"
#include "tests/extremes_sweep.h"
#include "tests/lights/local_lights.h"
#include "tests/value_of.h"

namespace lucerna::testing {
namespace {

/// A random number with 48 bits.
double random_u(RandomU& random) { return double{random.next()} + double{random.next()} * 0x1p-24; }

/// Whether the textbook's importance of a light's bounds is 0, for a receiver without a normal, in
/// floats.  From the angle to the axis it subtracts those of the normals' cone and of the box.  It
/// compares the result with the angle of emission, all by cosines.  [Pharr23, 12.6.3]
bool textbook_leaves_out(const LightBounds& bounds, const Vec3& position) {
  const Vec3f low(bounds.lower), high(bounds.upper), p(position), axis(bounds.axis);
  const Vec3f center = (low + high) * 0.5F;
  const auto cos_less = [](float cos_a, float sin_a, float cos_b, float sin_b) {
    return cos_a > cos_b ? 1 : cos_a * cos_b + sin_a * sin_b;
  };
  const auto sin_less = [](float cos_a, float sin_a, float cos_b, float sin_b) {
    return cos_a > cos_b ? 0 : sin_a * cos_b - cos_a * sin_b;
  };
  const auto sine = [](float cos) { return std::sqrt(std::fmax(0.F, 1 - cos * cos)); };
  float cos = dot(axis, normalized(p - center));
  if (bounds.two_sided) cos = std::fabs(cos);
  const float r2 = dot(high - center, high - center), d2 = dot(p - center, p - center);
  const float cos_box = d2 < r2 ? -1 : std::sqrt(std::fmax(0.F, 1 - r2 / d2));
  const auto cos_o = static_cast<float>(std::cos(bounds.normals_rad));
  const double emitted = bounds.two_sided ? kPi / 2 : bounds.cone_rad - bounds.normals_rad;
  const float beyond_cos = cos_less(cos, sine(cos), cos_o, sine(cos_o));
  const float beyond_sin = sin_less(cos, sine(cos), cos_o, sine(cos_o));
  return !(cos_less(beyond_cos, beyond_sin, cos_box, sine(cos_box)) >
           static_cast<float>(std::cos(emitted)));
}

/// Counts receivers that a light reaches although the tree never chooses it.
class EdgeSearch {
 public:
  EdgeSearch(const std::vector<LocalLight>& lights, double size, std::uint64_t seed)
      : lights_(lights), tree_(tree_of(lights)), size_(size), random_(seed) {}

  void search(std::uint32_t light, int receivers) {
    light_ = light;
    bounds_ = bounds_of(lights_[light]);
    const Vec3 center = bounds_.lower * 0.5 + bounds_.upper * 0.5;
    std::optional<Vec3> lit, dark;
    for (int i = 0; i < receivers; ++i) {
      u_ = random_.pair();
      const Vec3 p = center + somewhere();
      (arrives(p) ? lit : dark) = p;
      if (i % 8 == 0 && lit && dark) {
        // The last lit double on the way to a dark place.
        Vec3 inside = *lit, outside = *dark;
        for (int k = 0; k < 60; ++k) {
          const Vec3 middle = (inside + outside) * 0.5;
          (arrives(middle) ? inside : outside) = middle;
        }
        check(inside);
      } else if (i % 8 == 1) {
        check(near_plane(center));
      } else {
        check(p);
      }
    }
  }

  std::int64_t missed = 0, checked = 0, dark = 0, missed_by_textbook = 0;
  std::string where;  ///< the last missed receiver

 private:
  double number() { return 2.0 * random_.next() - 1; }
  Vec3 direction() { return normalized(Vec3{number(), number(), number()}); }
  /// Half of the offsets are within 50 sizes.  The others reach as far as 1e20, from where all of a
  /// light is at one angle.
  Vec3 somewhere() {
    const double log_distance =
        random_.next() < 0.5F ? 12 * double{random_.next()} - 8 : 46 * double{random_.next()};
    return direction() * (size_ * std::exp(log_distance));
  }
  /// Just above or below the plane of a flat light.
  Vec3 near_plane(const Vec3& center) {
    const Vec3 n = normalized(bounds_.axis), w = somewhere();
    return center + (w - n * dot(w, n)) + n * (length(w) * number() * next_to_nothing());
  }
  double next_to_nothing() { return std::pow(10, -18 * random_.next()); }
  bool arrives(const Receiver& receiver) {
    const auto s = sample_of(lights_[light_], receiver, u_);
    wi_ = s.wi;
    return s.reason == NoLight::kNone && s.value.max_component() > 0;
  }

  void check(const Vec3& p) {
    Receiver receiver(p);
    ++checked;
    if (!arrives(receiver)) {
      ++dark;
      return;
    }
    if (textbook_leaves_out(bounds_, p)) ++missed_by_textbook;
    bool is_chosen = tree_.probability(receiver, light_) > 0;
    // A surface that the light nearly grazes, for a caller that receives directions in floats.
    const Vec3 along = cross(wi_, direction());
    receiver.normal = normalized(normalized(along) + wi_ * (number() * next_to_nothing()));
    if (arrives(receiver) &&
        (dot(wi_, receiver.normal) > 0 || dot(Vec3(Vec3f(wi_)), receiver.normal) > 0))
      is_chosen &= tree_.probability(receiver, light_) > 0;
    if (is_chosen) return;
    ++missed;
    where = fmt::format("{} at ({}, {}, {})", lights_[light_].name, p.x, p.y, p.z);
  }

  const std::vector<LocalLight>& lights_;
  LightTree tree_;
  double size_;
  RandomU random_;
  std::uint32_t light_ = 0;
  LightBounds bounds_;
  Vec2 u_;
  Vec3 wi_;
};

TEST(LightTreeExtremes, ReceiversAtTheExactEdge) {
  Sweep sweep(
      13,
      "light tree of all local lights; receivers at edges of cones, in planes of lights, at "
      "grazing angles",
      "sizes 1e-30 ... 1e30 m, 0 ... 1e6 sizes from the origin, edges exact to the last bit",
      "receivers lit by a light that is never chosen");
  std::int64_t missed = 0, checked = 0, dark = 0, textbook = 0;
  RandomU random(13);
  for (const double size : {1e-30, 1e-6, 1., 1e30})
    for (const double spread : {3., 1e6}) {
      const std::vector<LocalLight> lights = LocalLights(random_place(random, size, spread)).take();
      EdgeSearch edges(lights, size, 1300 + checked);
      for (std::uint32_t i = 0; i < lights.size(); ++i) edges.search(i, 4000);
      EXPECT_EQ(edges.missed, 0) << edges.where;
      missed += edges.missed;
      checked += edges.checked;
      dark += edges.dark;
      textbook += edges.missed_by_textbook;
    }
  EXPECT_GT(checked, 1000000);
  EXPECT_LT(dark, checked * 2 / 3);
  sweep.textbook_count(textbook);
  sweep.expect_none(missed, checked, dark);
}

/// The share of the first of two lights, in floats.  The squared distance is clamped to half the
/// diagonal of the box.  [Pharr23, 12.6.3]
float textbook_share(const LightTree::Item (&items)[2], const Vec3& position) {
  float weight[2];
  for (int i = 0; i < 2; ++i) {
    const Vec3f low(items[i].bounds.lower), high(items[i].bounds.upper), p(position);
    const Vec3f way = p - (low + high) * 0.5F;
    weight[i] =
        static_cast<float>(items[i].power) / std::fmax(dot(way, way), length(high - low) / 2);
  }
  return weight[0] / (weight[0] + weight[1]);
}

TEST(LightTreeExtremes, ScenesOfAnyScale) {
  Sweep sweep(14, "scenes of local lights, scaled with their receivers",
              "by 2^-20 ... 2^20 and to 1e-30 and 1e30 m, powers by 2^-99 ... 2^99",
              "choices and probabilities with a changed bit");
  std::int64_t changed = 0, checked = 0, changed_in_textbook = 0;
  RandomU random(14);
  for (int scene = 0; scene < 4; ++scene) {
    std::vector<LightTree::Item> items;
    for (int i = 0; i < 5; ++i)
      for (const LocalLight& l : LocalLights(random_place(random, 1, 4)).take())
        items.push_back({bounds_of(l), power_of(l)});
    const LightTree tree = *LightTree::create(items);
    for (const int exponent : {-100, -60, -20, -10, -1, 1, 10, 20, 60, 96})
      for (const int of_power : {-99, 0, 1, 99}) {
        std::vector<LightTree::Item> other = items;
        for (LightTree::Item& item : other) {
          item.bounds.lower = scaled(item.bounds.lower, exponent);
          item.bounds.upper = scaled(item.bounds.upper, exponent);
          item.power = std::scalbn(item.power, of_power);
        }
        const LightTree scaled_tree = *LightTree::create(other);
        for (int i = 0; i < 200; ++i) {
          const auto number = [&] { return 5 * (2.0 * random.next() - 1); };
          Receiver here(Vec3{number(), number(), number()});
          if (i % 2 == 0) here.normal = normalized(Vec3{number(), number(), number()});
          Receiver there = here;
          there.position = scaled(here.position, exponent);
          const double u = random_u(random);
          const auto a = tree.choose(here, u), b = scaled_tree.choose(there, u);
          ++checked;
          if (a.has_value() != b.has_value() ||
              (a && (a->light != b->light || a->probability != b->probability ||
                     scaled_tree.probability(there, a->light) != a->probability)))
            ++changed;
          const std::size_t k = i % (items.size() - 1);
          const float share = textbook_share({items[k], items[k + 1]}, here.position);
          const float same = textbook_share({other[k], other[k + 1]}, there.position);
          if (std::fabs(share - same) > 1e-5F || std::isnan(same)) ++changed_in_textbook;
        }
      }
  }
  sweep.textbook_count(changed_in_textbook);
  sweep.expect_none(changed, checked, 0);
}

TEST(LightTreeExtremes, AMillionLightsInALine) {
  Sweep sweep(15, "a million lights in a line, at distances that grow by a constant factor",
              "distances 2^-100 ... 1, 1e-30 ... 1e30 m; powers equal, or proportional to the "
              "squared distance",
              "choices that are invalid or have a wrong probability");
  std::int64_t wrong = 0, checked = 0;
  RandomU random(15);
  // The powers fall with the distance.  So each split leaves most of the extent to one side, and
  // the tree is at least 130 nodes deep.
  struct Line {
    std::uint32_t count;
    double first, last, power_exponent;
  };
  for (const Line& line : {Line{1'000'000, 0x1p-100, 1, 2}, Line{30'000, 1e-30, 1e30, 0},
                           Line{30'000, 1e-30, 1e30, 2}}) {
    std::vector<LightTree::Item> lamps(line.count);
    for (std::uint32_t i = 0; i < line.count; ++i) {
      const double share = i / (line.count - 1.0);
      const double x = line.first * std::pow(line.last / line.first, share);
      const Vec3 at{x, 0, 0};
      lamps[i] = {{.lower = at, .upper = at, .cone_rad = kPi},
                  std::pow(x / line.last, line.power_exponent)};
    }
    const auto tree = value_of(LightTree::create(lamps));
    EXPECT_EQ(tree.size(), line.count);
    for (int i = 0; i < 30000; ++i) {
      const double y = line.first * std::pow(line.last / line.first, random.next());
      const Receiver receiver(Vec3{0, y, 0});
      const double u = i == 0 ? 0 : i == 1 ? 1 - 0x1p-48 : random_u(random);
      const auto choice = tree.choose(receiver, u);
      ++checked;
      if (!choice || choice->light >= line.count || !(choice->probability > 0) ||
          tree.probability(receiver, choice->light) != choice->probability)
        ++wrong;
      // Rarely chosen lights have a positive probability too.
      const auto any = static_cast<std::uint32_t>(random.next() * line.count);
      if (!(tree.probability(receiver, any) > 0)) ++wrong;
    }
    if (line.count > 100000) continue;
    double sum = 0;
    const Receiver receiver(Vec3{0, std::sqrt(line.first * line.last), 0});
    for (std::uint32_t i = 0; i < line.count; ++i) sum += tree.probability(receiver, i);
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  sweep.expect_none(wrong, checked, 0);
}

TEST(LightTreeExtremes, EveryOneOfManyLightsIsReached) {
  // 4096 lamps have the share that 4096 of so many lights have together.  One bright lamp takes the
  // share of all the others.  It stands at either end, so that the 4096 have the smallest values of
  // u, or the largest.
  constexpr std::uint32_t kLamps = 4096;
  Sweep sweep(
      16, "4096 lights, each with the probability of one of many lights, chosen by a u of 48 bits",
      "one of 2^24 ... 2^32 lights", "lights that no u selects");
  std::int64_t unreached = 0, checked = 0, unreached_by_float = 0;
  RandomU random(16);
  for (const int bits : {24, 26, 28, 30, 32})
    for (const bool is_bright_first : {false, true}) {
      std::vector<LightTree::Item> lamps(kLamps + 1);
      for (LightTree::Item& lamp : lamps) {
        const Vec3 at{random.next(), random.next(), random.next()};
        lamp = {{.lower = at, .upper = at, .cone_rad = kPi}, 1};
      }
      const Vec3 aside{is_bright_first ? -2. : 3., 0, 0};
      lamps[kLamps] = {{.lower = aside, .upper = aside, .cone_rad = kPi}, std::ldexp(1.0, bits)};
      const LightTree tree = *LightTree::create(lamps);
      const Receiver far(Vec3{0, 0, 1e9});
      std::vector<bool> reached(kLamps), reached_by_float(kLamps);
      // Twice their common share, in 2^18 steps: 32 for each lamp.
      constexpr int kSteps = 1 << 18;
      for (int i = 0; i < kSteps; ++i) {
        const double below = std::ldexp(2.0 * kLamps * i / kSteps, -bits);
        const double u = std::floor((is_bright_first ? 1 - below : below) * 0x1p48) * 0x1p-48;
        if (!(u < 1)) continue;
        const std::uint32_t light = tree.choose(far, u)->light;
        if (light < kLamps) reached[light] = true;
        // The bits that a float keeps of a value in [0, 1) with equal steps.
        const std::uint32_t other = tree.choose(far, std::floor(u * 0x1p24) * 0x1p-24)->light;
        if (other < kLamps) reached_by_float[other] = true;
      }
      checked += kLamps;
      for (std::uint32_t i = 0; i < kLamps; ++i) {
        EXPECT_GT(tree.probability(far, i), std::ldexp(0.5, -bits));
        unreached += reached[i] ? 0 : 1;
        unreached_by_float += reached_by_float[i] ? 0 : 1;
      }
    }
  sweep.textbook_count(unreached_by_float);
  sweep.expect_none(unreached, checked, 0);
}

}  // namespace
}  // namespace lucerna::testing
