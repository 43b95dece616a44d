// le.
#include <fmt/core.h>

#include <memory>

#include "client/batches.h"
#include "client/cli/output.h"
#include "client/cli/points.h"
#include "client/cli/session.h"
#include "client/cli/validators.h"

namespace lucerna::cli {
namespace {

struct LeOptions {
  std::string scene;
  PointOptions points;
  TripleOption directions;
  std::optional<std::uint64_t> light;
};

void le(Session& session, const LeOptions& options) {
  const PointSet set = options.points.read();
  const std::vector<Double3> directions =
      options.directions.given() ? options.directions.read(set.points.size()) : set.seconds;
  if (directions.empty()) wrong_use("no directions: give --direction, or six columns in --points");
  v1::LeRequest request;
  *request.mutable_points() = client::make_points(set.points);
  fill(directions, request.mutable_directions());
  if (options.light) request.set_light_id(*options.light);
  request.set_scene_id(session.scene_id(options.scene));
  const auto response = session.ask(client::le_in_batches(
      session.client(), request, {.max_items = 0, .call = session.call_options()}));
  if (session.json()) {
    fmt::print("{}", to_json(response));
  } else {
    Table table({{"x [m]"},
                 {"y [m]"},
                 {"z [m]"},
                 {"direction", true},
                 {"radiance (RGB) [cd/m2]", true},
                 {"light"},
                 {"", true}});
    const auto& rgb = response.radiance_cd_m2();
    for (int i = 0; i < response.light_ids_size() && 3 * i + 2 < rgb.size(); ++i) {
      const auto& [x, y, z] = set.points.at(i);
      const auto& [wx, wy, wz] = directions.at(i);
      const std::uint64_t light = response.light_ids(i);
      table.add({number(x), number(y), number(z), triple(wx, wy, wz),
                 triple(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]),
                 light == 0 ? "none" : std::to_string(light), item_status(response.status(), i)});
    }
    fmt::print("{}", table.to_string());
  }
  if (any_failed(response.status())) session.set_exit_status(kServerSaidNo);
}

}  // namespace

void add_emission_commands(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("le", "Radiance of the lights that rays meet, or of the sky (Le)");
  command->footer(
      "Example:\n  lucerna le room.pbrt --point 0,0,1.2 --direction 0,0.3,1\n"
      "  lucerna le room.pbrt --points rays.csv --light 2");
  const auto looking = std::make_shared<LeOptions>();
  command->add_option("SCENE", looking->scene, "Path or id")->required();
  looking->points.add(*command, "directions");
  looking->directions.add(*command, "--direction", "The ray's direction x,y,z");
  command->add_option("--light", looking->light, "Id of the only light to tell of; default: any")
      ->check(whole(1));
  command->callback([looking, &session] { le(session, *looking); });
}

}  // namespace lucerna::cli
