#include "tests/server/extremes/extreme_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <vector>

#include "tests/server/files/photometric_texts.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna::testing {
namespace {

/// A picture of one scale or of any scale.  A fifth of the texels are 0.  Texels below 0 count as
/// 0.
std::string picture(int width, int height, ExtremeNumbers& n) {
  const double scale = n.magnitude();
  const bool one_scale = n.chance(0.5), grey = n.chance(0.3);
  const auto value = [&]() -> float {
    switch (n.below(40)) {
      case 0:
        return std::numeric_limits<float>::max();
      case 1:
        return std::numeric_limits<float>::denorm_min();
      case 2:
        return -static_cast<float>(n.magnitude());
      default:
        break;
    }
    if (n.chance(0.2)) return 0;
    return static_cast<float>(one_scale ? scale * n.uniform() : n.magnitude());
  };
  std::vector<float> rgb;
  for (int i = 0; i < width * height; ++i) {
    const float r = value();
    rgb.insert(rgb.end(), {r, grey ? r : value(), grey ? r : value()});
  }
  return pfm(width, height, rgb);
}

/// Ascending from the first to the second, with up to three between them.  Some are right beside an
/// end.
std::vector<double> angles_deg(double from, double to, ExtremeNumbers& n) {
  std::vector<double> angles{from, to};
  for (std::uint64_t more = n.below(4); more > 0; --more) {
    const double share = n.chance(0.5) ? n.uniform() : n.magnitude(1e-15, 1);
    angles.push_back(n.chance(0.5) ? from + (to - from) * share : to - (to - from) * share);
  }
  std::ranges::sort(angles);
  angles.erase(std::unique(angles.begin(), angles.end()), angles.end());
  return angles;
}

std::vector<std::string> texts(const std::vector<double>& numbers) {
  std::vector<std::string> words;
  for (const double v : numbers) words.push_back(fmt::format("{}", v));
  return words;
}

std::vector<double> intensities(std::size_t count, ExtremeNumbers& n) {
  const double scale = n.magnitude();
  const bool one_scale = n.chance(0.5), huge = n.chance(0.05);
  std::vector<double> all;
  for (std::size_t i = 0; i < count; ++i) {
    if (n.chance(0.2))
      all.push_back(0);
    else if (huge)
      all.push_back(n.magnitude(1e-300, 1e300));
    else
      all.push_back(one_scale ? scale * n.uniform() : n.magnitude());
  }
  return all;
}

std::string ies(ExtremeNumbers& n) {
  Ies f;
  static const std::vector<std::string> kHeaders{f.header, "IESNA91\n", ""};
  f.header = n.one_of(kHeaders);
  f.lamps = fmt::format("1 1000 {}", n.chance(0.5) ? 1 : n.magnitude());
  f.ballast = fmt::format("{} {} 10\n", n.chance(0.5) ? 1 : n.magnitude(),
                          n.chance(0.5) ? 1 : n.magnitude());
  const int type = 1 + static_cast<int>(n.below(3));
  f.type = fmt::format("{}", type);
  std::vector<double> vertical, horizontal{0};
  if (type == 1) {
    const bool up = n.chance(0.3);
    vertical = angles_deg(up ? 90 : 0, up || n.chance(0.5) ? 180 : 90, n);
    if (const std::uint64_t quarters = n.below(5); quarters > 0)
      horizontal = quarters == 3 ? angles_deg(90, 270, n)
                                 : angles_deg(0, 90 * static_cast<double>(quarters), n);
  } else {
    vertical = angles_deg(n.chance(0.5) ? -90 : 0, 90, n);
    horizontal = angles_deg(n.chance(0.5) ? -90 : 0, 90, n);
  }
  f.counts = fmt::format("{} {}", vertical.size(), horizontal.size());
  f.angles = fmt::format("{}\n{}\n", fmt::join(vertical, " "), fmt::join(horizontal, " "));
  f.candela =
      fmt::format("{}\n", fmt::join(intensities(vertical.size() * horizontal.size(), n), " "));
  return f.text();
}

std::string ldt(ExtremeNumbers& n) {
  // The number of planes, of eight, that a file stores for its symmetry.
  constexpr std::array<std::size_t, 5> kPlanes{8, 1, 5, 5, 3};
  const std::size_t symmetry = n.below(kPlanes.size());
  Ldt f = planes(static_cast<int>(symmetry), {});
  f.lamps[2] = fmt::format("{}", n.magnitude());
  f.conversion = fmt::format("{}", n.chance(0.5) ? 1 : n.magnitude());
  f.gamma = texts(angles_deg(0, n.chance(0.5) ? 180 : 90, n));
  f.ng = static_cast<int>(f.gamma.size());
  f.intensities = texts(intensities(kPlanes[symmetry] * f.gamma.size(), n));
  return f.text();
}

}  // namespace

std::map<std::string, std::string> extreme_files(ExtremeNumbers& numbers) {
  const auto size = [&] { return 1 + static_cast<int>(numbers.below(8)); };
  std::map<std::string, std::string> files;
  const int width = size(), height = size(), square = size();
  files["picture.pfm"] = picture(width, height, numbers);
  files["square.pfm"] = picture(square, square, numbers);
  files["luminaire.ies"] = ies(numbers);
  files["luminaire.ldt"] = ldt(numbers);
  return files;
}

}  // namespace lucerna::testing
