// Parts of scenes that are made at their first use.
#include "server/scene/scene_part.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <set>
#include <thread>
#include <vector>

#include "server/runtime/parallel.h"
#include "server/store/scene_store.h"
#include "server/visibility/shaft.h"
#include "tests/server/pbrt/pbrt_fixture.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

struct Table {
  std::uint64_t size;
  std::uint64_t bytes() const { return size; }
};

std::string why(const Table& t) { return fmt::format("a table of {}", t.size); }

TEST(LazyPart, IsReportedOnceItIsMade) {
  const LazyPart<Table> part("table");
  EXPECT_FALSE(part.report());
  EXPECT_EQ(part.bytes(), 0u);
  int made = 0;
  const auto make = [&] {
    ++made;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return std::make_unique<const Table>(Table{24});
  };
  const Table& table = part.get(make, why);
  EXPECT_EQ(&part.get(make, why), &table);
  EXPECT_EQ(made, 1);
  const ScenePart report = part.report().value();
  EXPECT_EQ(report.name, "table");
  EXPECT_EQ(report.bytes, 24u);
  EXPECT_EQ(part.bytes(), 24u);
  EXPECT_GE(report.build_ms, 2);
  EXPECT_EQ(report.why, "a table of 24");
}

TEST(ScenePart, MeshesHaveOneVertexOfUnusedRoom) {
  TriangleMeshData mesh;
  for (std::uint32_t i = 0; i < 900; ++i) {
    mesh.positions.push_back({double(i % 30), double(i / 30), double(i % 7)});
    mesh.indices.push_back(i);
  }
  SceneDescription d = testing::description();
  d.shapes = {{.geometry = mesh}, {.geometry = mesh}};
  for (const double bend : {0.0, 0.3})
    for (int i = 0; i < 3; ++i)
      d.shapes.push_back(testing::patch({0, 0, 2.0 + i}, {1, 0, 2.0 + i}, {0, 1, 2.0 + i},
                                        {1, 1, 2.0 + i + bend}));
  const std::vector<ScenePart> parts = testing::build(d)->parts();
  const auto bytes = [&](const char* name) {
    return std::ranges::find(parts, name, &ScenePart::name)->bytes;
  };
  EXPECT_EQ(bytes("vertices"), (2 * 900 + 6 * 4 + 1) * sizeof(Vec3f));
  EXPECT_EQ(bytes("triangles"), (2 * 900 + 6 * 6) * sizeof(std::uint32_t));
}

TEST(LazyPart, IsMadeAgainAfterAFailure) {
  const LazyPart<Table> part("table");
  const auto fail = []() -> std::unique_ptr<const Table> { throw std::bad_alloc(); };
  EXPECT_THROW(part.get(fail, why), std::bad_alloc);
  EXPECT_FALSE(part.report());
  EXPECT_EQ(part.get([] { return std::make_unique<const Table>(Table{1}); }, why).size, 1u);
}

// Chunks of one loop use a part that is itself made by a loop.  The thread that makes it must
// not take another of these chunks while it waits.
TEST(LazyPart, IsMadeOnceByTheThreadsOfOneArena) {
  for (int repeat = 0; repeat < 20; ++repeat) {
    const LazyPart<Table> part("table");
    std::atomic<int> made = 0, wrong = 0;
    parallel_chunks(64, 1, {}, [&](std::size_t, std::size_t) {
      const Table& table = part.get(
          [&] {
            ++made;
            std::atomic<std::uint64_t> sum = 0;
            parallel_chunks(256, 1, {}, [&](std::size_t begin, std::size_t) { sum += begin; });
            return std::make_unique<const Table>(Table{sum});
          },
          why);
      if (table.size != 255 * 256 / 2) ++wrong;
    });
    EXPECT_EQ(made, 1);
    EXPECT_EQ(wrong, 0);
  }
}

TEST(LazyPart, OfASceneCountsFromItsFirstUse) {
  SceneDescription d = testing::description();
  d.shapes = {testing::emissive(testing::floor(1, 3), 1), testing::floor(4)};
  const auto scene = testing::build(std::move(d));
  const std::vector<ScenePart> before = scene->parts();
  const std::uint64_t bytes = scene->bytes();
  EXPECT_EQ(std::ranges::count(before, "shafts", &ScenePart::name), 0);

  const Shafts& made = shafts(*scene);
  EXPECT_TRUE(made.has_outline(0));
  const std::vector<ScenePart> after = scene->parts();
  // The boxes of surfaces are a part of their own, which revisions share.
  ASSERT_EQ(after.size(), before.size() + 2);
  const auto part = std::ranges::find(after, "shafts", &ScenePart::name);
  const auto boxes = std::ranges::find(after, "boxes of surfaces", &ScenePart::name);
  ASSERT_NE(part, after.end());
  ASSERT_NE(boxes, after.end());
  EXPECT_EQ(part->bytes, made.bytes());
  EXPECT_EQ(part->why, "a query used closed forms");
  EXPECT_EQ(scene->bytes(), bytes + part->bytes + boxes->bytes);
  EXPECT_EQ(&shafts(*scene), &made);
}

TEST(LazyPart, CountsForTheBudgetOfAStore) {
  testing::SceneFiles files;
  const auto name = [](int i) { return fmt::format("s{}.pbrt", i); };
  for (int i = 0; i < 3; ++i)
    files.write(name(i), fmt::format("WorldBegin # {}\nShape \"sphere\"\n", i));
  std::uint64_t bare = 0, grown = 0;
  {
    const auto store = SceneStore::open({.root = files.path().string()}).value();
    const auto scene = store->load(name(0)).value().stored.scene;
    bare = store->bytes();
    const std::uint64_t before = scene->bytes();
    shafts(*scene);
    grown = store->bytes();
    // With the boxes of surfaces, which shafts need.
    EXPECT_EQ(grown, bare + (scene->bytes() - before));
    ASSERT_GT(grown, bare + shafts(*scene).bytes());
  }
  // Room for exactly two scenes, one of them with shafts.
  const auto store =
      SceneStore::open({.root = files.path().string(), .memory_budget_bytes = bare + grown})
          .value();
  const auto load = [&](int i) { return store->load(name(i)).value().stored.scene; };
  const auto a = load(0), b = load(1);
  shafts(*a);
  EXPECT_EQ(store->bytes(), bare + grown);
  EXPECT_NE(store->find(a->id()), nullptr);
  EXPECT_EQ(store->size(), 2u);
  // A third scene would fit if the first had not grown.
  const auto c = load(2);
  EXPECT_EQ(store->size(), 2u);
  EXPECT_EQ(store->find(b->id()), nullptr);
  // A scene that grows while it is held evicts others at its next use.
  shafts(*c);
  EXPECT_EQ(store->size(), 2u);
  EXPECT_NE(store->find(c->id()), nullptr);
  EXPECT_EQ(store->size(), 1u);
  EXPECT_EQ(store->find(a->id()), nullptr);
  EXPECT_EQ(store->bytes(), grown);
}

}  // namespace
}  // namespace lucerna
