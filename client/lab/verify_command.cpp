#include "client/lab/verify_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/lab/emission_check.h"
#include "client/lab/estimate_check.h"
#include "client/lab/light_check.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_report.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

using verify::Finding;
using verify::Kind;
using verify::Records;
using verify::Truth;

constexpr Kind kKinds[] = {Kind::kSamples, Kind::kDensities,  Kind::kEmission,
                           Kind::kPower,   Kind::kIrradiance, Kind::kVisibility};

struct VerifyOptions {
  std::string scene;
  std::map<Kind, std::string> files;
  verify::Strictness strictness;
};

/// Reads files, whose lights may be ids or names.
class Files {
 public:
  explicit Files(const Truth& truth) : truth_(truth) {
    std::vector<std::string> ids;
    for (const v1::Light& light : truth.lights()) ids.push_back(std::to_string(light.id()));
    constexpr std::size_t kMostNamed = 20;
    if (ids.size() > kMostNamed) {
      allowed_ = fmt::format("the id of one of the scene's {} lights", ids.size());
    } else {
      allowed_ = fmt::format("the id of a light of the scene: {}", fmt::join(ids, ", "));
    }
  }

  Records read(Kind kind, const std::string& path) const {
    return verify::read_records(
        kind, path, [&](std::string_view name) { return id_of(name); },
        [&](std::uint64_t id) {
          return std::ranges::find(truth_.lights(), id, &v1::Light::id) != truth_.lights().end();
        },
        allowed_);
  }

 private:
  absl::StatusOr<double> id_of(std::string_view name) const {
    std::optional<double> id;
    for (const v1::Light& light : truth_.lights()) {
      if (light.name() != name) continue;
      if (id) return absl::InvalidArgumentError("several lights have this name; use their ids");
      id = static_cast<double>(light.id());
    }
    if (!id) return absl::NotFoundError("no light has this name, allowed: " + allowed_);
    return *id;
  }

  const Truth& truth_;
  std::string allowed_;
};

class Verification {
 public:
  Verification(Truth& truth, const verify::Strictness& strictness)
      : truth_(truth), strictness_(strictness) {}

  void check(const Records& records) {
    switch (records.kind) {
      case Kind::kSamples:
        each_light(records, verify::check_samples);
        add(verify::check_selection(truth_, records, strictness_));
        break;
      case Kind::kDensities:
        each_light(records, verify::check_densities);
        break;
      case Kind::kEmission:
        each_light(records, verify::check_emission);
        break;
      case Kind::kPower:
        add(verify::check_powers(truth_, records, strictness_));
        break;
      case Kind::kIrradiance:
        illuminances(records);
        break;
      case Kind::kVisibility:
        findings_.push_back(verify::check_visibility(truth_, records, strictness_));
        break;
    }
  }

  std::vector<Finding>& findings() { return findings_; }

 private:
  using Check = std::vector<Finding> (*)(Truth&, const v1::Light&, const Records&,
                                         const verify::Strictness&);

  void add(std::vector<Finding> more) { std::ranges::move(more, std::back_inserter(findings_)); }

  /// The light of each row: as given, the only one, or the one that the ray meets.
  std::vector<std::uint64_t> lights_of(const Records& records) {
    std::vector<std::uint64_t> lights = records.lights;
    lights.resize(records.rows, 0);
    std::vector<std::size_t> unknown;
    for (std::size_t i = 0; i < lights.size(); ++i)
      if (lights[i] == 0) unknown.push_back(i);
    if (unknown.empty()) return lights;
    if (truth_.lights().size() == 1) {
      for (const std::size_t i : unknown) lights[i] = truth_.lights()[0].id();
    } else if (records.kind != Kind::kEmission) {
      const Records rows = verify::rows_of(records, unknown);
      const std::vector<std::uint64_t> met =
          truth_.lights_met(rows.points, rows.directions, rows.distance);
      for (std::size_t i = 0; i < unknown.size(); ++i) lights[unknown[i]] = met[i];
    }
    return lights;
  }

  void each_light(const Records& records, Check check) {
    std::map<std::uint64_t, std::vector<std::size_t>> by_light;
    const std::vector<std::uint64_t> lights = lights_of(records);
    for (std::size_t i = 0; i < lights.size(); ++i) by_light[lights[i]].push_back(i);
    for (const auto& [id, rows] : by_light) {
      if (id == 0) {
        Finding f;
        f.quantity = verify::name(records.kind);
        f.left_out = rows.size();
        f.sentence = fmt::format("{} rows name no light and meet none; add the column \"light\"",
                                 rows.size());
        findings_.push_back(std::move(f));
        continue;
      }
      add(check(truth_, truth_.light(id), verify::rows_of(records, rows), strictness_));
    }
  }

  void illuminances(const Records& records) {
    std::map<std::uint64_t, std::vector<std::size_t>> by_light;
    for (std::size_t i = 0; i < records.rows; ++i)
      by_light[records.lights.empty() ? 0 : records.lights[i]].push_back(i);
    for (const auto& [id, rows] : by_light) {
      // One light may be named even if only the sum is given.
      const bool only = id == 0 && truth_.lights().size() == 1 && strictness_.bounces == 0;
      const v1::Light* light = only ? &truth_.lights()[0] : id == 0 ? nullptr : &truth_.light(id);
      findings_.push_back(
          verify::check_illuminances(truth_, light, verify::rows_of(records, rows), strictness_));
    }
  }

  Truth& truth_;
  const verify::Strictness& strictness_;
  std::vector<Finding> findings_;
};

void run(Session& session, const VerifyOptions& options) {
  if (options.files.empty())
    wrong_use(
        "verify requires --samples, --densities, --emission, --power, --irradiance or "
        "--visibility");
  session.need_one_server("verify asks one server");
  Truth truth(session, session.query_scene_id(options.scene));
  if (truth.lights().empty()) wrong_use("SCENE: has no lights, so there is nothing to compare");
  // All files are read before anything is asked, so a wrong one is reported at once.
  const Files files(truth);
  std::vector<Records> all;
  for (const auto& [kind, path] : options.files) all.push_back(files.read(kind, path));
  Verification verification(truth, options.strictness);
  for (const Records& records : all) verification.check(records);
  std::vector<Finding>& findings = verification.findings();
  verify::decide(findings, options.strictness);
  if (session.json()) {
    shell::print_text(stdout, "{}", verify::json_of(findings, truth, options.strictness));
  } else {
    session.show(verify::rows_of(findings, truth),
                 verify::notes_of(findings, truth, options.strictness));
    session.print_remarks();
  }
  if (verify::any_differs(findings)) session.set_exit_status(kServerRefused);
}

CLI::Validator probability() {
  return checked_number("a number in (0, 1)", [](double v) { return v > 0 && v < 1; });
}

}  // namespace

void add_verify_command(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("verify", "Compare numbers of another renderer with Lucerna's");
  std::string columns;
  for (const Kind kind : kKinds)
    columns +=
        fmt::format("  --{:<10} {}\n", verify::name(kind), fmt::join(verify::columns(kind), ","));
  command->footer(
      "FILE is .csv or .npy.  Columns, by name or in this order:\n" + columns +
      "Exit status: 0 everything agrees; 1 something differs, or the server refused; 2 wrong "
      "options or files.\n"
      "Example:\n  lucerna verify room.pbrt --samples samples.csv --power power.csv");
  const auto options = std::make_shared<VerifyOptions>();
  command->add_option("SCENE", options->scene, kSceneHelp)->required();
  constexpr const char* kHelp[] = {
      "Light samples: receiver, light, direction, density, value, distance",
      "Densities for given directions",
      "Rays that leave lights, with their densities",
      "Powers of lights [lm]",
      "Illuminances at points [lx]",
      "Whether pairs of points see each other"};
  for (const Kind kind : kKinds) {
    command
        ->add_option_function<std::string>(
            fmt::format("--{}", verify::name(kind)),
            [options, kind](const std::string& path) { options->files[kind] = path; },
            kHelp[static_cast<std::size_t>(kind)])
        ->type_name("FILE");
  }
  verify::Strictness& s = options->strictness;
  command
      ->add_option("--level", s.level,
                   "Chance that a correct renderer is called wrong; default: 0.001")
      ->check(probability());
  command
      ->add_option("--tolerance", s.tolerance,
                   "Relative error that counts as rounding, and angle [rad] to delta lights; "
                   "default: 0.1%")
      ->transform(share());
  command
      ->add_option("--angle", s.angle_rad,
                   "Error of directions that counts as rounding [rad]; default: 1e-5")
      ->check(not_negative());
  command->add_option("--outliers", s.outliers, "Share of rows that may differ; default: 0.5%")
      ->transform(share());
  command->add_flag("--same-density", s.same_density,
                    "Densities must be one of Lucerna's; otherwise they must fit their samples");
  command
      ->add_option("--estimate-samples", s.samples,
                   "Samples of Lucerna's illuminances, for each receiver")
      ->check(sample_count(64))
      ->capture_default_str();
  command->add_option("--bounces", s.bounces, "Most reflections in the illuminances; default: 0")
      ->check(whole(0));
  command->add_option("--seed", s.seed, "Random seed of Lucerna's samples")
      ->check(whole64())
      ->capture_default_str();
  session.prints_table(*command);
  command->callback([options, &session] { run(session, *options); });
}

}  // namespace lucerna::cli
