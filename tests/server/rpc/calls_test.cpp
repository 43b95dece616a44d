// Every call of the contract has a role.
#include "server/monitor/calls.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "lucerna/v1/admin.pb.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna::monitor {
namespace {

TEST(Calls, AreThoseOfTheContract) {
  std::set<std::string> contract, table;
  for (const google::protobuf::FileDescriptor* file :
       {v1::GetStatsRequest::descriptor()->file(), v1::LeRequest::descriptor()->file(),
        v1::RenderTileRequest::descriptor()->file(), v1::LoadSceneRequest::descriptor()->file()}) {
    for (int s = 0; s < file->service_count(); ++s) {
      const auto* service = file->service(s);
      for (int m = 0; m < service->method_count(); ++m) {
        contract.insert(service->full_name() + "/" + service->method(m)->name());
      }
    }
  }
  for (std::size_t i = 0; i < kContractCalls; ++i) {
    const std::string name = kCallTable[i].name;
    EXPECT_TRUE(table.insert(name).second) << name << " twice";
  }
  EXPECT_EQ(table, contract);
}

}  // namespace
}  // namespace lucerna::monitor
