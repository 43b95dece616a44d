// Loads a mesh of a million triangles, and does by hand what any loader has to do: read the bytes,
// let Embree build.
//
//     load_bench [PAIRS]
//
// The two run in turns.  The last line has the median of the ratios of the pairs.
#include <embree3/rtcore.h>
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "tests/bench/bench_program.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kSide = 708;  // quads along a side: 1 002 528 triangles
constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::int32_t);
constexpr const char* kEnd = "end_header\n";

void write_mesh(const std::filesystem::path& path) {
  static_assert(std::endian::native == std::endian::little);
  std::ofstream file(path, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\nelement vertex " << (kSide + 1) * (kSide + 1)
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
       << 2 * kSide * kSide << "\nproperty list uchar int vertex_indices\n"
       << kEnd;
  for (std::uint32_t i = 0; i <= kSide; ++i)
    for (std::uint32_t j = 0; j <= kSide; ++j) {
      const float u = static_cast<float>(i) / kSide, v = static_cast<float>(j) / kSide;
      const float vertex[] = {10 * u, 10 * v, 0.3F * std::sin(40 * u) * std::cos(37 * v)};
      file.write(reinterpret_cast<const char*>(vertex), sizeof vertex);
    }
  const auto face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    file.put(3);
    const std::uint32_t corners[] = {a, b, c};
    file.write(reinterpret_cast<const char*>(corners), sizeof corners);
  };
  for (std::uint32_t i = 0; i < kSide; ++i)
    for (std::uint32_t j = 0; j < kSide; ++j) {
      const std::uint32_t a = i * (kSide + 1) + j, c = a + kSide + 1;
      face(a, c, a + 1);
      face(a + 1, c, c + 1);
    }
}

void write_scene(const std::filesystem::path& folder) {
  write_mesh(folder / "sheet.ply");
  std::ofstream(folder / "scene.pbrt") << R"(LookAt 5 5 20  5 5 0  0 1 0
Camera "perspective"
WorldBegin
LightSource "point" "point3 from" [5 5 10]
Shape "plymesh" "string filename" "sheet.ply"
)";
}

std::vector<char> bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes(std::filesystem::file_size(path));
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return bytes;
}

/// Knows the layout of the file, so it only copies.
void by_hand(const std::filesystem::path& folder) {
  const std::vector<char> ply = bytes_of(folder / "sheet.ply");
  const char* at = std::search(ply.data(), ply.data() + ply.size(), kEnd, kEnd + std::strlen(kEnd));
  at += std::strlen(kEnd);
  const RTCDevice device = rtcNewDevice(nullptr);
  const RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  constexpr std::size_t kVertices = std::size_t{kSide + 1} * (kSide + 1);
  constexpr std::size_t kFaces = std::size_t{2} * kSide * kSide;
  auto* v = static_cast<char*>(rtcSetNewGeometryBuffer(
      mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), kVertices));
  auto* t = static_cast<char*>(rtcSetNewGeometryBuffer(
      mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), kFaces));
  for (std::size_t i = 0; i < kVertices; ++i, at += 12, v += 12) std::memcpy(v, at, 12);
  for (std::size_t i = 0; i < kFaces; ++i, at += kFaceBytes, t += 12) std::memcpy(t, at + 1, 12);
  rtcCommitGeometry(mesh);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // as the server's
  rtcAttachGeometry(scene, mesh);
  rtcReleaseGeometry(mesh);
  rtcCommitScene(scene);
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::runtime_error("Embree failed");
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}

template <typename F>
double seconds_of(const F& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

int run(int pairs) {
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  const TempDirectory folder;
  write_scene(folder.path());
  const auto by_server = [&] { (void)load_scene(folder.path() / "scene.pbrt"); };
  by_server();  // both then find the files in the page cache
  std::vector<double> ratios;
  fmt::print("{:>12} {:>12} {:>8}\n", "server [s]", "by hand [s]", "ratio");
  for (int i = 0; i < pairs; ++i) {
    double server = 0, hand = 0;
    if (i % 2 == 0) hand = seconds_of([&] { by_hand(folder.path()); });
    server = seconds_of(by_server);
    if (i % 2 == 1) hand = seconds_of([&] { by_hand(folder.path()); });
    ratios.push_back(server / hand);
    fmt::print("{:12.3f} {:12.3f} {:8.2f}\n", server, hand, ratios.back());
  }
  std::ranges::sort(ratios);
  fmt::print("median of the ratios: {:.2f}\n", ratios[ratios.size() / 2]);
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    return lucerna::run(argc > 1 ? std::stoi(argv[1]) : 9);
  } catch (const std::exception& e) {
    fmt::print(stderr, "load_bench: {}\n", e.what());
    return 1;
  }
}
