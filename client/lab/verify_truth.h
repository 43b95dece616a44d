// Lucerna's answers about lights, in vectors with one entry per row.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/lab/variation.h"
#include "client/library/batches.h"
#include "client/terminal/session.h"

namespace lucerna::verify {

/// Rays start this far on their way to a known point of a light, so that nothing hides it.
inline constexpr double kAlmostThere = 0.999;

/// How the server chooses points on area lights.
struct Way {
  v1::AreaSampling sampling = v1::AREA_SAMPLING_UNSPECIFIED;
  const char* name = "";
};

/// Samples of SampleLi.  A sample that is not OK has `ok` false.
struct LightSamples {
  std::vector<Double3> value, directions, light_normals;
  std::vector<double> distance, pdf;
  std::vector<bool> ok;
  std::vector<bool> behind;  ///< the receiver is behind a one-sided light
};

/// Estimates with standard errors.
struct Estimates {
  std::vector<double> value, standard_error;
};

/// Asks the server of the session.  Errors of the server end the program.
class Truth {
 public:
  Truth(cli::Session& session, std::string scene_id);

  const std::string& scene_id() const { return scene_id_; }
  const std::vector<v1::Light>& lights() const { return lights_; }
  const v1::Light& light(std::uint64_t id) const;
  const v1::SceneSummary& scene() const { return scene_; }

  /// The densities of directions [1/sr].  `normals` may be empty.
  std::vector<double> densities(std::uint64_t light, const std::vector<Double3>& points,
                                const std::vector<Double3>& normals,
                                const std::vector<Double3>& directions, v1::AreaSampling way,
                                const Variation& variation = {});
  /// `count` samples for each point.
  LightSamples samples(std::uint64_t light, const std::vector<Double3>& points,
                       const std::vector<Double3>& normals, std::uint32_t count, std::uint64_t seed,
                       v1::AreaSampling way, const Variation& variation = {});
  /// RGB radiances along rays [cd/m2], of one light.
  std::vector<Double3> radiances(std::uint64_t light, const std::vector<Double3>& points,
                                 const std::vector<Double3>& directions);
  /// The light that each ray meets: the first, or the one at the distance [m], which may be
  /// infinite.  0 for none, and if several lights at infinity lie in this direction.  `distances`
  /// may be empty or have NaN.
  std::vector<std::uint64_t> lights_met(const std::vector<Double3>& points,
                                        const std::vector<Double3>& directions,
                                        const std::vector<double>& distances);
  /// The light of the first surface that each ray meets; 0 for none.
  std::vector<std::uint64_t> lights_ahead(const std::vector<Double3>& points,
                                          const std::vector<Double3>& directions);
  /// The densities of rays that leave a light.
  void emission_densities(std::uint64_t light, const std::vector<Double3>& points,
                          const std::vector<Double3>& directions, std::vector<double>* position,
                          std::vector<double>* direction);
  /// Powers of lights [lm] and bounds on their errors.
  Estimates powers(const std::vector<std::uint64_t>& lights, const std::string& scene_id = {});
  /// Direct illuminance without occlusion [lx].  Without normals: spherical illuminance.
  std::vector<double> unoccluded(std::uint64_t light, const std::vector<Double3>& points,
                                 const std::vector<Double3>& normals,
                                 const Variation& variation = {});
  /// The integral of the light that arrives above the surface, with occlusion and without the
  /// cosine [lx].  For lights with a density.
  std::vector<double> without_cosine(std::uint64_t light, const std::vector<Double3>& points,
                                     const std::vector<Double3>& normals, std::uint32_t samples,
                                     std::uint64_t seed);
  /// Direct illuminances by one light [lx], with occlusion, from this number of samples.
  Estimates illuminances(std::uint64_t light, const std::vector<Double3>& points,
                         const std::vector<Double3>& normals, std::uint32_t samples,
                         std::uint64_t seed);
  /// Illuminances by all lights [lx], with at most this number of reflections.
  Estimates illuminances_of_all(const std::vector<Double3>& points,
                                const std::vector<Double3>& normals, std::uint32_t bounces,
                                std::uint32_t samples, std::uint64_t seed);
  std::vector<bool> visible(const std::vector<Double3>& from, const std::vector<Double3>& to);
  /// The id of a revision of the scene with another light; empty if the server refuses it.
  std::string with_light(const v1::Light& light);

 private:
  client::BatchOptions batches();
  std::string id_for(const Variation& variation) const;

  cli::Session& session_;
  std::string scene_id_;
  std::vector<v1::Light> lights_;
  v1::SceneSummary scene_;
};

/// Luminance of RGB, in any unit.
double luminance(const Double3& rgb);

}  // namespace lucerna::verify
