// The contract suites on panels with a luminaire's photometry.
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/panel_cases.h"

namespace lucerna::testing {
namespace {

using PanelCases = ::testing::Types<RectanglePanelCase, TrianglePanelCase, DiskPanelCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, AnyLight, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, LightWithDensity, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, LocalLight, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, EmittingLight, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, EmittingSurface, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, EmittingDirections, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, BoundedLight, PanelCases);

}  // namespace
}  // namespace lucerna::testing
