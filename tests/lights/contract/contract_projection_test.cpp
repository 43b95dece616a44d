// The contract suites on projection lights and beams.
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/projection_cases.h"

namespace lucerna::testing {
namespace {

using ProjectionCases = ::testing::Types<NearestProjectionCase, BilinearProjectionCase,
                                         WideBilinearProjectionCase, EvenProjectionCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Projection, AnyLight, ProjectionCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Projection, DeltaLight, ProjectionCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Projection, LocalLight, ProjectionCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Projection, EmittingLight, ProjectionCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Projection, EmittingDirections, ProjectionCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Projection, BoundedLight, ProjectionCases);

using BeamCases = ::testing::Types<NearestBeamCase, BilinearBeamCase, EvenBeamCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Beam, AnyLight, BeamCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Beam, DeltaLight, BeamCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Beam, LocalLight, BeamCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Beam, EmittingLight, BeamCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Beam, EmittingSurface, BeamCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Beam, BoundedLight, BeamCases);

}  // namespace
}  // namespace lucerna::testing
