// The commands sample and pdf.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "client/cli/commands.h"
#include "client/library/batch_parts.h"
#include "client/terminal/answer.h"
#include "client/terminal/certainty.h"
#include "client/terminal/light_option.h"
#include "client/terminal/method_options.h"
#include "client/terminal/output.h"
#include "client/terminal/point_options.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_option.h"
#include "client/terminal/time_option.h"
#include "client/terminal/validators.h"
#include "client/terminal/wavelengths.h"

namespace lucerna::cli {
namespace {

struct SampleOptions {
  std::string scene;
  PointOptions points;
  TripleOption normals;
  LightOption light;
  std::uint64_t seed = 0;
  std::vector<std::string> u;
  StopOption stop;
  bool visibility = false;
  SampleMethodOptions methods;
  TimeOption time;
  WavelengthOption wavelengths;
};

/// From "u1,u2" with --light and "u1,u2,u_light" without it; one text for all points, or one for
/// each.
v1::SampleValues sample_values(const SampleOptions& options, std::size_t points) {
  if (options.stop.samples.value_or(1) != 1) wrong_use("--u and --samples: only one of them");
  if (options.stop.error) wrong_use("--u and --error: only one of them");
  if (options.stop.budget_s) wrong_use("--u and --budget: only one of them");
  if (options.u.size() != 1 && options.u.size() != points) {
    wrong_use(fmt::format("--u: given {} times for {} points, must be once or once for each",
                          options.u.size(), points));
  }
  v1::SampleValues values;
  for (std::size_t i = 0; i < points; ++i) {
    const std::string& text = options.u.size() == 1 ? options.u[0] : options.u[i];
    const auto u = parse_sample_values(text, 2, !options.light.given());
    if (!u.ok()) wrong_use("--u " + std::string(u.status().message()));
    values.add_u(static_cast<float>((*u)[0]));
    values.add_u(static_cast<float>((*u)[1]));
    if (!options.light.given()) values.add_u_light((*u)[2]);
  }
  return values;
}

void print_samples(const Session& session, const v1::SampleLiResponse& response,
                   const SampleOptions& options, const v1::Accuracy& accuracy) {
  const std::uint32_t samples = options.stop.samples.value_or(1);
  std::vector<Table::Column> columns = {{"point"}, {"light"}};
  if (!options.light.given()) columns.push_back({"chosen with"});
  columns.insert(columns.end(),
                 {{"value (RGB)"}, {"unit", true}, {"wi", true}, {"distance [m]"}, {"pdf [1/sr]"}});
  if (options.wavelengths.given()) {
    columns.insert(columns.end(),
                   {options.wavelengths.column(), {"unit", true, {"spectral unit"}}});
  }
  if (options.visibility) columns.push_back({"visible", true});
  const bool in_part = response.transmittance_size() > 0;
  if (in_part) columns.push_back({"passes (RGB)", true});
  columns.push_back({"", true});
  Table table(columns);
  for (int i = 0; i < response.pdf_per_sr_size(); ++i) {
    const bool delta = client::bit(response.delta(), i);
    std::vector<Cell> row = {std::to_string(i / samples + 1)};
    row.push_back(options.light.given()
                      ? options.light.word()
                      : std::to_string(i < response.light_ids_size() ? response.light_ids(i) : 0));
    if (!options.light.given()) {
      row.push_back(number_cell(
          i < response.selection_probability_size() ? response.selection_probability(i) : 0.0));
    }
    row.push_back(triple_cell_of(response.value(), i));
    row.emplace_back(delta ? "lx" : "cd/m2");
    row.push_back(triple_cell_of(response.wi(), i));
    const float distance = i < response.distance_m_size() ? response.distance_m(i) : 0;
    const std::string status = item_status(response.status(), i);
    row.push_back(distance == 0 && status.empty() ? Cell("infinite") : number_cell(distance));
    row.push_back(delta ? Cell("delta") : number_cell(response.pdf_per_sr(i)));
    if (options.wavelengths.given()) {
      row.push_back(options.wavelengths.values(response.spectral_value(), i));
      row.emplace_back(delta ? "W/m2/nm" : "W/m2/sr/nm");
    }
    if (options.visibility) row.emplace_back(client::bit(response.visible(), i) ? "yes" : "no");
    if (in_part) row.push_back(triple_cell_of(response.transmittance(), i));
    row.push_back(status);
    table.add(std::move(row));
  }
  session.show(table, fmt::format("{}{}\n", describe(response.cost()),
                                  describe_approximations(accuracy, response.cost())));
}

std::uint64_t most_samples(const v1::ReceiverEstimates& estimates) {
  const auto& samples = estimates.samples();
  return samples.empty() ? 0 : *std::max_element(samples.begin(), samples.end());
}

/// The estimate of each point.
void print_estimates(const Session& session, const v1::SampleLiResponse& response,
                     const std::string& unit, const SampleOptions& options, const PointSet& set,
                     const v1::SampleLiRequest& request) {
  const v1::Accuracy& accuracy = request.accuracy();
  const v1::ReceiverEstimates& estimates = response.estimates();
  const bool on_surfaces = request.normals_size() > 0;
  std::vector<Table::Column> columns = {
      {"x [m]"},
      {"y [m]"},
      {"z [m]"},
      {fmt::format("{} [{}]", on_surfaces ? "illuminance" : "spherical illuminance", unit)},
      interval_column(unit),
      {"samples"}};
  if (options.wavelengths.given()) columns.push_back(options.wavelengths.column("W/m2/nm"));
  columns.push_back({"", true});
  Table table(columns);
  for (int i = 0; i < estimates.samples_size(); ++i) {
    const auto& [x, y, z] = set.points.at(i);
    const std::string status = item_status(estimates.status(), i);
    // Several equal samples may all have missed a light, so their interval is not exact.
    const bool approximate = is_approximate(accuracy) || estimates.samples(i) > 1;
    const Cell error = status.empty()
                           ? interval_cell(estimates.illuminance_lx(i), estimates.lower_lx(i),
                                           estimates.upper_lx(i), approximate)
                           : Cell();
    std::vector<Cell> row = {number_cell(x), number_cell(y),
                             number_cell(z), number_cell(estimates.illuminance_lx(i)),
                             error,          std::to_string(estimates.samples(i))};
    if (options.wavelengths.given())
      row.push_back(options.wavelengths.values(estimates.spectral_irradiance(), i));
    row.push_back(status);
    table.add(std::move(row));
  }
  session.show(
      table,
      fmt::format(
          "± and < hold with {}% confidence, of {}; {}{}{}{}\n", percent(options.stop.confidence()),
          options.visibility ? "visible lights" : "unoccluded lights (--visible tests visibility)",
          accuracy.has_target_error()
              ? check_target(estimates, estimates.samples(), accuracy.target_error())
                    .describe("points")
              : "",
          describe_overrun(accuracy, response.cost(), most_samples(estimates), "point"),
          describe(response.cost()), describe_approximations(accuracy, response.cost())));
}

void sample(Session& session, const SampleOptions& options) {
  const PointSet set = options.points.read();
  v1::SampleLiRequest request;
  *request.mutable_receivers() = client::make_points(set.points);
  options.light.put(request);
  if (options.u.empty()) {
    request.mutable_seed()->set_seed(options.seed);
  } else {
    *request.mutable_u() = sample_values(options, set.points.size());
  }
  request.set_test_visibility(options.visibility);
  fill(options.normals.given() ? options.normals.read(set.points.size()) : set.seconds,
       request.mutable_normals());
  options.stop.put(request);
  options.methods.put(request);
  options.time.put(request);
  options.wavelengths.put(request);
  request.set_scene_id(session.query_scene_id(options.scene));
  const v1::Accuracy& accuracy = request.accuracy();
  using Response = v1::SampleLiResponse;
  send_and_print<v1::SampleLiRequest, Response>(
      session, request, client::sample_li_in_batches,
      [&](const Response& response) {
        if (response.has_estimates()) {
          print_estimates(session, response, illuminance_units(session, request.scene_id()).sum,
                          options, set, request);
        } else {
          print_samples(session, response, options, accuracy);
        }
      },
      [&](const Response& response) {
        std::string more = json_of_approximate(accuracy);
        if (!accuracy.has_target_error()) return more;
        std::vector<bool> reached;
        check_target(response.estimates(), response.estimates().samples(), accuracy.target_error(),
                     &reached);
        return more + "," + json_of("reached", reached);
      });
}

struct PdfOptions {
  std::string scene;
  PointOptions points;
  TripleOption directions, normals;
  AreaSamplingOption area_sampling;
  TimeOption time;
  LightOption light;
};

void pdf(Session& session, const PdfOptions& options) {
  const PointSet set = options.points.read();
  const std::vector<Double3> directions = read_directions(options.directions, set);
  v1::PdfLiRequest request;
  *request.mutable_receivers() = client::make_points(set.points);
  fill(directions, request.mutable_wi());
  if (options.normals.given()) {
    fill(options.normals.read(set.points.size()), request.mutable_normals());
  }
  options.area_sampling.put(request);
  options.time.put(request);
  options.light.put(request);
  request.set_scene_id(session.query_scene_id(options.scene));
  send_and_print(
      session, request, client::pdf_li_in_batches, [&](const v1::PdfLiResponse& response) {
        Table table({{"x [m]"}, {"y [m]"}, {"z [m]"}, {"wi", true}, {"pdf [1/sr]"}, {"", true}});
        for (int i = 0; i < response.pdf_per_sr_size(); ++i) {
          const auto& [x, y, z] = set.points.at(i);
          const auto& [wx, wy, wz] = directions.at(i);
          table.add({number_cell(x), number_cell(y), number_cell(z), triple_cell(wx, wy, wz),
                     number_cell(response.pdf_per_sr(i)), item_status(response.status(), i)});
        }
        session.show(table, describe(response.cost()) + "\n");
      });
}

}  // namespace

void add_light_commands(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("sample", "Sample the light that arrives at points (SampleLi)");
  command->footer(
      "Example:\n  lucerna sample room.pbrt --point 0,0,0 --light 1 --samples 4 --visible\n"
      "  lucerna sample room.pbrt --points desks.csv --visible --error 1% --max-samples 4096");
  const auto sampling = std::make_shared<SampleOptions>();
  command->add_option("SCENE", sampling->scene, kSceneHelp)->required();
  sampling->points.add(*command, "normals");
  sampling->light.add(*command, "Id or name of the light; default: choose one for each sample");
  command->add_option("--seed", sampling->seed, "Random seed of the experiment")
      ->check(whole64())
      ->capture_default_str();
  command
      ->add_option(
          "--u", sampling->u,
          "Your own sample values: u1,u2 with --light, u1,u2,u_light without; once for all "
          "points, or once for each")
      ->allow_extra_args(false)
      ->excludes("--seed");
  sampling->stop.add(*command, "point", "1; --error and --budget print an estimate for each point",
                     "lx");
  command->add_flag("--visible", sampling->visibility,
                    "Also test whether the light is visible from the point");
  sampling->normals.add(*command, "--normal", "Surface normal x,y,z at the point");
  sampling->methods.add(*command);
  sampling->time.add(*command);
  sampling->wavelengths.add(*command);
  session.prints_table(*command);
  command->callback([sampling, &session] { sample(session, *sampling); });

  command =
      app.add_subcommand("pdf", "Print the density with which `sample` chooses directions (PdfLi)");
  command->footer("Example:\n  lucerna pdf room.pbrt --light 2 --point 0,0,0 --direction 0,0,1");
  const auto density = std::make_shared<PdfOptions>();
  command->add_option("SCENE", density->scene, kSceneHelp)->required();
  density->points.add(*command, "directions");
  density->directions.add(*command, "--direction", "Direction x,y,z from the point");
  density->light.add(*command, "Id or name of the light")->required();
  density->normals.add(*command, "--normal", "Surface normal x,y,z at the point");
  density->area_sampling.add(*command);
  density->time.add(*command);
  session.prints_table(*command);
  command->callback([density, &session] { pdf(session, *density); });
}

}  // namespace lucerna::cli
