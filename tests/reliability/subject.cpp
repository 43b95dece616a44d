#include "tests/reliability/subject.h"

#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <stdexcept>

#include "lucerna/client/points.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna::reliability {
namespace {

/// The floor as binary PLY, from (0, 0) to (10, 10).
void write_floor(const std::filesystem::path& path, std::uint32_t edge) {
  const std::uint32_t across = edge + 1;
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << across * across
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << 2 * edge * edge
      << "\nproperty list uchar uint vertex_indices\nend_header\n";
  const float step = 10.0F / static_cast<float>(edge);
  for (std::uint32_t y = 0; y < across; ++y) {
    for (std::uint32_t x = 0; x < across; ++x) {
      const std::array p = {step * static_cast<float>(x), step * static_cast<float>(y),
                            0.2F * std::sin(2 * step * static_cast<float>(x + y))};
      out.write(reinterpret_cast<const char*>(p.data()), sizeof p);
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

testing::LocalServer start(const SceneFiles& files, std::vector<std::string> arguments) {
  return value_of(
      testing::LocalServer::start(
          {.scene_root = files.folder(), .threads = 2, .arguments = std::move(arguments)}),
      "lucernad");
}

}  // namespace

SceneFiles::SceneFiles(std::uint32_t edge) { write_floor(directory_.path() / "floor.ply", edge); }

std::string SceneFiles::write(std::uint64_t number) const {
  const std::string name = fmt::format("scene{}.pbrt", number);
  std::ofstream out(directory_.path() / name);
  out << "Film \"rgb\" \"integer xresolution\" [256] \"integer yresolution\" [256]\n"
         "LookAt 5 -4 6  5 5 0  0 0 1\nCamera \"perspective\" \"float fov\" [60]\nWorldBegin\n";
  for (int i = 0; i < 20; ++i) {
    out << fmt::format("LightSource \"point\" \"rgb I\" [{} 1 1] \"point3 from\" [{} {} 3]\n",
                       1 + 1e-6 * static_cast<double>(number), 0.25 + 2 * (i % 5),
                       0.25 + 2 * (i / 5));
  }
  out << "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 3 3]\nTranslate 5 5 4\n"
         "ReverseOrientation\nShape \"disk\" \"float radius\" [0.5]\nAttributeEnd\n"
         "Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]\n"
         "Shape \"plymesh\" \"string filename\" [\"floor.ply\"]\n";
  out.close();
  if (!out) throw std::runtime_error("cannot write " + name);
  return name;
}

Subject::Subject(const SceneFiles& files, std::vector<std::string> arguments)
    : server_(start(files, std::move(arguments))), scene_(load(files.write(0))) {}

std::string Subject::load(const std::string& path) const {
  v1::LoadSceneRequest request;
  request.set_path(path);
  return value_of(client().load_scene(request), "LoadScene").scene_id();
}

double Subject::cpu_s() const {
  clockid_t clock{};
  timespec now{};
  // Unlike /proc, this clock has no ticks.
  if (clock_getcpuclockid(server_.process_id(), &clock) != 0 || clock_gettime(clock, &now) != 0)
    throw std::runtime_error("the server has ended");
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Subject::allocator_cpu_s() const {
  const auto time_s = [](const std::string& file) {
    double ns = 0;
    std::ifstream(file) >> ns;
    return 1e-9 * ns;
  };
  // A thread for each arena starts when the arena is first used.
  if (const auto now = std::chrono::steady_clock::now(); now - listed_ > std::chrono::seconds(1)) {
    listed_ = now;
    const std::string tasks = "/proc/" + std::to_string(server_.process_id()) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks)) {
      std::string name;
      std::ifstream(task.path() / "comm") >> name;
      const std::string file = task.path().string() + "/schedstat";
      if (name.starts_with("jemalloc") && !allocator_threads_.contains(file))
        allocator_threads_[file] = time_s(file);
    }
  }
  double sum_s = 0;
  for (const auto& [file, before_s] : allocator_threads_) sum_s += time_s(file) - before_s;
  return sum_s;
}

double Subject::resident_bytes() const {
  std::ifstream in("/proc/" + std::to_string(server_.process_id()) + "/statm");
  double total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double Subject::most_resident_bytes() const {
  std::ifstream in("/proc/" + std::to_string(server_.process_id()) + "/status");
  for (std::string word; in >> word;) {
    double kib = 0;
    if (word == "VmHWM:" && in >> kib) return 1024 * kib;
  }
  throw std::runtime_error("the server has no VmHWM");
}

v1::Points points_above(int count) {
  std::vector<client::Double3> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    points.push_back({0.5 + 0.01 * (i % 900), 0.5 + 0.01 * (i / 900 % 900), 1});
  return client::make_points(points);
}

Message Subject::thousand_samples() const {
  v1::SampleLiRequest request;
  request.set_scene_id(scene_);
  *request.mutable_receivers() = points_above(1000);
  return make_message("LightingService/SampleLi", request);
}

Message Subject::one_item() const { return irradiance(1, 1); }

Message Subject::irradiance(int receivers, std::uint32_t samples) const {
  v1::EstimateIrradianceRequest request;
  request.set_scene_id(scene_);
  *request.mutable_receivers() = points_above(receivers);
  for (int i = 0; i < receivers; ++i)
    for (const float n : {0.0F, 0.0F, 1.0F}) request.add_normals(n);
  request.mutable_accuracy()->set_samples(samples);
  // Every receiver takes all of its samples.
  request.mutable_accuracy()->set_closed_forms(v1::CLOSED_FORMS_OFF);
  return make_message("LightingService/EstimateIrradiance", request);
}

Message Subject::tile(std::uint32_t edge, std::uint32_t samples) const {
  v1::RenderTileRequest request;
  request.set_scene_id(scene_);
  request.mutable_rect()->set_x1(edge);
  request.mutable_rect()->set_y1(edge);
  request.mutable_accuracy()->set_samples(samples);
  return make_message("RenderService/RenderTile", request);
}

}  // namespace lucerna::reliability
