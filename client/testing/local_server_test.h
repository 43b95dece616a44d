// A GoogleTest fixture that runs a lucernad for each test.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "lucerna/client/testing/local_server.h"

namespace lucerna::testing {

/// Starts a server before each test and stops it afterwards.  Needs GoogleTest, which
/// lucerna::testing does not link.
///
///     class MyTest : public lucerna::testing::LocalServerTest {
///       LocalServerOptions options() const override { return {.scene_root = "scenes"}; }
///     };
class LocalServerTest : public ::testing::Test {
 protected:
  virtual LocalServerOptions options() const { return {}; }

  /// Fails the test if the server does not start.
  void SetUp() override {
    auto server = LocalServer::start(options());
    if (!server.ok()) FAIL() << server.status().message();
    server_.emplace(*std::move(server));
  }
  void TearDown() override { server_.reset(); }

  LocalServer& server() { return *server_; }
  const client::Client& client() const { return server_->client(); }

 private:
  std::optional<LocalServer> server_;
};

}  // namespace lucerna::testing
