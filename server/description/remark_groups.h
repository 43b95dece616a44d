// Collects what files hold that is not modelled.  Equal remarks form one group.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "server/description/scene_description.h"

namespace lucerna {

class RemarkGroups {
 public:
  /// The most groups.  Further remarks are only counted.
  static constexpr std::size_t kMostGroups = 1000;
  /// The most places that a group keeps after its first one.
  static constexpr std::size_t kMostMorePlaces = 4;

  /// Counts a remark.  The same remark at the same place counts once, since each shape of an area
  /// light would repeat it.
  void add(SourceLocation where, std::string what, std::string instead);
  /// The groups in the order of their first places.  The last one counts those that are left out;
  /// its place is `file`.
  std::vector<Remark> take(const std::string& file);

 private:
  std::vector<Remark> groups_;
  std::unordered_map<std::string, std::size_t> numbers_;  // by the two texts
  // Hashes of remarks with their places: files may have millions.  Two of a million have the same
  // hash with a chance of 3e-8; one of them would not be counted.
  std::unordered_set<std::uint64_t> seen_;
  std::uint64_t left_out_ = 0;
};

}  // namespace lucerna
