// The pinhole camera, ready to make rays.
#pragma once

#include <memory>

#include "lights/maths/motion.h"
#include "server/description/scene_description.h"
#include "server/rays/ray.h"

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
  /// pixel (i, j) covers [i, i + 1) x [j, j + 1).  The direction is a unit vector, the time
  /// `time_s`.  At a motion's key frames it is the ray of a camera that rests there: the same bits
  /// at the first one, and at others the same origin and a direction off by at most an ulp of 1.
  Ray ray(float x, float y, double time_s = 0) const;
  /// Positions are about the scene's origin; null where the camera rests.
  const Motion* motion() const { return motion_.get(); }

 private:
  int width_ = 0, height_ = 0;
  double film_scale_ = 1;
  Vec3<float> position_;
  Vec3<double> corner_, step_x_, step_y_;  // direction = corner + x step_x + y step_y
  // From directions, and from the camera's own position as zero, to the scene's coordinates.
  std::shared_ptr<const Motion> motion_;
};

}  // namespace lucerna
