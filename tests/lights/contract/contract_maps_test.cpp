// The contract suites on infinite lights with a picture.
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/map_cases.h"

namespace lucerna::testing {
namespace {

using MapCases = ::testing::Types<EqualAreaCase, BilinearEqualAreaCase,
                                  NearestLatitudeLongitudeCase, LatitudeLongitudeCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Maps, AnyLight, MapCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Maps, LightWithDensity, MapCases);

template <typename Case>
struct Emitting : Case, SceneDiskCase {};
using EmittingCases =
    ::testing::Types<Emitting<EqualAreaCase>, Emitting<BilinearEqualAreaCase>,
                     Emitting<NearestLatitudeLongitudeCase>, Emitting<LatitudeLongitudeCase>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Maps, EmittingLight, EmittingCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Maps, EmittingSurface, EmittingCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Maps, EmittingDirections, EmittingCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Maps, UnboundedLight, EmittingCases);

/// The light with the density of the radiance above the mean, as receivers with incomplete
/// densities sample it.
template <typename Case>
void check_incomplete() {
  const auto light = Case::make({});
  Receiver receiver(0, 0, 0);
  receiver.incomplete = true;
  const auto sample = [&](Vec2 u) { return light.sample_li(receiver, u); };
  const auto pdf = [&](const Vec3& w) { return double{light.pdf_li(receiver, Vec3(w)).per_sr}; };
  const Verdict integral = check_density_integrates({}, sample, pdf);
  EXPECT_TRUE(integral.ok()) << integral.failure;
  const Verdict follow = check_samples_follow_density({}, sample, pdf);
  EXPECT_TRUE(follow.ok()) << follow.failure;
}

TEST(ImageInfiniteLightContract, IncompleteDensitiesKeepTheContract) {
  check_incomplete<EqualAreaCase>();
  check_incomplete<BilinearEqualAreaCase>();
  check_incomplete<NearestLatitudeLongitudeCase>();
  check_incomplete<LatitudeLongitudeCase>();
}

}  // namespace
}  // namespace lucerna::testing
