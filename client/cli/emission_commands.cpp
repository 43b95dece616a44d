// The commands emit, emit-pdf and le.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/terminal/answer.h"
#include "client/terminal/certainty.h"
#include "client/terminal/light_option.h"
#include "client/terminal/method_options.h"
#include "client/terminal/output.h"
#include "client/terminal/point_options.h"
#include "client/terminal/session.h"
#include "client/terminal/time_option.h"
#include "client/terminal/validators.h"
#include "client/terminal/wavelengths.h"

namespace lucerna::cli {
namespace {

struct LeOptions {
  std::string scene;
  PointOptions points;
  TripleOption directions;
  LightOption light;
  TimeOption time;
  WavelengthOption wavelengths;
  ThinGlassOption thin_glass;
};

void le(Session& session, const LeOptions& options) {
  const PointSet set = options.points.read();
  const std::vector<Double3> directions = read_directions(options.directions, set);
  v1::LeRequest request;
  *request.mutable_points() = client::make_points(set.points);
  fill(directions, request.mutable_directions());
  options.light.put(request);
  options.time.put(request);
  options.wavelengths.put(request);
  options.thin_glass.put(request);
  request.set_scene_id(session.query_scene_id(options.scene));
  send_and_print(session, request, client::le_in_batches, [&](const v1::LeResponse& response) {
    std::vector<Table::Column> columns = {
        {"x [m]"}, {"y [m]"}, {"z [m]"}, {"direction", true}, {"radiance (RGB) [cd/m2]", true}};
    if (options.wavelengths.given()) {
      columns.push_back(options.wavelengths.column("W/m2/sr/nm"));
    }
    columns.insert(columns.end(), {{"light"}, {"", true}});
    Table table(columns);
    const auto& rgb = response.radiance_cd_m2();
    for (int i = 0; i < response.light_ids_size() && 3 * i + 2 < rgb.size(); ++i) {
      const auto& [x, y, z] = set.points.at(i);
      const auto& [wx, wy, wz] = directions.at(i);
      const std::uint64_t light = response.light_ids(i);
      std::vector<Cell> row = {number_cell(x), number_cell(y), number_cell(z),
                               triple_cell(wx, wy, wz),
                               triple_cell(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2])};
      if (options.wavelengths.given()) {
        row.push_back(options.wavelengths.values(response.spectral_radiance(), i));
      }
      row.push_back(light == 0 ? "none" : std::to_string(light));
      row.push_back(item_status(response.status(), i));
      table.add(std::move(row));
    }
    session.show(table, fmt::format("{}{}\n", describe(response.cost()),
                                    describe_approximations(request.accuracy(), response.cost())));
  });
}

struct EmitOptions {
  std::string scene;
  LightOption light;
  std::uint32_t count = 1;
  std::uint64_t seed = 0;
  std::vector<std::string> u;
  TimeOption time;
  WavelengthOption wavelengths;
};

/// From "u1,u2,u3,u4" with --light and "u1,u2,u3,u4,u_light" without it.
v1::SampleValues sample_values(const EmitOptions& options) {
  v1::SampleValues values;
  for (const std::string& text : options.u) {
    const auto u = parse_sample_values(text, 4, !options.light.given());
    if (!u.ok()) wrong_use("--u " + std::string(u.status().message()));
    for (std::size_t i = 0; i < 4; ++i) values.add_u(static_cast<float>((*u)[i]));
    if (!options.light.given()) values.add_u_light((*u)[4]);
  }
  return values;
}

/// Unit of the value: luminance [cd/m2] of a surface, intensity [cd] of a point, illuminance [lx]
/// of a distant light.
const char* unit_of(bool has_normal, float pdf_position, float pdf_direction) {
  if (has_normal) return "cd/m2";
  if (pdf_position == 0) return "cd";
  return pdf_direction == 0 ? "lx" : "cd/m2";
}

std::string spectral_unit_of(bool has_normal, float pdf_position, float pdf_direction) {
  const std::string unit = unit_of(has_normal, pdf_position, pdf_direction);
  if (unit == "cd") return "W/sr/nm";
  return unit == "lx" ? "W/m2/nm" : "W/m2/sr/nm";
}

void print_rays(const Session& session, const v1::SampleLeResponse& response,
                const EmitOptions& options) {
  std::vector<Table::Column> columns = {{"light"}};
  if (!options.light.given()) columns.push_back({"chosen with"});
  columns.insert(columns.end(), {{"from [m]", true},
                                 {"direction", true},
                                 {"value (RGB)", true},
                                 {"unit", true},
                                 {"pdf [1/m2]"},
                                 {"pdf [1/sr]"}});
  if (options.wavelengths.given()) {
    columns.insert(columns.end(),
                   {options.wavelengths.column(), {"unit", true, {"spectral unit"}}});
  }
  columns.push_back({"", true});
  Table table(columns);
  const v1::Vector3& origin = response.points().origin_m();
  const auto at = [](const google::protobuf::RepeatedField<float>& v, int i) {
    return i < v.size() ? v[i] : 0.0F;
  };
  const auto three = [&](const google::protobuf::RepeatedField<float>& v, int i) {
    return triple_cell(at(v, 3 * i), at(v, 3 * i + 1), at(v, 3 * i + 2));
  };
  for (int i = 0; i < response.pdf_direction_per_sr_size(); ++i) {
    const auto& offsets = response.points().offsets_m();
    const auto& normals = response.light_normals();
    const float position = at(response.pdf_position_per_m2(), i);
    const float direction = at(response.pdf_direction_per_sr(), i);
    const std::string status = item_status(response.status(), i);
    std::vector<Cell> row = {
        options.light.given()
            ? options.light.word()
            : std::to_string(i < response.light_ids_size() ? response.light_ids(i) : 0)};
    if (!options.light.given()) {
      row.push_back(number_cell(
          i < response.selection_probability_size() ? response.selection_probability(i) : 0.0));
    }
    if (status.empty()) {
      const bool surface =
          at(normals, 3 * i) != 0 || at(normals, 3 * i + 1) != 0 || at(normals, 3 * i + 2) != 0;
      // The wire holds floats, so the sum has no more digits than a float.
      row.push_back(triple_cell(static_cast<float>(origin.x() + at(offsets, 3 * i)),
                                static_cast<float>(origin.y() + at(offsets, 3 * i + 1)),
                                static_cast<float>(origin.z() + at(offsets, 3 * i + 2))));
      row.push_back(three(response.directions(), i));
      row.push_back(three(response.value(), i));
      row.emplace_back(unit_of(surface, position, direction));
      row.push_back(position == 0 ? Cell("certain") : number_cell(position));
      row.push_back(direction == 0 ? Cell("certain") : number_cell(direction));
      if (options.wavelengths.given()) {
        row.push_back(options.wavelengths.values(response.spectral_value(), i));
        row.push_back(spectral_unit_of(surface, position, direction));
      }
    } else {
      row.resize(columns.size() - 1);
    }
    row.push_back(status);
    table.add(std::move(row));
  }
  session.show(table, describe(response.cost()) + "\n");
}

void emit(Session& session, const EmitOptions& options) {
  v1::SampleLeRequest request;
  options.light.put(request);
  options.time.put(request);
  request.set_count(options.count);
  if (options.u.empty()) {
    request.mutable_seed()->set_seed(options.seed);
  } else {
    if (options.count != 1) wrong_use("--u and --count: only one of them");
    *request.mutable_u() = sample_values(options);
    request.set_count(static_cast<std::uint32_t>(options.u.size()));
  }
  options.wavelengths.put(request);
  request.set_scene_id(session.query_scene_id(options.scene));
  send_and_print(
      session, request, client::sample_le_in_batches,
      [&](const v1::SampleLeResponse& response) { print_rays(session, response, options); });
}

struct EmitPdfOptions {
  std::string scene;
  PointOptions points;
  TripleOption directions;
  LightOption light;
  TimeOption time;
};

void emit_pdf(Session& session, const EmitPdfOptions& options) {
  const PointSet set = options.points.read();
  const std::vector<Double3> directions = read_directions(options.directions, set);
  v1::PdfLeRequest request;
  *request.mutable_points() = client::make_points(set.points);
  fill(directions, request.mutable_directions());
  options.light.put(request);
  options.time.put(request);
  request.set_scene_id(session.query_scene_id(options.scene));
  send_and_print(
      session, request, client::pdf_le_in_batches, [&](const v1::PdfLeResponse& response) {
        Table table({{"x [m]"},
                     {"y [m]"},
                     {"z [m]"},
                     {"direction", true},
                     {"pdf [1/m2]"},
                     {"pdf [1/sr]"},
                     {"", true}});
        for (int i = 0;
             i < response.pdf_direction_per_sr_size() && i < response.pdf_position_per_m2_size();
             ++i) {
          const auto& [x, y, z] = set.points.at(i);
          const auto& [wx, wy, wz] = directions.at(i);
          table.add({number_cell(x), number_cell(y), number_cell(z), triple_cell(wx, wy, wz),
                     number_cell(response.pdf_position_per_m2(i)),
                     number_cell(response.pdf_direction_per_sr(i)),
                     item_status(response.status(), i)});
        }
        session.show(table, describe(response.cost()) + "\n");
      });
}

}  // namespace

void add_emission_commands(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("emit", "Sample rays that leave lights (SampleLe)");
  command->footer("Example:\n  lucerna emit room.pbrt --light 1 --count 4");
  const auto emission = std::make_shared<EmitOptions>();
  command->add_option("SCENE", emission->scene, kSceneHelp)->required();
  emission->light.add(*command,
                      "Id or name of the light; default: choose one for each ray by its power");
  command->add_option("--count", emission->count, "Number of rays")
      ->check(whole(1))
      ->capture_default_str();
  command->add_option("--seed", emission->seed, "Random seed of the experiment")
      ->check(whole64())
      ->capture_default_str();
  command
      ->add_option(
          "--u", emission->u,
          "Your own sample values, once for each ray: u1,u2 for the position and u3,u4 for "
          "the direction; without --light a fifth, u_light")
      ->allow_extra_args(false)
      ->excludes("--seed");
  emission->time.add(*command);
  emission->wavelengths.add(*command);
  session.prints_table(*command);
  command->callback([emission, &session] { emit(session, *emission); });

  command =
      app.add_subcommand("emit-pdf", "Print the densities with which `emit` chooses rays (PdfLe)");
  command->footer(
      "Example:\n  lucerna emit-pdf room.pbrt --light 2 --point 0,0,2.7 --direction 0,0,-1");
  const auto density = std::make_shared<EmitPdfOptions>();
  command->add_option("SCENE", density->scene, kSceneHelp)->required();
  density->points.add(*command, "directions");
  density->directions.add(*command, "--direction",
                          "Direction x,y,z of the ray, away from the light");
  density->light.add(*command, "Id or name of the light")->required();
  density->time.add(*command);
  session.prints_table(*command);
  command->callback([density, &session] { emit_pdf(session, *density); });

  command = app.add_subcommand(
      "le", "Print the radiance of the lights that rays meet, or of the sky (Le)");
  command->footer(
      "Example:\n  lucerna le room.pbrt --point 0,0,1.2 --direction 0,0.3,1\n"
      "  lucerna le room.pbrt --points rays.csv --light 2");
  const auto looking = std::make_shared<LeOptions>();
  command->add_option("SCENE", looking->scene, kSceneHelp)->required();
  looking->points.add(*command, "directions");
  looking->directions.add(*command, "--direction", "Direction x,y,z of the ray");
  looking->light.add(*command, "Id or name of the light; default: all lights");
  looking->time.add(*command);
  looking->wavelengths.add(*command);
  looking->thin_glass.add(*command);
  session.prints_table(*command);
  command->callback([looking, &session] { le(session, *looking); });
}

}  // namespace lucerna::cli
