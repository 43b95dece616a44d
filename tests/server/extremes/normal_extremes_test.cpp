// Row 40: receivers whose light grazes them.  The rounding of a normal or of a direction to floats
// is large against the cosine.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/extremes_sweep.h"
#include "tests/server/pbrt/pbrt_fixture.h"
#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {
namespace {

using Real = long double;

// A light of one direction, and a sun whose edge stays above the horizons.
constexpr char kScene[] = R"(WorldBegin
LightSource "distant" "rgb L" [1 1 1] "point3 from" [0.3 0.7 0.4] "point3 to" [0 0 0]
LightSource "distant" "rgb L" [1 1 1] "point3 from" [0.3 0.7 0.4] "point3 to" [0 0 0]
  "float angulardiameter" 1e-5
)";

TEST(NormalExtremes, GrazingLight) {
  SceneFiles files;
  files.write("lights.pbrt", kScene);
  Service service(scenes_in(files.path().string()));
  auto request = about<v1::EstimateIrradianceRequest>(service.load("lights.pbrt"));
  request.set_bounces(0);
  request.set_per_light(true);

  const Real to_light[] = {0.3L, 0.7L, 0.4L};
  const Real distance = std::hypot(0.3L, 0.7L, 0.4L);
  std::mt19937 random(40);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Real> cosines;
  std::vector<double> textbook;
  for (double least : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    for (int i = 0; i < 200; ++i) {
      // A normal of any length, across the light and then a little towards it.
      const Vec3 w{0.3, 0.7, 0.4}, any{unit(random), unit(random), unit(random)};
      const Vec3 n =
          (normalized(cross(w, any)) + normalized(w) * least) * std::pow(10.0, 3 * unit(random));
      const Vec3f sent(n);
      const Real x = sent.x, y = sent.y, z = sent.z;
      const Real cosine = (x * to_light[0] + y * to_light[1] + z * to_light[2]) /
                          (distance * std::sqrt(x * x + y * y + z * z));
      if (!(cosine > 0.3 * least)) continue;
      cosines.push_back(cosine);
      textbook.push_back(dot(normalized(sent), normalized(Vec3f(w))));
      for (const float v : {sent.x, sent.y, sent.z}) {
        request.add_normals(v);
        request.mutable_receivers()->add_offsets_m(0);
      }
    }
  }
  const auto response = service.answer(request);
  ASSERT_EQ(response.shares_size(), 2);
  Sweep sweep(40, "receivers whose light grazes them; a distant light and a narrow sun",
              "cosine 1e-6 ... 0.1", "illuminance, of the normal in the request's floats");
  for (const v1::LightShare& share : response.shares()) {
    for (std::size_t i = 0; i < cosines.size(); ++i) {
      const auto truth = double(cosines[i]);
      sweep.compare(share.illuminance_lx(static_cast<int>(i)), truth,
                    fmt::format("cosine {}, light {}", truth, share.light_id()));
      sweep.compare_textbook(textbook[i], truth);
    }
  }
  sweep.expect_within(1.2e-7);
}

}  // namespace
}  // namespace lucerna::testing
