// Loads and releases of scenes that all differ.
#include <algorithm>
#include <vector>

#include "tests/reliability/report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

// Single readings vary by some megabytes, because the allocator returns memory a second later.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

void churn(const Settings& settings, Report& report) {
  // Small scenes load in milliseconds, so more of them pass until memory is returned.  After 200
  // loads it still settled: four of eight runs grew by 4% to 9%.  After 400 it shrinks in each run.
  const std::uint64_t first = settings.brief ? 400 : 50, all = settings.brief ? 800 : 1000;
  const SceneFiles files(settings.brief ? 60 : 150);
  Subject subject(files);
  std::vector<double> early, late;  // the second half of the first loads, and as many at the end
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
    if (number > first / 2 && number <= first) early.push_back(subject.resident_bytes());
    if (number > all - first / 2) late.push_back(subject.resident_bytes());
  }
  report.note("resident memory, median before", 1e-6 * median(early), "MB");
  report.note("median of the last loads", 1e-6 * median(late), "MB");
  report.at_most("growth after the first loads", 100 * (median(late) / median(early) - 1), 5, "%");
}

}  // namespace lucerna::reliability
