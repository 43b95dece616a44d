// The suites of the contract.  INSTANTIATE_CONTRACT(Suite, condition) runs a suite on each
// LightCase `c` that fulfils the condition.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <ostream>
#include <vector>

#include "tests/lights/contract/light_case.h"

namespace lucerna::testing {

class ContractTest : public ::testing::TestWithParam<LightCase> {
 protected:
  const LightCase& c = GetParam();
  const std::unique_ptr<const Light> light = c.make({});
};

inline void PrintTo(const LightCase& c, std::ostream* os) { *os << c.name; }

template <typename Condition>
std::vector<LightCase> cases_where(Condition condition) {
  std::vector<LightCase> some;
  std::ranges::copy_if(all_cases(), std::back_inserter(some), condition);
  return some;
}

#define INSTANTIATE_CONTRACT(suite, condition)                                                    \
  INSTANTIATE_TEST_SUITE_P(Contract, suite,                                                       \
                           ::testing::ValuesIn(cases_where(                                       \
                               [](const LightCase& c) { return static_cast<bool>(condition); })), \
                           [](const auto& info) { return info.param.name; })

}  // namespace lucerna::testing
