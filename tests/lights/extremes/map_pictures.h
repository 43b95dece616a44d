// The pictures of tests/data/extremes/maps.py as maps and lights.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lights/models/goniometric_light.h"
#include "lights/models/image_infinite_light.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"

namespace lucerna::testing {

/// `value(i, j)` is the texel in column i and row j.
template <typename F>
std::shared_ptr<const Image> grey_image(int width, int height, F&& value) {
  std::vector<Rgbf> texels;
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) texels.emplace_back(static_cast<float>(value(i, j)));
  return *Image::create(width, height, std::move(texels));
}

/// The picture of the table `sphere_maps`.  A third of it is black.
inline double patchy_texel(int i, int j) { return std::max(0, (3 * i + 5 * j) % 9 - 2); }

inline SphereMapping mapping_of(const ReferenceTable::Row& row) {
  return row.text("mapping") == "equalarea" ? SphereMapping::kEqualArea
                                            : SphereMapping::kLatitudeLongitude;
}
inline ImageFilter filter_of(const ReferenceTable::Row& row) {
  return row.text("filter") == "nearest" ? ImageFilter::kNearest : ImageFilter::kBilinear;
}

inline std::shared_ptr<const Image> patchy_image(const ReferenceTable::Row& row) {
  return grey_image(static_cast<int>(row["w"]), static_cast<int>(row["h"]), patchy_texel);
}

/// The texel at (5, 2) is `bright`, all others `background`.
inline std::shared_ptr<const Image> spotted_image(const ReferenceTable::Row& row) {
  return grey_image(
      8, 8, [&](int i, int j) { return i == 5 && j == 2 ? row["bright"] : row["background"]; });
}

inline ImageInfiniteLight sky(std::shared_ptr<const Image> image, SphereMapping mapping,
                              ImageFilter filter, const Transform& turned = {}) {
  return *ImageInfiniteLight::create(
      {.map = *SphereMap::create(std::move(image), mapping, filter), .world_from_map = turned});
}

inline GoniometricLight lamp(std::shared_ptr<const Image> image, SphereMapping mapping,
                             ImageFilter filter) {
  return *GoniometricLight::create(
      {.intensity = Rgb(1), .map = *IntensityMap::create(std::move(image), mapping, filter)});
}

}  // namespace lucerna::testing
