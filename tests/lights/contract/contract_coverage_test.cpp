// Every kind of light takes part in the contract.
#include <gtest/gtest.h>

#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <vector>

#include "tests/lights/area_lights.h"
#include "tests/lights/contract/takes_part.h"

namespace lucerna::testing {
namespace {

template <typename Model>
void expect_takes_part_in_one_of(const std::vector<std::string_view>& suites) {
  int count = 0;
  for (const std::string_view suite : suites)
    count += static_cast<int>(participants()[suite].count(typeid(Model)));
  EXPECT_GT(count, 0) << typeid(Model).name() << " has no case in any of "
                      << ::testing::PrintToString(suites);
}

template <typename L>
constexpr bool has_closed_form() {
  if constexpr (requires { L::kHasIrradiance; })
    return L::kHasIrradiance;
  else
    return std::is_base_of_v<LightBeyond, L> && !std::is_same_v<L, ImageInfiniteLight>;
}

template <typename L>
void expect_takes_part() {
  expect_takes_part_in_one_of<L>({"AnyLight"});
  expect_takes_part_in_one_of<L>({"LightWithDensity", "DeltaLight"});
  expect_takes_part_in_one_of<L>({"EmittingLight"});
  expect_takes_part_in_one_of<L>({"BoundedLight", "UnboundedLight"});
  // UnboundedLight states that there are no bounds.  A light with bounds has a place.
  expect_takes_part_in_one_of<L>({"LocalLight", "UnboundedLight"});
  expect_takes_part_in_one_of<L>({"MovingLight"});
  // A density needs places and directions to spread over.  A light without density spreads one of
  // the two, and the other is certain.
  if (std::is_base_of_v<DeltaLight, L>) {
    expect_takes_part_in_one_of<L>({"EmittingSurface", "EmittingDirections"});
  } else {
    expect_takes_part_in_one_of<L>({"EmittingSurface"});
    expect_takes_part_in_one_of<L>({"EmittingDirections"});
  }
  if (has_closed_form<L>()) expect_takes_part_in_one_of<L>({"LightWithIrradiance"});
}

template <template <typename...> typename List, typename... Lights>
void expect_all_take_part(const List<Lights...>*) {
  (expect_takes_part<Lights>(), ...);
}

TEST(Contract, EveryLightTakesPart) {
  expect_all_take_part(static_cast<const FreeLights*>(nullptr));
  expect_all_take_part(static_cast<const AreaLights*>(nullptr));
}

}  // namespace
}  // namespace lucerna::testing
