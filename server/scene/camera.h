// The pinhole camera that makes rays.
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
  /// The factor for pixel values.
  double film_scale() const { return film_scale_; }
  /// The ray through film position (x, y) [pixels], at `time_s`; the direction is a unit
  /// vector.  (0, 0) is the upper left corner of the picture; pixel (i, j) covers [i, i + 1)
  /// x [j, j + 1).
  ///
  /// At a key frame of a motion, this is the ray of a camera that rests there.  At the first key
  /// frame it has the same bits.  At others it has the same origin, and the direction differs by at
  /// most an ulp of 1.
  Ray ray(float x, float y, double time_s = 0) const;
  /// Positions are about the scene's origin; null if the camera does not move.
  const Motion* motion() const { return motion_.get(); }

 private:
  int width_ = 0, height_ = 0;
  double film_scale_ = 1;
  Vec3<float> position_;
  Vec3<double> corner_, step_x_, step_y_;  // direction = corner + x step_x + y step_y
  // Maps directions, and the camera's own position as zero, to the scene's coordinates.
  std::shared_ptr<const Motion> motion_;
};

}  // namespace lucerna
