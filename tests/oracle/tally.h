// Counts of verdicts, and what they must fulfil.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <string>

#include "tests/oracle/questioner.h"

namespace lucerna::testing {

/// The counts of one kind of question.
struct Tally {
  std::array<std::uint64_t, 6> of{};
  std::uint64_t operator[](Verdict::Kind kind) const {
    return of.at(static_cast<std::size_t>(kind));
  }
  void add(Verdict::Kind kind) { ++of.at(static_cast<std::size_t>(kind)); }

  void print(const std::string& name) const {
    using K = Verdict::Kind;
    const Tally& t = *this;
    std::cout << fmt::format(
        "{}: {} agree, {} wrong, {} intervals hold, {} miss, {} unsure, {} without an answer\n",
        name, t[K::kAgrees], t[K::kWrong], t[K::kHolds], t[K::kMisses], t[K::kUnsure],
        t[K::kNoAnswer]);
  }

  /// Fails if a larger share of intervals misses, or of questions is left out, than four standard
  /// deviations explain.
  void expect_shares(const std::string& name, double may_miss, double may_be_unsure) const {
    using K = Verdict::Kind;
    const auto most = [](double share, double n) {
      return share * n + 4 * std::sqrt(share * (1 - share) * n);
    };
    const Tally& t = *this;
    const auto sampled = static_cast<double>(t[K::kHolds] + t[K::kMisses]);
    EXPECT_LE(static_cast<double>(t[K::kMisses]), most(may_miss, sampled)) << name;
    // The rule for unsure answers must not hide what is wrong.
    const auto unsure = static_cast<double>(t[K::kUnsure]);
    const double all = static_cast<double>(t[K::kAgrees] + t[K::kWrong]) + sampled + unsure;
    EXPECT_LE(unsure, most(may_be_unsure, all)) << name;
  }
};

/// Printing a failure takes as long as testing many scenes.
inline constexpr std::uint64_t kMostFailures = 20;

}  // namespace lucerna::testing
