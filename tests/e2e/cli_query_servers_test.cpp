// Small queries of lucerna to several servers, one of which is killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "lucerna/client/testing/local_server.h"
#include "tests/client/library/fake_server.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class QueryServers : public ::testing::Test {
 protected:
  QueryServers() {
    for (int i = 0; i < 2; ++i) servers_.push_back(start());
  }

  static std::unique_ptr<testing::LocalServer> start() {
    auto server = testing::LocalServer::start({.scene_root = test_data("reference"), .threads = 1});
    EXPECT_TRUE(server.ok()) << server.status();
    return std::make_unique<testing::LocalServer>(*std::move(server));
  }
  std::string both() const { return servers_[0]->target() + "," + servers_[1]->target(); }
  static Outcome lucerna(std::vector<std::string> arguments, const std::string& server) {
    arguments.insert(arguments.begin(), build_path("bin/lucerna"));
    return run_program(std::move(arguments), {}, {{"LUCERNA_SERVER", server}});
  }
  static std::vector<std::string> irradiance(const std::string& scene) {
    return {"irradiance", scene, "--point", "0,0,0", "--normal", "0,0,1", "--samples", "64"};
  }

  std::vector<std::unique_ptr<testing::LocalServer>> servers_;
};

TEST_F(QueryServers, TheProgramAnswersTheSameFromOneServerAndFromSeveral) {
  const Outcome one = lucerna(irradiance("point.pbrt"), servers_[0]->target());
  ASSERT_EQ(one.status, 0) << one.err;
  Outcome several = lucerna(irradiance("point.pbrt"), both());
  EXPECT_EQ(several.status, 0) << several.err;
  EXPECT_EQ(without_cost(several.out), without_cost(one.out));
  // Both servers have the scene now, so its id or the first digits of it name the scene.
  const std::string id = lucerna({"load", "point.pbrt"}, servers_[1]->target()).out.substr(0, 64);
  for (const std::string& scene : {id, id.substr(0, 6)}) {
    several = lucerna(irradiance(scene), both());
    EXPECT_EQ(several.status, 0) << several.err;
    EXPECT_EQ(without_cost(several.out), without_cost(one.out));
    EXPECT_THAT(several.err, IsEmpty());
  }
  for (const char* command : {"power", "lights"}) {
    EXPECT_EQ(lucerna({command, "point.pbrt"}, both()).out,
              lucerna({command, "point.pbrt"}, servers_[0]->target()).out);
  }
  // After one server is killed.
  ::kill(servers_[0]->process_id(), SIGKILL);
  several = lucerna(irradiance("point.pbrt"), both());
  EXPECT_EQ(several.status, 0) << several.err;
  EXPECT_EQ(without_cost(several.out), without_cost(one.out));
  EXPECT_THAT(several.err, AllOf(HasSubstr(servers_[0]->target()), HasSubstr("without it")));
  ::kill(servers_[1]->process_id(), SIGKILL);
  several = lucerna(irradiance("point.pbrt"), both());
  EXPECT_EQ(several.status, 1);
  EXPECT_THAT(several.err, HasSubstr("cannot reach any server of " + both()));
}

TEST(QueryServersMixed, TheProgramRefusesThemUnlessAllowed) {
  FakeServer servers[2];
  servers[1].fingerprint = "g";
  for (FakeServer& server : servers) {
    server.load_scene = [](auto&, const auto&, v1::LoadSceneResponse* response) {
      response->set_scene_id("scene");
      return grpc::Status::OK;
    };
    server.irradiance = [](auto&, const auto&, auto*) { return grpc::Status::OK; };
  }
  const auto query = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {build_path("bin/lucerna"), "irradiance", "a.pbrt", "--point", "0,0,0", "--normal",
                 "0,0,1", "--json", "--server", servers[0].target() + "," + servers[1].target()});
    return run_program(std::move(more));
  };
  const Outcome refused = query({});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("its numeric fingerprint is g"));
  const Outcome allowed = query({"--allow-mixed"});
  EXPECT_EQ(allowed.status, 0) << allowed.err;
  EXPECT_THAT(allowed.err, HasSubstr("different numeric fingerprints: f, g\n"));
}

TEST_F(QueryServers, CommandsForOneServerRefuseSeveral) {
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"load", "point.pbrt"},
                                             {"scenes"},
                                             {"info"},
                                             {"release", "point.pbrt"},
                                             {"lease", "point.pbrt", "--for", "5"},
                                             {"render", "point.pbrt", "-o", "never.exr"}}) {
    const Outcome outcome = lucerna(command, both());
    EXPECT_EQ(outcome.status, 2) << command[0];
    EXPECT_THAT(outcome.err, HasSubstr("name one")) << command[0];
  }
  const Outcome outcome = lucerna(irradiance("point.pbrt"), "a:1,b:x");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--server: server \"b:x\": port \"x\", allowed: 1 to 65535"));
  const Outcome unknown = lucerna(irradiance("no_such.pbrt"), both());
  EXPECT_EQ(unknown.status, 1);
  EXPECT_THAT(unknown.err, HasSubstr("no_such.pbrt"));
}

}  // namespace
}  // namespace lucerna
