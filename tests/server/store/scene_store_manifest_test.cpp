// Scenes of uploaded files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "server/store/scene_store.h"
#include "tests/server/files/gzip.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using testing::gzipped;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::message;
using testing::SceneFiles;
using ::testing::StartsWith;

constexpr char kPly[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
constexpr char kMain[] = R"(WorldBegin
Shape "plymesh" "string filename" "meshes/a.ply"
LightSource "point" "rgb I" [10 10 10] "point3 from" [0 0 3]
Include "parts/more.pbrt"
Shape "plymesh" "string filename" "meshes/a.ply"
)";
constexpr char kMore[] = "Shape \"plymesh\" \"string filename\" \"meshes/b.ply\"\n";

class ManifestTest : public ::testing::Test {
 protected:
  void SetUp() override {
    assets_ = AssetStore::open({.directory = (files_.path() / "assets").string()}).value();
    std::filesystem::create_directory(files_.path() / "root");
    store_ = SceneStore::open({.root = (files_.path() / "root").string()}, assets_.get()).value();
  }

  /// Uploads `bytes` and names them in the manifest.
  void put(const std::string& name, const std::string& bytes) {
    manifest_.assets[name] = sha256(bytes);
    if (assets_->held(sha256(bytes)).whole) return;
    auto upload = assets_->upload(sha256(bytes), bytes.size(), 0);
    ASSERT_TRUE(upload.ok()) << upload.status();
    ASSERT_TRUE(upload->append(bytes).ok());
    ASSERT_TRUE(upload->finish().ok());
  }

  absl::StatusOr<LoadedScene> load() { return store_->load(manifest_); }
  /// The names of the missing files.
  std::vector<std::string> missing() {
    std::vector<std::string> names;
    const auto loaded = load();
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    if (!loaded.ok()) return names;
    EXPECT_EQ(loaded->stored.scene == nullptr, !loaded->missing.empty());
    for (const MissingAsset& m : loaded->missing) names.push_back(m.name);
    return names;
  }

  SceneFiles files_;
  std::unique_ptr<AssetStore> assets_;
  std::unique_ptr<SceneStore> store_;
  Manifest manifest_{.main = "room.pbrt", .assets = {}};
};

// The digests of a manifest are those of the compressed files.
TEST_F(ManifestTest, LoadsCompressedFiles) {
  manifest_.main = "room.pbrt.gz";
  put("room.pbrt.gz", gzipped("WorldBegin Shape \"plymesh\" \"string filename\" \"a.ply.gz\""));
  manifest_.assets["a.ply.gz"] = sha256(gzipped(kPly));
  EXPECT_THAT(missing(), ElementsAre("a.ply.gz"));
  put("a.ply.gz", gzipped(kPly));
  EXPECT_THAT(missing(), IsEmpty());
  EXPECT_EQ(load()->stored.scene->geometry().primitive_count(), 1U);
  put("a.ply.gz", gzipped(kPly).substr(0, 40));
  EXPECT_THAT(message(load().status()),
              HasSubstr("file \"a.ply.gz\": its gzip data are broken or incomplete"));
}

TEST_F(ManifestTest, ReportsAllMissingFilesAtOnce) {
  manifest_.assets["room.pbrt"] = sha256(kMain);
  const auto first = load();
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_EQ(first->missing.size(), 1U);
  EXPECT_EQ(first->missing[0].digest, sha256(kMain));
  put("room.pbrt", kMain);
  const auto second = load();
  ASSERT_TRUE(second.ok()) << second.status();
  ASSERT_EQ(second->missing.size(), 2U);  // each once
  EXPECT_EQ(second->missing[0].name, "meshes/a.ply");
  EXPECT_EQ(second->missing[0].digest, "");
  EXPECT_EQ(second->missing[1].name, "parts/more.pbrt");
  put("parts/more.pbrt", kMore);
  EXPECT_THAT(missing(), ElementsAre("meshes/a.ply", "meshes/b.ply"));
  put("meshes/a.ply", kPly);
  put("meshes/b.ply", kPly);
  EXPECT_EQ(store_->size(), 0U);
  EXPECT_THAT(missing(), IsEmpty());
  EXPECT_EQ(store_->size(), 1U);
  EXPECT_EQ(store_->list("", 1)[0].path, "room.pbrt");
  EXPECT_EQ(store_->list("", 1)[0].scene->geometry().shape_count(), 3U);
  EXPECT_TRUE(load()->already_loaded);
  EXPECT_EQ(store_->builds(), 1U);
}

TEST_F(ManifestTest, IsTheSameSceneAsTheSameFilesUnderTheRoot) {
  put("room.pbrt", kMain);
  put("parts/more.pbrt", kMore);
  put("meshes/a.ply", kPly);
  put("meshes/b.ply", kPly);
  files_.write("root/room.pbrt", kMain);
  files_.write("root/parts/more.pbrt", kMore);
  files_.write("root/meshes/a.ply", kPly);
  files_.write("root/meshes/b.ply", kPly);
  std::vector<std::string> ids(8);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      threads.emplace_back([&, i] {
        const auto loaded = i % 2 == 0 ? store_->load("room.pbrt") : store_->load(manifest_);
        if (loaded.ok()) ids[i] = loaded->stored.scene->id();
      });
    }
  }
  for (const std::string& id : ids) EXPECT_EQ(id, ids[0]);
  EXPECT_EQ(ids[0].size(), 64U);
  EXPECT_EQ(store_->builds(), 1U);
}

TEST_F(ManifestTest, AnUploadedSceneIsFoundByTheNameThatTheListShows) {
  put("mine/room.pbrt", "WorldBegin\n");
  manifest_.main = "mine/room.pbrt";
  EXPECT_THAT(missing(), IsEmpty());
  const std::string name = store_->list("", 1).at(0).path;
  const auto by_name = store_->load(name, {.lease_s = 5});
  ASSERT_TRUE(by_name.ok()) << by_name.status();
  EXPECT_TRUE(by_name->already_loaded);
  EXPECT_EQ(by_name->stored.scene, load()->stored.scene);
  EXPECT_FALSE(by_name->lease.id.empty());
  EXPECT_EQ(store_->builds(), 1U);

  const absl::Status other = store_->load("mine/other.pbrt").status();
  EXPECT_EQ(other.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(message(other), HasSubstr((files_.path() / "root").string()));
  EXPECT_THAT(message(other), HasSubstr("upload"));
  // A file of this name has priority, and its errors are reported.
  std::filesystem::create_directory(files_.path() / "root/mine");
  files_.write("root/mine/room.pbrt", "WorldBegin\nInclude \"none.pbrt\"\n");
  EXPECT_THAT(message(store_->load(name).status()), StartsWith("mine/room.pbrt:2:"));
  files_.write("root/mine/room.pbrt", "WorldBegin\n\n");
  EXPECT_FALSE(store_->load(name)->already_loaded);
}

TEST_F(ManifestTest, UnneededFilesMayBeMissing) {
  put("room.pbrt", "WorldBegin\n");
  manifest_.assets["never.ply"] = sha256("never");
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(ManifestTest, FilesThatTheClientLacksAreErrorsAtTheirPlace) {
  put("room.pbrt", kMain);
  put("parts/more.pbrt", kMore);
  put("meshes/b.ply", kPly);
  manifest_.assets["meshes/a.ply"] = "";
  const absl::Status status = load().status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(message(status), StartsWith("room.pbrt:2:"));
  EXPECT_THAT(message(status), HasSubstr("\"meshes/a.ply\" does not exist"));
}

TEST_F(ManifestTest, LooksBesideTheIncludingFileOnlyWhereTheFirstPlaceHasNone) {
  put("room.pbrt", "WorldBegin\nInclude \"parts/more.pbrt\"\n");
  put("parts/more.pbrt", kMore);
  EXPECT_THAT(missing(), ElementsAre("meshes/b.ply"));
  manifest_.assets["meshes/b.ply"] = "";
  EXPECT_THAT(missing(), ElementsAre("parts/meshes/b.ply"));
  put("parts/meshes/b.ply", kPly);
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(ManifestTest, ErrorsWaitUntilAllFilesAreThere) {
  // The second line is only wrong because the first was left out.
  put("room.pbrt",
      "WorldBegin\nImport \"objects.pbrt\"\nObjectInstance \"lamp\"\nShape \"teapot\"\n");
  EXPECT_THAT(missing(), ElementsAre("objects.pbrt"));
  put("objects.pbrt", "ObjectBegin \"lamp\"\nObjectEnd\n");
  EXPECT_EQ(load().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(store_->size(), 0U);
}

TEST_F(ManifestTest, NamesReachNoFileOfTheServer) {
  files_.write("root/secret.pbrt", "WorldBegin\n");
  put("room.pbrt", "Include \"secret.pbrt\"\n");
  EXPECT_THAT(missing(), ElementsAre("secret.pbrt"));
  for (const char* name : {"../root/secret.pbrt", "/etc/passwd"}) {
    put("room.pbrt", "Include \"" + std::string(name) + "\"\n");
    EXPECT_EQ(load().status().code(), absl::StatusCode::kInvalidArgument) << name;
  }
}

TEST_F(ManifestTest, FilesChangedOnDiskAreRequestedAgain) {
  put("room.pbrt", "WorldBegin\n");
  files_.write("assets/" + hexadecimal(sha256("WorldBegin\n")), "WorldBeginX");
  const auto loaded = load();
  ASSERT_TRUE(loaded.ok() || absl::IsInvalidArgument(loaded.status())) << loaded.status();
  files_.write("assets/" + hexadecimal(sha256("WorldBegin\n")), "WorldBegin ");
  EXPECT_THAT(missing(), ElementsAre("room.pbrt"));
  put("room.pbrt", "WorldBegin\n");
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(ManifestTest, AReleasedSceneCanBeLoadedAgain) {
  put("room.pbrt", "WorldBegin\n");
  EXPECT_THAT(missing(), IsEmpty());
  ASSERT_TRUE(store_->release(store_->list("", 1)[0].scene->id()).value());
  EXPECT_FALSE(load()->already_loaded);
  EXPECT_EQ(store_->builds(), 2U);
}

TEST_F(ManifestTest, AScenesManifestsAreForgottenBeyondALimit) {
  put("room.pbrt", "WorldBegin LightSource \"point\"");
  std::string id;
  for (int i = 0; i < 200; ++i) {
    // A file that the scene does not use makes another manifest of the same scene.
    manifest_.assets["unused" + std::to_string(i)] = "";
    const auto loaded = load();
    ASSERT_TRUE(loaded.ok()) << loaded.status();
    if (i > 0) {
      EXPECT_EQ(loaded->stored.scene->id(), id);
    }
    id = loaded->stored.scene->id();
  }
  EXPECT_EQ(store_->builds(), 1U);
  EXPECT_EQ(store_->sources(), 64U);
  EXPECT_TRUE(load()->already_loaded);
}

}  // namespace
}  // namespace lucerna
