// The names of a scene's lights.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lucerna {

/// Names and the lights that have them.  Several lights may share a name, which is stored once.
/// Holds nothing for lights without a name.  Immutable; may be read from any thread.
class LightNames {
 public:
  LightNames() = default;
  /// `named`: the index of each light that has a name, ascending, with the name.
  explicit LightNames(std::vector<std::pair<std::uint32_t, std::string>> named);

  bool empty() const { return names_.empty(); }
  /// The number of different names.
  std::size_t size() const { return names_.size(); }
  /// The number of lights that have a name.
  std::size_t light_count() const { return by_light_.size(); }
  /// The name of the light with this index; empty if it has none.
  std::string_view of(std::uint32_t light) const;
  /// Indices of the lights with this name, ascending; empty if there are none.
  std::span<const std::uint32_t> lights(std::string_view name) const;
  /// At most `most` names that are spelled like `name`, the most similar first.  Looks at 256 names
  /// at most, those beside `name` in the order of bytes, since a scene may have millions.
  std::vector<std::string_view> similar(std::string_view name, std::size_t most) const;
  /// Memory, without the object itself.
  std::uint64_t bytes() const;

 private:
  std::vector<std::string> names_;     // ascending, each once
  std::vector<std::uint32_t> begins_;  // of each name, and the end of the last: into lights_
  std::vector<std::uint32_t> lights_;  // by name
  // Light and the number of its name, ascending by light.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> by_light_;
};

}  // namespace lucerna
