// Loads and releases of scenes that all differ.
#include "tests/reliability/report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {

void churn(const Settings& settings, Report& report) {
  const std::uint64_t first = 50, all = settings.brief ? 150 : 1000;
  const SceneFiles files(settings.brief ? 60 : 150);
  Subject subject(files);
  double early = 0, most = 0;
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
    const double now = subject.resident_bytes();
    (number <= first ? early : most) = std::max(number <= first ? early : most, now);
  }
  report.note("resident memory, most of the first 50 loads", 1e-6 * early, "MB");
  report.note("most of the later loads", 1e-6 * most, "MB");
  report.at_most("growth after the first 50 loads", 100 * (most / early - 1), 5, "%");
}

}  // namespace lucerna::reliability
