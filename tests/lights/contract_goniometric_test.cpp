// The contract suites on goniometric lights.
#include "tests/lights/contract_emission.h"
#include "tests/lights/goniometric_cases.h"
#include "tests/lights/goniometric_map_cases.h"

namespace lucerna::testing {
namespace {

struct EmittingUneven : UnevenWebCase {
  static constexpr bool kConfined = false;
  static Region emission_region(const Vec3<double>&) { return {}; }
};
struct EmittingDown : DownWebCase {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3<double>&) { return {{0, 0, -1}, 1.3}; }
};
struct EmittingIsotropic : IsotropicCase {
  static constexpr bool kConfined = false;
  static Region emission_region(const Vec3<double>&) { return {}; }
};

struct EmittingUnevenMap : UnevenMapCase {
  static constexpr bool kConfined = false;
  static Region emission_region(const Vec3<double>&) { return {}; }
};
struct EmittingConfinedMap : ConfinedMapCase {
  static constexpr bool kConfined = true;
  static Region emission_region(const Vec3<double>&) { return {{0, 0, -1}, 0.73}; }
};
struct EmittingLatitudeLongitudeMap : LatitudeLongitudeMapCase {
  static constexpr bool kConfined = false;
  static Region emission_region(const Vec3<double>&) { return {}; }
};

using Cases = ::testing::Types<EmittingUneven, EmittingDown, EmittingIsotropic, EmittingUnevenMap,
                               EmittingConfinedMap, EmittingLatitudeLongitudeMap>;
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, AnyLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, DeltaLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, LocalLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, EmittingLight, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, EmittingDirections, Cases);
INSTANTIATE_TYPED_TEST_SUITE_P(Goniometric, BoundedLight, Cases);

}  // namespace
}  // namespace lucerna::testing
