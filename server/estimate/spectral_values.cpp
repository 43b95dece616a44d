#include "server/estimate/spectral_values.h"

#include <algorithm>
#include <cmath>

namespace lucerna {
namespace {
// Scenes usually have a few spectra.  This limits memory if there are a million.
constexpr std::size_t kMostSpectra = 256;
}  // namespace

void SpectralValues::add(std::optional<std::uint32_t> spectrum, const Rgb& value,
                         std::span<double> sum) {
  if (size() == 0 || value.is_black()) return;
  if (!spectrum) {
    if (basis_.empty())
      for (const double nm : wavelengths_nm_) basis_.push_back(rgb_basis_per_lumen(nm));
    for (std::size_t k = 0; k < size(); ++k) {
      const Rgb c = basis_[k] * value;
      sum[k] += c.r + c.g + c.b;
    }
    return;
  }
  if (per_lumen_.size() >= kMostSpectra && !per_lumen_.contains(*spectrum)) per_lumen_.clear();
  const auto [row, is_new] = per_lumen_.try_emplace(*spectrum);
  if (is_new)
    for (const double nm : wavelengths_nm_)
      row->second.push_back(scene_.lights().spectra()[*spectrum]->per_lumen(nm));
  const double lumens = luminance(value);
  for (std::size_t k = 0; k < size(); ++k) sum[k] += lumens * row->second[k];
}

bool store_spectral(std::span<const double> values, float* out) {
  if (!std::ranges::all_of(values, [](double v) { return std::isfinite(static_cast<float>(v)); }))
    return false;
  std::ranges::transform(values, out, [](double v) { return static_cast<float>(v); });
  return true;
}

}  // namespace lucerna
