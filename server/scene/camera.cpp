#include "server/scene/camera.h"

#include <cmath>

#include "lights/pictures/sphere_map.h"
#include "lights/sampling/sampling.h"

namespace lucerna {
namespace {

/// Goes on beyond the edges of the unit square that shows the sphere by equal areas.  Each edge is
/// folded about its middle.
Vec2 within_equal_area_square(Vec2 p) {
  const auto fold = [](double& along, double& across) {
    const double whole = std::floor(along);
    along -= whole;
    if (std::fmod(whole, 2) == 0) return;
    along = 1 - along;
    across = 1 - across;
  };
  fold(p.x, p.y);
  fold(p.y, p.x);
  return p;
}

}  // namespace

Camera::Camera(const CameraDescription& camera, const Film& film, const Vec3& origin_m)
    : film_width_(film.width),
      film_height_(film.height),
      crop_(film.crop.value_or(FilmCrop{0, 0, film.width, film.height})),
      film_scale_(film.scale),
      position_(camera.world_from_camera.point({}) - origin_m),
      filter_(film.filter) {
  const auto world = [&](double x, double y, double z) {
    return camera.world_from_camera.vector({x, y, z});
  };
  const auto& low = camera.screen_min;
  const auto& high = camera.screen_max;
  corner_ = world(low.x, high.y, camera.projection == Projection::kOrthographic ? 0 : 1);
  step_x_ = world((high.x - low.x) / film.width, 0, 0);
  step_y_ = world(0, (low.y - high.y) / film.height, 0);
  if (camera.motion) {
    // Relative to the camera's position, so that its path has no rounding error from a distant
    // origin.
    motion_ = std::make_shared<const Motion>(
        camera.motion->about(camera.world_from_camera.point({}), origin_m));
  }
  if (camera.projection != Projection::kPerspective || camera.lens_radius > 0) {
    optics_ = std::make_shared<const Optics>(
        Optics{camera.projection, camera.world_from_camera.point({}) - origin_m, world(1, 0, 0),
               world(0, 1, 0), world(0, 0, 1), camera.lens_radius, camera.focal_distance});
  }
}

bool Camera::has_lens() const {
  return optics_ != nullptr && optics_->lens_radius > 0 &&
         (optics_->projection == Projection::kPerspective ||
          optics_->projection == Projection::kOrthographic);
}

Vec3 Camera::on_sphere(double x, double y) const {
  const Vec2 p{x / film_width_, y / film_height_};
  Vec3 w;
  if (optics_->projection == Projection::kEquirectangular) {
    // Above the top edge, the colatitude is negative: the direction is beyond the pole.
    w = direction_from_square(SphereMapping::kLatitudeLongitude, p);
  } else {
    // The map's +z is in its middle; the camera's +y is.
    const Vec3 map = direction_from_square(SphereMapping::kEqualArea, within_equal_area_square(p));
    w = {map.x, map.z, map.y};
  }
  return optics_->right * w.x + optics_->up * w.y + optics_->forward * w.z;
}

Camera::Line Camera::from_lens(Vec2f lens, const Vec3& focus) const {
  const auto p = sample_concentric_disk(Vec2{lens.x, lens.y});
  const Vec3 from = (optics_->right * p.x + optics_->up * p.y) * optics_->lens_radius;
  return {from, focus - from};
}

Camera::Line Camera::line(double x, double y, Vec2f lens) const {
  const Vec3 screen = corner_ + step_x_ * x + step_y_ * y;
  if (optics_ == nullptr) return {{}, screen};
  switch (optics_->projection) {
    case Projection::kPerspective:
      return from_lens(lens, screen * optics_->focal_distance);
    case Projection::kOrthographic:
      // As in pbrt-v4, all rays pass through one lens, so only the plane in focus is orthographic.
      if (optics_->lens_radius > 0)
        return from_lens(lens, screen + optics_->forward * optics_->focal_distance);
      return {screen, optics_->forward};
    case Projection::kEqualArea:
    case Projection::kEquirectangular:
      break;
  }
  return {{}, on_sphere(x, y)};
}

Ray Camera::ray(float x, float y, double time_s, Vec2f lens) const {
  const Line l = line(double(x), double(y), lens);
  const Vec3 direction = l.direction / std::sqrt(dot(l.direction, l.direction));
  Ray ray;
  ray.time_s = time_s;
  if (motion_ == nullptr) {
    ray.origin = optics_ == nullptr ? position_ : Vec3f(optics_->position + l.from);
    ray.direction = Vec3f(direction);
  } else {
    const Pose pose = motion_->at(time_s);
    ray.origin = Vec3f(optics_ == nullptr ? pose.shift_m : pose.point(l.from));
    ray.direction = Vec3f(pose.vector(direction));
  }
  return ray;
}

}  // namespace lucerna
