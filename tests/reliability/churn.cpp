// Loads and releases of scenes that all differ.
#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "proto/common/quantile.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

// The allocator returns memory a second after it was freed, so readings between loads vary by 4%.
// At rest they vary by 1.5%.
double resident_bytes_at_rest(const Subject& subject) {
  double least = subject.resident_bytes();
  for (int reading = 0; reading < 20; ++reading) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    least = std::min(least, subject.resident_bytes());
  }
  return least;
}

}  // namespace

void churn(const Settings& settings, Report& report) {
  // Small scenes load in milliseconds, so more of them pass until memory has settled.
  const std::uint64_t first = settings.brief ? 250 : 50, all = 1000;
  const SceneFiles files(settings.brief ? 60 : 150);
  Subject subject(files);
  std::vector<double> early, late;  // five rests of the first loads, and of the last
  for (std::uint64_t number = 1; number <= all; ++number) {
    const std::string name = files.write(number);
    const std::string id = subject.load(name);
    v1::EstimateIrradianceRequest query;
    query.set_scene_id(id);
    *query.mutable_receivers() = points_above(1);
    for (const float n : {0.0F, 0.0F, 1.0F}) query.add_normals(n);
    (void)value_of(subject.client().estimate_irradiance(query), "EstimateIrradiance");
    v1::ReleaseSceneRequest release;
    release.set_scene_id(id);
    (void)value_of(subject.client().release_scene(release), "ReleaseScene");
    std::filesystem::remove(std::filesystem::path(files.folder()) / name);
    if (number % (first / 5) != 0) continue;
    if (number <= first) early.push_back(resident_bytes_at_rest(subject));
    if (number > all - first) late.push_back(resident_bytes_at_rest(subject));
  }
  report.note("resident memory at rest, before", 1e-6 * quantile(early, 0.5), "MB");
  report.note("after the last loads", 1e-6 * quantile(late, 0.5), "MB");
  report.at_most("growth after the first loads",
                 100 * (quantile(late, 0.5) / quantile(early, 0.5) - 1), 5, "%");
}

}  // namespace lucerna::reliability
