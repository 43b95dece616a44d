// The server's answers about random small scenes against the oracle's.
//
// LUCERNA_ORACLE_SCENES: how many scenes, by default 2000.  LUCERNA_ORACLE_SCENE: the number of a
// single scene, to reproduce a failure.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>

#include "tests/oracle/truth.h"
#include "tests/oracle/world.h"
#include "tests/server/extremes/wire_settings.h"
#include "tests/server/rpc/service_fixture.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

using oracle::Amount;
using oracle::Place;
using oracle::Real;
using oracle::Truth;
using oracle::Vec;
using oracle::Way;
using oracle::World;

/// The counts of one kind of answer.
struct Tally {
  std::uint64_t compared = 0, unsure = 0, wrong = 0;
};

std::string shown(const Place& p) {
  const auto three = [](const Vec& v) {
    return fmt::format("({:.17g}, {:.17g}, {:.17g})", static_cast<double>(v.x),
                       static_cast<double>(v.y), static_cast<double>(v.z));
  };
  return three(p.at) + " m, normal " + three(p.normal) + fmt::format(", on shape {}", p.on);
}

/// Adds a point.  The first point of a batch is its origin, and the offsets are zero: each query
/// asks for one point, so that no coordinate is rounded.
void set_point(const Place& p, v1::Points* points) {
  points->mutable_origin_m()->set_x(static_cast<double>(p.at.x));
  points->mutable_origin_m()->set_y(static_cast<double>(p.at.y));
  points->mutable_origin_m()->set_z(static_cast<double>(p.at.z));
  for (int i = 0; i < 3; ++i) points->add_offsets_m(0);
}

template <typename Field>
void add_normal(const Place& p, Field* field) {
  for (const Real x : {p.normal.x, p.normal.y, p.normal.z}) field->Add(static_cast<float>(x));
}

class Oracle : public ::testing::Test {
 protected:
  rpc::ServerOptions options() const {
    rpc::ServerOptions options = service_options();
    options.scenes.root = root_.path();
    return options;
  }

  void check(std::uint64_t number) {
    const World world = oracle::random_world(number);
    std::ofstream(root_.path() / "scene.pbrt") << pbrt_text(world);
    id_ = service_.load("scene.pbrt");
    ASSERT_FALSE(HasFailure()) << pbrt_text(world);
    const Truth truth(world);
    const std::size_t before = failures_.size();
    for (const World::Segment& segment : world.segments) check_visibility(truth, segment);
    for (const Place& receiver : world.receivers) check_illuminance(truth, receiver);
    if (failures_.size() > before) {
      std::cout << fmt::format("LUCERNA_ORACLE_SCENE={}\n{}", number, pbrt_text(world));
      for (std::size_t i = before; i < failures_.size(); ++i) std::cout << failures_[i] << "\n";
    }
    v1::ReleaseSceneRequest release;
    release.set_scene_id(id_);
    v1::ReleaseSceneResponse released;
    ASSERT_TRUE(status_of([&](auto* c) {
                  return service_.scenes.ReleaseScene(c, release, &released);
                }).ok());
  }

  void check_visibility(const Truth& truth, const World::Segment& segment) {
    const Way way = truth.way(segment.from, segment.to);
    if (way == Way::kUnsure) {
      ++visibility_.unsure;
      return;
    }
    v1::TestVisibilityRequest q;
    q.set_scene_id(id_);
    set_point(segment.from, q.mutable_segments()->mutable_from());
    set_point(segment.to, q.mutable_segments()->mutable_to());
    if (length(segment.from.normal) > 0) add_normal(segment.from, q.mutable_normals());
    v1::TestVisibilityResponse r;
    const grpc::Status s =
        status_of([&](auto* c) { return service_.lighting.TestVisibility(c, q, &r); });
    ASSERT_TRUE(s.ok()) << s.error_message();
    ++visibility_.compared;
    const bool visible = (r.visible()[0] & 1) != 0;
    if (visible == (way == Way::kFree)) return;
    ++visibility_.wrong;
    failures_.push_back(fmt::format("from {}\nto {}\nvisible: the server says {}",
                                    shown(segment.from), shown(segment.to), visible));
  }

  void check_illuminance(const Truth& truth, const Place& receiver) {
    const Amount amount = truth.illuminance(receiver);
    if (!amount.sure || amount.bound > 0.01L * amount.value) {
      ++exact_.unsure;
      return;
    }
    v1::EstimateIrradianceRequest q;
    q.set_scene_id(id_);
    set_point(receiver, q.mutable_receivers());
    add_normal(receiver, q.mutable_normals());
    q.set_bounces(0);
    v1::EstimateIrradianceResponse r;
    const grpc::Status s =
        status_of([&](auto* c) { return service_.lighting.EstimateIrradiance(c, q, &r); });
    ASSERT_TRUE(s.ok()) << s.error_message();
    if (r.status_size() > 0 && r.status(0) == v1::ITEM_STATUS_OUT_OF_RANGE) return;
    const Real slack = amount.bound + 1e-6L * amount.value;
    const bool exact = r.standard_error_lx(0) == 0 && r.lower_lx(0) == r.upper_lx(0);
    const bool holds =
        r.lower_lx(0) <= amount.value + slack && r.upper_lx(0) >= amount.value - slack;
    Tally& tally = exact ? exact_ : sampled_;
    ++tally.compared;
    if (holds) return;
    ++tally.wrong;
    if (!exact) return;  // judged as a whole
    failures_.push_back(fmt::format(
        "at {}\nilluminance: the server says {} exact, right is {} +- {} lx", shown(receiver),
        r.illuminance_lx(0), static_cast<double>(amount.value), static_cast<double>(amount.bound)));
  }

  TempDirectory root_;
  Service service_{options()};
  std::string id_;
  Tally visibility_, exact_, sampled_;
  std::vector<std::string> failures_;
};

TEST_F(Oracle, AgreesWithTheServer) {
  const auto setting = [](const char* name, std::uint64_t usual) {
    return whole_number_of(name, 0, usual).value();
  };
  const std::uint64_t all = ~std::uint64_t{0};
  const std::uint64_t one = setting("LUCERNA_ORACLE_SCENE", all);
  const std::uint64_t scenes = setting("LUCERNA_ORACLE_SCENES", 2000);
  for (std::uint64_t i = one == all ? 0 : one; i < (one == all ? scenes : one + 1); ++i) {
    check(i);
    if (HasFatalFailure()) return;
  }
  for (const auto& [name, tally] :
       {std::pair{"visibility", visibility_}, {"exact", exact_}, {"sampled", sampled_}})
    std::cout << fmt::format("{}: {} compared, {} unsure, {} wrong\n", name, tally.compared,
                             tally.unsure, tally.wrong);
  EXPECT_EQ(failures_.size(), 0U);
  if (one != all) return;
  // Intervals hold in 95%: a share that is four standard deviations lower is no chance.
  const auto sampled = static_cast<double>(sampled_.compared);
  EXPECT_LE(static_cast<double>(sampled_.wrong), 0.05 * sampled + 4 * std::sqrt(0.0475 * sampled));
  // The rule for unsure answers must not hide what is wrong.
  EXPECT_LE(visibility_.unsure,
            0.05 * static_cast<double>(visibility_.unsure + visibility_.compared));
  const std::uint64_t receivers = exact_.unsure + exact_.compared + sampled_.compared;
  EXPECT_LE(exact_.unsure, 0.05 * static_cast<double>(receivers));
}

}  // namespace
}  // namespace lucerna::testing
