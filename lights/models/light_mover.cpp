#include "lights/models/light_mover.h"

#include <utility>

namespace lucerna {

LightMover::LightMover(const Vec3& anchor_m, const Vec3& shift_m, const Vec3& turn_axis,
                       double turn_rad)
    : anchor_(anchor_m), shift_(shift_m) {
  if (turn_rad != 0) turn_ = Transform::rotate(turn_rad, turn_axis).value_or(Transform());
}

void LightMover::frame(std::shared_ptr<const Frame>& axes) const {
  if (axes == nullptr) return;
  auto turned = std::make_shared<Frame>(*axes);
  frame(*turned);
  axes = std::move(turned);
}

void LightMover::transform(Transform& world_from_own) const {
  Transform move = Transform::translate(shift_);
  if (turn_)
    move = Transform::translate(anchor_ + shift_) * *turn_ * Transform::translate(-anchor_);
  world_from_own = move * world_from_own;
}

}  // namespace lucerna
