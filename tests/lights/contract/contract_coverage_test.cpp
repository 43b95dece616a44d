// Every light of the closed set takes part in the contract.
#include <gtest/gtest.h>

#include <string_view>
#include <typeinfo>
#include <variant>
#include <vector>

#include "lights/models/light.h"
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

/// A density needs places and directions to spread over.  A light without density spreads one of
/// the two, and the other is certain.
template <typename Model>
void expect_what_spreads_takes_part() {
  if (Model::kDelta) {
    expect_takes_part_in_one_of<Model>({"EmittingSurface", "EmittingDirections"});
  } else {
    expect_takes_part_in_one_of<Model>({"EmittingSurface"});
    expect_takes_part_in_one_of<Model>({"EmittingDirections"});
  }
}

template <typename... Models>
void expect_what_spreads_of_all_takes_part(const std::variant<Models...>*) {
  (expect_what_spreads_takes_part<Models>(), ...);
}

template <typename... Models>
void expect_all_take_part(const std::variant<Models...>*,
                          const std::vector<std::string_view>& suites) {
  (expect_takes_part_in_one_of<Models>(suites), ...);
}

template <typename Model>
void expect_closed_form_takes_part() {
  if constexpr (requires(const Model& light, const Receiver& r) { light.irradiance(r); })
    expect_takes_part_in_one_of<Model>({"LightWithIrradiance"});
}

template <typename... Models>
void expect_closed_forms_take_part(const std::variant<Models...>*) {
  (expect_closed_form_takes_part<Models>(), ...);
}

TEST(Contract, EveryLightTakesPart) {
  constexpr const LightModels* kAll = nullptr;
  expect_all_take_part(kAll, {"AnyLight"});
  expect_all_take_part(kAll, {"LightWithDensity", "DeltaLight"});
  expect_all_take_part(kAll, {"EmittingLight"});
  expect_all_take_part(kAll, {"BoundedLight", "UnboundedLight"});
  // UnboundedLight states that there are no bounds.  A light with bounds has a place.
  expect_all_take_part(kAll, {"LocalLight", "UnboundedLight"});
  expect_what_spreads_of_all_takes_part(kAll);
  expect_all_take_part(kAll, {"MovingLight"});
  expect_closed_forms_take_part(kAll);
}

// Tables of lights are as small as point lights allow, whatever the size of the largest model.
TEST(Light, IsAsLargeAsAPointLightAndItsKind) {
  EXPECT_LE(sizeof(Light), sizeof(PointLight) + alignof(PointLight));
  EXPECT_EQ(Light(*PointLight::create({})).bytes_beside(), 0U);
  const Light spot(*SpotLight::create({.cone_half_angle_rad = 1}));
  EXPECT_EQ(spot.bytes_beside(), sizeof(SpotLight));
  EXPECT_NE(spot.get_if<SpotLight>(), nullptr);
  EXPECT_EQ(spot.get_if<PointLight>(), nullptr);
}

}  // namespace
}  // namespace lucerna::testing
