// The camera that makes rays.
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
  Camera(const CameraDescription& camera, const Film& film, const Vec3& origin_m);

  /// Of the picture [pixels]: the crop of the film, if there is one.
  int width() const { return crop_.x1 - crop_.x0; }
  int height() const { return crop_.y1 - crop_.y0; }
  /// Of the whole film [pixels].
  int film_width() const { return film_width_; }
  int film_height() const { return film_height_; }
  /// The film's pixels that the picture shows.
  const FilmCrop& crop() const { return crop_; }
  bool is_cropped() const { return width() != film_width_ || height() != film_height_; }
  /// The factor for pixel values.
  double film_scale() const { return film_scale_; }
  /// Null for a box of one pixel.
  const PixelFilter* filter() const { return filter_.get(); }
  /// Whether values of pixels may be negative.
  bool may_be_negative() const { return filter_ != nullptr && filter_->has_negative_weights(); }
  /// Whether rays depend on the point of the lens.
  bool has_lens() const;

  /// The ray through film position (x, y) [pixels], at `time_s`; the direction is a unit
  /// vector.  (0, 0) is the upper left corner of the film; pixel (i, j) of the film covers [i, i +
  /// 1) x [j, j + 1).  A pixel filter also asks for positions beside the film.  `lens`, in the unit
  /// square, chooses a point of the lens.
  ///
  /// At a key frame of a motion, this is the ray of a camera that rests there.  At the first key
  /// frame it has the same bits.  At others it has the same origin, and the direction differs by at
  /// most an ulp of 1.
  Ray ray(float x, float y, double time_s = 0, Vec2f lens = {0.5F, 0.5F}) const;
  /// Positions are about the scene's origin; null if the camera does not move.
  const Motion* motion() const { return motion_.get(); }

 private:
  /// What a pinhole camera does not have.
  struct Optics {
    Projection projection;
    Vec3 position;            // about the scene's origin
    Vec3 right, up, forward;  // a unit of camera space
    double lens_radius, focal_distance;
  };
  /// A ray at the first key frame, from a point about the camera's position.
  struct Line {
    Vec3 from, direction;
  };
  Line line(double x, double y, Vec2f lens) const;
  Line from_lens(Vec2f lens, const Vec3& focus) const;
  Vec3 on_sphere(double x, double y) const;

  int film_width_ = 0, film_height_ = 0;
  FilmCrop crop_{};
  double film_scale_ = 1;
  Vec3f position_;
  // Perspective: direction = corner + x step_x + y step_y.  Orthographic: the same for the origin.
  Vec3 corner_, step_x_, step_y_;
  // Maps directions, and the camera's own position as zero, to the scene's coordinates.
  std::shared_ptr<const Motion> motion_;
  std::shared_ptr<const Optics> optics_;  // null for a pinhole
  std::shared_ptr<const PixelFilter> filter_;
};

}  // namespace lucerna
