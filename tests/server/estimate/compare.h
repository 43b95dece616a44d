// The rule by which a rendered picture agrees with a reference, for all reference tests.
#pragma once

#include <string>
#include <vector>

namespace lucerna::testing {

/// Three channels per pixel, rows from the top.
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

/// The channels R, G, B of an image file.  Throws std::runtime_error if it cannot be read.
Picture read_picture(const std::string& path);
/// Writes 32-bit floats in the format of the extension.
void write_picture(const std::string& path, const Picture& picture);

struct Agreement {
  bool finite = false;
  double mean_ratio[3] = {};  ///< mine over the reference's, by channel
  double outliers = 0;        ///< share of pixels that differ by more than six standard errors
  double block_percentile =
      0;            ///< 99th of the 8x8 blocks' differences, in units of the allowed difference
  std::string why;  ///< the failed conditions; empty if the pictures agree
};

/// Pictures agree if every value is finite and three conditions hold.  Each channel's mean differs
/// by less than 0.3%.  At most 1% of the pixels differ in some channel by more than six combined
/// standard errors.  99% of the 8x8 blocks differ by less than 3% of themselves plus 0.3% of the
/// mean.
///
/// The reference's standard error counts as at least 0.5% of the pixel plus 0.1% of the mean.  That
/// of `mine` counts up to four times the reference's, so that a noisy picture cannot hide a wrong
/// one.
Agreement compare(const Picture& mine, const Picture& mine_stderr, const Picture& reference,
                  const Picture& reference_stderr);

}  // namespace lucerna::testing
