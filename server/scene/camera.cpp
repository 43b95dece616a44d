#include "server/scene/camera.h"

namespace lucerna {

Camera::Camera(const PerspectiveCamera& camera, const Film& film, const Vec3<double>& origin_m)
    : width_(film.width),
      height_(film.height),
      film_scale_(film.scale),
      position_(camera.world_from_camera.point({}) - origin_m) {
  const auto world = [&](double x, double y, double z) {
    return camera.world_from_camera.vector({x, y, z});
  };
  const auto& low = camera.screen_min;
  const auto& high = camera.screen_max;
  corner_ = world(low.x, high.y, 1);
  step_x_ = world((high.x - low.x) / film.width, 0, 0);
  step_y_ = world(0, (low.y - high.y) / film.height, 0);
  if (camera.motion) {
    // Relative to the camera's position, so that its path has no rounding error from a distant
    // origin.
    motion_ = std::make_shared<const Motion>(
        camera.motion->about(camera.world_from_camera.point({}), origin_m));
  }
}

Ray Camera::ray(float x, float y, double time_s) const {
  const Vec3<double> d = corner_ + step_x_ * double(x) + step_y_ * double(y);
  const Vec3<double> direction = d / std::sqrt(dot(d, d));
  Ray ray;
  ray.time_s = time_s;
  if (motion_ == nullptr) {
    ray.origin = position_;
    ray.direction = Vec3<float>(direction);
  } else {
    const Pose pose = motion_->at(time_s);
    ray.origin = Vec3<float>(pose.shift_m);
    ray.direction = Vec3<float>(pose.vector(direction));
  }
  return ray;
}

}  // namespace lucerna
