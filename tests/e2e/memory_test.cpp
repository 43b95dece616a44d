// The memory that GetScene reports agrees with that of the operating system.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "lucerna/client/testing/local_server.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

/// A wavy sheet of 2 edge^2 triangles as binary PLY.
void write_sheet(const fs::path& path, std::uint32_t edge) {
  const std::uint32_t across = edge + 1;
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << across * across
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << 2 * edge * edge
      << "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (std::uint32_t y = 0; y < across; ++y) {
    for (std::uint32_t x = 0; x < across; ++x) {
      const float p[3] = {static_cast<float>(x), static_cast<float>(y),
                          std::sin(0.1F * static_cast<float>(x + y))};
      out.write(reinterpret_cast<const char*>(p), sizeof p);
    }
  }
  for (std::uint32_t y = 0; y < edge; ++y) {
    for (std::uint32_t x = 0; x < edge; ++x) {
      const std::uint32_t a = y * across + x, b = a + 1, c = a + across, d = c + 1;
      for (const auto& t : {std::array{a, b, c}, std::array{b, d, c}}) {
        out.put(3);
        out.write(reinterpret_cast<const char*>(t.data()), sizeof t);
      }
    }
  }
}

double resident_bytes(int process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/statm");
  double total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

constexpr double kMiB = 1 << 20;

class Memory : public ::testing::Test {
 protected:
  void SetUp() override {
    write_sheet(directory_ / "sheet.ply", 1750);
    std::ofstream(directory_ / "sheet.pbrt")
        << "WorldBegin\nShape \"plymesh\" \"string filename\" \"sheet.ply\"\n";
    auto server = testing::LocalServer::start({.scene_root = directory_.string()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }
  v1::LoadSceneRequest sheet() const {
    v1::LoadSceneRequest request;
    request.set_path("sheet.pbrt");
    return request;
  }

  /// The most memory that the server had so far.
  double peak_bytes() const { return status_bytes("VmHWM:"); }
  double status_bytes(const std::string& field) const {
    std::ifstream in("/proc/" + std::to_string(server_->process_id()) + "/status");
    std::string word;
    double kilobytes = 0;
    while (in >> word)
      if (word == field) in >> kilobytes;
    return kilobytes * 1024;
  }
  void restart(const std::string& budget) {
    server_.reset();
    auto server = testing::LocalServer::start(
        {.scene_root = directory_.string(), .arguments = {"--memory-budget", budget}});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }

  const TempDirectory temporary_;  // outlives the servers
  const fs::path directory_ = temporary_.path();
  std::unique_ptr<testing::LocalServer> server_;
};

TEST_F(Memory, GetSceneAgreesWithTheChangeOfResidentMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers use additional memory";
#endif
  const double before = resident_bytes(server_->process_id());
  const auto loaded = server_->client().load_scene(sheet());
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  const double after = resident_bytes(server_->process_id());
  v1::GetSceneRequest get;
  get.set_scene_id(loaded->scene_id());
  const auto scene = server_->client().get_scene(get);
  ASSERT_TRUE(scene.ok()) << scene.status();
  const auto reported = static_cast<double>(scene->summary().bytes());
  EXPECT_GT(reported, 400e6);
  EXPECT_NEAR(after - before, reported, 0.1 * reported);
  // Unloading the scene frees it.
  v1::ReleaseSceneRequest release;
  release.set_scene_id(loaded->scene_id());
  ASSERT_TRUE(server_->client().release_scene(release).ok());
  EXPECT_LT(resident_bytes(server_->process_id()) - before, 0.1 * reported);
}

TEST_F(Memory, ACancelledLoadStopsAndLeavesNothing) {
  const auto loads = [&] {
    const auto stats = server_->client().get_stats();
    EXPECT_TRUE(stats.ok()) << stats.status();
    return stats.ok() && std::ranges::any_of(stats->calls(), [](const v1::CallStats& call) {
             return call.running() > 0 && call.method().ends_with("LoadScene");
           });
  };
  const double begun = resident_bytes(server_->process_id()) + 30 * kMiB;
  // On a busy machine a load may end before it is cancelled.
  bool left = true;
  for (int i = 0; i < 20 && left; ++i) {
    std::stop_source stop;
    std::atomic<bool> over = false;
    std::jthread canceller([&] {
      while (!over && resident_bytes(server_->process_id()) < begun) std::this_thread::yield();
      stop.request_stop();
    });
    (void)server_->client().load_scene(sheet(), {.stop = stop.get_token()});
    over = true;
    while (loads()) std::this_thread::yield();
    const auto scenes = server_->client().list_scenes({});
    ASSERT_TRUE(scenes.ok()) << scenes.status();
    left = scenes->scenes_size() > 0;
    for (const v1::SceneSummary& scene : scenes->scenes()) {
      v1::ReleaseSceneRequest release;
      release.set_scene_id(scene.scene_id());
      ASSERT_TRUE(server_->client().release_scene(release).ok());
    }
  }
  EXPECT_FALSE(left);
}

TEST_F(Memory, ALoadOverTheBudgetEndsBeforeItNeedsMore) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers use additional memory";
#endif
  // The scene needs more than 500 MB, its file alone 117 MB.
  for (const double budget_mib : {60.0, 150.0, 400.0}) {
    restart(std::to_string(static_cast<int>(budget_mib)) + "MiB");
    const double idle = resident_bytes(server_->process_id());
    const auto refused = server_->client().load_scene(sheet());
    EXPECT_EQ(refused.status().code(), absl::StatusCode::kResourceExhausted) << refused.status();
    EXPECT_LT(peak_bytes() - idle, 1.1 * budget_mib * kMiB);
    // Nothing stays.
    EXPECT_LT(resident_bytes(server_->process_id()) - idle, 0.1 * budget_mib * kMiB + 8 * kMiB);
  }
}

TEST_F(Memory, TwoLoadsShareTheBudget) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers use additional memory";
#endif
  constexpr double kBudgetMib = 400;
  restart("400MiB");
  const double idle = resident_bytes(server_->process_id());
  std::ofstream(directory_ / "other.pbrt")
      << "WorldBegin\nShape \"plymesh\" \"string filename\" \"sheet.ply\"\nShape \"sphere\"\n";
  std::thread first([&] { (void)server_->client().load_scene(sheet()); });
  v1::LoadSceneRequest other;
  other.set_path("other.pbrt");
  (void)server_->client().load_scene(other);
  first.join();
  EXPECT_LT(peak_bytes() - idle, 1.1 * kBudgetMib * kMiB);
}

// Loads that fail and scenes that are unloaded free memory, which others then take.
TEST_F(Memory, ManyLoadsShareTheBudget) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers use additional memory";
#endif
  write_sheet(directory_ / "small.ply", 300);
  constexpr int kLoads = 32;
  constexpr double kBudgetMib = 40;  // a few of the loads fit at once
  restart("40MiB");
  const double idle = resident_bytes(server_->process_id());
  std::vector<std::jthread> loads;
  for (int i = 0; i < kLoads; ++i) {
    const std::string name = "small" + std::to_string(i) + ".pbrt";
    std::ofstream(directory_ / name)
        << "WorldBegin Shape \"plymesh\" \"string filename\" \"small.ply\"\n"
        << "Shape \"sphere\" \"float radius\" " << 1 + i;
    loads.emplace_back([this, name] {
      v1::LoadSceneRequest request;
      request.set_path(name);
      (void)server_->client().load_scene(request);
    });
  }
  loads.clear();
  // A server that has loaded a scene has 8 MiB more of code and buffers.
  EXPECT_LT(peak_bytes() - idle, (1.1 * kBudgetMib + 8) * kMiB);
}

// The allocator keeps arrays of this size when they are freed, and a list that grows may copy them.
TEST_F(Memory, ManyMeshesOfMediumSizeKeepToTheBudget) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers use additional memory";
#endif
  write_sheet(directory_ / "medium.ply", 300);
  std::ofstream scene(directory_ / "many.pbrt");
  scene << "WorldBegin\n";
  for (int i = 0; i < 24; ++i) {
    const std::string name = "medium" + std::to_string(i) + ".ply";
    fs::create_hard_link(directory_ / "medium.ply", directory_ / name);
    scene << "Shape \"plymesh\" \"string filename\" \"" << name << "\"\n";
  }
  scene.close();
  constexpr double kBudgetMib = 100;  // 17 of the meshes need more while they are read
  restart("100MiB");
  const double idle = resident_bytes(server_->process_id());
  v1::LoadSceneRequest request;
  request.set_path("many.pbrt");
  const auto refused = server_->client().load_scene(request);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kResourceExhausted) << refused.status();
  EXPECT_LT(peak_bytes() - idle, 1.1 * kBudgetMib * kMiB);
}

TEST_F(Memory, ALargePictureOfASmallFileIsRefusedByItsHeader) {
  // 11000 x 11000 texels are announced; the file holds none of them.
  constexpr char kHeader[] =
      "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x2a\xf8\0\0\x2a\xf8\x08\2\0\0\0\x41\x4d\x0d\xdd";
  std::ofstream(directory_ / "large.png", std::ios::binary)
      << std::string(kHeader, sizeof kHeader - 1)
      << std::string("\0\0\0\0IDAT\x35\xaf\x06\x1e", 12);
  std::ofstream(directory_ / "large.pbrt")
      << "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"large.png\"";
  std::ofstream(directory_ / "broken.png", std::ios::binary) << kHeader;
  std::ofstream(directory_ / "broken.pbrt")
      << "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"broken.png\"";
  restart("100MiB");
  // The first picture loads the library that decodes pictures, which has 100 MB of code and data.
  v1::LoadSceneRequest request;
  request.set_path("broken.pbrt");
  EXPECT_TRUE(server_->client().load_scene(request).ok());  // the texture is grey
  const double idle = resident_bytes(server_->process_id());
  request.set_path("large.pbrt");
  const auto refused = server_->client().load_scene(request);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kResourceExhausted) << refused.status();
  EXPECT_LT(peak_bytes() - idle, 20 * kMiB);
}

}  // namespace
}  // namespace lucerna
