// The server's answers about random small scenes against the oracle's.
//
// LUCERNA_ORACLE_SCENES: how many scenes, by default 2000.  LUCERNA_ORACLE_FIRST: the number of the
// first one, by default 0.  LUCERNA_ORACLE_SCENE: the number of a single scene, to reproduce a
// failure.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iostream>
#include <map>

#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/questioner.h"
#include "tests/oracle/shrink.h"
#include "tests/oracle/tally.h"
#include "tests/server/extremes/wire_settings.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

class Oracle : public ::testing::Test {
 protected:
  void check(std::uint64_t number) {
    const oracle::World world = oracle::random_world(number);
    count(world);
    const grpc::Status loaded = questioner_.load(world);
    ASSERT_TRUE(loaded.ok()) << loaded.error_code() << ": " << loaded.error_message() << "\n"
                             << pbrt_text(world);
    const oracle::Truth truth(world);
    for (const Question& question : questions_about(world)) {
      const Verdict verdict = questioner_.judge(truth, question);
      tallies_[question.kind].add(verdict.kind);
      if (verdict.kind != Verdict::Kind::kWrong) continue;
      ++failures_;
      show(number, world, question, verdict);
    }
    questioner_.release();
  }

  void count(const oracle::World& world) {
    for (const oracle::Shape& shape : world.shapes) {
      const std::string kind = oracle::kShapeNames.at(static_cast<std::size_t>(shape.kind));
      ++kinds_[kind];
      if (shape.radiance > 0) ++kinds_[kind + " that emits"];
      if (length(shape.moves) > 0) ++kinds_["shape that moves"];
    }
    for (const oracle::Light& light : world.lights)
      ++kinds_[std::string("light: ") +
               oracle::kLightNames.at(static_cast<std::size_t>(light.kind))];
  }

  Verdict judge(const oracle::World& world, const Question& question) {
    questioner_.release();
    // The server may leave out or refuse shapes that rounding made degenerate.
    for (const int emitter : emitting_shapes(world))
      if (!(area_of(world.shapes[static_cast<std::size_t>(emitter)]).first > 0))
        return {Verdict::Kind::kNoAnswer};
    if (!questioner_.load(world).ok()) return {Verdict::Kind::kNoAnswer};
    return questioner_.judge(oracle::Truth(world), question);
  }

  /// Prints the first verdict, and the smallest scene that still has a wrong answer to the
  /// question.
  void show(std::uint64_t number, const oracle::World& world, const Question& question,
            const Verdict& first) {
    // A call that failed once leaves no smaller scene.
    std::cout << fmt::format("scene {}: {}\n", number, first.text);
    const auto [least, same] = oracle::shrink(world, question, [&](const auto& w, const auto& q) {
      return judge(w, q).kind == Verdict::Kind::kWrong;
    });
    std::cout << fmt::format("LUCERNA_ORACLE_SCENE={}\n{}time {}\n{}\n", number, pbrt_text(least),
                             static_cast<double>(least.time), judge(least, same).text);
    judge(world, question);  // loads the whole scene again
  }

  TempDirectory root_;
  Service service_{scenes_in(root_.path())};
  Questioner questioner_{service_, root_.path()};
  std::map<Question::Kind, Tally> tallies_;
  std::map<std::string, std::uint64_t> kinds_;
  std::uint64_t failures_ = 0;
};

TEST_F(Oracle, AgreesWithTheServer) {
  const std::uint64_t none = ~std::uint64_t{0};
  const auto one_scene = whole_number_of("LUCERNA_ORACLE_SCENE", 0, none);
  const auto from = whole_number_of("LUCERNA_ORACLE_FIRST", 0, 0);
  const auto scenes = whole_number_of("LUCERNA_ORACLE_SCENES", 1, 2000);
  for (const auto* setting : {&one_scene, &from, &scenes})
    ASSERT_TRUE(setting->ok()) << setting->status();
  const std::uint64_t one = *one_scene;
  const std::uint64_t first = one == none ? *from : one;
  const std::uint64_t last = one == none ? first + *scenes : one + 1;
  for (std::uint64_t i = first; i < last; ++i) {
    check(i);
    ASSERT_LT(failures_, kMostFailures) << "stopped after scene " << i;
  }
  for (const auto& [kind, n] : kinds_) std::cout << fmt::format("{}: {}\n", kind, n);
  for (const auto& [kind, t] : tallies_) t.print(name_of(kind));
  std::cout << fmt::format("{} calls were sent again, because their connection broke\n",
                           questioner_.repeats());
  EXPECT_EQ(failures_, 0U);
  if (one != none) return;
  for (const auto& [kind, t] : tallies_) t.expect_shares(name_of(kind), 0.05, 0.05);
}

TEST(OracleCalls, AreSentAgainOnlyIfTheirConnectionBreaks) {
  const auto outcome = [](grpc::StatusCode code, int failures) {
    int calls = 0;
    std::uint64_t repeats = 0;
    const grpc::Status status = status_on_any_connection(
        [&](auto*) { return calls++ < failures ? grpc::Status(code, "") : grpc::Status::OK; },
        repeats);
    EXPECT_EQ(repeats + 1, static_cast<std::uint64_t>(calls));
    return std::pair(status.error_code(), calls);
  };
  using enum grpc::StatusCode;
  EXPECT_EQ(outcome(UNAVAILABLE, 0), std::pair(OK, 1));
  EXPECT_EQ(outcome(UNAVAILABLE, 3), std::pair(OK, 4));
  EXPECT_EQ(outcome(UNAVAILABLE, 9), std::pair(UNAVAILABLE, 4));
  EXPECT_EQ(outcome(INTERNAL, 1), std::pair(INTERNAL, 1));
}

}  // namespace
}  // namespace lucerna::testing
