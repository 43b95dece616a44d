#include "client/tradeoff/study_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "client/terminal/point_options.h"
#include "client/terminal/print.h"
#include "client/terminal/program.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_signals.h"
#include "client/terminal/validators.h"
#include "client/tradeoff/study_report.h"
#include "client/tradeoff/trade.h"
#include "proto/common/stopwatch.h"

namespace lucerna::tradeoff {
namespace {

namespace fs = std::filesystem;
using cli::Session;
using cli::wrong_use;

struct Options {
  std::string scene;
  std::string query = "irradiance";
  std::string points;
  std::optional<std::uint32_t> bounces;
  double budget_s = 60;
  std::uint32_t rounds = 0;
  std::uint32_t max_samples = 64;
  double exposure_ev = 0;
  std::uint64_t seed = 0;
  std::string directory;
  std::string report;
  bool quiet = false;
};

Query query_of(const std::string& name) {
  const auto& names = query_names();
  return static_cast<Query>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// The path of the points.csv beside the scene file.  The scene's path is relative to the working
/// directory or to scenes/.  Empty if there is no such file.
std::string points_beside(const std::string& scene) {
  for (const fs::path& root : {fs::path(), fs::path("scenes")}) {
    const fs::path file = root / fs::path(scene).parent_path() / "points.csv";
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) return file.string();
  }
  return {};
}

QuestionOptions question_options(const Options& options, Query query) {
  QuestionOptions result{.scene = options.scene};
  result.bounces = options.bounces;
  result.exposure_ev = options.exposure_ev;
  if (query == Query::kRender || query == Query::kPower) return result;
  result.points_file = options.points;
  if (result.points_file.empty()) {
    result.points_file = points_beside(options.scene);
    if (result.points_file.empty()) {
      wrong_use(
          fmt::format("no points: give --points FILE, since there is no points.csv beside {} here "
                      "or under scenes/",
                      options.scene));
    }
  }
  std::ifstream file(result.points_file);
  if (!file) wrong_use("--points " + result.points_file + ": cannot be opened");
  auto set = cli::read_csv(file, result.points_file);
  if (!set.ok()) wrong_use(std::string(set.status().message()));
  if (set->points.empty()) wrong_use("--points " + result.points_file + ": has no points");
  if (set->seconds.empty()) {
    wrong_use("--points " + result.points_file + ": no normals, must have six columns");
  }
  result.points = std::move(set->points);
  result.normals = std::move(set->seconds);
  return result;
}

absl::StatusOr<std::unique_ptr<Question>> make_question(Query query, const client::Client& client,
                                                        const QuestionOptions& options) {
  switch (query) {
    case Query::kIrradiance:
      return make_irradiance_question(client, options);
    case Query::kRender:
      return make_picture_question(client, options);
    case Query::kSample:
      return make_sample_question(client, options);
    case Query::kPower:
      return make_power_question(client, options);
    case Query::kVisibility:
      return make_visibility_question(client, options);
  }
  return absl::InternalError("no such query");
}

/// Whether commands without --server use this server.
bool is_default_server(const CLI::App& app, const std::string& server) {
  const CLI::Option* option = app.get_option("--server");
  const char* named = std::getenv(option->get_envname().c_str());
  return server == (named == nullptr ? option->get_default_str() : named);
}

void make_directory_or_end(const std::string& directory) {
  if (directory.empty()) wrong_use("--out is required");
  const absl::Status made = make_directory(directory);
  if (!made.ok()) wrong_use(std::string(made.message()));
}

/// Makes report.html and errors.png from a tradeoff.json.
void report(const Options& options) {
  std::ifstream file(options.report, std::ios::binary);
  if (!file) wrong_use("--report " + options.report + ": cannot be opened");
  const std::string json{std::istreambuf_iterator<char>(file), {}};
  const auto page = report_page(json);
  if (!page.ok())
    wrong_use("--report " + options.report + ": " + std::string(page.status().message()));
  make_directory_or_end(options.directory);
  const std::string html = (fs::path(options.directory) / "report.html").string();
  const std::string png = (fs::path(options.directory) / "errors.png").string();
  absl::Status written = write_file(html, *page);
  if (written.ok()) {
    shell::print_text(stdout, "{}\n", html);
    written = draw_plot(html, png);
    if (absl::IsNotFound(written)) {
      shell::print_text(stderr, "{}: {} was not written\n", std::string(written.message()), png);
      return;
    }
  }
  if (!written.ok()) throw cli::CommandError(cli::kServerRefused, std::string(written.message()));
  shell::print_text(stdout, "{}\n", png);
}

void trade(const CLI::App& app, Session& session, const Options& options) {
  if (options.scene.empty()) wrong_use("SCENE is required, or --report FILE");
  session.need_one_server("times are those of one server");
  const Query query = query_of(options.query);
  QuestionOptions setup = question_options(options, query);
  make_directory_or_end(options.directory);
  setup.scene_id = session.scene_id(options.scene);
  setup.call = session.call_options();
  if (!is_default_server(app, session.server())) setup.server = session.server();
  const auto question = make_question(query, session.client(), setup);
  if (absl::IsInvalidArgument(question.status()))
    session.fail_here(question.status(), cli::kWrongUse);
  if (!question.ok()) session.fail(question.status());
  const auto info =
      session.value_or_fail(session.client().get_server_info({}, session.call_options()));

  const Stopwatch watch;
  TradeOptions trade_options{.budget_s = options.budget_s,
                             .rounds = options.rounds,
                             .max_samples = options.max_samples,
                             .seed = options.seed};
  trade_options.clock = [&] { return watch.seconds(); };
  if (!options.quiet) {
    trade_options.on_event = [](const std::string& event) {
      shell::print_text(stderr, "{}\n", event);
    };
  }
  auto record = measure_trade(**question, trade_options);
  if (absl::IsDeadlineExceeded(record.status()) &&
      std::string(record.status().message()).starts_with("--budget")) {
    wrong_use(std::string(record.status().message()));
  }
  if (!record.ok()) session.fail(record.status());

  Circumstances& c = record->circumstances;
  c.scene = options.scene;
  c.scene_id = setup.scene_id;
  c.client_version = LUCERNA_VERSION;
  c.server_version = info.version();
  c.fingerprint = info.fingerprint().digest();
  c.build = info.fingerprint().build();
  c.embree = info.fingerprint().embree();
  c.server_threads = info.threads();
  c.date = fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr)));
  if (options.rounds == 0) c.budget_s = options.budget_s;
  if (options.rounds > 0) {
    c.rounds = options.rounds;
    c.max_samples = options.max_samples;
  }
  c.seed = options.seed;
  c.exposure_ev = options.exposure_ev;
  const absl::Status written = write(*record, options.directory);
  if (!written.ok()) session.fail_here(written, cli::kServerRefused);
  if (session.json()) {
    shell::print_text(stdout, "{}\n", to_json(*record, false));
  } else {
    shell::print_text(stdout, "{}{}\n", to_text(*record),
                      (fs::path(options.directory) / "report.html").string());
  }
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("SCENE", options.scene, "Path under the server's scene root, or id");
  app.add_option("--query", options.query, "The query to study")
      ->check(cli::one_of(query_names()))
      ->capture_default_str();
  app.add_option("--points", options.points,
                 "CSV file of points x,y,z [m] and normals, not for render and power; default: "
                 "points.csv beside SCENE, here or under scenes/")
      ->type_name("FILE");
  app.add_option("--bounces", options.bounces,
                 "Reflections of light in irradiance and pictures; default: no limit")
      ->check(cli::whole(0));
  CLI::Option* budget =
      app.add_option("--budget", options.budget_s, "Time for the whole study; default 60s")
          ->transform(cli::duration());
  CLI::Option* rounds = app.add_option("--rounds", options.rounds,
                                       "Instead of --budget: measures every amount of every "
                                       "setting in this number of rounds. The amounts do not "
                                       "depend on the speed of the machine")
                            ->check(cli::whole(2))
                            ->excludes(budget);
  app.add_option("--max-samples", options.max_samples,
                 "With --rounds: the largest number of samples of an item; default 64")
      ->check(cli::whole(1, 1 << 20))
      ->needs(rounds);
  app.add_option("--exposure", options.exposure_ev,
                 "Exposure of pictures before FLIP compares them [EV]; default 0")
      ->check(cli::finite_number());
  app.add_option("--seed", options.seed, "Random seed of the study")
      ->check(cli::whole64())
      ->capture_default_str();
  app.add_option("--report", options.report,
                 "Only makes report.html and errors.png (with chromium) from this tradeoff.json")
      ->type_name("FILE");
  app.add_option("--out", options.directory, "Directory for the results")->type_name("DIR");
  app.add_flag("--quiet", options.quiet, "Prints no progress");
}

}  // namespace

int run_tradeoff(int argc, char** argv) {
  Session session(cli::stop_on_signals(), cli::first_signal());
  CLI::App app("Measures error against time of every sampling method, through a running lucernad.",
               "lucerna tradeoff");
  app.set_version_flag("--version", "lucerna-tradeoff " LUCERNA_VERSION);
  app.footer(
      "Writes tradeoff.csv (one row a measurement), tradeoff.json (everything) and report.html.\n"
      "Examples:\n"
      "  lucerna tradeoff room/scene.pbrt --points desks.csv --budget 60s --out room\n"
      "  lucerna tradeoff room/scene.pbrt --query render --rounds 5 --out room\n"
      "  lucerna tradeoff --report room/tradeoff.json --out room");
  session.add_options(app);
  Options options;
  add_options(app, options);
  app.callback([&] {
    if (options.report.empty()) {
      trade(app, session, options);
    } else {
      report(options);
    }
  });
  return cli::run_program(app, session, argc, argv);
}

}  // namespace lucerna::tradeoff
