#include "lights/maths/spectrum.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lights/maths/cie.h"
#include "lights/maths/rgb_basis.h"
#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

using cie::kObserverFirstNm;
using cie::kObserverSize;
using cie::kObserverStepNm;

double observer_nm(std::size_t k) {
  return kObserverFirstNm + kObserverStepNm * static_cast<double>(k);
}

/// Interpolates between entries of a table at the observer's wavelengths, which end at 830 nm.
template <typename T>
T between(std::span<const T> table, double nm) {
  const double x = std::clamp((nm - kObserverFirstNm) / kObserverStepNm, 0.0,
                              static_cast<double>(table.size() - 1));
  const auto below = std::min(static_cast<std::size_t>(x), table.size() - 2);
  const double t = x - static_cast<double>(below);
  return table[below] * (1 - t) + table[below + 1] * t;
}

/// The sum over the table's wavelengths, times their distance.
template <typename F>
Vec3 table_sum(F&& value) {
  Vec3 xyz{};
  for (std::size_t k = 0; k < kObserverSize; ++k) xyz += cie::observer()[k] * value(observer_nm(k));
  return xyz * kObserverStepNm;
}

/// Second radiation constant h c / k, exact since 2019.  [CODATA18]
constexpr double kSecondRadiationNmK = 1.438776877e7;

/// The logarithm of Planck's law: ln(nm^-5 / (exp(c2 / (nm T)) - 1)).  For low temperatures, the
/// visible values leave the range of double.
double log_planck(double nm, double kelvin) {
  const double x = kSecondRadiationNmK / (nm * kelvin);
  return -5 * std::log(nm) - x - std::log(-std::expm1(-x));
}

/// ln of the integral of exp(log_planck) over all wavelengths: (T / c2)^4 pi^4 / 15, the law of
/// Stefan and Boltzmann.
double log_planck_total(double kelvin) {
  return 4 * std::log(kelvin / kSecondRadiationNmK) + std::log(kPi * kPi * kPi * kPi / 15);
}

const cie::Illuminant& d65() {
  static const cie::Illuminant& table = *cie::find_illuminant("D65");
  return table;
}

Vec3 d65_xyz() {
  static const Vec3 xyz = table_sum([](double nm) { return cie::value_at(d65(), nm); });
  return xyz;
}

double interpolate(std::span<const double> x, std::span<const double> y, double at) {
  if (x.empty() || !(at >= x.front() && at <= x.back())) return 0;
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(x, at) - x.begin());
  if (above == x.size()) return y.back();
  const double t = (at - x[above - 1]) / (x[above] - x[above - 1]);
  return std::lerp(y[above - 1], y[above], t);
}

/// The integral of a piecewise linear function.
double total(std::span<const double> nm, std::span<const double> values) {
  double sum = 0;
  StopPoll poll;
  for (std::size_t i = 1; i < nm.size(); ++i, poll())
    sum += (nm[i] - nm[i - 1]) * (0.5 * values[i - 1] + 0.5 * values[i]);
  return sum;
}

}  // namespace

absl::Status check_samples(const SampledSpectrum& s) {
  const std::vector<double>& nm = s.wavelengths_nm;
  if (nm.size() != s.values.size() || nm.empty())
    return absl::InvalidArgumentError(
        fmt::format("spectrum of {} wavelengths and {} values, allowed: equal numbers, at least 1",
                    nm.size(), s.values.size()));
  StopPoll poll;
  for (std::size_t i = 0; i < nm.size(); ++i, poll()) {
    if (!(nm[i] >= 0 && std::isfinite(nm[i])))
      return absl::InvalidArgumentError(
          fmt::format("wavelength {} nm, allowed: finite, not negative", nm[i]));
    if (i > 0 && !(nm[i] > nm[i - 1]))
      return absl::InvalidArgumentError(
          fmt::format("wavelength {} nm follows {} nm, allowed: ascending", nm[i], nm[i - 1]));
    if (!(s.values[i] >= 0 && std::isfinite(s.values[i])))
      return absl::InvalidArgumentError(
          fmt::format("value {} at {} nm, allowed: finite, not negative", s.values[i], nm[i]));
  }
  return absl::OkStatus();
}

namespace {

/// The integral of samples against a table at the observer's wavelengths.
Vec3 integral(std::span<const Vec3> observer, std::span<const double> wavelengths_nm,
              std::span<const double> values) {
  Vec3 xyz{};
  if (wavelengths_nm.empty()) return xyz;
  std::vector<double> nodes;
  for (std::size_t k = 0; k < kObserverSize; ++k) nodes.push_back(observer_nm(k));
  const double first = nodes.front(), last = nodes.back();
  StopPoll poll;
  for (const double nm : wavelengths_nm) {
    poll();
    if (nm > first && nm < last) nodes.push_back(nm);
  }
  std::ranges::sort(nodes, [&](double a, double b) { return poll(), a < b; });
  for (std::size_t i = 1; i < nodes.size(); ++i, poll()) {
    const double a = std::max(nodes[i - 1], wavelengths_nm.front());
    const double b = std::min(nodes[i], wavelengths_nm.back());
    if (!(b > a)) continue;
    // Exact, because both factors are linear here.  It uses no point in between: a line may be so
    // narrow that no double lies inside.
    const double at_a = interpolate(wavelengths_nm, values, a);
    const double at_b = interpolate(wavelengths_nm, values, b);
    xyz += (between(observer, a) * (2 * at_a + at_b) + between(observer, b) * (at_a + 2 * at_b)) *
           ((b - a) / 6);
  }
  return xyz;
}

}  // namespace

Vec3 tristimulus(std::span<const double> wavelengths_nm, std::span<const double> values) {
  return integral(cie::observer(), wavelengths_nm, values);
}

Rgb reflected_rgb(std::span<const double> wavelengths_nm, std::span<const double> values) {
  static const std::vector<Vec3> weights = [] {
    std::vector<Vec3> under_d65;
    for (std::size_t k = 0; k < kObserverSize; ++k)
      under_d65.push_back(cie::observer()[k] * cie::value_at(d65(), observer_nm(k)));
    return under_d65;
  }();
  static const Vec3 white = [] {
    constexpr double kAll[] = {0, 1e4}, kOne[] = {1, 1};
    return integral(weights, kAll, kOne);
  }();
  const Vec3 xyz = integral(weights, wavelengths_nm, values);
  // The white of this integral and of the table's sum differ in the seventh digit.
  const Vec3 d65_white = d65_xyz() / d65_xyz().y;
  return rgb_from_xyz({xyz.x / white.x * d65_white.x, xyz.y / white.y * d65_white.y,
                       xyz.z / white.z * d65_white.z});
}

Rgb rgb_from_xyz(const Vec3& xyz) {
  // X and Z of (1, 1, 1), the sums of the inverse's first and last row.
  constexpr double kX = 0.9504559270516718, kZ = 1.0890577507598784;
  const Vec3 white = d65_xyz();
  const Vec3 c{xyz.x * (kX * white.y / white.x), xyz.y, xyz.z * (kZ * white.y / white.z)};
  return {3.2409699419045213 * c.x - 1.5373831775700935 * c.y - 0.4986107602930033 * c.z,
          -0.9692436362808798 * c.x + 1.8759675015077206 * c.y + 0.0415550574071756 * c.z,
          0.0556300796969936 * c.x - 0.2039769588889765 * c.y + 1.0569715142428786 * c.z};
}

Rgb rgb_basis_per_lumen(double nm) {
  // Outside of the observer's table, the reflectances are constant.
  const double light = cie::value_at(d65(), nm);
  return between(std::span<const Rgb>(kRgbBasis), nm) *
         (light / (cie::kLumensPerWatt * d65_xyz().y));
}

Spectrum::Spectrum(Source source, const Vec3& xyz) : source_(std::move(source)) {
  const Rgb raw = rgb_from_xyz(xyz / xyz.y);
  // A channel below zero by rounding is not a colour outside of RGB.
  clipped_ = std::min({raw.r, raw.g, raw.b}) < -1e-9;
  rgb_ = {std::max(raw.r, 0.0), std::max(raw.g, 0.0), std::max(raw.b, 0.0)};
  rgb_ = rgb_ / luminance(rgb_);
}

absl::StatusOr<Spectrum> Spectrum::create(const BlackBody& source) {
  if (!(source.kelvin >= 100 && source.kelvin <= 1e7))
    return absl::InvalidArgumentError(
        fmt::format("black body of {} K, allowed: [100, 1e7] K", source.kelvin));
  // Relative to the red end: for low temperatures the largest visible values are there.
  const double reference = log_planck(observer_nm(kObserverSize - 1), source.kelvin);
  const Vec3 xyz =
      table_sum([&](double nm) { return std::exp(log_planck(nm, source.kelvin) - reference); });
  Spectrum s(source, xyz);
  s.log_per_lumen_ = -reference - std::log(cie::kLumensPerWatt * xyz.y);
  s.watts_per_lumen_ = std::exp(log_planck_total(source.kelvin) + s.log_per_lumen_);
  return s;
}

absl::StatusOr<Spectrum> Spectrum::create(const CieIlluminant& source) {
  const cie::Illuminant* table = cie::find_illuminant(source.name);
  if (table == nullptr) {
    std::string names;
    for (const cie::Illuminant& i : cie::illuminants()) names += fmt::format(" {}", i.name);
    return absl::InvalidArgumentError(
        fmt::format("unknown illuminant \"{}\", allowed:{}", source.name, names));
  }
  const Vec3 xyz = table_sum([&](double nm) { return cie::value_at(*table, nm); });
  Spectrum s(source, xyz);
  s.scale_ = 1 / (cie::kLumensPerWatt * xyz.y);
  double sum = 0;
  for (std::size_t i = 1; i < table->values.size(); ++i)
    sum += 0.5 * (table->values[i - 1] + table->values[i]);
  s.watts_per_lumen_ = s.scale_ * sum * table->step_nm;
  return s;
}

absl::StatusOr<Spectrum> Spectrum::create(SampledSpectrum source) {
  if (absl::Status status = check_samples(source); !status.ok()) return status;
  // Values have any scale.  Relative to the largest, sums do not overflow.
  const double largest = *std::ranges::max_element(source.values);
  std::vector<double> relative = source.values;
  for (double& v : relative) v /= largest > 0 ? largest : 1;
  const Vec3 xyz = tristimulus(source.wavelengths_nm, relative);
  const double per_lumen = 1 / (cie::kLumensPerWatt * xyz.y);
  const double watts = total(source.wavelengths_nm, relative) * per_lumen;
  if (!(xyz.y > 0) || !(per_lumen <= kMostWattsPerLumen) || !(watts <= kMostWattsPerLumen))
    return absl::FailedPreconditionError("the spectrum has no visible light");
  Spectrum s(std::move(source), xyz);
  s.largest_ = largest;
  s.scale_ = per_lumen;
  s.watts_per_lumen_ = watts;
  return s;
}

double Spectrum::per_lumen(double nm) const {
  if (const auto* body = std::get_if<BlackBody>(&source_))
    return nm > 0 ? std::exp(log_planck(nm, body->kelvin) + log_per_lumen_) : 0;
  if (const auto* illuminant = std::get_if<CieIlluminant>(&source_))
    return scale_ * cie::value_at(*cie::find_illuminant(illuminant->name), nm);
  const auto& s = std::get<SampledSpectrum>(source_);
  return scale_ * (interpolate(s.wavelengths_nm, s.values, nm) / largest_);
}

std::uint64_t Spectrum::bytes() const {
  std::uint64_t bytes = sizeof *this;
  if (const auto* s = std::get_if<SampledSpectrum>(&source_))
    bytes += (s->wavelengths_nm.capacity() + s->values.capacity()) * sizeof(double);
  return bytes;
}

}  // namespace lucerna
