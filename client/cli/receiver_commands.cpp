// The commands visible and irradiance.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/irradiance_files.h"
#include "client/library/batch_parts.h"
#include "client/terminal/answer.h"
#include "client/terminal/certainty.h"
#include "client/terminal/method_options.h"
#include "client/terminal/output.h"
#include "client/terminal/point_options.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_option.h"
#include "client/terminal/time_option.h"
#include "client/terminal/validators.h"
#include "client/terminal/wavelengths.h"

namespace lucerna::cli {
namespace {

struct VisibleOptions {
  std::string scene;
  PointOptions points;
  TripleOption to, directions, normals;
  std::optional<double> length_m;
  std::optional<double> position_error_m;
  TimeOption time;
  ThinGlassOption thin_glass;
};

void visible(Session& session, const VisibleOptions& options) {
  const PointSet set = options.points.read();
  const std::size_t count = set.points.size();
  const bool rays = options.directions.given();
  if (rays && options.to.given()) wrong_use("--to and --direction: only one of them");
  if (options.length_m && !rays) wrong_use("--length: only with --direction");
  const std::vector<Double3> ends = rays                 ? options.directions.read(count)
                                    : options.to.given() ? options.to.read(count)
                                                         : set.seconds;
  if (ends.empty()) {
    wrong_use("no second points: give --to, --direction, or six columns in --points");
  }
  v1::TestVisibilityRequest request;
  if (rays) {
    *request.mutable_rays()->mutable_from() = client::make_points(set.points);
    fill(ends, request.mutable_rays()->mutable_directions());
    if (options.length_m) {
      request.mutable_rays()->mutable_lengths_m()->Resize(static_cast<int>(count),
                                                          static_cast<float>(*options.length_m));
    }
  } else {
    *request.mutable_segments()->mutable_from() = client::make_points(set.points);
    *request.mutable_segments()->mutable_to() = client::make_points(ends);
  }
  if (options.normals.given()) fill(options.normals.read(count), request.mutable_normals());
  if (options.position_error_m) {
    request.set_position_error_m(static_cast<float>(*options.position_error_m));
  }
  options.time.put(request);
  options.thin_glass.put(request);
  request.set_scene_id(session.query_scene_id(options.scene));
  send_and_print(session, request, client::test_visibility_in_batches,
                 [&](const v1::TestVisibilityResponse& response) {
                   std::vector<Table::Column> columns = {{"x [m]"},
                                                         {"y [m]"},
                                                         {"z [m]"},
                                                         {rays ? "direction" : "to [m]", true},
                                                         {"visible", true}};
                   const bool in_part = response.transmittance_size() > 0;
                   if (in_part) columns.push_back({"passes (RGB)", true});
                   Table table(columns);
                   for (std::size_t i = 0; i < response.count() && i < count; ++i) {
                     const auto& [x, y, z] = set.points[i];
                     const std::string status = item_status(response.status(), i);
                     std::vector<Cell> row = {number_cell(x), number_cell(y), number_cell(z),
                                              triple_cell(ends[i][0], ends[i][1], ends[i][2]),
                                              !status.empty()                      ? status
                                              : client::bit(response.visible(), i) ? "yes"
                                                                                   : "no"};
                     if (in_part) row.push_back(triple_cell_of(response.transmittance(), i));
                     table.add(std::move(row));
                   }
                   session.show(table, fmt::format("{}{}\n", describe(response.cost()),
                                                   describe_approximations(request.accuracy(),
                                                                           response.cost())));
                 });
}

struct IrradianceOptions {
  std::string scene;
  PointOptions points;
  TripleOption normals;
  std::optional<std::uint32_t> bounces;
  StopOption stop;
  std::uint64_t seed = 0;
  bool per_light = false;
  MethodOptions methods;
  TimeOption time;
  WavelengthOption wavelengths;
  IrradianceFilesOption files;
};

/// The column ± for item `i`.  `bound` is above 0 if all samples were zero.  A single
/// sample has no interval.
template <typename Answer>
Cell error_cell(const Answer& answer, int i, float bound, bool approximate) {
  if (bound > 0) return {fmt::format("< {}", number(bound)), {"0", fmt::format("{}", bound)}};
  if (i >= answer.upper_lx_size()) return {"unknown", {"", ""}};
  return interval_cell(answer.illuminance_lx(i), answer.lower_lx(i), answer.upper_lx(i),
                       approximate);
}

/// The same for the light of all lights together.
Cell total_error_cell(const v1::EstimateIrradianceResponse& response, int i, bool approximate) {
  if (!has_answer(response.status(), i)) return {};
  const bool open = item_status(response.status(), i) == "MAY_MISS_LIGHT" &&
                    unsampled_bound(response, i) == 0 && i < response.upper_lx_size();
  if (!open) return error_cell(response, i, response.zero_bound_lx(i), approximate);
  // Without a bound, the light that may be missing has no upper end.
  if (response.upper_lx(i) == response.lower_lx(i))
    return {"or more", {fmt::format("{}", response.lower_lx(i)), ""}};
  const Cell cell = error_cell(response, i, response.zero_bound_lx(i), approximate);
  return {cell.text() + " or more", cell.values()};
}

/// The same for the share of one light.
Cell share_error_cell(const v1::EstimateIrradianceResponse& response, const v1::LightShare& share,
                      int i, bool approximate) {
  if (!has_answer(response.status(), i)) return {};
  const Cell cell = error_cell(share, i, 0, approximate);
  if (item_status(response.status(), i) != "MAY_MISS_LIGHT") return cell;
  return {cell.text() == "exact" ? "or more" : cell.text() + " or more", cell.values()};
}

/// "1024 samples per point", if all points have equally many.
std::string samples_text(const v1::EstimateIrradianceResponse& response) {
  if (response.cost().samples() == 0) return "no samples taken";
  const auto points = static_cast<std::uint64_t>(response.illuminance_lx_size());
  return fmt::format(
      "{} samples per point{}", response.samples(),
      response.cost().samples() < response.samples() * points ? " that needed samples" : "");
}

void print_irradiance(const Session& session, const v1::EstimateIrradianceResponse& response,
                      const IlluminanceUnits& units, const PointSet& set,
                      const WavelengthOption& wavelengths, const StopOption& stop,
                      const v1::Accuracy& accuracy) {
  const bool approximate = is_approximate(accuracy);
  std::vector<Table::Column> columns = {{"x [m]"},
                                        {"y [m]"},
                                        {"z [m]"},
                                        {fmt::format("illuminance [{}]", units.sum)},
                                        interval_column(units.sum),
                                        {fmt::format("RGB [{}]", units.sum), true}};
  const bool by_target = response.has_item_costs();
  if (by_target) columns.insert(columns.end() - 1, {{"samples"}, {"rays"}, {"time [ms]"}});
  if (wavelengths.given()) columns.push_back(wavelengths.column("W/m2/nm"));
  columns.push_back({"", true});
  Table table(columns);
  for (int i = 0; i < response.illuminance_lx_size(); ++i) {
    const auto& [x, y, z] = set.points.at(i);
    const std::string status = item_status(response.status(), i);
    const auto& rgb = response.irradiance_lx();
    std::vector<Cell> row = {number_cell(x),
                             number_cell(y),
                             number_cell(z),
                             number_cell(response.illuminance_lx(i)),
                             total_error_cell(response, i, approximate),
                             triple_cell_of(rgb, i)};
    if (by_target) {
      const v1::ItemCosts& costs = response.item_costs();
      row.insert(row.end() - 1, {std::to_string(costs.samples(i)), std::to_string(costs.rays(i)),
                                 number_cell(1e3 * costs.time_s(i))});
    }
    if (wavelengths.given()) row.push_back(wavelengths.values(response.spectral_irradiance(), i));
    row.push_back(status);
    table.add(std::move(row));
  }
  // CSV is one table: of the lights if they are asked for.
  if (!session.csv() || response.shares_size() == 0) session.show(table);
  if (response.shares_size() > 0) {
    const bool mixed = units.sum == "mixed";
    columns = {{"light"},
               {"x [m]"},
               {"y [m]"},
               {"z [m]"},
               {mixed ? "share" : fmt::format("share [{}]", units.sum)},
               interval_column(units.sum)};
    if (mixed) columns.push_back({"unit", true});
    columns.push_back({"", true});
    Table shares(columns);
    for (const v1::LightShare& share : response.shares()) {
      for (int i = 0; i < share.illuminance_lx_size(); ++i) {
        const auto& [x, y, z] = set.points.at(i);
        std::vector<Cell> row = {std::to_string(share.light_id()),
                                 number_cell(x),
                                 number_cell(y),
                                 number_cell(z),
                                 number_cell(share.illuminance_lx(i)),
                                 share_error_cell(response, share, i, approximate)};
        if (mixed) row.emplace_back(units.lights.at(share.light_id()));
        row.emplace_back(item_status(response.status(), i));
        shares.add(std::move(row));
      }
    }
    if (!session.csv()) shell::print_text(stdout, "\n");
    session.show(shares);
  }
  if (session.csv()) return;
  shell::print_text(
      stdout, "{}± and < hold with {}% confidence; {}{}{}{}{}\n",
      by_target ? "" : samples_text(response) + "; ", percent(stop.confidence()),
      describe_inside(response.status()) + describe_missed(response),
      by_target ? check_target(response, response.item_costs().samples(), accuracy.target_error())
                      .describe("points")
                : "",
      describe_overrun(accuracy, response.cost(), response.samples(), "point"),
      describe(response.cost()), describe_approximations(accuracy, response.cost()));
}

void irradiance(Session& session, const IrradianceOptions& options) {
  v1::EstimateIrradianceRequest request;
  if (options.bounces) request.set_bounces(*options.bounces);
  request.set_per_light(options.per_light);
  request.mutable_seed()->set_seed(options.seed);
  options.stop.put(request);
  options.methods.put(request);
  options.time.put(request);
  options.wavelengths.put(request);
  if (options.files.given()) {
    if (options.stop.budget_s)
      wrong_use(
          "--budget: not with -o, whose points are sent in pieces that have no common time limit");
    return options.files.run(session, options.scene, options.points, options.normals, request);
  }
  options.files.check();
  const PointSet set = options.points.read();
  const std::vector<Double3> normals =
      options.normals.given() ? options.normals.read(set.points.size()) : set.seconds;
  if (normals.empty()) wrong_use("no normals: give --normal, or six columns in --points");
  *request.mutable_receivers() = client::make_points(set.points);
  fill(normals, request.mutable_normals());
  request.set_scene_id(session.query_scene_id(options.scene));
  const v1::Accuracy& accuracy = request.accuracy();
  using Response = v1::EstimateIrradianceResponse;
  send_and_print<v1::EstimateIrradianceRequest, Response>(
      session, request, client::estimate_irradiance_in_batches,
      [&](const Response& response) {
        print_irradiance(session, response, illuminance_units(session, request.scene_id()), set,
                         options.wavelengths, options.stop, accuracy);
      },
      [&](const Response& response) {
        std::string more = json_of_approximate(accuracy);
        if (!response.has_item_costs()) return more;
        std::vector<bool> reached;
        check_target(response, response.item_costs().samples(), accuracy.target_error(), &reached);
        return more + "," + json_of("reached", reached);
      });
}

}  // namespace

void add_receiver_commands(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("visible", "Test whether anything is between two points, or along a ray");
  command->footer(
      "Example:\n  lucerna visible room.pbrt --point 0,0,0 --to 1,2,2.5\n"
      "  lucerna visible room.pbrt --point 0,0,0 --direction 0,0,1 --length 10");
  const auto looking = std::make_shared<VisibleOptions>();
  command->add_option("SCENE", looking->scene, kSceneHelp)->required();
  looking->points.add(*command, "second points, as --to");
  looking->to.add(*command, "--to", "Second point x,y,z [m]", Triple::kPoint);
  looking->directions.add(*command, "--direction", "Direction x,y,z of the ray");
  command
      ->add_option("--length", looking->length_m,
                   "With --direction: length of the ray [m]; default: infinite")
      ->check(positive());
  looking->normals.add(*command, "--normal", "Surface normal x,y,z at the point");
  command
      ->add_option("--position-error", looking->position_error_m,
                   "Largest error of each coordinate [m]; default: a few units in the last place")
      ->check(not_negative());
  looking->time.add(*command);
  looking->thin_glass.add(*command);
  session.prints_table(*command);
  command->callback([looking, &session] { visible(session, *looking); });

  command = app.add_subcommand("irradiance", "Print the light that arrives on small surfaces");
  command->footer(
      "Example:\n  lucerna irradiance room.pbrt --point 0,0,0.8 --normal 0,0,1 --samples 1024\n"
      "  lucerna irradiance room.pbrt --points desks.csv --error 1%\n"
      "  lucerna irradiance room.pbrt --points desks.csv --bounces 0 --per-light\n"
      "  lucerna irradiance room.pbrt --points desks.csv --bounces 0 --wavelength 450,555\n"
      "  lucerna irradiance room.pbrt --points baked.exr -o light.exr --servers a:50051,b:50051\n"
      "A row of an .npy file has float32 numbers: illuminance, R, G, B, standard error, zero "
      "bound,\n"
      "status, both ends of the interval; with --error also samples.\n"
      "--json prints EstimateIrradianceResponse and `approximate`, whether you chose an\n"
      "approximation (--far-light, --visibility shadow-maps, --thin-glass blocks); with --error "
      "also\n"
      "`reached`,\n"
      "whether each point met the target.");
  const auto meter = std::make_shared<IrradianceOptions>();
  command->add_option("SCENE", meter->scene, kSceneHelp)->required();
  meter->points.add(*command, "normals");
  meter->normals.add(*command, "--normal", "Surface normal x,y,z of any length");
  command
      ->add_option("--bounces", meter->bounces,
                   "Most reflections of the light, 0 for direct light; default: no limit")
      ->check(whole(0));
  meter->stop.add(*command, "point", "256", "lx");
  command->add_option("--seed", meter->seed, "Random seed of the experiment")
      ->check(whole64())
      ->capture_default_str();
  command->add_flag("--per-light", meter->per_light,
                    "Also print the light of each lamp, directly and by way of mirrors and panes");
  meter->methods.add(*command);
  meter->time.add(*command);
  meter->wavelengths.add(*command);
  meter->files.add(*command);
  session.prints_table(*command);
  command->callback([meter, &session] { irradiance(session, *meter); });
}

}  // namespace lucerna::cli
