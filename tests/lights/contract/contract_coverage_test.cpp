// Every kind of light takes part in the contract.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/lights/contract/takes_part.h"

namespace lucerna::testing {
namespace {

TEST(Contract, EveryLightTakesPart) {
  std::map<std::string_view, std::set<std::string>> kinds;
  std::map<std::string, LightTraits> traits;
  for (const auto& [suite, makers] : participants())
    for (const auto make : makers) {
      const Participant p = make();
      kinds[suite].insert(p.kind);
      traits[p.kind].is_delta |= p.traits.is_delta;
      traits[p.kind].has_irradiance |= p.traits.has_irradiance;
    }
  for (const std::string& kind : all_kinds()) {
    const auto expect_one_of = [&](const std::vector<std::string_view>& suites) {
      bool found = false;
      for (const std::string_view suite : suites) found |= kinds[suite].contains(kind);
      EXPECT_TRUE(found) << kind << " has no case in any of " << ::testing::PrintToString(suites);
    };
    expect_one_of({"AnyLight"});
    expect_one_of({"LightWithDensity", "DeltaLight"});
    expect_one_of({"EmittingLight"});
    expect_one_of({"BoundedLight", "UnboundedLight"});
    // UnboundedLight states that there are no bounds.  A light with bounds has a place.
    expect_one_of({"LocalLight", "UnboundedLight"});
    expect_one_of({"MovingLight"});
    // A density needs places and directions to spread over.  A light without density spreads one of
    // the two, and the other is certain.
    if (traits[kind].is_delta) {
      expect_one_of({"EmittingSurface", "EmittingDirections"});
    } else {
      expect_one_of({"EmittingSurface"});
      expect_one_of({"EmittingDirections"});
    }
    if (traits[kind].has_irradiance) expect_one_of({"LightWithIrradiance"});
  }
}

}  // namespace
}  // namespace lucerna::testing
