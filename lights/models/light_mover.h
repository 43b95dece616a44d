// The movement of a light as a whole: its parameters say which of their fields it changes.
#pragma once

#include <memory>
#include <optional>

#include "lights/maths/transform.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// Turns directions, and moves points about the one that the turn keeps.
class LightMover {
 public:
  /// `turn_axis`: of any length but 0, unless `turn_rad` is 0.  `anchor_m`, `shift_m`: world.
  LightMover(const Vec3& anchor_m, const Vec3& shift_m, const Vec3& turn_axis, double turn_rad);

  bool turns() const { return turn_.has_value(); }
  /// Exact without a turn: as if the scene file had the new position.
  void point(Vec3& p) const { p = (turn_ ? anchor_ + turn_->vector(p - anchor_) : p) + shift_; }
  void direction(Vec3& w) const {
    if (turn_) w = turn_->vector(w);
  }
  void frame(Frame& axes) const { direction(axes.s), direction(axes.t), direction(axes.n); }
  /// Null: no frame.
  void frame(std::shared_ptr<const Frame>& axes) const;
  /// A transform that is used for directions only.
  void rotation(Transform& world_from_own) const {
    if (turn_) world_from_own = *turn_ * world_from_own;
  }
  void transform(Transform& world_from_own) const;

 private:
  Vec3 anchor_, shift_;
  std::optional<Transform> turn_;
};

}  // namespace lucerna
