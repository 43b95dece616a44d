// Mixed calls, edits, loads and releases for a long time.
#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <random>
#include <thread>

#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

/// A straight line through points by least squares.
struct Line {
  /// The change of y with x, and its standard error for independent points.
  double slope = 0, error = 0;
};

Line line_through(const std::vector<std::pair<double, double>>& points) {
  const auto n = static_cast<double>(points.size());
  if (points.size() < 3) return {};
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, yy = 0;
  for (const auto& [x, y] : points) mean_x += x / n, mean_y += y / n;
  for (const auto& [x, y] : points) {
    xx += (x - mean_x) * (x - mean_x);
    xy += (x - mean_x) * (y - mean_y);
    yy += (y - mean_y) * (y - mean_y);
  }
  const double slope = xy / xx;
  return {slope, std::sqrt(std::max(0.0, yy - slope * xy) / ((n - 2) * xx))};
}

/// Where workers wait while the server rests.
class Gate {
 public:
  /// Waits until the gate is open.
  void enter() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return open_; });
    ++inside_;
  }
  void leave() {
    const std::scoped_lock lock(mutex_);
    --inside_;
    changed_.notify_all();
  }
  /// Closes the gate, and waits until all have left.
  void close() {
    std::unique_lock lock(mutex_);
    open_ = false;
    changed_.wait(lock, [this] { return inside_ == 0; });
  }
  void open() {
    const std::scoped_lock lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = true;
  int inside_ = 0;
};

/// One client that makes calls in a random order.
class Worker {
 public:
  Worker(const Subject& subject, const SceneFiles& files, unsigned number)
      : subject_(subject),
        files_(files),
        client_(value_of(client::Client::connect({.target = subject.target()}), "connect")),
        random_(number),
        next_scene_(1'000'000 * (number + 1)) {}

  /// Makes one call, or a load with what belongs to it.  Returns how many calls.
  int step() {
    switch (std::uniform_int_distribution(0, 9)(random_)) {
      case 0:
        return load();
      case 1:
        return edit();
      case 2:
        return render();
      case 3:
        return cancel();
      case 4:
        return lists();
      default:
        return query(subject_.scene());
    }
  }
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  template <typename T>
  bool good(const absl::StatusOr<T>& answer, const char* what) {
    if (!answer.ok()) errors_.push_back(fmt::format("{}: {}", what, answer.status().ToString()));
    return answer.ok();
  }

  int query(const std::string& scene) {
    v1::EstimateIrradianceRequest request;
    request.set_scene_id(scene);
    const int count = std::uniform_int_distribution(1, 300)(random_);
    *request.mutable_receivers() = points_above(count);
    for (int i = 0; i < count; ++i)
      for (const float n : {0.0F, 0.0F, 1.0F}) request.add_normals(n);
    good(client_.estimate_irradiance(request), "EstimateIrradiance");
    v1::SampleLiRequest sample;
    sample.set_scene_id(scene);
    *sample.mutable_receivers() = request.receivers();
    sample.set_test_visibility(true);
    good(client_.sample_li(sample), "SampleLi");
    return 2;
  }

  int load() {
    const std::string name = files_.write(++next_scene_);
    v1::LoadSceneRequest request;
    request.set_path(name);
    const auto loaded = client_.load_scene(request);
    std::filesystem::remove(std::filesystem::path(files_.folder()) / name);
    if (!good(loaded, "LoadScene")) return 1;
    const int calls = query(loaded->scene_id());
    return calls + 1 + release(loaded->scene_id());
  }

  int release(const std::string& scene) {
    v1::ReleaseSceneRequest request;
    request.set_scene_id(scene);
    good(client_.release_scene(request), "ReleaseScene");
    return 1;
  }

  int edit() {
    v1::EditLightsRequest request;
    request.set_scene_id(subject_.scene());
    v1::LightChange& change = *request.add_edits()->mutable_change();
    change.set_light_id(std::uniform_int_distribution<std::uint64_t>(1, 20)(random_));
    // Two workers never make the same revision, since one would release it under the other.
    change.set_scale(1e-6 * static_cast<double>(++next_scene_));
    const auto edited = client_.edit_lights(request);
    if (!good(edited, "EditLights")) return 1;
    const int calls = query(edited->scene_id());
    return calls + 1 + release(edited->scene_id());
  }

  int render() {
    v1::RenderImageRequest request;
    request.set_scene_id(subject_.scene());
    request.mutable_accuracy()->set_samples(4);
    const absl::Status status =
        client_.render_image(request, [](const v1::RenderImageResponse&) { return true; });
    if (!status.ok()) errors_.push_back("RenderImage: " + status.ToString());
    return 1;
  }

  /// A picture that is cancelled after its first message.
  int cancel() {
    v1::RenderImageRequest request;
    request.set_scene_id(subject_.scene());
    request.mutable_accuracy()->set_samples(1 << 16);
    request.set_samples_per_block(1);  // so that the first message is soon ready
    const absl::Status status =
        client_.render_image(request, [](const v1::RenderImageResponse&) { return false; });
    if (!absl::IsCancelled(status)) errors_.push_back("cancelled: " + status.ToString());
    return 1;
  }

  int lists() {
    good(client_.get_stats(), "GetStats");
    good(client_.list_scenes({}), "ListScenes");
    v1::EstimatePowerRequest power;
    power.set_scene_id(subject_.scene());
    good(client_.estimate_power(power), "EstimatePower");
    return 3;
  }

  const Subject& subject_;
  const SceneFiles& files_;
  client::Client client_;
  std::mt19937 random_;
  std::uint64_t next_scene_;
  std::vector<std::string> errors_;
};

}  // namespace

void soak(const Settings& settings, Report& report) {
  const SceneFiles files;
  Subject subject(files, {"--metrics", "127.0.0.1:0", "--log-level", "warning"});
  const Seconds whole(settings.brief ? 3 : 60 * settings.soak_minutes);
  const Seconds warm_up = whole / 4;
  // Free memory returns to the system after a second.
  const Seconds work(settings.brief ? 1 : 10), rest(settings.brief ? 0.1 : 2);
  std::atomic<std::int64_t> calls{0};
  std::vector<std::unique_ptr<Worker>> workers;
  for (unsigned i = 0; i < 4; ++i) workers.push_back(std::make_unique<Worker>(subject, files, i));
  Gate gate;
  std::vector<std::jthread> threads;
  const auto begin = Clock::now();
  for (const auto& worker : workers)
    threads.emplace_back([&calls, &gate, &worker](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        gate.enter();
        calls += worker->step();
        gate.leave();
      }
    });
  // Time [h] and memory [MB]: the mean of each period of calls, and the memory after each rest.
  std::vector<std::pair<double, double>> under_load, at_rest;
  double most = 0;
  while (Clock::now() < after(begin, whole)) {
    double sum = 0;
    int samples = 0;
    for (const auto end = after(Clock::now(), work); Clock::now() < end; ++samples) {
      std::this_thread::sleep_for(std::chrono::milliseconds(250));
      const double memory = 1e-6 * subject.resident_bytes();
      sum += memory;
      most = std::max(most, memory);
    }
    gate.close();
    std::this_thread::sleep_for(rest);
    const Seconds time = Clock::now() - begin;
    if (time > warm_up) {
      under_load.emplace_back(time.count() / 3600, sum / samples);
      at_rest.emplace_back(time.count() / 3600, 1e-6 * subject.resident_bytes());
    }
    gate.open();
  }
  threads.clear();  // stops and joins
  std::size_t errors = 0;
  for (const auto& worker : workers) {
    errors += worker->errors().size();
    for (const std::string& error : worker->errors()) fmt::print("    {}\n", error);
  }
  report.note("time", whole.count() / 60, "min");
  report.note("calls", static_cast<double>(calls), "calls");
  report.at_most("calls that failed", static_cast<double>(errors), 0, "calls");
  report.at_least("calls, at least those of the short form", static_cast<double>(calls), 20,
                  "calls");
  report.note("resident memory, most", most, "MB");
  // A few minutes say nothing about hours.
  if (!settings.brief && settings.soak_minutes >= 10) {
    const Line load = line_through(under_load), idle = line_through(at_rest);
    report.note("slope of the resident memory under load, after the warm-up", load.slope, "MB/h");
    report.note("its standard error", load.error, "MB/h");
    report.at_most("slope at rest, after the warm-up", idle.slope, 1, "MB/h");
    report.note("its standard error", idle.error, "MB/h");
  }
  report.at_most("exit status of the server", subject.server().stop(), 0, "");
}

}  // namespace lucerna::reliability
