// The memory that GetScene reports agrees with that of the operating system.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>

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
  // Reading the file alone takes longer than this.
  const auto late = server_->client().load_scene(
      sheet(), client::CallOptions::within(std::chrono::milliseconds(50)));
  EXPECT_EQ(late.status().code(), absl::StatusCode::kDeadlineExceeded) << late.status();
  const auto scenes = server_->client().list_scenes({});
  ASSERT_TRUE(scenes.ok());
  EXPECT_EQ(scenes->scenes_size(), 0);
}

}  // namespace
}  // namespace lucerna
