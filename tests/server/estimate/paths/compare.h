// Whether a rendered picture agrees with a reference: one rule for all reference tests.
#pragma once

#include <string>
#include <vector>

namespace lucerna::testing {

/// Three channels a pixel, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<double> values;

  double at(int x, int y, int channel) const {
    return values[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)) +
                  static_cast<std::size_t>(channel)];
  }
  double mean() const;
};

/// The channels R, G, B of an image file; throws std::runtime_error where it cannot be read.
Picture read_picture(const std::string& path);
/// As 32-bit floats; the format follows the extension.
void write_picture(const std::string& path, const Picture& picture);

struct Agreement {
  bool finite = false;
  double mean_ratio[3] = {};  ///< mine over the reference's, by channel
  double outliers = 0;        ///< share of pixels further apart than six standard errors
  double block_percentile =
      0;            ///< 99th of the 8x8 blocks' differences, in units of what is allowed
  std::string why;  ///< which parts disagree; empty where the pictures agree
};

/// They agree when every value is finite; each channel's mean differs by less than 0.3%; at most 1%
/// of the pixels differ in some channel by more than six combined standard errors, the reference's
/// being at least 0.5% of the pixel plus 0.1% of the mean, and `mine`'s counted up to four times
/// that, so that a noisy picture cannot hide a wrong one; and 99% of the 8x8 blocks differ by less
/// than 3% of themselves plus 0.3% of the mean.
Agreement compare(const Picture& mine, const Picture& mine_stderr, const Picture& reference,
                  const Picture& reference_stderr);

}  // namespace lucerna::testing
