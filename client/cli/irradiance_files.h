// irradiance -o: reads points from files of any length and writes the results to a file.
#pragma once

#include <string>
#include <vector>

#include "client/cli/render_servers.h"
#include "client/terminal/point_options.h"
#include "client/terminal/session.h"
#include "lucerna/v1/lighting.pb.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

class IrradianceFilesOption {
 public:
  void add(CLI::App& command);
  bool given() const { return !output_.empty(); }
  /// Ends the program if an option that needs -o is given without it.
  void check() const;

  /// Sends `request` for the receivers of `points` and writes the answers.  `normal` is for all
  /// receivers if the files have no normals.
  void run(Session& session, const std::string& scene, const PointOptions& points,
           const TripleOption& normal, const v1::EstimateIrradianceRequest& request) const;

 private:
  std::string output_, normals_;
  ServersOption servers_;
};

}  // namespace lucerna::cli
