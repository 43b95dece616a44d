// Uploads to a server that requests any files and ends calls at any time.
#include "lucerna/client/upload.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include "fake_server.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "proto/common/sha256.h"
#include "tests/temp_directory.h"

namespace lucerna::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class UploadTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write("scene/room.pbrt", "the room");
    // Like the real server: files of the manifest that are not held are missing, then those of
    // `wants_`.
    server_.load_scene = [this](auto&, const v1::LoadSceneRequest& request,
                                v1::LoadSceneResponse* response) {
      std::map<std::string, std::string> named;
      for (const auto& asset : request.manifest().assets()) named[asset.name()] = asset.sha256();
      manifest_ = named;
      blender_ = request.has_blender() ? std::optional(request.blender()) : std::nullopt;
      wants_.insert(wants_.begin(), request.manifest().main());
      for (const std::string& name : wants_) {
        const auto found = named.find(name);
        if (found != named.end() && (found->second.empty() || held_.contains(found->second)))
          continue;
        v1::NamedAsset* missing = response->add_missing();
        missing->set_name(name);
        if (found != named.end()) missing->set_sha256(found->second);
      }
      if (response->missing().empty()) response->set_scene_id("id");
      return grpc::Status::OK;
    };
    server_.find_missing_assets = [this](auto&, const v1::FindMissingAssetsRequest& request,
                                         v1::FindMissingAssetsResponse* response) {
      for (const std::string& digest : request.sha256()) {
        if (held_.contains(digest)) continue;
        response->add_missing_sha256(digest);
        response->add_received_bytes(parts_[digest].size());
      }
      return grpc::Status::OK;
    };
    server_.upload_asset = [this](auto& reader, v1::UploadAssetResponse* response) {
      v1::UploadAssetRequest request;
      reader.Read(&request);
      const v1::AssetHeader header = request.header();
      offsets_.push_back(header.offset_bytes());
      std::string& bytes = parts_[header.sha256()];
      bytes.resize(header.offset_bytes());
      while (reader.Read(&request)) {
        bytes += request.chunk();
        if (!failures_.empty()) {
          const grpc::Status failure = failures_.back();
          failures_.pop_back();
          return failure;
        }
      }
      response->set_received_bytes(bytes.size());
      if (bytes.size() == header.size_bytes()) {
        EXPECT_EQ(sha256(bytes), header.sha256());
        held_[header.sha256()] = bytes;
      }
      return grpc::Status::OK;
    };
  }

  void write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((directory_ / name).parent_path());
    std::ofstream(directory_ / name, std::ios::binary) << bytes;
  }
  absl::StatusOr<v1::LoadSceneResponse> upload(const UploadOptions& options = {}) {
    return upload_scene(server_.client(), (directory_ / "scene/room.pbrt").string(), options,
                        CallOptions::within(std::chrono::minutes(10)));
  }
  std::vector<std::string> held() const {
    std::vector<std::string> all;
    for (const auto& [digest, bytes] : held_) all.push_back(bytes);
    std::sort(all.begin(), all.end());
    return all;
  }

  const TempDirectory temporary_;
  const std::filesystem::path directory_ = temporary_.path();
  FakeServer server_;
  std::vector<std::string> wants_;
  std::map<std::string, std::string> held_, parts_, manifest_;
  std::optional<v1::BlenderLevels> blender_;  // of the last LoadScene
  std::vector<std::uint64_t> offsets_;
  std::vector<grpc::Status> failures_;  // errors of the next uploads, in reverse order
};

TEST_F(UploadTest, SendsRequestedFilesOnly) {
  write("scene/a.ply", "mesh");
  write("scene/sub/b.exr", "picture");
  write("scene/private", "never requested");
  wants_ = {"a.ply", "sub/b.exr"};
  const auto loaded = upload();
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(loaded->scene_id(), "id");
  EXPECT_THAT(held(), ElementsAre("mesh", "picture", "the room"));
  EXPECT_EQ(manifest_.size(), 3U);
}

TEST_F(UploadTest, SendsTheLevelsOfBlenderWithEachLoad) {
  v1::BlenderLevels levels;
  levels.set_mode(v1::BLENDER_LIGHTING_MODE_RAW);
  levels.set_lumens_per_watt(100);
  ASSERT_TRUE(upload({.blender = levels}).ok());
  ASSERT_TRUE(blender_.has_value());
  EXPECT_EQ(blender_->mode(), v1::BLENDER_LIGHTING_MODE_RAW);
  EXPECT_EQ(blender_->lumens_per_watt(), 100);
  ASSERT_TRUE(upload().ok());
  EXPECT_FALSE(blender_.has_value());
}

TEST_F(UploadTest, SendsMissingContentOnce) {
  write("scene/a.ply", "mesh");
  write("scene/b.ply", "mesh");
  wants_ = {"a.ply", "b.ply"};
  held_[sha256("the room")] = "the room";
  ASSERT_TRUE(upload().ok());
  EXPECT_THAT(offsets_, ElementsAre(0));
}

TEST_F(UploadTest, ReportsMissingFiles) {
  wants_ = {"gone.ply"};
  ASSERT_TRUE(upload().ok());
  EXPECT_EQ(manifest_.at("gone.ply"), "");
  EXPECT_THAT(held(), ElementsAre("the room"));
}

TEST_F(UploadTest, ContinuesABrokenUpload) {
  const std::string bytes((3 << 20) + 5, 'x');
  write("scene/room.pbrt", bytes);
  failures_ = {{grpc::StatusCode::UNAVAILABLE, "gone"}, {grpc::StatusCode::UNAVAILABLE, "gone"}};
  std::vector<std::uint64_t> sent;
  const auto loaded = upload({.progress = [&](const UploadProgress& progress) {
    EXPECT_EQ(progress.name, "room.pbrt");
    EXPECT_EQ(progress.size_bytes, bytes.size());
    sent.push_back(progress.sent_bytes);
  }});
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  ASSERT_GE(offsets_.size(), 3U);
  EXPECT_EQ(offsets_.front(), 0U);
  EXPECT_GE(offsets_.back(), 2U << 20);
  EXPECT_TRUE(held_.contains(sha256(bytes)));
}

TEST_F(UploadTest, GivesUpAfterSeveralAttemptsWithoutProgress) {
  server_.upload_asset = [this](auto&, auto*) {
    offsets_.push_back(0);
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "broken for good");
  };
  const auto loaded = upload();
  EXPECT_EQ(loaded.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_GE(offsets_.size(), 5U);
}

TEST_F(UploadTest, WaitsForAnotherClientThatSendsTheSameFile) {
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_nanos(1'000'000);
  google::rpc::Status wire;
  wire.add_details()->PackFrom(retry);
  int calls = 0;
  server_.upload_asset = [&](auto&, auto*) {
    if (++calls == 3) held_[sha256("the room")] = "the room";  // the other client has finished
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "being uploaded",
                        wire.SerializeAsString());
  };
  const auto loaded = upload();
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(calls, 3);
}

TEST_F(UploadTest, NothingOutsideOfTheRootIsSent) {
  write("secret", "SECRET");
  std::filesystem::create_symlink("../secret", directory_ / "scene/link");
  std::filesystem::create_directory(directory_ / "scene/sub");
  for (const char* name : {"../secret", "link", "sub/../../secret"}) {
    wants_ = {name};
    const auto loaded = upload();
    EXPECT_EQ(loaded.status().code(), absl::StatusCode::kInvalidArgument) << name;
    EXPECT_THAT(std::string(loaded.status().message()), HasSubstr(name));
  }
  wants_ = {(directory_ / "secret").string()};
  ASSERT_TRUE(upload().ok());  // searched within the root, where it does not exist
  EXPECT_THAT(held(), ElementsAre("the room"));
  // Files within a wider root are sent.
  wants_ = {"secret"};
  ASSERT_TRUE(upload({.root = directory_.string()}).ok());
  EXPECT_THAT(held(), ElementsAre("SECRET", "the room"));
  EXPECT_TRUE(manifest_.contains("scene/room.pbrt"));
}

TEST_F(UploadTest, InvalidFilesAreErrorsBeforeAnyCall) {
  server_.load_scene = [](auto&, auto&, auto*) -> grpc::Status {
    ADD_FAILURE() << "the server was called";
    return grpc::Status::OK;
  };
  const auto status = [&](const std::string& path, const UploadOptions& options = {}) {
    return upload_scene(server_.client(), (directory_ / path).string(), options).status().code();
  };
  EXPECT_EQ(status("none.pbrt"), absl::StatusCode::kNotFound);
  EXPECT_EQ(status("scene"), absl::StatusCode::kNotFound);
  EXPECT_EQ(status("scene/room.pbrt", {.root = (directory_ / "none").string()}),
            absl::StatusCode::kNotFound);
  std::filesystem::create_directory(directory_ / "other");
  EXPECT_EQ(status("scene/room.pbrt", {.root = (directory_ / "other").string()}),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(UploadTest, EndlessRequestsOfAServerEndTheUpload) {
  server_.load_scene = [n = 0](auto&, auto&, v1::LoadSceneResponse* response) mutable {
    response->add_missing()->set_name("f" + std::to_string(n++));
    return grpc::Status::OK;
  };
  EXPECT_EQ(upload().status().code(), absl::StatusCode::kInternal);
}

}  // namespace
}  // namespace lucerna::client
