// Pixel filters: the weight of the light around a pixel's centre.  [Pharr23, 8.8]
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <memory>
#include <variant>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

/// 1 everywhere.
struct BoxFilter {};
/// Falls linearly to 0 at the radius.
struct TriangleFilter {};
/// A normal distribution, less its value at the radius.
struct GaussianFilter {
  double sigma_px = 0.5;  ///< in (0, 1e6]
};
/// Two cubic pieces, which meet at half the radius.  [Mitchell88]
struct MitchellFilter {
  double b = 1.0 / 3, c = 1.0 / 3;
};
/// sin(pi x) / (pi x) with a Lanczos window: its main lobe, stretched to half width tau.
struct SincFilter {
  double tau = 3;  ///< [pixels], at least 0.25
};

struct PixelFilterParams {
  Vec2 radius_px{0.5, 0.5};  ///< each in [0.001, 64]; the filter is 0 beyond
  std::variant<BoxFilter, TriangleFilter, GaussianFilter, MitchellFilter, SincFilter> shape{};
};

/// A product of the same function of x and of y, 0 outside a rectangle.  A sample's position has
/// the density of the filter's magnitude, so the weights of all samples have the same size.
/// [Ernst06]
///
/// Immutable, so safe to share between threads.
class PixelFilter {
 public:
  struct Sample {
    Vec2f position_px;  ///< from the pixel's upper left corner, +y downwards
    /// 1 for filters without negative values.  Otherwise a constant with the filter's sign there.
    /// Its mean over all positions is 1.
    double weight;
  };

  /// Errors: a parameter outside its range; negative parts that nearly cancel the positive ones.
  static absl::StatusOr<std::shared_ptr<const PixelFilter>> create(const PixelFilterParams& params);

  /// `u` in the closed unit square.  Nearby values give nearby positions.
  Sample sample(Vec2f u) const;

  /// Whether weights, and so the values of pixels, may be negative.
  bool has_negative_weights() const { return x_.is_signed() || y_.is_signed(); }

  std::size_t bytes() const { return sizeof(*this) + x_.bytes() + y_.bytes(); }

 private:
  /// The function along one axis.  Box and triangle have closed forms.  All others are linear
  /// between nodes, close enough that the function differs by less than 1e-4 of its largest value.
  class Axis {
   public:
    /// The box and the triangle.
    Axis(double radius_px, bool is_triangle) : radius_px_(radius_px), is_triangle_(is_triangle) {}
    /// Values at equal steps from 0 to the radius, at least two; the function is even.
    Axis(double radius_px, const std::vector<double>& values);

    /// The integral of |f| over the integral of f.  Not above 0 if the latter is not.
    double excess() const { return excess_; }
    bool is_signed() const { return is_signed_; }
    /// The distance from the centre, and whether the function is negative there.
    struct Offset {
      double offset_px;
      bool is_negative;
    };
    Offset sample(double u) const;
    std::size_t bytes() const { return nodes_.capacity() * sizeof(Node); }

   private:
    struct Node {
      double x_px;
      double magnitude;  // at the node
      double before;     // share of the magnitude's integral up to the node
      bool is_negative;  // the function between this node and the next
    };

    double radius_px_;
    double excess_ = 1;
    bool is_triangle_ = false;
    bool is_signed_ = false;
    std::vector<Node> nodes_;
  };

  PixelFilter(Axis x, Axis y)
      : x_(std::move(x)), y_(std::move(y)), weight_(x_.excess() * y_.excess()) {}
  static Axis axis(const PixelFilterParams& params, double radius_px);

  Axis x_, y_;
  double weight_;
};

}  // namespace lucerna
