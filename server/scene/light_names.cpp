#include "server/scene/light_names.h"

#include <algorithm>
#include <numeric>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// The number of bytes to insert, to delete or to replace between two texts.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, replaced});
    }
  }
  return row.back();
}

}  // namespace

LightNames::LightNames(std::vector<std::pair<std::uint32_t, std::string>> named) {
  // Stable, so that the lights of one name stay ascending.
  std::ranges::stable_sort(named, {}, &std::pair<std::uint32_t, std::string>::second);
  StopPoll poll;
  for (auto& [light, name] : named) {
    poll();
    if (names_.empty() || names_.back() != name) {
      begins_.push_back(static_cast<std::uint32_t>(lights_.size()));
      names_.push_back(std::move(name));
    }
    by_light_.emplace_back(light, static_cast<std::uint32_t>(names_.size() - 1));
    lights_.push_back(light);
  }
  if (!names_.empty()) begins_.push_back(static_cast<std::uint32_t>(lights_.size()));
  std::ranges::sort(by_light_);
  names_.shrink_to_fit();
  begins_.shrink_to_fit();
  lights_.shrink_to_fit();
  by_light_.shrink_to_fit();
}

std::string_view LightNames::of(std::uint32_t light) const {
  const auto found = std::ranges::lower_bound(by_light_, light, {},
                                              &std::pair<std::uint32_t, std::uint32_t>::first);
  if (found == by_light_.end() || found->first != light) return {};
  return names_[found->second];
}

std::span<const std::uint32_t> LightNames::lights(std::string_view name) const {
  const auto found = std::ranges::lower_bound(names_, name);
  if (found == names_.end() || *found != name) return {};
  const auto number = static_cast<std::size_t>(found - names_.begin());
  return std::span(lights_).subspan(begins_[number], begins_[number + 1] - begins_[number]);
}

std::vector<std::string_view> LightNames::similar(std::string_view name, std::size_t most) const {
  constexpr std::size_t kMostCompared = 256, kMostBytes = 64;
  const auto at = static_cast<std::size_t>(std::ranges::lower_bound(names_, name) - names_.begin());
  const std::size_t compared = std::min(names_.size(), kMostCompared);
  const std::size_t first =
      std::min(at - std::min(at, kMostCompared / 2), names_.size() - compared);
  std::vector<std::pair<std::size_t, std::string_view>> found;
  for (std::size_t i = first; i < first + compared; ++i)
    found.emplace_back(edit_distance(name.substr(0, kMostBytes),
                                     std::string_view(names_[i]).substr(0, kMostBytes)),
                       names_[i]);
  const std::size_t kept = std::min(most, found.size());
  std::ranges::partial_sort(found, found.begin() + static_cast<std::ptrdiff_t>(kept));
  std::vector<std::string_view> result;
  for (std::size_t i = 0; i < kept; ++i) result.push_back(found[i].second);
  return result;
}

std::uint64_t LightNames::bytes() const {
  std::uint64_t sum = names_.capacity() * sizeof(std::string) +
                      (begins_.capacity() + lights_.capacity()) * sizeof(std::uint32_t) +
                      by_light_.capacity() * sizeof by_light_[0];
  // Short names are within the string itself.
  StopPoll poll;
  for (const std::string& name : names_) {
    poll();
    if (name.capacity() > std::string().capacity()) sum += name.capacity() + 1;
  }
  return sum;
}

}  // namespace lucerna
