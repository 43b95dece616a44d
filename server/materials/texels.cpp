#include "server/materials/texels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// The different values of a picture, as long as a byte can number them.
class Palette {
 public:
  /// The number of the value.  Nothing if there are more than 256 values.
  std::optional<std::uint8_t> code(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    // Neighbours often have the same value.
    std::size_t slot = (bits * 2654435761U) >> 22;
    for (; slots_[slot] != 0; slot = (slot + 1) % slots_.size()) {
      const auto number = static_cast<std::uint8_t>(slots_[slot] - 1);
      if (std::bit_cast<std::uint32_t>(values_[number]) == bits) return number;
    }
    if (values_.size() == 256) return std::nullopt;
    values_.push_back(value);
    slots_[slot] = static_cast<std::uint16_t>(values_.size());
    return static_cast<std::uint8_t>(values_.size() - 1);
  }
  std::vector<float>& values() { return values_; }

 private:
  std::array<std::uint16_t, 1024> slots_{};  ///< number + 1 of a value, by its hash
  std::vector<float> values_;
};

}  // namespace

Texels::Texels(const Image& image)
    : width_(image.width()),
      height_(image.height()),
      is_grey_(std::ranges::all_of(image.texels(),
                                   [](const Rgbf& c) { return c.r == c.g && c.g == c.b; })) {
  const std::size_t values = image.texels().size() * (is_grey_ ? 1 : 3);
  Palette palette;
  codes_.reserve(values);
  const bool is_coded = std::ranges::all_of(image.texels(), [&](const Rgbf& c) {
    const auto r = palette.code(c.r), g = palette.code(c.g), b = palette.code(c.b);
    if (!r || !g || !b) return false;
    codes_.push_back(*r);
    if (!is_grey_) codes_.push_back(*g), codes_.push_back(*b);
    return true;
  });
  if (is_coded) {
    values_ = std::move(palette.values());
    return;
  }
  codes_ = std::vector<std::uint8_t>();  // = {} would keep the memory
  values_.reserve(values);
  for (const Rgbf& c : image.texels()) {
    values_.push_back(c.r);
    if (!is_grey_) values_.push_back(c.g), values_.push_back(c.b);
  }
}

Texels::Texels(int width, int height, bool is_grey, std::vector<std::uint8_t> codes,
               std::vector<float> values)
    : width_(width),
      height_(height),
      is_grey_(is_grey),
      codes_(std::move(codes)),
      values_(std::move(values)) {}

Texels Texels::grey(int width, int height, std::vector<float> values) {
  Palette palette;
  std::vector<std::uint8_t> codes;
  codes.reserve(values.size());
  StopPoll poll;
  for (const float value : values) {
    poll();
    const auto code = palette.code(value);
    if (!code) return Texels(width, height, true, {}, std::move(values));
    codes.push_back(*code);
  }
  return Texels(width, height, true, std::move(codes), std::move(palette.values()));
}

void Texels::make_levels(const std::stop_token& stop) {
  if (!smaller_.empty()) return;
  std::vector<Texels> levels;
  for (const Texels* last = this; last->width_ > 1 || last->height_ > 1; last = &levels.back()) {
    Texels next = last->halved(stop);
    if (stop.stop_requested()) return;
    levels.push_back(std::move(next));
  }
  smaller_ = std::move(levels);
}

template <typename F>
void Texels::for_each_mean(const std::stop_token& stop, F&& f) const {
  for (int y = 0; y < height_ && !stop.stop_requested(); y += 2)
    for (int x = 0; x < width_; x += 2) {
      Rgb sum;
      int count = 0;
      for (int j = y; j < std::min(y + 2, height_); ++j)
        for (int i = x; i < std::min(x + 2, width_); ++i) sum += texel(i, j), ++count;
      f(sum / count);
    }
}

void Texels::halve(const std::stop_token& stop) {
  if (!smaller_.empty()) {
    std::vector<Texels> rest = std::move(smaller_);
    Texels first = std::move(rest.front());
    rest.erase(rest.begin());
    *this = std::move(first);
    smaller_ = std::move(rest);
    return;
  }
  Texels next = halved(stop);
  if (!stop.stop_requested()) *this = std::move(next);
}

Texels Texels::halved(const std::stop_token& stop) const {
  Texels half((width_ + 1) / 2, (height_ + 1) / 2, is_grey_, {}, {});
  // The means are computed twice, since those of a large picture as floats are as large as its
  // codes.
  float largest = 0;
  for_each_mean(stop, [&](const Rgb& mean) {
    largest = std::max(largest, static_cast<float>(mean.max_component()));
  });
  constexpr double kMostSteps = 65535;
  half.step_ = double{largest} / kMostSteps;
  const double per_step = half.step_ > 0 ? 1 / half.step_ : 0;
  half.wide_codes_.reserve(static_cast<std::size_t>(half.width_) *
                           static_cast<std::size_t>(half.height_) * (is_grey_ ? 1 : 3));
  const auto add = [&](double value) {
    half.wide_codes_.push_back(static_cast<std::uint16_t>(
        std::min(static_cast<float>(value) * per_step + 0.5, kMostSteps)));
  };
  for_each_mean(stop, [&](const Rgb& mean) {
    add(mean.r);
    if (!is_grey_) add(mean.g), add(mean.b);
  });
  return half;
}

}  // namespace lucerna
