// tradeoff.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>

#include "client/terminal/point_options.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"
#include "client/tradeoff/stopwatch.h"
#include "client/tradeoff/trade.h"

namespace lucerna::cli {
namespace {

namespace fs = std::filesystem;
using tradeoff::Query;

struct TradeoffOptions {
  std::string scene;
  std::string query = "irradiance";
  std::string points;
  std::optional<std::uint32_t> bounces;
  double budget_s = 60;
  double exposure_ev = 0;
  std::uint64_t seed = 0;
  std::string directory;
  bool quiet = false;
};

Query query_of(const std::string& name) {
  const auto& names = tradeoff::query_names();
  return static_cast<Query>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// A scene's own points: points.csv beside its file, where the scene root is seen from here.
std::string points_beside(const std::string& scene) {
  for (const fs::path& root : {fs::path(), fs::path("scenes")}) {
    const fs::path file = root / fs::path(scene).parent_path() / "points.csv";
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) return file.string();
  }
  return {};
}

tradeoff::QuestionOptions question_options(const TradeoffOptions& options, Query query) {
  tradeoff::QuestionOptions result{.scene = options.scene};
  result.bounces = options.bounces;
  result.exposure_ev = options.exposure_ev;
  if (query == Query::kRender || query == Query::kPower) return result;
  result.points_file = options.points;
  if (result.points_file.empty()) {
    result.points_file = points_beside(options.scene);
    if (result.points_file.empty()) {
      wrong_use(
          fmt::format("no points: give --points FILE, as there is no points.csv beside {} "
                      "here or under scenes/",
                      options.scene));
    }
  }
  std::ifstream file(result.points_file);
  if (!file) wrong_use("--points " + result.points_file + ": cannot be opened");
  auto set = read_csv(file, result.points_file);
  if (!set.ok()) wrong_use(std::string(set.status().message()));
  if (set->points.empty()) wrong_use("--points " + result.points_file + ": has no points");
  if (set->seconds.empty()) {
    wrong_use("--points " + result.points_file + ": no normals, must have six columns");
  }
  result.points = std::move(set->points);
  result.normals = std::move(set->seconds);
  return result;
}

absl::StatusOr<std::unique_ptr<tradeoff::Question>> make_question(
    Query query, const client::Client& client, const tradeoff::QuestionOptions& options) {
  switch (query) {
    case Query::kIrradiance:
      return tradeoff::make_irradiance_question(client, options);
    case Query::kRender:
      return tradeoff::make_picture_question(client, options);
    case Query::kSample:
      return tradeoff::make_sample_question(client, options);
    case Query::kPower:
      return tradeoff::make_power_question(client, options);
    case Query::kVisibility:
      return tradeoff::make_visibility_question(client, options);
  }
  return absl::InternalError("no such query");
}

/// Whether commands that name no server ask this one.
bool is_default_server(const CLI::App& app, const std::string& server) {
  const CLI::Option* option = app.get_option("--server");
  const char* named = std::getenv(option->get_envname().c_str());
  return server == (named == nullptr ? option->get_default_str() : named);
}

void trade(const CLI::App& app, Session& session, const TradeoffOptions& options,
           const std::string& version) {
  session.need_one_server("times are those of one server");
  const Query query = query_of(options.query);
  tradeoff::QuestionOptions asked = question_options(options, query);
  if (const absl::Status made = tradeoff::make_directory(options.directory); !made.ok())
    wrong_use(std::string(made.message()));
  asked.scene_id = session.scene_id(options.scene);
  asked.call = session.call_options();
  if (!is_default_server(app, session.server())) asked.server = session.server();
  const auto question = make_question(query, session.client(), asked);
  if (absl::IsInvalidArgument(question.status())) session.fail_here(question.status(), kWrongUse);
  if (!question.ok()) session.fail(question.status());
  const auto info = session.ask(session.client().get_server_info({}, session.call_options()));

  const tradeoff::Stopwatch watch;
  tradeoff::TradeOptions trade_options{.budget_s = options.budget_s, .seed = options.seed};
  trade_options.clock = [&] { return watch.seconds(); };
  if (!options.quiet) {
    trade_options.on_event = [](const std::string& event) { fmt::print(stderr, "{}\n", event); };
  }
  auto record = tradeoff::measure_trade(**question, trade_options);
  if (absl::IsDeadlineExceeded(record.status()) &&
      std::string(record.status().message()).starts_with("--budget")) {
    wrong_use(std::string(record.status().message()));
  }
  if (!record.ok()) session.fail(record.status());

  tradeoff::Circumstances& c = record->circumstances;
  c.scene = options.scene;
  c.scene_id = asked.scene_id;
  c.client_version = version;
  c.server_version = info.version();
  c.fingerprint = info.fingerprint().digest();
  c.build = info.fingerprint().build();
  c.embree = info.fingerprint().embree();
  c.server_threads = info.threads();
  c.date = fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr)));
  c.budget_s = options.budget_s;
  c.seed = options.seed;
  c.exposure_ev = options.exposure_ev;
  const absl::Status written = tradeoff::write(*record, options.directory);
  if (!written.ok()) session.fail_here(written, kServerSaidNo);
  if (session.json()) {
    fmt::print("{}\n", tradeoff::to_json(*record, false).dump());
  } else {
    fmt::print("{}{}\n", tradeoff::to_text(*record),
               (fs::path(options.directory) / "report.html").string());
  }
}

}  // namespace

void add_tradeoff_command(CLI::App& app, Session& session, const std::string& version) {
  CLI::App* command = app.add_subcommand(
      "tradeoff", "Error against time of every way to ask a query, measured through the server");
  command->footer(
      "Writes tradeoff.csv (a row a question), tradeoff.json (everything) and report.html.\n"
      "Example:\n  lucerna tradeoff room/scene.pbrt --query irradiance --points desks.csv "
      "--budget 60s --out room\n"
      "  lucerna tradeoff room/scene.pbrt --query render --budget 5m --out room");
  const auto trading = std::make_shared<TradeoffOptions>();
  command->add_option("SCENE", trading->scene, "Path or id")->required();
  command->add_option("--query", trading->query, "What is asked")
      ->check(one_of(tradeoff::query_names()))
      ->capture_default_str();
  command->add_option("--points", trading->points,
                      "CSV file of points x,y,z [m] and normals, for all but render and power; "
                      "default: points.csv beside SCENE, here or under scenes/");
  command
      ->add_option("--bounces", trading->bounces,
                   "Of irradiance and pictures: reflections that light may take; default: all")
      ->check(whole(0));
  command->add_option("--budget", trading->budget_s, "The time for all of it; default 60s")
      ->transform(duration());
  command
      ->add_option("--exposure", trading->exposure_ev,
                   "Of pictures, before FLIP looks at them [EV]; default 0, as they are rendered")
      ->check(checked_number("a finite number", [](double) { return true; }));
  command->add_option("--seed", trading->seed, "Seed of all seeds and of the order")
      ->check(whole64())
      ->capture_default_str();
  command->add_option("--out", trading->directory, "Directory for what it writes")->required();
  command->add_flag("--quiet", trading->quiet, "Tell nothing on the way");
  command->callback([trading, &app, &session, version] { trade(app, session, *trading, version); });
}

}  // namespace lucerna::cli
