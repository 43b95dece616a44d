#include "server/store/scene_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

namespace lucerna {
namespace {

constexpr char kScene[] = R"(WorldBegin
LightSource "point" "rgb I" [10 10 10] "point3 from" [0 0 3]
Shape "bilinearmesh" "point3 P" [-5 -5 0  5 -5 0  -5 3 0  5 3 0]
)";

class SceneStoreTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = std::filesystem::temp_directory_path() /
            ("lucerna_store_" + std::to_string(::getpid()) + "_" +
             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(root_);
    write("a.pbrt", kScene);
    auto store = SceneStore::open({.root = root_.string()});
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(root_ / name) << text;
  }
  LoadedScene load(const std::string& path) {
    auto loaded = store_->load(path);
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    return *std::move(loaded);
  }

  std::filesystem::path root_;
  std::unique_ptr<SceneStore> store_;
};

TEST_F(SceneStoreTest, LoadingAgainReturnsTheLoadedScene) {
  const LoadedScene first = load("a.pbrt");
  EXPECT_FALSE(first.already_loaded);
  EXPECT_EQ(first.stored.scene->id().size(), 64U);
  const LoadedScene again = load("a.pbrt");
  EXPECT_TRUE(again.already_loaded);
  EXPECT_EQ(again.stored.scene, first.stored.scene);
  EXPECT_EQ(store_->builds(), 1U);
}

TEST_F(SceneStoreTest, PicturesOverTheLimitAreHalvedWhichChangesTheId) {
  std::string pfm = "PF\n64 64\n-1.0\n";
  for (int i = 0; i < 64 * 64 * 3; ++i) {
    const float value = 1e-5F * static_cast<float>(i);
    pfm.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  write("tiles.pfm", pfm);
  write("tiles.pbrt",
        "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"tiles.pfm\" "
        "Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"disk\"");
  const auto whole = load("tiles.pbrt").stored.scene;
  EXPECT_TRUE(whole->report().remarks.empty());
  auto small = SceneStore::open({.root = root_.string(), .texture_bytes = 10'000});
  ASSERT_TRUE(small.ok()) << small.status();
  const auto halved = (*small)->load("tiles.pbrt");
  ASSERT_TRUE(halved.ok()) << halved.status();
  const Scene& scene = *halved->stored.scene;
  EXPECT_NE(scene.id(), whole->id());
  ASSERT_EQ(scene.report().remarks.size(), 1U);
  EXPECT_EQ(scene.report().remarks[0].where.file, "tiles.pfm");
  EXPECT_EQ(scene.report().remarks[0].what,
            "a picture of 64 x 64 texels exceeds the memory of textures");
  EXPECT_EQ(scene.report().remarks[0].instead, "32 x 32, each the mean of several texels");
  for (const ScenePart& part : scene.parts())
    if (part.name == "textures") {
      EXPECT_LE(part.bytes, 11'000U);
      EXPECT_EQ(part.why, "1 textures of surfaces; pictures at most 10000 bytes");
    }
  EXPECT_TRUE((*small)->load("tiles.pbrt")->already_loaded);
}

TEST_F(SceneStoreTest, AbsolutePathsBeneathTheRootAreAcceptedAndOthersAreNot) {
  const LoadedScene first = load("a.pbrt");
  EXPECT_EQ(load((root_ / "a.pbrt").string()).stored.scene, first.stored.scene);
  EXPECT_EQ(load((root_ / "b/.." / "a.pbrt").string()).stored.scene, first.stored.scene);
  // Another name of the root.
  const std::filesystem::path link = root_.string() + "_link";
  std::filesystem::create_directory_symlink(root_, link);
  const auto store = SceneStore::open({.root = link.string() + "/"}).value();
  for (const std::filesystem::path& root : {root_, link}) {
    const auto loaded = store->load((root / "a.pbrt").string());
    ASSERT_TRUE(loaded.ok()) << loaded.status();
    EXPECT_EQ(loaded->stored.path, "a.pbrt");
  }
  std::filesystem::remove(link);
  for (const std::string& path : {root_.string(), root_.string() + "x/a.pbrt",
                                  (root_ / ".." / "a.pbrt").string(), std::string("/a.pbrt")})
    EXPECT_EQ(store_->load(path).status().code(), absl::StatusCode::kInvalidArgument) << path;
}

TEST_F(SceneStoreTest, AvailableScenesAreTheFilesOfTheRoot) {
  std::filesystem::create_directory(root_ / "room");
  write("room/b.pbrt", kScene);
  write("room/mesh.ply", "");
  const FileListing files = store_->available();
  EXPECT_EQ(files.paths, (std::vector<std::string>{"a.pbrt", "room/b.pbrt"}));
  EXPECT_EQ(store_->root(), root_.string());
}

TEST_F(SceneStoreTest, AnotherNameOfTheSameFileIsTheSameScene) {
  const LoadedScene first = load("a.pbrt");
  const LoadedScene other = load("./a.pbrt");
  EXPECT_TRUE(other.already_loaded);
  EXPECT_EQ(other.stored.scene, first.stored.scene);
  EXPECT_EQ(store_->builds(), 1U);
}

TEST_F(SceneStoreTest, AChangedFileIsAnotherScene) {
  const LoadedScene first = load("a.pbrt");
  write("a.pbrt", std::string(kScene) + "# changed\n");
  const LoadedScene changed = load("a.pbrt");
  EXPECT_FALSE(changed.already_loaded);
  EXPECT_NE(changed.stored.scene->id(), first.stored.scene->id());
  EXPECT_EQ(store_->size(), 2U);  // the old one stays until it is released
}

TEST_F(SceneStoreTest, AChangeOfAnIncludedFileIsSeen) {
  write("main.pbrt", "Include \"a.pbrt\"\n");
  const LoadedScene first = load("main.pbrt");
  write("a.pbrt", std::string(kScene) + "# changed\n");
  EXPECT_NE(load("main.pbrt").stored.scene->id(), first.stored.scene->id());
}

TEST_F(SceneStoreTest, AFailedLoadLeavesNothing) {
  write("broken.pbrt", "WorldBegin\nShape \"trianglemesh\" \"integer indices\" [0 1\n");
  const auto broken = store_->load("broken.pbrt");
  EXPECT_EQ(broken.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(broken.status().message()).find("broken.pbrt:"), std::string::npos)
      << broken.status();
  EXPECT_EQ(store_->load("none.pbrt").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->load("../a.pbrt").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(store_->size(), 0U);
  write("broken.pbrt", kScene);  // and it can be fixed
  EXPECT_FALSE(load("broken.pbrt").already_loaded);
}

TEST_F(SceneStoreTest, CancelledLoadsLeaveNothing) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(store_->load("a.pbrt", {.stop = stop.get_token()}).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(store_->size(), 0U);
}

TEST_F(SceneStoreTest, ConcurrentLoadsBuildOnce) {
  std::vector<std::jthread> threads;
  std::vector<std::string> ids(8);
  for (auto& id : ids) {
    threads.emplace_back([&] { id = load("a.pbrt").stored.scene->id(); });
  }
  threads.clear();
  for (const auto& id : ids) EXPECT_EQ(id, ids[0]);
  EXPECT_EQ(store_->builds(), 1U);
}

TEST_F(SceneStoreTest, ReleasedScenesLiveAsLongAsTheyAreHeld) {
  LoadedScene held = load("a.pbrt");
  const std::string id = held.stored.scene->id();
  const std::uint64_t bytes = store_->bytes();
  EXPECT_GT(bytes, 0U);
  EXPECT_TRUE(store_->release(id).value());
  EXPECT_EQ(store_->bytes(), 0U);
  EXPECT_EQ(store_->counted_bytes(), bytes);
  EXPECT_EQ(store_->release(id).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->find(id), nullptr);
  EXPECT_EQ(held.stored.scene->lights().size(), 1U);
  held = {};
  EXPECT_EQ(store_->counted_bytes(), 0U);
  EXPECT_FALSE(load("a.pbrt").already_loaded);
}

TEST_F(SceneStoreTest, ListsInTheOrderOfIds) {
  write("b.pbrt", std::string(kScene) + "# b\n");
  write("c.pbrt", std::string(kScene) + "# c\n");
  for (const char* name : {"a.pbrt", "b.pbrt", "c.pbrt"}) load(name);
  const auto first = store_->list("", 2);
  ASSERT_EQ(first.size(), 2U);
  EXPECT_LT(first[0].scene->id(), first[1].scene->id());
  const auto rest = store_->list(first[1].scene->id(), 2);
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_LT(first[1].scene->id(), rest[0].scene->id());
}

TEST(SceneStore, NeedsADirectory) {
  EXPECT_FALSE(SceneStore::open({.root = "/no/such/directory"}).ok());
}

TEST_F(SceneStoreTest, NamesOfOneFileAreOneName) {
  std::filesystem::create_directories(root_ / "sub");
  std::string longer;
  for (int i = 0; i < 1000; ++i) longer += "./";
  for (const std::string& name :
       {longer + "a.pbrt", std::string("sub/../a.pbrt"), std::string(".//a.pbrt")})
    EXPECT_EQ(load(name).stored.path, "a.pbrt") << name;
  EXPECT_EQ(store_->builds(), 1U);
  // These are refused as before.
  EXPECT_FALSE(store_->load("../a.pbrt").ok());
  EXPECT_FALSE(store_->load(".").ok());
}

TEST_F(SceneStoreTest, LoadsCountAgainstTheBudgetBeforeTheyAreBuilt) {
  // 300 kB of text need as many bytes, and their numbers more.
  std::string text = "WorldBegin Shape \"trianglemesh\" \"point3 P\" [";
  for (int i = 0; i < 150'000; ++i) text += "1 ";
  write("big.pbrt", text + "]");
  auto small = SceneStore::open({.root = root_.string(), .memory_budget_bytes = 200'000});
  ASSERT_TRUE(small.ok()) << small.status();
  const auto refused = (*small)->load("big.pbrt");
  EXPECT_TRUE(absl::IsResourceExhausted(refused.status())) << refused.status();
  EXPECT_EQ((*small)->builds(), 0U);
  // Nothing stays counted.
  for (int i = 0; i < 3; ++i) EXPECT_TRUE((*small)->load("a.pbrt").ok());
}

TEST_F(SceneStoreTest, RevisionsNeedRoomOnlyForWhatNoOtherHas) {
  write("lamp.pbrt",
        "WorldBegin Shape \"sphere\" AreaLightSource \"diffuse\" Translate 0 0 3 Shape \"disk\"");
  LightEdits moved, dimmed;
  moved.changes[1] = {.shift_m = {0.5, 0, 0}};
  dimmed.changes[1] = {.scale = 0.5, .shift_m = {0.5, 0, 0}};
  // Loads the scene, moves its light, and dims it too.  All three are leased.
  const auto edit_all = [&](SceneStore& store) {
    const LoadOptions leased{.lease_s = 60};
    const auto scene = store.load("lamp.pbrt", leased);
    EXPECT_TRUE(scene.ok()) << scene.status();
    for (const LightEdits& edits : {moved, dimmed}) {
      const auto revision = store.revise(scene->stored, edits, leased);
      EXPECT_TRUE(revision.ok()) << revision.status();
      EXPECT_TRUE(!revision.ok() || revision->stored.scene->has_own_geometry());
    }
    return store.bytes();
  };
  const std::uint64_t all = edit_all(*SceneStore::open({.root = root_.string()}).value());
  const auto tight = SceneStore::open({.root = root_.string(), .memory_budget_bytes = all}).value();
  EXPECT_EQ(edit_all(*tight), all);
}

}  // namespace
}  // namespace lucerna
