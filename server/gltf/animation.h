// Animations: the poses of nodes over time.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "server/gltf/document.h"
#include "server/gltf/matrix.h"

namespace lucerna::gltf {

/// The values of one channel over time.
class Track {
 public:
  enum class Kind : std::uint8_t { kLinear, kStep, kSpline };

  Track() = default;
  /// `components` 4 is a rotation.  Times ascend.
  Track(std::vector<double> times_s, std::vector<double> values, std::size_t components, Kind kind)
      : times_s_(std::move(times_s)),
        values_(std::move(values)),
        components_(components),
        kind_(kind) {}

  bool empty() const { return times_s_.empty(); }
  Kind kind() const { return kind_; }
  const std::vector<double>& times_s() const { return times_s_; }
  /// The value at a time.  Before the first and after the last key frame it rests.
  /// [glTF2, appendix C]
  std::array<double, 4> at(double time_s) const;

 private:
  const double* key(std::size_t i) const {
    return &values_[(kind_ == Kind::kSpline ? 3 * i + 1 : i) * components_];
  }
  std::vector<double> times_s_, values_;
  std::size_t components_ = 3;
  Kind kind_ = Kind::kLinear;
};

/// Translations and rotations of nodes.  All animations of the file play at once.
class Animations {
 public:
  explicit Animations(const Document& document);

  bool animates(std::size_t node) const { return nodes_.contains(node); }
  /// The transform from a node to its parent: at rest without a time.
  Matrix local(std::size_t node, std::optional<double> time_s) const;
  /// The key times of a node [s].  Between them its motion is straight and its rotation constant.
  /// `in_chain`: another node above or below moves too, so curves get more times.
  std::vector<double> times_s(std::size_t node, bool in_chain) const;

 private:
  struct Tracks {
    Track translation, rotation;
  };
  void add(const View& channel, const tinygltf::Animation& animation,
           const tinygltf::AnimationChannel& source, const View& animation_place);

  const Document& document_;
  std::map<std::size_t, Tracks> nodes_;
};

}  // namespace lucerna::gltf
