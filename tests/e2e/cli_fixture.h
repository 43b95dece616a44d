// Runs the program lucerna against a lucernad.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "client/testing/local_server.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {

namespace fs = std::filesystem;

/// One server for all tests.  The scene root is a temporary directory with the reference scenes and
/// a broken scene.
class Cli : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = std::make_unique<TempDirectory>();
    const fs::path scenes = directory_->path() / "scenes";
    fs::create_directories(scenes);
    for (const char* file : {"point.pbrt", "sphere.pbrt", "rectangle_near.pbrt", "ball.ply"}) {
      fs::copy_file(fs::path(test_data("reference")) / file, scenes / file);
    }
    // sphere.pbrt with a ninth of its pixels.
    std::ifstream sphere(scenes / "sphere.pbrt");
    std::ofstream small(scenes / "small.pbrt");
    for (std::string line; std::getline(sphere, line); small << line << "\n")
      if (line.starts_with("Film"))
        line = "Film \"rgb\" \"integer xresolution\" 54 \"integer yresolution\" 40";
    small.close();
    fs::copy_file(test_data("pbrt/moving_point.pbrt"), scenes / "moving_point.pbrt");
    std::ofstream(scenes / "broken.pbrt") << "WorldBegin\nShape sphere\n";
    std::ofstream(scenes / "lamp.pbrt")
        << "WorldBegin\nLightSource \"point\" \"spectrum I\" [500 1 600 1] \"float power\" 1000\n";
    std::ofstream(scenes / "sky.pbrt")
        << "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n"
           "LightSource \"distant\" \"rgb L\" [1 1 1]\nLightSource \"point\" \"rgb I\" [1 1 1]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]\n";
    std::ofstream(scenes / "named.pbrt")
        << "WorldBegin\nLightSource \"point\" \"rgb I\" [1 1 1] \"string name\" \"desk lamp\"\n"
           "LightSource \"point\" \"rgb I\" [2 2 2]\n";
    auto server = testing::LocalServer::start({.scene_root = scenes.string()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }
  static void TearDownTestSuite() {
    server_.reset();
    directory_.reset();
  }
  void SetUp() override { ASSERT_NE(server_, nullptr); }

  static Outcome lucerna(std::vector<std::string> arguments, const std::string& input = {}) {
    arguments.insert(arguments.begin(), build_path("bin/lucerna"));
    return run_program(std::move(arguments), input, {{"LUCERNA_SERVER", server_->target()}});
  }
  static std::string path(const std::string& name) { return (directory_->path() / name).string(); }
  /// All files in the tests' directory, hidden files included.
  static std::vector<std::string> files() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_->path())) {
      if (entry.path().filename() != "scenes") names.push_back(entry.path().filename().string());
    }
    return names;
  }

  static inline std::unique_ptr<TempDirectory> directory_;
  static inline std::unique_ptr<testing::LocalServer> server_;
};

inline void expect_wrong_use(const Outcome& outcome, const std::string& what) {
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_THAT(outcome.err, ::testing::HasSubstr(what));
  EXPECT_THAT(outcome.out, ::testing::IsEmpty());
}

inline void expect_no(const Outcome& outcome, const std::string& what) {
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.err, ::testing::HasSubstr(what));
}

}  // namespace lucerna
