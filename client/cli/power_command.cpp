// The command power.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/light_table.h"
#include "client/library/pages.h"
#include "client/terminal/certainty.h"
#include "client/terminal/light_option.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_option.h"
#include "client/terminal/validators.h"
#include "client/terminal/wavelengths.h"

namespace lucerna::cli {
namespace {

struct PowerOptions {
  std::string scene;
  std::vector<std::string> lights;  ///< ids and names
  std::string method = "exact";
  StopOption stop;
  std::uint64_t seed = 0;
  WavelengthOption wavelengths;
};

/// All pages.  The total of every page counts all lights.
v1::EstimatePowerResponse all_powers(Session& session, const v1::EstimatePowerRequest& powers) {
  return session.query_scene([&](const client::Client& client) {
    return client::all_pages(powers, [&](v1::EstimatePowerRequest& request) {
      auto page = client.estimate_power(request, session.call_options());
      // The time budget is for the first page.  The other pages take as many samples, so all share
      // one total.
      if (page.ok() && request.accuracy().has_time_budget_s() && page->lights_size() > 0)
        request.mutable_accuracy()->set_samples(
            static_cast<std::uint32_t>(page->lights(0).samples()));
      return page;
    });
  });
}

/// Half the interval of a sampled flux.
Cell flux_interval_cell(const v1::LightPower& light) {
  if (!light.has_upper_lm()) return "unknown";
  return number_cell((light.upper_lm() - light.lower_lm()) / 2);
}

void power(Session& session, const PowerOptions& options) {
  v1::EstimatePowerRequest request;
  request.set_scene_id(session.query_scene_id(options.scene));
  for (const std::string& word : options.lights) {
    if (const std::uint64_t id = light_id_of(word); id != 0) {
      request.add_light_ids(id);
    } else {
      request.add_light_names(word);
    }
  }
  if (options.method == "approximate") {
    request.set_method(v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  }
  const bool sampled = options.method == "sampled";
  if (sampled) {
    request.set_method(v1::EstimatePowerRequest::METHOD_SAMPLED);
    request.set_seed(options.seed);
    options.stop.put(request);
  } else if (options.stop.samples || options.stop.error || options.stop.budget_s) {
    wrong_use("--samples, --error and --budget require --method sampled");
  }
  options.wavelengths.put(request);
  const v1::EstimatePowerResponse response = all_powers(session, request);
  const auto& target = request.accuracy().target_error();
  TargetCheck check(target);
  std::vector<bool> reached;
  if (request.accuracy().has_target_error()) {
    for (const v1::LightPower& light : response.lights())
      reached.push_back(check.add(light.power_lm(), light.lower_lm(), light.upper_lm(),
                                  light.samples() + kDefaultBlocks));
  }
  if (session.json()) {
    shell::print_text(stdout, "{}",
                      to_json(response, reached.empty() ? "" : json_of("reached", reached)));
    return;
  }
  std::map<std::uint64_t, const v1::Light*> by_id;
  const v1::ListLightsResponse lights = list_lights(session, request.scene_id());
  for (const v1::Light& light : lights.lights()) by_id[light.id()] = &light;
  const bool watts = std::any_of(response.lights().begin(), response.lights().end(),
                                 [](const v1::LightPower& light) { return light.has_power_w(); });
  const std::string in_lumens = lumens_header(response.lights());
  std::vector<Table::Column> columns = {
      {"id"}, {"type", true}, {"flux" + in_lumens}, {"±" + in_lumens}};
  if (in_lumens.empty()) columns.push_back({"unit", true});
  if (sampled) columns.push_back({"samples"});
  if (watts) columns.push_back({"flux [W]"});
  columns.push_back({"RGB" + in_lumens, true});
  if (options.wavelengths.given()) columns.push_back(options.wavelengths.column("W/nm"));
  Table table(columns);
  const auto add = [&](const std::string& id, const std::string& type, const v1::LightPower& light,
                       bool from_infinity) {
    const v1::Rgb& rgb = light.rgb_lm();
    std::vector<Cell> row = {id, type, flux_cell(light.power_lm(), from_infinity),
                             sampled ? flux_interval_cell(light) : error_cell(light.error_lm())};
    if (in_lumens.empty()) row.push_back(flux_unit(light));
    if (sampled) row.push_back(std::to_string(light.samples()));
    if (watts) row.push_back(light.has_power_w() ? number_cell(light.power_w()) : Cell("unknown"));
    row.push_back(triple_cell(rgb.r(), rgb.g(), rgb.b()));
    if (options.wavelengths.given()) {
      row.push_back(options.wavelengths.values(light.spectral_w_per_nm(), 0));
    }
    table.add(std::move(row));
  };
  bool any_from_infinity = false;
  for (const v1::LightPower& power : response.lights()) {
    const auto light = by_id.find(power.light_id());
    const bool known = light != by_id.end();
    const bool from_infinity = known && is_at_infinity(*light->second);
    any_from_infinity |= from_infinity;
    add(std::to_string(power.light_id()), known ? type_of(*light->second) : "", power,
        from_infinity);
  }
  add("all", "", response.total(), any_from_infinity);
  session.show(table);
  if (session.csv()) return;
  if (any_from_infinity) shell::print_text(stdout, "{}; \"all\" includes it\n", kFluxFromInfinity);
  if (sampled) {
    std::uint64_t most = 0;
    for (const v1::LightPower& light : response.lights()) most = std::max(most, light.samples());
    shell::print_text(stdout, "± holds with {}% confidence; {}{}{}\n",
                      percent(options.stop.confidence()), check.describe("lights"),
                      describe_overrun(request.accuracy(), response.cost(), most, "light"),
                      describe(response.cost()));
  }
  session.print_remarks();
}

}  // namespace

void add_power_command(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("power", "Print the luminous and radiant flux of lights");
  command->footer(
      "Example:\n  lucerna power room.pbrt --light 1 --light 2\n"
      "  lucerna power room.pbrt --wavelength 450,555,650\n"
      "  lucerna power room.pbrt --method sampled --error 0.1%\n"
      "--json prints EstimatePowerResponse; with --error also `reached`, whether each light met "
      "the "
      "target.");
  const auto powers = std::make_shared<PowerOptions>();
  command->add_option("SCENE", powers->scene, kSceneHelp)->required();
  command
      ->add_option("--light", powers->lights,
                   "Id or name of a light; may be repeated; default: all. Ids come first")
      ->check(light_id_or_name())
      ->allow_extra_args(false);
  command
      ->add_option("--method", powers->method,
                   "exact; approximate: textbook formulas with their error; sampled: the mean of "
                   "rays that leave the light")
      ->check(one_of({"exact", "approximate", "sampled"}))
      ->capture_default_str();
  powers->stop.add(*command, "light", "4096; only with --method sampled", "lm");
  command
      ->add_option("--seed", powers->seed, "With --method sampled: random seed of the experiment")
      ->check(whole64())
      ->capture_default_str();
  powers->wavelengths.add(*command);
  session.prints_table(*command);
  command->callback([powers, &session] { power(session, *powers); });
}

}  // namespace lucerna::cli
