// No answer holds NaN, an infinity or a negative number, whatever is asked of whichever light:
// random scenes of extreme lights, each asked every query with random extreme items.
//
// LUCERNA_WIRE_ITEMS: how many items, by default 100000.  LUCERNA_WIRE_SCENE: the number of the one
// scene to ask, to look at one that failed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <regex>

#include "tests/server/extremes/extreme_scenes.h"
#include "tests/server/extremes/wire_answers.h"
#include "tests/server/extremes/wire_queries.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

class WireProperty : public ::testing::Test {
 protected:
  WireProperty() {
    const std::filesystem::path data(LUCERNA_TEST_DATA);
    for (const char* file : {"reference/sky.exr", "reference/slide.exr", "reference/screen.exr",
                             "lights/downlight.ies", "lights/sconce.ldt"}) {
      const std::filesystem::path from = data / file;
      std::filesystem::copy(from, root_.path() / from.filename());
    }
    std::ofstream(root_.path() / "calm.pbrt")
        << "WorldBegin Shape \"sphere\" LightSource \"point\" \"point3 from\" [0 0 3]\n";
  }

  rpc::ServerOptions options() const {
    rpc::ServerOptions options = service_options();
    options.scenes.root = root_.path();
    return options;
  }

  /// Writes a scene of a dozen kinds of lights, the next in turn, and loads it.  Lines that the
  /// server refuses are drawn again or left out; returns the kinds of those that remain by their
  /// lines.
  std::map<std::string, std::string> load_next(const SceneScale& scale, ExtremeNumbers& numbers,
                                               std::uint64_t scene, std::string* scene_id) {
    constexpr std::size_t kLights = 12;
    std::vector<SceneLine> lines;
    for (const std::string& line : head_lines(scale, numbers)) lines.push_back({"", line});
    for (std::size_t i = 0; i < kLights; ++i) {
      const auto& kinds = light_kinds();
      lines.push_back(light_line(kinds[(scene * kLights + i) % kinds.size()], scale, numbers));
    }
    for (int i = 0; i < 3; ++i) lines.push_back(shape_line(scale, numbers));
    static const std::regex kPlace("^[^:]*:([0-9]+):");
    int refused = 0;
    while (true) {
      const grpc::Status s = load(text_of(lines), scene_id);
      if (s.ok()) break;
      std::smatch place;
      const std::string message = s.error_message();
      const bool placed = std::regex_search(message, place, kPlace);
      EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << message;
      EXPECT_TRUE(placed) << message;
      if (!placed || s.error_code() != grpc::StatusCode::INVALID_ARGUMENT) return {};
      ++refused_;
      // Another of its kind; after a few, none.
      SceneLine& line = lines.at(std::stoul(place[1]) - 1);
      line =
          light_kinds().end() != std::ranges::find(light_kinds(), line.kind) && ++refused % 4 != 0
              ? light_line(line.kind, scale, numbers)
              : SceneLine{"", "# " + message.substr(0, 60)};
    }
    text_ = text_of(lines);
    std::map<std::string, std::string> kinds;
    for (std::size_t i = 0; i < lines.size(); ++i)
      kinds[fmt::format("scene.pbrt:{}", i + 1)] = lines[i].kind;
    return kinds;
  }

  static std::string text_of(const std::vector<SceneLine>& lines) {
    std::string text;
    for (const SceneLine& line : lines) text += line.text + "\n";
    return text;
  }

  grpc::Status load(const std::string& text, std::string* scene_id) {
    std::ofstream(root_.path() / "scene.pbrt") << text;
    v1::LoadSceneRequest request;
    request.set_path("scene.pbrt");
    v1::LoadSceneResponse response;
    const grpc::Status s =
        ask([&](auto* c) { return service_.scenes.LoadScene(c, request, &response); });
    *scene_id = response.scene_id();
    for (const std::string& wrong : wrong_numbers(response)) ADD_FAILURE() << wrong;
    return s;
  }

  void release(const std::string& scene_id) {
    v1::ReleaseSceneRequest request;
    request.set_scene_id(scene_id);
    v1::ReleaseSceneResponse response;
    const grpc::Status s =
        ask([&](auto* c) { return service_.scenes.ReleaseScene(c, request, &response); });
    EXPECT_TRUE(s.ok()) << s.error_message();
  }

  v1::SampleLiResponse calm_answer() {
    v1::SampleLiRequest q;
    q.set_scene_id(service_.load("calm.pbrt"));
    set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 2);
    q.mutable_seed()->set_seed(1);
    v1::SampleLiResponse r;
    const grpc::Status s = ask([&](auto* c) { return service_.lighting.SampleLi(c, q, &r); });
    EXPECT_TRUE(s.ok()) << s.error_message();
    r.clear_cost();
    return r;
  }

  TempDirectory root_;
  Service service_{options()};
  std::string text_;  // of the scene that was loaded last
  std::uint64_t refused_ = 0;
};

TEST_F(WireProperty, EveryNumberIsFiniteAndNotNegative) {
  constexpr std::uint64_t kSeed = 20260101;
  const std::uint64_t wanted = from_environment("LUCERNA_WIRE_ITEMS", 100000);
  const std::uint64_t only = from_environment("LUCERNA_WIRE_SCENE", ~std::uint64_t{0});
  constexpr int kBatch = 64;
  const v1::SampleLiResponse before = calm_answer();

  std::uint64_t items = 0, scenes = 0, lights = 0, empty = 0;
  std::map<std::string, std::uint64_t> lights_of_kind;
  WireQueries::Counts counts;
  for (std::uint64_t scene = only == ~std::uint64_t{0} ? 0 : only; items < wanted; ++scene) {
    SCOPED_TRACE(fmt::format("LUCERNA_WIRE_SCENE={}", scene));
    ExtremeNumbers numbers(kSeed + scene);
    const SceneScale scale = SceneScale::random(numbers);
    std::string scene_id;
    const auto kinds = load_next(scale, numbers, scene, &scene_id);
    ASSERT_FALSE(HasFailure());
    WireQueries queries(service_, numbers, scene_id, kBatch);
    const v1::Light* asked = nullptr;
    for (const v1::Light& light : queries.lights()) {
      asked = &light;
      queries.ask_light(light);
      if (!queries.failures().empty()) break;
      const std::string line = light.source().substr(0, light.source().rfind(':'));
      ++lights_of_kind[kinds.at(line)];
      ++lights;
    }
    if (queries.failures().empty()) {
      asked = nullptr;
      queries.ask_scene();
      queries.ask_refused();
    }
    for (const std::string& failure : queries.failures()) ADD_FAILURE() << failure;
    if (HasFailure()) {
      if (asked != nullptr) std::cout << asked->ShortDebugString() << "\n";
      std::cout << text_;
      FAIL();
    }
    release(scene_id);
    items += queries.items();
    for (const auto& [what, n] : queries.counts()) counts[what] += n;
    if (queries.lights().empty()) ++empty;
    ++scenes;
    if (only != ~std::uint64_t{0}) return;
  }

  for (const auto& [what, n] : counts)
    std::cout << fmt::format("{:20} {:28} {}\n", what.first, v1::ItemStatus_Name(what.second), n);
  std::cout << fmt::format(
      "{} items of {} lights in {} scenes ({} without lights), {} lines refused, {} numbers\n",
      items, lights, scenes, empty, refused_, numbers_seen());
  // Every kind of light was asked, and every reason was met.
  for (const std::string& kind : light_kinds()) EXPECT_GT(lights_of_kind[kind], 0u) << kind;
  for (int s = v1::ITEM_STATUS_OK; s <= v1::ItemStatus_MAX; ++s) {
    const auto status = static_cast<v1::ItemStatus>(s);
    EXPECT_GT((counts[{"SampleLi", status}]), 0u) << v1::ItemStatus_Name(status);
  }
  // It still serves, and answers what it answered.
  EXPECT_EQ(calm_answer().SerializeAsString(), before.SerializeAsString());
}

}  // namespace
}  // namespace lucerna::testing
