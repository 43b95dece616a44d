// Row 20: pictures around the sphere at their seams, at their poles and at the edges between
// texels.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/lights/extremes/map_pictures.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;
constexpr float kFloatPi = std::numbers::pi_v<float>;

Vec3 look_of(const Row& row) { return {row["x"], row["y"], row["z"]}; }
std::string place_of(const Row& row) {
  return row.text("mapping") + " " + row.text("filter") + " (" + row.text("x") + ", " +
         row.text("y") + ", " + row.text("z") + ")";
}

/// By the arc cosine of an angle, with the value of a texel at its corner: half a texel off.
float textbook_value(const Row& row) {
  const auto x = static_cast<float>(row["x"]), y = static_cast<float>(row["y"]),
             z = static_cast<float>(row["z"]);
  const int w = static_cast<int>(row["w"]), h = static_cast<int>(row["h"]);
  float s = std::atan2(z, x) / (2 * kFloatPi), t = std::acos(std::clamp(y, -1.0F, 1.0F)) / kFloatPi;
  if (s < 0) s += 1;
  s *= static_cast<float>(w), t *= static_cast<float>(h);
  if (filter_of(row) == ImageFilter::kNearest) s -= 0.5F, t -= 0.5F;
  const auto at = [&](int i, int j) {
    return static_cast<float>(patchy_texel(((i % w) + w) % w, std::clamp(j, 0, h - 1)));
  };
  const int i = static_cast<int>(std::floor(s)), j = static_cast<int>(std::floor(t));
  if (filter_of(row) == ImageFilter::kNearest) return at(i, j);
  const float a = s - static_cast<float>(i), b = t - static_cast<float>(j);
  return (at(i, j) * (1 - a) + at(i + 1, j) * a) * (1 - b) +
         (at(i, j + 1) * (1 - a) + at(i + 1, j + 1) * a) * b;
}

const char* const kPlaces = "1e-9 from the seam, the poles and texel edges; texel centres";

/// Compares `lookup(row)` with a column of the table.
template <typename F>
void sweep_looks(Sweep& sweep, const std::string& column, F&& lookup) {
  const ReferenceTable table("sphere_maps");
  for (const auto& row : table.rows()) {
    sweep.compare(lookup(row), row[column], place_of(row));
    if (column == "value" && mapping_of(row) == SphereMapping::kLatitudeLongitude &&
        row["value"] > 0)
      sweep.compare_textbook(textbook_value(row), row["value"]);
  }
  sweep.expect_within(1e-12);
}

ImageInfiniteLight sky_of(const Row& row) {
  return sky(patchy_image(row), mapping_of(row), filter_of(row));
}
GoniometricLight lamp_of(const Row& row) {
  return lamp(patchy_image(row), mapping_of(row), filter_of(row));
}

TEST(MapExtremes, RadianceOfTheSky) {
  Sweep sweep(20, "environment map, direction", kPlaces, "radiance");
  sweep_looks(sweep, "value",
              [](const Row& row) { return sky_of(row).le_escaped({}, look_of(row)).g; });
}

TEST(MapExtremes, DensityOfTheSky) {
  Sweep sweep(20, "environment map, direction", kPlaces, "density of sampled directions");
  sweep_looks(sweep, "per_sr", [](const Row& row) {
    return sky_of(row).pdf_li({0, 0, 0}, look_of(row)).per_sr;
  });
}

TEST(MapExtremes, IntensityOfALamp) {
  Sweep sweep(20, "goniometric map, direction", kPlaces, "intensity");
  sweep_looks(sweep, "value",
              [](const Row& row) { return lamp_of(row).intensity(look_of(row)).g; });
}

TEST(MapExtremes, DensityOfRaysFromALamp) {
  Sweep sweep(20, "goniometric map, direction", kPlaces, "density of rays that leave it");
  sweep_looks(sweep, "per_sr", [](const Row& row) {
    return lamp_of(row).pdf_le({}, look_of(row), {}).direction.per_sr;
  });
}

/// Calls `f` with skies of the table's kinds: rotated, so that no seam lies along an axis, and
/// unrotated.
template <typename F>
void for_each_sky(F&& f) {
  const Transform turned = *Transform::rotate(1.1, {3, -2, 1});
  for (const Transform& world_from_map : {Transform(), turned})
    for (const ImageFilter filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
      f(sky(grey_image(6, 6, patchy_texel), SphereMapping::kEqualArea, filter, world_from_map), 6,
        6);
      f(sky(grey_image(8, 5, patchy_texel), SphereMapping::kLatitudeLongitude, filter,
            world_from_map),
        8, 5);
      f(sky(grey_image(1024, 512,
                       [](int i, int j) { return (i * 7 + j * 13) % 5 == 0 ? 0 : 1 + i % 3; }),
            SphereMapping::kLatitudeLongitude, filter, world_from_map),
        1024, 512);
    }
}

/// The ends of [0, 1], steps of all sizes from them, and both sides of the shares of `n`.
std::vector<double> sample_values(int n) {
  std::vector<double> u{0, 1};
  for (double step = 0x1p-2; step >= 0x1p-60; step *= 0x1p-4) u.insert(u.end(), {step, 1 - step});
  for (const double share : {1.0 / n, 2.0 / n, 0.5, 1 - 1.0 / n})
    u.insert(u.end(), {share, std::nextafter(share, 0), std::nextafter(share, 1)});
  return u;
}

TEST(MapExtremes, SamplesAgreeWithTheirDirections) {
  Sweep sweep(20, "environment map, sample values",
              "0, 2^-60 ... 1 - 2^-60, 1; both sides of texels",
              "value and density of a sample against those of its direction");
  int kept = 0, rounded_away = 0;
  for_each_sky([&](const ImageInfiniteLight& light, int w, int h) {
    for (const bool incomplete : {false, true})
      for (const double u : sample_values(w))
        for (const double v : sample_values(h)) {
          Receiver receiver(0, 0, 0);
          receiver.incomplete = incomplete;
          const auto s = light.sample_li(receiver, {u, v});
          const std::string at =
              std::to_string(w) + " " + std::to_string(u) + " " + std::to_string(v);
          const double le = light.le_escaped({}, s.wi).g;
          const double pdf = light.pdf_li(receiver, s.wi).per_sr;
          if (s.reason != NoLight::kNone) {
            EXPECT_TRUE(s.value.is_black() && (le == 0 || pdf == 0)) << at;
            ++rounded_away;
            continue;
          }
          sweep.compare(s.value.g, le, "value " + at);
          sweep.compare(s.pdf.per_sr, pdf, "density " + at);
          ++kept;
        }
  });
  // A pole can be so near that a direction does not determine the texel.
  EXPECT_LT(rounded_away, kept / 100);
  sweep.expect_within(0);
}

TEST(MapExtremes, DensityCoversTheLight) {
  Sweep sweep(20, "environment map, directions",
              "2e5 at random, and at 1e-17 ... 0.1 from the poles and the seam",
              "whether the density is positive exactly where there is light");
  RandomU random(20);
  for_each_sky([&](const ImageInfiniteLight& light, int, int) {
    const auto look = [&](const Vec3& map) {
      const Vec3 w = normalized(light.params().world_from_map.vector(map));
      const bool lit = light.le_escaped({}, w).g > 0;
      const bool covered = light.pdf_li({0, 0, 0}, w).per_sr > 0;
      sweep.answer(lit == covered ? "yes" : lit ? "light without density" : "density in the dark");
    };
    for (int i = 0; i < 15000; ++i)
      look({random.next() - 0.5, random.next() - 0.5, random.next() - 0.5});
    for (double d = 0.1; d > 1e-17; d /= 10)
      for (const double a : {-d, 0.0, d})
        for (const double b : {-d, 0.0, d})
          for (const double end : {-1.0, 1.0}) {
            look({a, end, b});
            look({a, b, end});
            look({end, a, b});
          }
  });
  sweep.expect_answers("yes");
}

}  // namespace
}  // namespace lucerna::testing
