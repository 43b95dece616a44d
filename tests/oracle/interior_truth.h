// Illuminance in rooms by image sources, and by quadrature of the light that walls reflect.
#pragma once

#include <cstddef>
#include <vector>

#include "tests/oracle/interior.h"
#include "tests/oracle/oracle_truth.h"

namespace lucerna::oracle {

class InteriorTruth {
 public:
  /// Bounces without a limit; only for rooms with at most two smooth sheets and none that is grey.
  static constexpr int kAll = -1;

  /// `interior` must outlive this object.
  explicit InteriorTruth(const Interior& interior);

  /// The illuminance from a lamp, directly and by at most this many mirrors [lx].
  Amount by_images(std::size_t receiver, std::size_t lamp, int bounces) const;
  /// The illuminance with at most this many reflections, at most 2 of them by walls [lx].
  Amount illuminance(std::size_t receiver, int bounces) const;

 private:
  /// Mirrors and panes in the order from the receiver.
  using Chain = std::vector<std::size_t>;
  struct Eye {
    Vector at, n;
    int on = -1;  ///< the sheet that it lies on
  };
  /// A leg of a path.
  struct Leg {
    Vector from, w;  ///< w: unit
    double length = 0;
    int on = -1, to = -1;  ///< sheets of its ends
  };
  static constexpr std::size_t kNoLamp = ~std::size_t{0};

  std::vector<Chain> chains(std::size_t longest) const;
  double passed(const Leg& leg, std::size_t to_lamp, bool& doubt) const;
  double arriving(const Eye& eye, const Lamp& lamp, std::size_t number, const Chain& chain,
                  double s, double t, bool& doubt) const;
  double lit(const Eye& eye, int bounces) const;
  template <typename AtWall>
  double gathered(const Vector& from, const Vector& w, int on, int bounces,
                  const AtWall& at_wall) const;
  Amount by_one_wall(const Eye& eye, int bounces, Real enough) const;
  Amount by_two_walls(const Eye& eye, int bounces) const;

  const Interior& interior_;
  std::array<std::vector<Chain>, 3> few_;  ///< of at most 0, 1 and 2 mirrors
};

}  // namespace lucerna::oracle
