// Visibility queries over loopback, compared with a bare loop of Embree's rtcOccluded1.
//
//     visibility_bench [ROUNDS]
//
// A million small triangles anywhere in a box.  64 batches of 16 384 segments, 4 in flight, to a
// lucernad of its own with two threads.  The bare loop has the same segments in the given order and
// two threads, in a scene with Embree's default flags.  Both take turns; the table has medians.
#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "client/testing/local_server.h"
#include "lights/maths/vec.h"
#include "lucerna/client/client.h"
#include "proto/common/quantile.h"

namespace lucerna {
namespace {

constexpr std::size_t kBatches = 64, kBatch = 16'384, kInFlight = 4, kThreads = 2;
constexpr float kSize = 10;  // of the box [m]

struct Mesh {
  std::vector<Vec3f> vertices;
  std::vector<std::uint32_t> triangles;
};

/// Small triangles anywhere in the box, in no order.
Mesh leaves() {
  constexpr std::uint32_t kLeaves = 1'000'000;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto anywhere = [&] { return Vec3f{uniform(random), uniform(random), uniform(random)}; };
  Mesh mesh;
  for (std::uint32_t i = 0; i < kLeaves; ++i) {
    const Vec3f middle = anywhere() * kSize;
    for (std::uint32_t k = 0; k < 3; ++k) {
      mesh.vertices.push_back(middle + (anywhere() - Vec3f{0.5F, 0.5F, 0.5F}) * 0.05F);
      mesh.triangles.push_back(3 * i + k);
    }
  }
  return mesh;
}

void write_scene(const Mesh& mesh, const std::filesystem::path& folder) {
  std::ofstream ply(folder / "leaves.ply", std::ios::binary);
  ply << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
      << mesh.triangles.size() / 3 << "\nproperty list uchar int vertex_indices\nend_header\n";
  ply.write(reinterpret_cast<const char*>(mesh.vertices.data()),
            static_cast<std::streamsize>(mesh.vertices.size() * sizeof(Vec3f)));
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    ply.put(3);
    ply.write(reinterpret_cast<const char*>(&mesh.triangles[i]), 12);
  }
  std::ofstream(folder / "scene.pbrt")
      << "Camera \"perspective\"\nWorldBegin\nLightSource \"point\"\n"
         "Shape \"plymesh\" \"string filename\" \"leaves.ply\"\n";
}

/// The ends of segments, three numbers for each.
struct Segments {
  std::vector<float> from, to;
};

/// Random: both ends anywhere in the box.  Coherent: a picture's rays, rows after rows.
Segments segments(std::size_t batch, bool coherent) {
  std::mt19937 random(static_cast<unsigned>(batch + 2));
  std::uniform_real_distribution<float> uniform(0, kSize);
  Segments s;
  constexpr std::size_t kAcross = 1024;
  for (std::size_t i = 0; i < kBatch; ++i) {
    const std::size_t k = batch * kBatch + i;
    if (coherent) {
      s.from.insert(s.from.end(), {0.5F * kSize, -kSize, 0.5F * kSize});
      s.to.insert(s.to.end(), {kSize * (static_cast<float>(k % kAcross) + 0.5F) / kAcross, kSize,
                               kSize * (static_cast<float>(k / kAcross) + 0.5F) / kAcross});
    } else {
      for (int c = 0; c < 3; ++c) s.from.push_back(uniform(random));
      for (int c = 0; c < 3; ++c) s.to.push_back(uniform(random));
    }
  }
  return s;
}

template <typename Work>
double seconds(std::size_t threads, const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::thread> running;
  std::atomic<std::size_t> next = 0;
  for (std::size_t t = 0; t < threads; ++t)
    running.emplace_back([&] {
      for (std::size_t i; (i = next++) < kBatches;) work(i);
    });
  for (std::thread& thread : running) thread.join();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Release {
  void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
  void operator()(RTCScene s) const { rtcReleaseScene(s); }
};

/// A scene as Embree's tutorials make it.
class Bare {
 public:
  explicit Bare(const Mesh& mesh)
      : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_.get())) {
    RTCGeometry g = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    void* v = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                      mesh.vertices.size());
    std::copy_n(mesh.vertices.data(), mesh.vertices.size(), static_cast<Vec3f*>(v));
    void* i = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                      mesh.triangles.size() / 3);
    std::copy_n(mesh.triangles.data(), mesh.triangles.size(), static_cast<std::uint32_t*>(i));
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene_.get(), g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene_.get());
  }
  std::size_t visible(const Segments& s) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    std::size_t count = 0;
    for (std::size_t i = 0; i < s.from.size(); i += 3) {
      alignas(16) RTCRay ray{};
      ray.org_x = s.from[i], ray.org_y = s.from[i + 1], ray.org_z = s.from[i + 2];
      ray.dir_x = s.to[i] - s.from[i], ray.dir_y = s.to[i + 1] - s.from[i + 1];
      ray.dir_z = s.to[i + 2] - s.from[i + 2];
      ray.tfar = 1, ray.mask = ~0U;
      rtcOccluded1(scene_.get(), &context, &ray);
      count += ray.tfar >= 0 ? 1 : 0;
    }
    return count;
  }

 private:
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
};

void measure(const client::Client& client, const std::string& scene, const Bare& bare,
             bool coherent, int rounds) {
  std::vector<Segments> all;
  for (std::size_t b = 0; b < kBatches; ++b) all.push_back(segments(b, coherent));
  std::vector<v1::TestVisibilityRequest> plain(kBatches), exact(kBatches);
  for (std::size_t b = 0; b < kBatches; ++b) {
    auto& s = *plain[b].mutable_segments();
    plain[b].set_scene_id(scene);
    s.mutable_from()->mutable_offsets_m()->Add(all[b].from.begin(), all[b].from.end());
    s.mutable_to()->mutable_offsets_m()->Add(all[b].to.begin(), all[b].to.end());
    exact[b] = plain[b];
    exact[b].set_position_error_m(0);
  }
  std::atomic<std::size_t> seen = 0, free = 0;
  const auto ask = [&](const std::vector<v1::TestVisibilityRequest>& requests) {
    seen = 0;
    return seconds(kInFlight, [&](std::size_t b) {
      const auto answer = client.test_visibility(requests[b]);
      if (!answer.ok()) {
        fmt::print(stderr, "visibility_bench: {}\n", answer.status().ToString());
        std::exit(1);
      }
      std::size_t n = 0;
      for (const char c : answer->visible()) n += std::popcount(static_cast<unsigned char>(c));
      seen += n;
    });
  };
  std::vector<double> a, b, c, ratio_a, ratio_b;
  for (int i = -1; i < rounds; ++i) {
    free = 0;
    const double raw = seconds(kThreads, [&](std::size_t k) { free += bare.visible(all[k]); });
    const double first = ask(plain);
    const std::size_t of_plain = seen;
    const double second = ask(exact);
    if (i < 0) {
      fmt::print("{}: visible {} by Embree, {} and {} by the server\n",
                 coherent ? "coherent" : "random", free.load(), of_plain, seen.load());
      continue;
    }
    a.push_back(first), b.push_back(second), c.push_back(raw);
    ratio_a.push_back(raw / first), ratio_b.push_back(raw / second);
  }
  const auto rate = [](double s) { return kBatches * kBatch / s / 1e6; };
  fmt::print(
      "{:9} Embree {:5.2f} Mray/s; server {:5.2f}, {:.2f} times; position_error_m 0: {:5.2f}, "
      "{:.2f} times\n",
      coherent ? "coherent" : "random", rate(median(c)), rate(median(a)), median(ratio_a),
      rate(median(b)), median(ratio_b));
}

int run(int rounds) {
  const Mesh mesh = leaves();
  std::string name = (std::filesystem::temp_directory_path() / "visibility_bench.XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  const std::filesystem::path folder = name;
  write_scene(mesh, folder);
  auto server = testing::LocalServer::start({.scene_root = folder.string(), .threads = kThreads});
  if (!server.ok()) throw std::runtime_error(server.status().ToString());
  v1::LoadSceneRequest load;
  load.set_path("scene.pbrt");
  const auto loaded = server->client().load_scene(load);
  std::filesystem::remove_all(folder);
  if (!loaded.ok()) throw std::runtime_error(loaded.status().ToString());
  const Bare bare(mesh);
  fmt::print("{} triangles\n", mesh.triangles.size() / 3);
  for (const bool coherent : {false, true})
    measure(server->client(), loaded->scene_id(), bare, coherent, rounds);
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    return lucerna::run(argc > 1 ? std::atoi(argv[1]) : 9);
  } catch (const std::exception& e) {
    fmt::print(stderr, "visibility_bench: {}\n", e.what());
    return 1;
  }
}
