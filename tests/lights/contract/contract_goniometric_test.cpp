// The contract suites on goniometric lights.
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/goniometric_cases.h"
#include "tests/lights/contract/goniometric_map_cases.h"

namespace lucerna::testing {
namespace {

template <typename Case>
struct EmittingAllAround : Case {
  static constexpr bool kConfined = false;
  static Region emission_region(const Vec3&) { return {}; }
};
struct EmittingDown : DownWebCase {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3&) { return {{0, 0, -1}, 1.3}; }
};
struct EmittingFlood : FloodWebCase {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3&) { return {{0, 0, -1}, kPi / 2}; }
};
struct EmittingHeadlamp : HeadlampWebCase {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3&) { return {{1, 0, 0}, kPi / 2}; }
};
struct EmittingConfinedMap : ConfinedMapCase {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3&) { return {{0, 0, -1}, 0.73}; }
};

using Cases =
    ::testing::Types<EmittingAllAround<UnevenWebCase>, EmittingDown, EmittingFlood,
                     EmittingHeadlamp, EmittingAllAround<IsotropicCase>,
                     EmittingAllAround<PatchyMapCase>, EmittingConfinedMap,
                     EmittingAllAround<BilinearMapCase>, EmittingAllAround<NearestPanoramaCase>,
                     EmittingAllAround<BilinearPanoramaCase>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, AnyLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, DeltaLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, LocalLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, EmittingLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, EmittingDirections, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, BoundedLight, Cases);

}  // namespace
}  // namespace lucerna::testing
