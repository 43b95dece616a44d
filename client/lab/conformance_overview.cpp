// What a reader of a pack reads first.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "client/lab/conformance_pack.h"

namespace lucerna::conformance {
namespace {

constexpr const char* kReadme = R"(# Conformance pack

Each folder has a scene with one light, and what Lucerna answers about this light.  Compare your renderer with the
tables, without running Lucerna.  `manifest.json` lists the cases and the version that made them.

| file of a case | one row is |
|---|---|
| `scene.pbrt` or `scene.gltf` | the scene, in the syntax of pbrt-v4 or glTF 2.0 |
| `power.csv` | the power of the light |
| `irradiance.csv` | the direct illuminance at a receiver, with occlusion |
| `irradiance_intervals.csv` | the 95% interval of the same row in `irradiance.csv` |
| `samples.csv` | a light sample at a receiver, without occlusion |
| `densities.csv` | the density of a given direction at a receiver |
| `emission.csv` | a ray that leaves the light |
| `visibility.csv` | two points |

| column | meaning |
|---|---|
| `x`, `y`, `z` | the receiver, or where a ray or a segment starts, world [m] |
| `nx`, `ny`, `nz` | the unit normal of the receiver; in `emission.csv` that of the light, or the direction if it has no surface |
| `light` | the number of the light in Lucerna, always the same in a case |
| `wx`, `wy`, `wz` | the unit direction to the light; in `emission.csv` away from the light; world |
| `pdf` | the density of the direction with respect to solid angle [1/sr]; 0 for a light without a density |
| `r`, `g`, `b` | radiance [cd/m2] of a sample, or the illuminance [lx] on a surface that faces a delta light; intensity [cd] of a ray that leaves a point; power [lm]; irradiance [lx] |
| `distance` | to the light [m]; `inf` for a light at infinity |
| `pdf_position`, `pdf_direction` | densities of a ray's start [1/m2] and direction [1/sr]; 0 if it is certain |
| `power` | luminous flux [lm] |
| `illuminance` | [lx], the luminance of `r`, `g`, `b`: 0.2126 r + 0.7152 g + 0.0722 b |
| `stderr` | standard error of `illuminance`, bound on the error of `power`; 0 if the value is exact |
| `lower`, `upper`, `exact` | the interval [lx]; 1 if it has no width |
| `tx`, `ty`, `tz`, `visible` | the other end [m]; 1 if nothing is between both ends, else 0 |

- Numbers of light samples are 32-bit floats, written with all their digits.
- Your renderer may sample in another way.  Then its densities differ.  Its powers, irradiances and visibilities do not.
- The flux of a light at infinity is that through the bounding disk of the scene, or through its portal.
- `lucerna verify` compares files with these columns, and names the likely mistake.
)";

}  // namespace

void write_overview(cli::Session& session, const std::vector<CaseSummary>& cases,
                    const std::string& directory, const PackOptions& options) {
  using Json = nlohmann::ordered_json;
  const auto info =
      session.value_or_fail(session.client().get_server_info({}, session.call_options()));
  Json manifest = {{"format", 1},
                   {"generator", "lucerna " LUCERNA_VERSION},
                   {"server", info.version()},
                   {"fingerprint", info.fingerprint().digest()},
                   {"samples", options.samples},
                   {"irradianceSamples", options.irradiance_samples},
                   {"seed", options.seed},
                   {"cases", Json::array()}};
  for (const CaseSummary& c : cases) {
    manifest["cases"].push_back({{"name", c.name},
                                 {"about", c.about},
                                 {"kind", c.kind},
                                 {"setting", c.extreme ? "extreme" : "ordinary"},
                                 {"scene", c.scene},
                                 {"rows",
                                  {{"samples", c.samples},
                                   {"densities", c.densities},
                                   {"emission", c.emission},
                                   {"irradiance", c.irradiances},
                                   {"visibility", c.visibilities}}}});
  }
  const std::filesystem::path root(directory);
  write_file((root / "manifest.json").string(), manifest.dump(1) + "\n");
  write_file((root / "README.md").string(), kReadme);
}

}  // namespace lucerna::conformance
