// docs/api.md lists every reason of an error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "server/rpc/messages/errors.h"
#include "tests/paths.h"

namespace lucerna::rpc {
namespace {

TEST(ReasonsPage, NamesEveryReason) {
  std::ifstream file(source_path("docs/api.md"));
  ASSERT_TRUE(file.is_open());
  std::stringstream page;
  page << file.rdbuf();
  for (const ErrorReason& reason : kErrorReasons)
    EXPECT_THAT(page.str(), ::testing::HasSubstr("`" + std::string(reason.name) + "`"));
}

}  // namespace
}  // namespace lucerna::rpc
