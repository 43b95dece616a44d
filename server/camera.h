// The pinhole camera, ready to make rays.
#pragma once

#include "server/ray.h"
#include "server/scene_description.h"

namespace lucerna {

class Camera {
 public:
  Camera() = default;
  /// `origin_m`: the scene's origin.
  Camera(const PerspectiveCamera& camera, const Film& film, const Vec3<double>& origin_m);

  int width() const { return width_; }
  int height() const { return height_; }
  /// What pixel values are multiplied by.
  double film_scale() const { return film_scale_; }
  /// The ray through film position (x, y) [pixels]; (0, 0) is the upper left corner of the picture,
  /// pixel (i, j) covers [i, i + 1) x [j, j + 1).  The direction is a unit vector.
  Ray ray(float x, float y) const;

 private:
  int width_ = 0, height_ = 0;
  double film_scale_ = 1;
  Vec3<float> position_;
  Vec3<double> corner_, step_x_, step_y_;  // direction = corner + x step_x + y step_y
};

}  // namespace lucerna
