// Adaptive quadrature over an emitter, behind the shapes of a scene.
#pragma once

#include <optional>
#include <vector>

#include "tests/oracle/cells.h"
#include "tests/oracle/oracle_truth.h"

namespace lucerna::oracle {

/// What is integrated: the irradiance with what is in the way, or the solid angle without.
struct Integral {
  Place at;
  Vec normal{};  ///< unit; zero: the solid angle
  bool is_solid_angle() const { return dot(normal, normal) == 0; }
};

/// Divides the emitter into cells, and the cell with the largest bound again.  A cell that may be
/// partly hidden, within the rounding of coordinates, counts as half visible, with the other half
/// as its bound.
class Quadrature {
 public:
  Quadrature(const Truth& truth, const Integral& integral, const Emitter& emitter);

  Amount run(Real radiance, const Texels& picture) const;

 private:
  struct Part {
    Cell cell;
    Real value = 0, bound = 0;
  };
  /// A flat shape or a sphere as the eye sees it.
  struct Occluder {
    const Shape* shape;
    bool own;                   ///< the eye lies on it
    Vec off;                    ///< how far off it and the eye may be along each axis
    Vec normal{};               ///< of a flat shape, towards the eye
    Real height = 0;            ///< of the eye over it
    std::vector<Vec> around{};  ///< unit normals of planes through the eye and the edges, outwards
  };

  std::optional<Part> part(const Cell& cell) const;
  Way way_to(const Cell& cell, const Cell::Hull& hull) const;
  Way past_curved_shape(const Shape& shape, const Cell& cell, const Cell::Hull& hull) const;
  Way past(const Occluder& occluder, const Cell::Hull& hull) const;
  bool surely_apart(const Occluder& occluder, const Cell::Hull& hull) const;
  /// Per s and t, from an eye that may be a little off.
  Real integrand(const Cell& cell, const Cell::Element& element, const Vec& off) const;

  const Truth& truth_;
  const Integral& integral_;
  const Emitter& emitter_;
  std::vector<Occluder> occluders_;
  std::vector<const Shape*> curved_;
  std::vector<Vec> moves_;  ///< what rounding may move the eye by
};

}  // namespace lucerna::oracle
