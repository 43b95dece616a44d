#include "server/materials/texels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

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

Texels::Texels(const Image& image) : width_(image.width()), height_(image.height()) {
  const auto for_each = [&](auto&& f) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        if (!f(image.texel(x, y))) return false;
    return true;
  };
  is_grey_ = for_each([](const Rgb<float>& c) { return c.r == c.g && c.g == c.b; });
  const std::size_t count = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  Palette palette;
  codes_.reserve(count * (is_grey_ ? 1 : 3));
  const bool is_coded = for_each([&](const Rgb<float>& c) {
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
  values_.reserve(count * (is_grey_ ? 1 : 3));
  for_each([&](const Rgb<float>& c) {
    values_.push_back(c.r);
    if (!is_grey_) values_.push_back(c.g), values_.push_back(c.b);
    return true;
  });
}

void Texels::make_levels() {
  if (!smaller_.empty()) return;
  std::vector<Texels> levels;
  for (const Texels* last = this; last->width_ > 1 || last->height_ > 1; last = &levels.back()) {
    // The copy shares no memory with the elements that push_back may move.
    Texels next = *last;
    next.halve();
    levels.push_back(std::move(next));
  }
  smaller_ = std::move(levels);
}

void Texels::halve() {
  if (!smaller_.empty()) {
    std::vector<Texels> rest = std::move(smaller_);
    Texels first = std::move(rest.front());
    rest.erase(rest.begin());
    *this = std::move(first);
    smaller_ = std::move(rest);
    return;
  }
  const int width = (width_ + 1) / 2, height = (height_ + 1) / 2, channels = is_grey_ ? 1 : 3;
  std::vector<float> means;
  means.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Rgb<double> sum;
      int count = 0;
      for (int j = 2 * y; j < std::min(2 * y + 2, height_); ++j)
        for (int i = 2 * x; i < std::min(2 * x + 2, width_); ++i) sum += texel(i, j), ++count;
      const Rgb<double> mean = sum / count;
      means.push_back(static_cast<float>(mean.r));
      if (!is_grey_) {
        means.push_back(static_cast<float>(mean.g));
        means.push_back(static_cast<float>(mean.b));
      }
    }
  constexpr double kMostSteps = 65535;
  step_ = double{*std::ranges::max_element(means)} / kMostSteps;
  const double per_step = step_ > 0 ? 1 / step_ : 0;
  std::vector<std::uint16_t> codes;
  codes.reserve(means.size());
  for (const float mean : means)
    codes.push_back(static_cast<std::uint16_t>(std::min(mean * per_step + 0.5, kMostSteps)));
  width_ = width, height_ = height;
  wide_codes_ = std::move(codes);
  codes_ = std::vector<std::uint8_t>();
  values_ = std::vector<float>();
}

}  // namespace lucerna
