// The server's answers about light in random rooms with mirrors, panes and grey walls.
//
// LUCERNA_ORACLE_ROOMS: how many rooms, by default 200.  LUCERNA_ORACLE_FIRST: the number of the
// first one, by default 0.  LUCERNA_ORACLE_ROOM: the number of a single room.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iostream>
#include <limits>
#include <map>

#include "tests/oracle/interior_truth.h"
#include "tests/oracle/tally.h"
#include "tests/oracle/wire_parts.h"
#include "tests/server/extremes/wire_settings.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

using oracle::Interior;
using oracle::InteriorTruth;

/// Corners of surfaces are floats: angles and reflectances are a little off.
constexpr Real kOfFloats = 2e-4L;
/// A reference with a larger error decides nothing.
constexpr Real kMostError = 2e-3L;
constexpr double kTarget = 0.05;

struct Request {
  std::size_t receiver = 0;
  int bounces = 0;            ///< or InteriorTruth::kAll
  std::uint32_t samples = 0;  ///< 0: a target error
  bool per_light = false;
  std::uint64_t seed = 0;
};

std::string name_of(const Interior& room, const Request& q) {
  std::string name =
      q.bounces == InteriorTruth::kAll ? "all bounces" : fmt::format("{} bounces", q.bounces);
  if (q.bounces != 0) name += room.has_grey() ? ", grey walls" : ", mirrors";
  return name + (q.samples == 0 ? ", target" : "");
}

std::vector<Request> requests_about(const Interior& room, std::uint64_t number) {
  oracle::Numbers random(number + (std::uint64_t{1} << 40));
  std::vector<Request> requests;
  const auto add = [&](std::size_t receiver, int bounces) {
    const std::uint32_t samples = random.chance(0.25) ? 0 : 64U << random.below(5);
    requests.push_back({receiver, bounces, samples, random.chance(0.3),
                        static_cast<std::uint64_t>(random.below(1 << 20))});
  };
  for (std::size_t r = 0; r < room.receivers.size(); ++r) {
    add(r, 0);
    if (room.has_grey()) continue;
    add(r, 1);
    add(r, 2);
    if (room.smooth_sheets() <= 2) add(r, InteriorTruth::kAll);
  }
  if (room.has_grey()) add(0, 1);  // a reference for two reflections by walls takes too long
  return requests;
}

class Interiors : public ::testing::Test {
 protected:
  void check(std::uint64_t number) {
    const Interior room = oracle::random_interior(number);
    const grpc::Status loaded = questioner_.load(pbrt_text(room));
    ASSERT_TRUE(loaded.ok()) << loaded.error_message() << "\n" << pbrt_text(room);
    for (const Request& q : requests_about(room, number)) {
      const auto right = right_answers(room, q);
      const Verdict verdict = compare(room, q, right);
      tallies_[name_of(room, q)].add(verdict.kind);
      const bool wrong = verdict.kind == Kind::kWrong;
      if (wrong) ++failures_;
      if (wrong || misses_always(room, q, right, verdict)) show(number, room, q);
    }
    questioner_.release();
  }

  static std::vector<oracle::Amount> right_answers(const Interior& room, const Request& request) {
    const InteriorTruth truth(room);
    std::vector<oracle::Amount> right{truth.illuminance(request.receiver, request.bounces)};
    if (request.per_light)
      for (std::size_t l = 0; l < room.lamps.size(); ++l)
        right.push_back(truth.by_images(request.receiver, l, request.bounces));
    return right;
  }

  /// `right`: the illuminance, and that from each lamp if the request is per light.
  Verdict compare(const Interior& room, const Request& request,
                  const std::vector<oracle::Amount>& right) {
    for (const oracle::Amount& a : right)
      if (a.bound > kMostError * a.value) return {Kind::kUnsure};
    v1::EstimateIrradianceRequest q;
    if (request.bounces != InteriorTruth::kAll)
      q.set_bounces(static_cast<std::uint32_t>(request.bounces));
    q.set_per_light(request.per_light);
    q.mutable_seed()->set_seed(request.seed);
    if (request.samples > 0) {
      q.mutable_accuracy()->set_samples(request.samples);
    } else {
      q.mutable_accuracy()->mutable_target_error()->set_relative(kTarget);
      q.mutable_accuracy()->mutable_target_error()->set_max_samples(2048);
    }
    const Place at = room.place_of(room.receivers[request.receiver]);
    v1::EstimateIrradianceResponse r;
    const grpc::Status s = questioner_.irradiance(at, q, &r);
    if (!s.ok()) return {Kind::kWrong, s.error_message()};
    // Light without a known bound may be missing from such an answer: it has no upper end.
    const bool is_open = r.status_size() > 0 && r.status(0) == v1::ITEM_STATUS_MAY_MISS_LIGHT &&
                         r.unsampled_bound_lx(0) == 0;
    Verdict worst{Kind::kAgrees};
    for (std::size_t i = 0; i < right.size(); ++i) {
      const auto l = static_cast<int>(i) - 1;
      const Real value = l < 0 ? r.illuminance_lx(0) : r.shares(l).illuminance_lx(0);
      const Real lower = l < 0 ? r.lower_lx(0) : r.shares(l).lower_lx(0);
      Real upper = l < 0 ? r.upper_lx(0) : r.shares(l).upper_lx(0);
      if (is_open) upper = std::numeric_limits<Real>::infinity();
      const Real slack = right[i].bound + kOfFloats * right[i].value;
      const bool holds = lower <= right[i].value + slack && upper >= right[i].value - slack;
      const std::string what = l < 0 ? "illuminance" : fmt::format("from lamp {}", l + 1);
      const std::string text = fmt::format(
          "at {}\nbounces {}, samples {}, seed {}\n{}: the server says {} from {} to {} lx, right "
          "is {} lx",
          shown(at), request.bounces, request.samples, request.seed, what,
          static_cast<double>(value), static_cast<double>(lower), static_cast<double>(upper),
          shown(right[i]));
      const Verdict one = lower == upper ? verdict_of(holds, text)
                                         : Verdict{holds ? Kind::kHolds : Kind::kMisses, text};
      if (one.kind == Kind::kWrong) return one;
      if (one.kind == Kind::kMisses || worst.kind == Kind::kAgrees) worst = one;
    }
    return worst;
  }

  /// Whether four further seeds miss too, which is no chance.
  bool misses_always(const Interior& room, Request q, const std::vector<oracle::Amount>& right,
                     Verdict verdict) {
    for (int i = 0; i < 4 && verdict.kind == Kind::kMisses; ++i) {
      ++q.seed;
      verdict = compare(room, q, right);
    }
    return verdict.kind == Kind::kMisses;
  }

  /// Prints the smallest room that still has an answer of this kind to the question.
  void show(std::uint64_t number, const Interior& room, const Request& q) {
    const Kind kind = judge_anew(room, q).kind;
    Interior least = room;
    const auto leave_out = [&](auto member) {
      for (std::size_t i = (least.*member).size(); i-- > 0;) {
        Interior less = least;
        (less.*member).erase((less.*member).begin() + static_cast<std::ptrdiff_t>(i));
        if (judge_anew(less, q).kind == kind) least = less;
      }
    };
    leave_out(&Interior::sheets);
    if (!q.per_light) leave_out(&Interior::lamps);
    std::cout << fmt::format("LUCERNA_ORACLE_ROOM={}: {}\n{}{}\n", number, name_of(room, q),
                             pbrt_text(least), judge_anew(least, q).text)
              << std::flush;
    judge_anew(room, q);  // loads the whole room again
  }

  Verdict judge_anew(const Interior& room, const Request& q) {
    questioner_.release();
    if (!questioner_.load(pbrt_text(room)).ok()) return {Kind::kNoAnswer};
    return compare(room, q, right_answers(room, q));
  }

  TempDirectory root_;
  Service service_{scenes_in(root_.path())};
  Questioner questioner_{service_, root_.path()};
  std::map<std::string, Tally> tallies_;
  std::uint64_t failures_ = 0;
};

TEST_F(Interiors, AgreeWithTheServer) {
  const std::uint64_t none = ~std::uint64_t{0};
  const auto one_room = whole_number_of("LUCERNA_ORACLE_ROOM", 0, none);
  const auto from = whole_number_of("LUCERNA_ORACLE_FIRST", 0, 0);
  const auto rooms = whole_number_of("LUCERNA_ORACLE_ROOMS", 1, 200);
  for (const auto* setting : {&one_room, &from, &rooms})
    ASSERT_TRUE(setting->ok()) << setting->status();
  const std::uint64_t first = *one_room == none ? *from : *one_room;
  const std::uint64_t last = *one_room == none ? first + *rooms : first + 1;
  for (std::uint64_t i = first; i < last; ++i) {
    check(i);
    ASSERT_LT(failures_, kMostFailures) << "stopped after room " << i;
  }
  for (const auto& [name, t] : tallies_) t.print(name);
  EXPECT_EQ(failures_, 0U);
  if (*one_room != none) return;
  for (const auto& [name, t] : tallies_) t.expect_shares(name, 0.07, 0.05);
}

}  // namespace
}  // namespace lucerna::testing
