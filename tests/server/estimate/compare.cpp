#include "tests/server/estimate/compare.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lucerna::testing {
namespace {

// Linear interpolation between the two nearest order statistics.
double percentile(std::vector<double> values, double percent) {
  std::ranges::sort(values);
  const double at = percent / 100 * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - std::floor(at)) * (values[high] - values[low]);
}

double channel_mean(const Picture& p, int channel) {
  double sum = 0;
  for (std::size_t i = static_cast<std::size_t>(channel); i < p.values.size(); i += 3)
    sum += p.values[i];
  return sum / (static_cast<double>(p.values.size()) / 3);
}

double block_mean(const Picture& p, int x0, int y0, int channel) {
  double sum = 0;
  for (int y = y0; y < y0 + 8; ++y)
    for (int x = x0; x < x0 + 8; ++x) sum += p.at(x, y, channel);
  return sum / 64;
}

}  // namespace

double Picture::mean() const {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

Picture read_picture(const std::string& path) {
  const auto input = OIIO::ImageInput::open(path);
  if (!input) throw std::runtime_error(path + ": " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  int first = 0;
  for (int i = 0; i < spec.nchannels; ++i)
    if (spec.channelnames[static_cast<std::size_t>(i)] == "R") first = i;
  if (spec.nchannels < first + 3) throw std::runtime_error(path + ": fewer than three channels");
  std::vector<float> pixels(3 * spec.image_pixels());
  if (!input->read_image(0, 0, first, first + 3, OIIO::TypeDesc::FLOAT, pixels.data()))
    throw std::runtime_error(path + ": " + input->geterror());
  return {spec.width, spec.height, {pixels.begin(), pixels.end()}};
}

void write_picture(const std::string& path, const Picture& picture) {
  const auto output = OIIO::ImageOutput::create(path);
  const std::vector<float> pixels(picture.values.begin(), picture.values.end());
  if (!output || !output->open(path, {picture.width, picture.height, 3, OIIO::TypeDesc::FLOAT}) ||
      !output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()))
    throw std::runtime_error(path + " cannot be written");
}

Agreement compare(const Picture& mine, const Picture& mine_stderr, const Picture& reference,
                  const Picture& reference_stderr) {
  Agreement a;
  if (mine.width != reference.width || mine.height != reference.height ||
      mine.values.size() != reference.values.size() ||
      mine_stderr.values.size() != mine.values.size() ||
      reference_stderr.values.size() != reference.values.size()) {
    a.why = "size";
    return a;
  }
  a.finite = std::ranges::all_of(mine.values, [](double v) { return std::isfinite(v); });
  if (!a.finite) {
    a.why = "not finite";
    return a;
  }
  bool means_agree = true;
  for (int c = 0; c < 3; ++c) {
    a.mean_ratio[c] = channel_mean(mine, c) / channel_mean(reference, c);
    means_agree &= std::fabs(a.mean_ratio[c] - 1) <= 0.003;
  }
  if (!means_agree) a.why += " mean";

  const double mean = reference.mean();
  std::size_t outliers = 0;
  for (std::size_t i = 0; i < mine.values.size(); i += 3) {
    bool apart = false;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double theirs =
          std::max(reference_stderr.values[c], 5e-3 * reference.values[c] + 1e-3 * mean);
      const double both = std::hypot(std::min(mine_stderr.values[c], 4 * theirs), theirs);
      apart |= std::fabs(mine.values[c] - reference.values[c]) > 6 * both;
    }
    outliers += apart ? 1 : 0;
  }
  a.outliers = static_cast<double>(outliers) / (static_cast<double>(mine.values.size()) / 3);
  if (a.outliers > 0.01) a.why += " pixels";

  std::vector<double> blocks;
  for (int y = 0; y + 8 <= reference.height; y += 8)
    for (int x = 0; x + 8 <= reference.width; x += 8)
      for (int c = 0; c < 3; ++c) {
        const double theirs = block_mean(reference, x, y, c);
        blocks.push_back(std::fabs(block_mean(mine, x, y, c) - theirs) /
                         (0.03 * theirs + 0.003 * mean));
      }
  a.block_percentile = percentile(std::move(blocks), 99);
  if (a.block_percentile > 1) a.why += " blocks";
  return a;
}

}  // namespace lucerna::testing
