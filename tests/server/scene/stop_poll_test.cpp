// Loops over the content of files and edits end after a request to stop.
#include "lights/maths/stop_poll.h"

#include <gtest/gtest.h>

#include <functional>

#include "lights/maths/spectrum.h"
#include "lights/pictures/image_distribution.h"
#include "lights/shapes/mesh.h"
#include "server/description/loop_subdivision.h"
#include "server/description/mesh_census.h"
#include "server/description/scene_contents.h"
#include "server/rays/surface_table.h"
#include "server/runtime/parallel.h"
#include "server/scene/create_light.h"
#include "server/scene/light_edit.h"
#include "server/visibility/smooth_surfaces.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kMany = 1000;

std::stop_token requested() {
  std::stop_source stop;
  stop.request_stop();
  return stop.get_token();
}

TEST(StopPoll, EndsALoopOnlyWithinAScope) {
  const auto loop = [] {
    StopPoll poll;
    for (std::uint32_t i = 0; i < kMany; ++i, poll()) {
    }
  };
  const std::stop_token stop = requested(), none;
  EXPECT_NO_THROW(loop());
  const StopScope outer(stop);
  EXPECT_THROW(loop(), Stopped);
  {
    const StopScope inner(none);
    EXPECT_NO_THROW(loop());
  }
  EXPECT_THROW(loop(), Stopped);
}

TEST(StopPoll, EndsAChunkOnlyAfterTheStopOfItsOwnLoop) {
  const std::stop_token of_caller = requested();
  const StopScope scope(of_caller);
  std::stop_source stop;
  for (const std::size_t chunks : {1, 16}) {
    std::atomic<std::size_t> whole = 0;
    const auto run = [&](std::size_t, std::size_t) {
      StopPoll poll;
      for (std::uint32_t i = 0; i < kMany; ++i, poll()) {
      }
      ++whole;
    };
    parallel_chunks(chunks, 1, {}, run);
    EXPECT_EQ(whole, chunks);
    std::stop_source own;
    parallel_chunks(chunks, 1, own.get_token(), [&](std::size_t begin, std::size_t end) {
      own.request_stop();
      run(begin, end);
    });
    EXPECT_EQ(whole, chunks);
  }
}

TriangleMeshData mesh() {
  TriangleMeshData data;
  for (std::uint32_t i = 0; i < kMany; ++i) {
    data.positions.emplace_back(i, i % 7, i % 5);
    for (const std::uint32_t k : {0, 1, 2}) data.indices.push_back((i + k) % kMany);
  }
  return data;
}

ShapeDescription shape() {
  ShapeDescription made;
  made.geometry = mesh();
  made.emission = ShapeDescription::Emission{};
  return made;
}

TEST(StopPoll, EndsEachLoopOverContent) {
  const std::vector<Triangle> triangles(kMany, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const std::vector<BilinearPatch> patches(kMany, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  const std::vector<Rgbf> texels(kMany, Rgbf(1, 1, 1));
  const auto image = Image::create(1, kMany, texels).value();
  SampledSpectrum spectrum;
  for (std::uint32_t i = 0; i < kMany; ++i) {
    spectrum.wavelengths_nm.push_back(400 + 1e-3 * i);
    spectrum.values.push_back(1);
  }
  const ControlMesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}};
  LightEdits edits;
  for (std::uint64_t id = 1; id <= kMany; ++id) edits.changes[id].scale = 2;
  SceneDescription scene;
  for (std::uint32_t i = 0; i < kMany; ++i) scene.shapes.push_back({});
  const LightChange moved{.shift_m = {1, 0, 0}};
  const std::vector<std::pair<const char*, std::function<void()>>> loops = {
      {"triangles of a light", [&] { (void)TriangleMesh::create(triangles); }},
      {"patches of a light", [&] { (void)PatchMesh::create(patches); }},
      {"a light of a shape", [&] { (void)create_area_light(shape(), {}); }},
      {"texels", [&] { (void)Image::create(1, kMany, texels); }},
      {"a picture to draw from",
       [&] { (void)ImageDistribution(*image, ImageFilter::kNearest, ImageBorder::kClamp); }},
      {"samples of a spectrum", [&] { (void)Spectrum::create(spectrum); }},
      {"subdivision", [&] { (void)loop_subdivide(tetrahedron, 5); }},
      {"triangles without area", [&] { (void)census_of(mesh()); }},
      {"contents", [&] { (void)contents_of(scene); }},
      {"bounds", [&] { (void)shape_bounds(shape()); }},
      {"surfaces",
       [&] {
         GeometrySet set;
         SurfaceTable table;
         (void)append_shape(shape(), {}, 1, -1, set, table);
       }},
      {"the name of edits", [&] { (void)edits.canonical(); }},
      {"moved vertices",
       [&] {
         ShapeDescription made = shape();
         (void)move_surface(1, moved, made);
       }},
  };
  const std::stop_token stop = requested();
  for (const auto& [what, loop] : loops) {
    EXPECT_NO_THROW(loop()) << what;
    const StopScope scope(stop);
    EXPECT_THROW(loop(), Stopped) << what;
  }
}

// Queries make parts of a scene at their first use.
TEST(StopPoll, EndsTheBuildOfAPartThatTheNextCallBuildsAgain) {
  SceneDescription of = testing::description();
  of.materials.push_back({.params = MetalParams{.reflectance = ColourValue{Rgb(0.9)}}});
  ShapeDescription mirror = shape();
  mirror.emission = {};
  mirror.material = 1;
  of.shapes.push_back(std::move(mirror));
  const auto scene = testing::build(std::move(of));
  const std::stop_token stop = requested();
  {
    const StopScope scope(stop);
    EXPECT_THROW((void)smooth_surfaces(*scene), Stopped);
  }
  EXPECT_NO_THROW((void)smooth_surfaces(*scene));
}

}  // namespace
}  // namespace lucerna
