#include "server/camera.h"

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
}

Ray Camera::ray(float x, float y) const {
  const Vec3<double> d = corner_ + step_x_ * double(x) + step_y_ * double(y);
  return {position_, Vec3<float>(d / std::sqrt(dot(d, d)))};
}

}  // namespace lucerna
