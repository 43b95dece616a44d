#include "client/lab/rotation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucerna::verify {
namespace {

constexpr double kCoarseDegrees = 5;
constexpr double kFineDegrees = 0.5;

/// The mean distance of the logarithms, each at most 1.
double distance(const std::vector<double>& theirs, const std::vector<double>& predicted) {
  double sum = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (theirs[i] > 0 && predicted[i] > 0) {
      sum += std::min(1.0, std::fabs(std::log(theirs[i] / predicted[i])));
    } else if (theirs[i] > 0 || predicted[i] > 0) {
      sum += 1;
    }
  }
  return sum / static_cast<double>(theirs.size());
}

}  // namespace

void add_rotation(const v1::Light& light, const std::vector<double>& theirs,
                  const std::function<std::vector<double>(const Variation&)>& predict,
                  std::vector<Hypothesis>* hypotheses) {
  if (theirs.empty() || turned(light).empty()) return;
  const LightFrame frame = frame_of(light);
  if (!frame.all_turns && !frame.quarter_turns) return;
  constexpr const char* kNames[] = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis != 2 && !frame.all_turns) continue;
    LightFrame about = frame;
    about.axes = {frame.axes[(axis + 1) % 3], frame.axes[(axis + 2) % 3], frame.axes[axis]};
    double best = 0, least = std::numeric_limits<double>::infinity();
    const auto search = [&](double from, double to, double step) {
      for (double degrees = from; degrees <= to + step / 2; degrees += step) {
        const double d = distance(theirs, predict(turned_about_z(about, degrees)));
        if (d < least) {
          least = d;
          best = degrees;
        }
      }
    };
    search(kCoarseDegrees - 180, 180, kCoarseDegrees);
    const double coarse = best;
    search(coarse - kCoarseDegrees, coarse + kCoarseDegrees, kFineDegrees);
    Variation v = turned_about_z(about, best);
    v.sentence = fmt::format("the map is rotated by about {:g} degrees about {} of the light", best,
                             kNames[axis]);
    hypotheses->push_back({v.mistake, v.sentence, predict(v), 2});
  }
}

}  // namespace lucerna::verify
