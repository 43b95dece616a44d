// Words of the command line: times, shares, addresses, corrections, remarks and errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/terminal/error.h"
#include "client/terminal/remarks.h"
#include "client/terminal/server_address.h"
#include "client/terminal/suggestion.h"
#include "client/terminal/validators.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "lucerna/client/client.h"

namespace lucerna {
namespace {

TEST(EditDistance, CountsInsertionsDeletionsReplacementsAndSwaps) {
  EXPECT_EQ(cli::edit_distance("", ""), 0U);
  EXPECT_EQ(cli::edit_distance("", "abc"), 3U);
  EXPECT_EQ(cli::edit_distance("abc", ""), 3U);
  EXPECT_EQ(cli::edit_distance("render", "render"), 0U);
  EXPECT_EQ(cli::edit_distance("rendr", "render"), 1U);
  EXPECT_EQ(cli::edit_distance("renderr", "render"), 1U);
  EXPECT_EQ(cli::edit_distance("lender", "render"), 1U);
  EXPECT_EQ(cli::edit_distance("redner", "render"), 1U);
  EXPECT_EQ(cli::edit_distance("kitten", "sitting"), 3U);
}

TEST(NearestWord, IsFoundIfAThirdOfTheLettersAreWrongAtMost) {
  const std::vector<std::string> known = {"scene", "scenes", "le", "pdf"};
  EXPECT_EQ(cli::nearest_word("scens", known), "scene");
  EXPECT_EQ(cli::nearest_word("sceness", known), "scenes");
  EXPECT_EQ(cli::nearest_word("pfd", known), "pdf");
  EXPECT_EQ(cli::nearest_word("ls", known), "");
  EXPECT_EQ(cli::nearest_word("frobnicate", known), "");
  EXPECT_EQ(cli::nearest_word("", known), "");
}

TEST(ServerAddress, HostsWithoutAPortGetTheDefaultPort) {
  const std::pair<const char*, const char*> cases[] = {{"localhost", "localhost:50051"},
                                                       {"localhost:1", "localhost:1"},
                                                       {"10.0.0.7", "10.0.0.7:50051"},
                                                       {"::1", "[::1]:50051"},
                                                       {"fe80::1:2", "[fe80::1:2]:50051"},
                                                       {"[::1]", "[::1]:50051"},
                                                       {"[::1]:2", "[::1]:2"},
                                                       {"a,b:2,::1", "a:50051,b:2,[::1]:50051"},
                                                       {"dns:///servers", "dns:///servers:50051"},
                                                       {"dns:///servers:2", "dns:///servers:2"},
                                                       {"", ""},
                                                       {"a,,b", "a:50051,,b:50051"},
                                                       {"a:", "a:"}};
  for (const auto& [typed, address] : cases) EXPECT_EQ(cli::with_default_port(typed), address);
  for (const char* other : {"@servers.txt", "slurm:50051", "unix:/run/lucernad", "unix:///run/l",
                            "ipv4:1.2.3.4:5,6.7.8.9:1", "ipv6:[::1]:5"}) {
    EXPECT_EQ(cli::with_default_port(other), other);
  }
}

TEST(ServerAddresses, NeedAHostAndAPort) {
  const auto read = [](std::string text) {
    const std::string error = cli::server_addresses()(text);
    return error.empty() ? text : error;
  };
  EXPECT_EQ(read("localhost"), "localhost:50051");
  EXPECT_EQ(read("a,b:65535"), "a:50051,b:65535");
  EXPECT_EQ(read("[::1]:1"), "[::1]:1");
  EXPECT_EQ(read("dns:///name"), "dns:///name:50051");
  EXPECT_EQ(read("unix:/run/lucernad"), "unix:/run/lucernad");
  EXPECT_EQ(read("x:y"), "server \"x:y\": port \"y\", allowed: 1 to 65535");
  EXPECT_EQ(read("a:"), "server \"a:\": port \"\", allowed: 1 to 65535");
  EXPECT_EQ(read("a:65536"), "server \"a:65536\": port \"65536\", allowed: 1 to 65535");
  EXPECT_EQ(read("a:0"), "server \"a:0\": port \"0\", allowed: 1 to 65535");
  EXPECT_EQ(read("dns:///a:-1"), "server \"a:-1\": port \"-1\", allowed: 1 to 65535");
  EXPECT_EQ(read("a,,b"), "server \"\": no host, allowed: HOST:PORT");
  EXPECT_EQ(read(":50051"), "server \":50051\": no host, allowed: HOST:PORT");
  EXPECT_EQ(read("[::1]:119537"), "server \"[::1]:119537\": port \"119537\", allowed: 1 to 65535");
  EXPECT_EQ(read("ipv4:10.0.0.7:119537"),
            "server \"10.0.0.7:119537\": port \"119537\", allowed: 1 to 65535");
  EXPECT_EQ(read("slurm:119537"), "server \"slurm:119537\": port \"119537\", allowed: 1 to 65535");
}

TEST(Duration, IsReadWithUnitsInDescendingOrder) {
  const std::pair<const char*, double> cases[] = {
      {"60", 60},      {"60s", 60},       {"2m", 120},       {"500ms", 0.5}, {"1h", 3600},
      {"1h30m", 5400}, {"1h30m5s", 5405}, {"1m500ms", 60.5}, {"1.5h", 5400}, {"1e3s", 1000}};
  for (const auto& [text, seconds] : cases) EXPECT_EQ(cli::read_duration(text), seconds) << text;
  for (const char* text :
       {"h", "1x", "1h30", "30m1h", "1m1m", "1 h", "-1h", "1h-1m", "1sm", "nan"}) {
    EXPECT_EQ(cli::read_duration(text), std::nullopt) << text;
  }
}

TEST(Share, OfOneOrMoreNeedsThePercentSign) {
  const auto read = [](std::string text) {
    const std::string error = cli::share()(text);
    return error.empty() ? text : error;
  };
  EXPECT_EQ(read("0.01"), "0.01");
  EXPECT_EQ(read("1%"), "0.01");
  EXPECT_EQ(read("500%"), "5");
  EXPECT_EQ(read("0.999"), "0.999");
  EXPECT_EQ(read("5"), "5 is 500%; did you mean 5%?");
  EXPECT_EQ(read("1"), "1 is 100%; did you mean 1%?");
  EXPECT_EQ(read("0"), "0 is not a fraction above 0, such as 1% or 0.01");
  EXPECT_EQ(read("-5"), "-5 is not a fraction above 0, such as 1% or 0.01");
}

TEST(Remarks, AreCountedByTheirReplacement) {
  google::protobuf::RepeatedPtrField<v1::Remark> remarks;
  EXPECT_EQ(cli::count_remarks(remarks), "");
  const auto add = [&](const char* what, const char* instead) {
    v1::Remark* remark = remarks.Add();
    remark->set_what(what);
    remark->set_instead(instead);
  };
  add("Film \"gbuffer\" is not modelled", "linear RGB");
  EXPECT_EQ(cli::count_remarks(remarks), "1 other remark");
  add("material \"hair\" is not modelled", "diffuse, reflectance 0.5");
  add("Shape \"curve\" is not modelled", "left out");
  add("mesh \"a.ply\" is empty", "left out");
  add("\"stdillum-A\" is not the spectrum of a reflectance", "grey 0.25, its luminous reflectance");
  add("rgb \"reflectance\" of a surface is not modelled", "grey 0.5");
  EXPECT_EQ(cli::count_remarks(remarks),
            "2 surfaces left out, 1 material taken as diffuse, 2 colours taken as grey, "
            "1 other remark");
  // A remark of several places counts at each of them.
  remarks.Mutable(0)->set_count(1000);
  EXPECT_THAT(cli::count_remarks(remarks), ::testing::EndsWith(", 1000 other remarks"));
}

TEST(Remarks, OfSeveralPlacesAreOneLine) {
  v1::Remark remark;
  remark.set_file("a.pbrt");
  remark.set_line(3);
  remark.set_column(5);
  remark.set_what("hair");
  remark.set_instead("diffuse");
  EXPECT_EQ(cli::describe(remark), "a.pbrt:3:5: hair; diffuse");
  remark.set_count(2);
  EXPECT_EQ(cli::describe(remark), "a.pbrt:3:5 and 1 more place: hair; diffuse");
  remark.set_count(1000);
  EXPECT_EQ(cli::describe(remark), "a.pbrt:3:5 and 999 more places: hair; diffuse");
}

TEST(Error, IsOneLineOfJsonWithTheServersDetails) {
  EXPECT_EQ(cli::to_json(absl::NotFoundError("no \"a\"")),
            R"({"error":{"code":"NOT_FOUND","message":"no \"a\"","details":[]}})"
            "\n");
  google::rpc::ErrorInfo info;
  info.set_reason("SCENE_NOT_LOADED");
  google::rpc::Status details;
  details.add_details()->PackFrom(info);
  details.add_details()->set_type_url("type.googleapis.com/some.Unknown");
  absl::Status status = absl::NotFoundError("gone");
  status.SetPayload(client::kStatusPayloadUrl, absl::Cord(details.SerializeAsString()));
  const auto error = nlohmann::json::parse(cli::to_json(status))["error"];
  ASSERT_EQ(error["details"].size(), 2U);
  EXPECT_EQ(error["details"][0]["@type"], "type.googleapis.com/google.rpc.ErrorInfo");
  EXPECT_EQ(error["details"][0]["reason"], "SCENE_NOT_LOADED");
  EXPECT_EQ(error["details"][1]["@type"], "type.googleapis.com/some.Unknown");
  // Bytes that are no UTF-8 must not stop the report.
  EXPECT_THAT(cli::to_json(absl::UnknownError("\xff")), ::testing::HasSubstr("UNKNOWN"));
}

}  // namespace
}  // namespace lucerna
